//! Adaptive volumetric shadow map: the transmittance of each light column at a few nodes, chosen while it is marched.

use super::info::{Marker, MethodInfo, Role, Trials, trial};
use super::rounding::Rounding;
use super::twin::{Column, Encoding, LookUp, Twin};
use super::{GEOMETRY, LightOcclusion, Plan, TEXELS};
use crate::error::Result;
use crate::param::{Applies, ParamKind, ParamSpec, Params};
use crate::shader_defs::Defs;

/// Adaptive volumetric shadow map.
pub struct Avsm;

const PARAMS: &[ParamSpec] = &[
    ParamSpec {
        name: "nodes",
        unit: "",
        doc: "Nodes n of the curve (Salvi et al. 2010: 4 or 8); a texel holds 2n values.",
        kind: ParamKind::Int {
            min: 4,
            max: 16,
            default: 8,
        },
        applies: Applies::Always,
        as_printed: &[],
    },
    ParamSpec {
        name: "between",
        unit: "",
        doc: "T between two nodes: linear (as in the authors' demo), or exponential, as in uniform medium.",
        kind: ParamKind::Choice {
            options: &["linear", "exponential"],
            default: "linear",
        },
        applies: Applies::Always,
        as_printed: &[],
    },
];

const TRIALS: Trials = Trials {
    pictures: &[
        trial("", "nodes=6"),
        trial("nodes=4", "nodes=5"),
        trial("storage=f32", "nodes=6 storage=f32"),
        trial("between=exponential", ""),
        trial("nodes=5 lookup=hardware", "nodes=5"),
        trial("sampling=end", ""),
    ],
    clouds: &[trial("nodes=4", "nodes=4 between=exponential")],
    // Few steps: which of two nodes goes is open to rounding where their areas are nearly equal.
    texels: &[
        trial("placement=occupied", "placement=occupied sampling=end"),
        trial("steps=16", "steps=16 sampling=end"),
        trial("steps=24 nodes=4", "steps=24 nodes=4 sampling=end"),
        trial("steps=20 nodes=5 fit=axes", "steps=20 nodes=5"),
    ],
    // A line between two nodes is not an exponential.
    exact: &["between=exponential", "between=exponential nodes=4"],
};

impl LightOcclusion for Avsm {
    fn info(&self) -> &'static MethodInfo {
        &MethodInfo {
            id: "avsm",
            title: "Adaptive volumetric shadow map",
            summary: "adaptive volumetric shadow map: T at n nodes, linear between them",
            texel: "2n",
            expect: "A line between two nodes lies above the curve, and which node goes is decided before the rest of the column is known: light leaks into dense cloud, most with 4 nodes. Nodes of neighbouring texels do not match, so that `lookup=hardware` is off.",
            citation: "Salvi et al. 2010, Adaptive Volumetric Shadow Maps",
            role: Role::Practical,
            colour: 0x5a8f1f,
            marker: Marker::Hexagon,
            shader: "occlusion/avsm.wgsl",
            source: include_str!("../../../shaders/occlusion/avsm.wgsl"),
            params: &[GEOMETRY, TEXELS, PARAMS],
            monotone: true,
            bounded: false,
            tolerance: 5e-5,
            trials: TRIALS,
        }
    }

    fn oracle(&self, params: &Params) -> Result<Twin> {
        Ok(Twin::Map(Box::new(Nodes {
            most: params.int("nodes")? as usize,
            exponential: params.choice("between")? == "exponential",
        })))
    }

    fn value_names(&self, params: &Params) -> Result<Vec<String>> {
        let nodes = 1..=params.int("nodes")?;
        let names = nodes.flat_map(|i| [format!("depth of node {i}"), format!("T of node {i}")]);
        Ok(names.collect())
    }

    fn plan(&self, params: &Params) -> Result<Plan> {
        let nodes = params.int("nodes")?;
        let layers = nodes.div_ceil(2);
        let number = |v: u32| Some(v.cast_signed());
        let defs = Defs::from([
            ("NODES".into(), number(nodes)),
            ("PLACES".into(), number(nodes + 1)),
            ("LAYERS".into(), number(layers)),
            ("PADDED".into(), number(2 * layers)),
        ]);
        Ok(Plan {
            defs,
            ..Plan::array(2 * nodes)
        })
    }
}

