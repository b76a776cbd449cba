//! Parameters that maps share. The renderer reads them by name: those of [`GEOMETRY`] of every map, `storage` where it
//! holds floats, `lookup` where it is read by texels.

use crate::error::Result;
use crate::param::{Applies, AsPrinted, ParamKind, ParamSpec, Params};

/// Parameters of every map, whatever it stores: where its texels and samples lie.
pub const GEOMETRY: &[ParamSpec] = &[
    RESOLUTION,
    STEPS,
    SAMPLING,
    PLACEMENT,
    COLUMN_END,
    FIT,
    WARP_EXPONENT,
    CASCADES,
    CASCADE_RATIO,
    NEAR_STEPS,
    NEAR_REACH,
    FILL_FRAMES,
];

/// Parameters of a map of floats that is read by texels, beside [`GEOMETRY`].
pub const TEXELS: &[ParamSpec] = &[STORAGE, LOOKUP];

/// Numbers among them that the renderer reads, and no shader.
pub const READ_BY_RENDERER: &[&str] = &[
    WARP_EXPONENT.name,
    CASCADES.name,
    CASCADE_RATIO.name,
    FILL_FRAMES.name,
];

/// Rows of texels of a map with these parameters: those of all cascades.
pub(super) fn map_rows(params: &Params) -> Result<u32> {
    let resolution = params.int("resolution")?;
    Ok(resolution.saturating_mul(params.int("cascades")?))
}

/// Edge of a map.
const RESOLUTION: ParamSpec = ParamSpec {
    name: "resolution",
    unit: "texels",
    doc: "Edge of the square map.",
    kind: ParamKind::Int {
        min: 1,
        max: 65536,
        default: 512,
    },
    applies: Applies::Always,
    as_printed: &[],
};

/// Samples of a column.
const STEPS: ParamSpec = ParamSpec {
    name: "steps",
    unit: "",
    doc: "Samples a map column takes over its own length inside the layer.",
    kind: ParamKind::Int {
        min: 1,
        max: 1000,
        default: 100,
    },
    applies: Applies::Always,
    as_printed: &[],
};

/// Floating-point format of stored values.
pub const STORAGE: ParamSpec = ParamSpec {
    name: "storage",
    unit: "",
    doc: "Bits of a stored value: half or single precision.",
    kind: ParamKind::Choice {
        options: &["f16", "f32"],
        default: "f16",
    },
    applies: Applies::Always,
    as_printed: &[],
};

/// Look-up between texels of floats or fractions.
pub const LOOKUP: ParamSpec = ParamSpec {
    name: "lookup",
    unit: "",
    doc: "nearest: one texel; hardware: stored values interpolated by the sampler; blend: T of four texels, interpolated.",
    kind: ParamKind::Choice {
        options: &["nearest", "hardware", "blend"],
        default: "blend",
    },
    applies: Applies::Always,
    as_printed: &[],
};

/// Look-up between texels of words, which no sampler interpolates.
pub const TEXEL_LOOKUP: ParamSpec = ParamSpec {
    name: "lookup",
    unit: "",
    doc: "nearest: one texel; blend: T of four texels, interpolated.",
    kind: ParamKind::Choice {
        options: &["nearest", "blend"],
        default: "blend",
    },
    applies: Applies::Always,
    as_printed: &[],
};

/// Where a column is sampled.
const SAMPLING: ParamSpec = ParamSpec {
    name: "sampling",
    unit: "",
    doc: "Where a step is sampled: its midpoint, or its far end.",
    kind: ParamKind::Choice {
        options: &["midpoint", "end", "quadratic"],
        default: "midpoint",
    },
    applies: Applies::Always,
    as_printed: &[AsPrinted {
        option: "quadratic",
        doc: "step k of n is sampled at k(k+1)/(n(n−1)) of the column but counts at k/n, a misprint (thesis M, Algorithm 7)",
    }],
};

/// Where the steps of a column lie.
const PLACEMENT: ParamSpec = ParamSpec {
    name: "placement",
    unit: "",
    doc: "Where a column's steps lie: even = over its whole length; occupied = only where it may hold medium, and fewer where they would be shorter than ¾ of a cell of the grid of empty space.",
    kind: ParamKind::Choice {
        options: &["even", "occupied"],
        default: "even",
    },
    applies: Applies::Always,
    as_printed: &[],
};

