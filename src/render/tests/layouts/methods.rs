//! The tests' own methods: each stores optical depth, in one of the layouts.

use occlab::occlusion::plan::{
    MapLayout, MapNumbers, MapPlan, MapResource, MapResourceKind, MethodPass, StorableFormat,
};
use occlab::occlusion::rounding::{FloatFormat, Rounding, fraction};
use occlab::occlusion::twin::{Column, Encoding, LookUp, Twin, between_slices};
use occlab::occlusion::{
    GEOMETRY, LOOKUP, LightOcclusion, Marker, MethodInfo, MethodSetup, Plan, Role, STORAGE,
    TEXEL_LOOKUP, Trials,
};
use occlab::param::{Applies, ParamKind, ParamSpec, Params};
use occlab::{Error, Result};

pub const EDGE: u64 = 64;
pub const STEPS_A_COLUMN: u64 = 96;
pub const SLICES: u32 = 24;
/// Largest optical depth that a fraction represents.
pub const MOST_TAU: f64 = 8.0;

pub struct Method {
    pub info: &'static MethodInfo,
    plan: fn(control: bool) -> Plan,
    twin: Option<fn() -> Box<dyn Encoding>>,
}

impl LightOcclusion for Method {
    fn info(&self) -> &'static MethodInfo {
        self.info
    }

    fn plan(&self, params: &Params) -> Result<Plan> {
        let mut plan = (self.plan)(params.choice("control")? == "on");
        let number = |v: u32| Some(v.cast_signed());
        plan.defs.insert("SLICES".into(), number(SLICES));
        Ok(plan)
    }

    fn oracle(&self, _params: &Params) -> Result<Twin> {
        let twin = self.twin.map(|twin| Twin::Map(twin()));
        twin.ok_or_else(|| Error::defect(self.info.id, "it has no twin"))
    }
}

/// Negative control: makes a method wrong, in its shader or its plan.
const CONTROL: ParamSpec = ParamSpec {
    name: "control",
    unit: "",
    doc: "Left out on purpose.",
    kind: ParamKind::Choice {
        options: &["off", "on"],
        default: "off",
    },
    applies: Applies::Always,
    as_printed: &[],
};
const FLOATS: &[ParamSpec] = &[STORAGE, LOOKUP, CONTROL];
const SAMPLED: &[ParamSpec] = &[STORAGE, CONTROL];
const FRACTIONS: &[ParamSpec] = &[LOOKUP, CONTROL];
const PACKED: &[ParamSpec] = &[TEXEL_LOOKUP, CONTROL];

const fn info(
    id: &'static str,
    source: &'static str,
    params: &'static [&'static [ParamSpec]],
) -> MethodInfo {
    MethodInfo {
        id,
        title: id,
        summary: "",
        texel: "",
        expect: "",
        citation: "",
        role: Role::Practical,
        colour: 0,
        marker: Marker::Circle,
        shader: id,
        source,
        params,
        monotone: true,
        bounded: false,
        tolerance: 0.0,
        trials: Trials {
            pictures: &[],
            clouds: &[],
            texels: &[],
            exact: &[],
        },
    }
}

pub static VOLUME: Method = Method {
    info: &info(
        "test/volume.wgsl",
        include_str!("volume.wgsl"),
        &[GEOMETRY, SAMPLED],
    ),
    plan: |_| {
        Plan::of(MapLayout::Volume {
            slices: SLICES,
            values: 1,
            numbers: MapNumbers::Float,
        })
    },
    twin: Some(|| Box::new(Slices)),
};

pub static FRACTION: Method = Method {
    info: &info(
        "test/fraction.wgsl",
        include_str!("fraction.wgsl"),
        &[GEOMETRY, FRACTIONS],
    ),
    plan: |_| {
        Plan::of(MapLayout::Array {
            values: 3,
            numbers: MapNumbers::Unorm8,
        })
    },
    twin: None,
};

pub static WORD: Method = Method {
    info: &info(
        "test/word.wgsl",
        include_str!("word.wgsl"),
        &[GEOMETRY, PACKED],
    ),
    plan: |_| {
        Plan::of(MapLayout::Array {
            values: 1,
            numbers: MapNumbers::Word,
        })
    },
    twin: Some(|| Box::new(Packed)),
};

pub static BUFFER: Method = Method {
    info: &info(
        "test/buffer.wgsl",
        include_str!("buffer.wgsl"),
        &[GEOMETRY, PACKED],
    ),
    plan: |_| Plan::of(MapLayout::Buffer { words: SLICES }),
    twin: None,
};

/// Fractions of the largest optical depth of a tile of 8 × 8 texels, which a pass before the columns finds.
pub static BOUNDED: Method = Method {
    info: &info(
        "test/bounded.wgsl",
        include_str!("bounded.wgsl"),
        &[GEOMETRY, FRACTIONS],
    ),
    plan: |control| {
        let mut map = MapPlan::of(MapLayout::Array {
            values: 1,
            numbers: MapNumbers::Unorm8,
        });
        map.resources.push(MapResource {
            read: "tile_bounds",
            write: "tile_bounds_store",
            kind: MapResourceKind::Buffer {
                words: (EDGE / 8).pow(2) as u32,
            },
            temporary: false,
        });
        if !control {
            map.before.push(pass("bound_tile", &[]));
        }
        with(map)
    },
    twin: None,
};