/// T below which a segment between two nodes is black.
const LEAST_T: f64 = 1.0 / 16_777_216.0;
/// Where a step's edges are read, in steps from them: inside it, since the edge of two spans is on both sides of a gap.
const INSIDE: f64 = 1.0 / 64.0;
/// Optical thickness from which a step holds medium.
const LEAST_THICKNESS: f64 = 1e-7;
/// A gap is longer than this, in steps.
const GAP: f64 = 0.125;

/// T(d) through at most `most` of a column's nodes.
struct Nodes {
    most: usize,
    exponential: bool,
}

/// A point of the curve.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// d/L_max.
    depth: f64,
    transmittance: f64,
}

impl Nodes {
    /// Appends a node to the curve; where it is full, the node goes without which the area changes least.
    fn append(&self, curve: &mut Vec<Node>, depth: f64, transmittance: f64) {
        curve.push(Node {
            depth,
            transmittance,
        });
        if curve.len() > self.most {
            let areas = curve.windows(3).map(|w| triangle(w[0], w[1], w[2]));
            let least = areas
                .enumerate()
                .reduce(|a, b| if b.1 < a.1 { b } else { a });
            curve.remove(least.map_or(1, |(i, _)| i + 1));
        }
    }

    fn between(&self, a: Node, b: Node, depth: f64) -> f64 {
        let length = b.depth - a.depth;
        let x = if depth - a.depth >= length {
            1.0
        } else {
            (depth - a.depth) / length
        };
        if self.exponential {
            let ratio = at_least(b.transmittance) / at_least(a.transmittance);
            a.transmittance * ratio.powf(x)
        } else {
            a.transmittance + (b.transmittance - a.transmittance) * x
        }
    }
}

/// `value`, or [`LEAST_T`] below it; NaN stays.
fn at_least(value: f64) -> f64 {
    if value < LEAST_T { LEAST_T } else { value }
}

/// Area between a curve's corner and the line that takes its place.
fn triangle(a: Node, b: Node, c: Node) -> f64 {
    let (bx, by) = (b.depth - a.depth, b.transmittance - a.transmittance);
    let (cx, cy) = (c.depth - a.depth, c.transmittance - a.transmittance);
    0.5 * (by * cx - cy * bx).abs()
}

impl Encoding for Nodes {
    fn encode(&self, column: &Column, rounding: &Rounding) -> Vec<f64> {
        let step = column.step_m / column.depth_m;
        let near = |k: usize| column.depth_at(k, INSIDE) - INSIDE * step;
        let far = |k: usize| column.depth_at(k, 1.0 - INSIDE) + INSIDE * step;
        let mut curve: Vec<Node> = Vec::new();
        let (mut tau, mut end) = (0.0_f64, f64::NEG_INFINITY);
        for (k, thickness) in column.thicknesses().enumerate() {
            if thickness < LEAST_THICKNESS {
                continue;
            }
            if near(k) > end + GAP * step {
                self.append(&mut curve, near(k), rounding.computed((-tau).exp()));
            }
            tau = rounding.computed(tau + thickness);
            end = far(k);
            self.append(&mut curve, end, rounding.computed((-tau).exp()));
        }
        let last = curve.last().copied().unwrap_or(Node {
            depth: 1.0,
            transmittance: 1.0,
        });
        curve.resize(self.most, last);
        let values = curve
            .iter()
            .flat_map(|node| [node.depth, node.transmittance]);
        values.collect()
    }

    fn transmittance(&self, values: &[f64], look_up: LookUp, rounding: &Rounding) -> f64 {
        let node = |i: usize| Node {
            depth: values[2 * i],
            transmittance: values[2 * i + 1],
        };
        let segments = (1..self.most).map(|i| (node(i - 1), node(i)));
        // The last segment that begins before the depth.
        let mut reached = segments.filter(|(a, _)| look_up.depth > a.depth || a.depth.is_nan());
        let t = match reached.next_back() {
            Some((a, b)) => self.between(a, b, look_up.depth),
            None => node(0).transmittance,
        };
        rounding.computed(t)
    }
}