/// Where a column ends.
const COLUMN_END: ParamSpec = ParamSpec {
    name: "column_end",
    unit: "",
    doc: "Where a column's march ends: layer = at the end of the layer or the ground; dark = at the latest where T has fallen below 2⁻⁸, so that what lies behind casts no shadow of its own.",
    kind: ParamKind::Choice {
        options: &["layer", "dark"],
        default: "layer",
    },
    applies: Applies::Always,
    as_printed: &[],
};

/// How the map's rectangle is laid.
const FIT: ParamSpec = ParamSpec {
    name: "fit",
    unit: "",
    doc: "Rectangle around what the view sees: square = one edge, the larger extent; axes = one extent an axis; warped = axes, with texels denser where the view takes its samples (Rosen 2012).",
    kind: ParamKind::Choice {
        options: &["square", "axes", "warped"],
        default: "square",
    },
    applies: Applies::Always,
    as_printed: &[],
};

/// How strongly texels follow the view's samples.
const WARP_EXPONENT: ParamSpec = ParamSpec {
    name: "warp_exponent",
    unit: "",
    doc: "Texel density is the density of the view's samples to this power, on each axis; 0 = equal texels.",
    kind: ParamKind::Float {
        min: 0.0,
        max: 1.0,
        default: 1.0 / 3.0,
    },
    applies: Applies::Choice {
        of: "fit",
        is: &["warped"],
    },
    as_printed: &[],
};

/// Nested rectangles.
const CASCADES: ParamSpec = ParamSpec {
    name: "cascades",
    unit: "",
    doc: "Nested rectangles of `resolution`² texels each: points near the camera are read from a smaller one, mixed with the next over the last tenth of its reach (Dimitrov 2007).",
    kind: ParamKind::Int {
        min: 1,
        max: 4,
        default: 1,
    },
    applies: Applies::Always,
    as_printed: &[],
};

/// Reaches of nested rectangles.
const CASCADE_RATIO: ParamSpec = ParamSpec {
    name: "cascade_ratio",
    unit: "",
    doc: "Reach of a cascade over that of the next, both counted from the nearest point of the layer in view.",
    kind: ParamKind::Float {
        min: 0.01,
        max: 0.99,
        default: 0.3,
    },
    applies: Applies::AtLeast {
        of: "cascades",
        min: 2,
    },
    as_printed: &[],
};

/// Steps of the march before the map is asked.
const NEAR_STEPS: ParamSpec = ParamSpec {
    name: "near_steps",
    unit: "",
    doc: "Samples marched from a point toward the sun, quadratically spaced, before the map answers for the rest; 0 = the map answers for all.",
    kind: ParamKind::Int {
        min: 0,
        max: 64,
        default: 0,
    },
    applies: Applies::Always,
    as_printed: &[],
};

/// Reach of the march before the map is asked.
const NEAR_REACH: ParamSpec = ParamSpec {
    name: "near_m",
    unit: "m",
    doc: "Reach of the near march, at most the ray's length inside the layer.",
    kind: ParamKind::Float {
        min: 1e-3,
        max: 1e6,
        default: 300.0,
    },
    applies: Applies::AtLeast {
        of: "near_steps",
        min: 1,
    },
    as_printed: &[],
};

/// Frames over which the map is filled.
const FILL_FRAMES: ParamSpec = ParamSpec {
    name: "fill_frames",
    unit: "",
    doc: "Frames over which the map is filled, an equal part in each, beside the one that is read meanwhile; 1 = the whole map in every frame. At rest the picture is the same.",
    kind: ParamKind::Int {
        min: 1,
        max: 64,
        default: 1,
    },
    applies: Applies::Always,
    as_printed: &[],
};

/// Definition of the front, where a column's cloud begins.
pub const FRONT: ParamSpec = ParamSpec {
    name: "front",
    unit: "",
    doc: "Where a column's cloud begins: threshold = T first falls below 0.99 (thesis M), first = near edge of the first occupied step.",
    kind: ParamKind::Choice {
        options: &["threshold", "first"],
        default: "threshold",
    },
    applies: Applies::Always,
    as_printed: &[],
};

/// Form of a method's equations: stable or published.
pub const FORM: ParamSpec = ParamSpec {
    name: "form",
    unit: "",
    doc: "Form of the equations: stable cannot overflow.",
    kind: ParamKind::Choice {
        options: &["stable", "published"],
        default: "stable",
    },
    applies: Applies::Always,
    as_printed: &[AsPrinted {
        option: "published",
        doc: "the formula as printed, kept to show where it fails",
    }],
};