/// A box blur of 3 × 3 texels, rows first.
pub static BLURRED: Method = Method {
    info: &info(
        "test/blurred.wgsl",
        include_str!("blurred.wgsl"),
        &[GEOMETRY, FLOATS],
    ),
    plan: |control| {
        let mut map = floats();
        map.resources.push(MapResource {
            read: "rows",
            write: "rows_store",
            kind: MapResourceKind::Array {
                size: [EDGE as u32, EDGE as u32, 1],
                levels: 1,
                format: StorableFormat::R32Float,
            },
            temporary: true,
        });
        if !control {
            map.after = vec![pass("blur_rows", &[]), pass("blur_columns", &[])];
        }
        with(map)
    },
    twin: None,
};

/// The mean of 2 × 2 texels as a second level, which alone is read.
pub static MIPPED: Method = Method {
    info: &info(
        "test/mipped.wgsl",
        include_str!("mipped.wgsl"),
        &[GEOMETRY, FLOATS],
    ),
    plan: |control| {
        let mut map = floats();
        map.levels = 2;
        if !control {
            let mut halve = pass("halve", &[("map_texture", 0), ("map_store", 1)]);
            halve.threads = [EDGE as u32 / 2; 2];
            map.after.push(halve);
        }
        with(map)
    },
    twin: None,
};

/// Refers to a mip level that its map does not have.
pub static LEVELLESS: Method = Method {
    info: &info(
        "test/mipped.wgsl",
        include_str!("mipped.wgsl"),
        &[GEOMETRY, FLOATS],
    ),
    plan: |_| {
        let mut map = floats();
        map.after.push(pass("halve", &[("map_store", 1)]));
        with(map)
    },
    twin: None,
};

/// The same method with another shader.
pub fn renamed(method: &Method, id: &'static str, source: String) -> &'static Method {
    let info = MethodInfo {
        id,
        shader: id,
        source: source.leak(),
        ..*method.info
    };
    Box::leak(Box::new(Method {
        info: Box::leak(Box::new(info)),
        ..*method
    }))
}

fn floats() -> MapPlan {
    MapPlan::of(MapLayout::Array {
        values: 1,
        numbers: MapNumbers::Float,
    })
}

fn pass(entry: &'static str, levels: &[(&'static str, u32)]) -> MethodPass {
    MethodPass {
        entry,
        threads: [EDGE as u32; 2],
        levels: levels.to_vec(),
    }
}

fn with(map: MapPlan) -> Plan {
    Plan {
        map: Some(map),
        ..Plan::default()
    }
}

/// Twin of [`VOLUME`]: optical depth at equal distances, from 0 to L_max.
struct Slices;

impl Encoding for Slices {
    fn encode(&self, column: &Column, _rounding: &Rounding) -> Vec<f64> {
        let at = |slice: u32| {
            let depth_m = f64::from(slice) / f64::from(SLICES - 1) * column.depth_m;
            let steps = column.thicknesses().enumerate();
            let step_m = column.step_m.max(1e-300);
            let share = |k: usize| (depth_m / step_m - k as f64).clamp(0.0, 1.0);
            steps.map(|(k, thickness)| thickness * share(k)).sum()
        };
        (0..SLICES).map(at).collect()
    }

    fn transmittance(&self, values: &[f64], look_up: LookUp, _rounding: &Rounding) -> f64 {
        let n = f64::from(SLICES);
        (-between_slices(values, (look_up.depth * (n - 1.0) + 0.5) / n)).exp()
    }
}

/// Twin of [`WORD`]: the column's optical depth in 24 bits, its length in 8.
struct Packed;

impl Encoding for Packed {
    fn encode(&self, column: &Column, _rounding: &Rounding) -> Vec<f64> {
        let tau: f64 = column.thicknesses().sum();
        vec![tau / MOST_TAU, column.length_m / column.depth_m]
    }

    fn stored(&self, values: Vec<f64>, rounding: &Rounding) -> Vec<f64> {
        match rounding.storage {
            FloatFormat::Packed => vec![
                fraction(values[0], 16_777_215.0),
                fraction(values[1], 255.0),
            ],
            _ => values,
        }
    }

    fn transmittance(&self, values: &[f64], look_up: LookUp, _rounding: &Rounding) -> f64 {
        let share = (look_up.depth / values[1].max(1e-20)).min(1.0);
        (-MOST_TAU * values[0] * share).exp()
    }
}

/// The method with parameters written `name=value`.
pub fn setup(method: &'static Method, params: &str) -> MethodSetup {
    let all = format!("resolution={EDGE} steps={STEPS_A_COLUMN} {params}");
    let defaults = MethodSetup {
        method,
        params: Params::defaults(method.info.specs()),
    };
    all.split_whitespace().fold(defaults, |setup, pair| {
        let (name, value) = pair.split_once('=').unwrap();
        setup.with(name, value).unwrap()
    })
}
