//! Parameters that maps share. The renderer reads them by name: `resolution`, `steps` and `sampling` of every map,
//! `storage` where it holds floats, `lookup` where it is read by texels.

use crate::param::{Applies, AsPrinted, ParamKind, ParamSpec};

/// Parameters of a map of floats that is read by texels.
pub const MAP_PARAMS: &[ParamSpec] = &[RESOLUTION, STEPS, STORAGE, LOOKUP, SAMPLING];

/// Edge of a map.
pub const RESOLUTION: ParamSpec = ParamSpec {
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
pub const STEPS: ParamSpec = ParamSpec {
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

/// Positions of the samples in a column.
pub const SAMPLING: ParamSpec = ParamSpec {
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
