//! T along light columns on the oracle, with number formats emulated, against the f64 truth.

use super::record::{Columns, FormVerdict};
use crate::error::Result;
use crate::occlusion::MethodSetup;
use crate::occlusion::rounding::Rounding;
use crate::oracle::{LightColumn, Options, Oracle};
use crate::scene::Scene;
use glam::DVec3;

/// Depths at which T is compared, ends included.
const DEPTHS: u32 = 65;
/// Samples of the truth between two depths.
const TRUTH_SUBSTEPS: u32 = 64;
/// Tolerance of T outside `[0, 1]` and of its rises: f32 and f64 rounding stay below.
const TOLERANCE: f64 = 1e-6;
/// Behind a thin, thick sheet the truncated series overshoots to τ̂ = 1.19 τ (Gibbs); f16 coefficients add 2⁻¹¹ each.
const OVERSHOOT: f64 = 1.2;
/// Directions of view rays through which columns are laid, in half image extents: on no pixel centre and no texel edge.
const DIRECTIONS: [[f64; 2]; 5] = [
    [0.013, 0.017],
    [0.61, 0.43],
    [-0.57, 0.37],
    [-0.67, -0.47],
    [0.53, -0.41],
];
/// Positions on a view ray through which columns are laid, as shares of its length inside the layer.
const SHARES: [f64; 3] = [0.472, 0.231, 0.794];

/// A light column and its truth.
pub(super) struct ColumnProbe {
    column: LightColumn,
    /// Metres inside the layer.
    pub depths_m: Vec<f64>,
    /// T of the truth there.
    pub truth: Vec<f64>,
    /// σT of the truth there, m⁻¹.
    weights: Vec<f64>,
}

/// Columns through what a picture of `scene` sees; none where it sees nothing of the layer.
pub(super) fn probes(oracle: &Oracle, scene: &Scene, aspect: f64) -> Vec<ColumnProbe> {
    let position = DVec3::from(scene.camera.position_m);
    let (right, up, forward) = scene.camera.basis();
    // A very wide picture would have all of its columns far apart, a very narrow one in a plane.
    let (half_x, half_y) = scene.camera.half_extent(aspect.clamp(0.5, 2.0));
    let far_m = scene.camera.far_m.unwrap_or(1e30);
    let mut out = Vec::new();
    for [x, y] in DIRECTIONS {
        let direction = (forward + right * (x * half_x) + up * (y * half_y)).normalize();
        let intervals = scene.container.intervals(position, direction, 0.0, far_m);
        let Some((start, end)) = intervals.into_iter().find(|(start, end)| end > start) else {
            continue;
        };
        for share in SHARES {
            let p = position + direction * (start + share * (end - start));
            out.extend(probe(oracle, p));
        }
    }
    out
}

/// The truth by the midpoint rule, in one f64 march along the column.
fn probe(oracle: &Oracle, p: DVec3) -> Option<ColumnProbe> {
    let column = oracle.column_through(p);
    let length_m = column.length_m();
    if length_m <= 0.0 {
        return None;
    }
    let last = f64::from(DEPTHS - 1);
    let step_m = length_m / last / f64::from(TRUTH_SUBSTEPS);
    let (mut tau, mut k) = (0.0, 0u32);
    let mut probe = ColumnProbe {
        column,
        depths_m: Vec::new(),
        truth: Vec::new(),
        weights: Vec::new(),
    };
    for i in 0..DEPTHS {
        while k < i * TRUTH_SUBSTEPS {
            let middle_m = (f64::from(k) + 0.5) * step_m;
            tau += oracle.extinction_per_m(column.point(middle_m)) * step_m;
            k += 1;
        }
        let depth_m = length_m * f64::from(i) / last;
        let truth = (-tau).exp();
        probe.depths_m.push(depth_m);
        probe.truth.push(truth);
        probe
            .weights
            .push(oracle.extinction_per_m(column.point(depth_m)) * truth);
    }
    Some(probe)
}

/// Numbers of a method along the columns, and its T along the first.
pub(super) fn measure(
    oracle: &Oracle,
    probes: &[ColumnProbe],
    setup: &MethodSetup,
    rounding: Rounding,
) -> Result<(Columns, Vec<f64>)> {
    let options = Options {
        rounding,
        ..Options::default()
    };
    let occlusion = oracle.prepare(setup, options)?;
    let curves: Vec<Vec<f64>> = probes
        .iter()
        .map(|probe| occlusion.along(&probe.column, &probe.depths_m))
        .collect();
    let mut numbers = Numbers::default();
    for (probe, curve) in probes.iter().zip(&curves) {
        numbers.add(probe, curve);
    }
    let stored = occlusion.nonfinite_stored();
    let documented = match numbers.rises {
        0 => true,
        _ => rises_as_documented(oracle, probes, &curves, setup)?,
    };
    let columns = numbers.judge(stored, documented);
    Ok((columns, curves.into_iter().next().unwrap_or_default()))
}

/// Whether the rises of T are those that a method documents: FOM while τ̂ stays below its overshoot over the column's
/// own τ, a series of T within its own overshoot, and a method without a map because it samples anew from every point.
fn rises_as_documented(
    oracle: &Oracle,
    probes: &[ColumnProbe],
    curves: &[Vec<f64>],
    setup: &MethodSetup,
) -> Result<bool> {
    let info = setup.method.info();
    if setup.method.plan(&setup.params)?.map_values().is_none() {
        return Ok(true);
    }
    if info.monotone {
        return Ok(false);
    }
    if let Some(largest) = setup.method.largest_rise() {
        let rise = |curve: &Vec<f64>| {
            let mut lowest = f64::INFINITY;
            curve.iter().fold(0.0, |rise: f64, t| {
                lowest = lowest.min(*t);
                rise.max(t - lowest)
            })
        };
        return Ok(curves.iter().all(|curve| rise(curve) <= largest));
    }
    // The same texels, uncompressed and exact: the column's τ as this map samples and interpolates it.
    let floor = oracle.prepare(&setup.uncompressed()?, Options::default())?;
    let inside = |(probe, curve): (&ColumnProbe, &Vec<f64>)| {
        let least = floor.behind(&probe.column).powf(OVERSHOOT) - TOLERANCE;
        curve.iter().all(|t| *t >= least)
    };
    Ok(probes.iter().zip(curves).all(inside))
}

/// Sums over columns.
#[derive(Default)]
struct Numbers {
    nonfinite: u64,
    range: Option<[f64; 2]>,
    rises: u64,
    largest_rise: f64,
    max_error: Option<f64>,
    squares: f64,
    weights: f64,
}

impl Numbers {
    fn add(&mut self, probe: &ColumnProbe, curve: &[f64]) {
        let mut lowest = f64::INFINITY;
        let mut before = f64::INFINITY;
        for (i, t) in curve.iter().copied().enumerate() {
            if !t.is_finite() {
                self.nonfinite += 1;
                continue;
            }
            let [low, high] = self.range.unwrap_or([t, t]);
            self.range = Some([low.min(t), high.max(t)]);
            self.rises += u64::from(t - before > TOLERANCE);
            self.largest_rise = self.largest_rise.max(t - lowest);
            (before, lowest) = (t, lowest.min(t));
            let error = t - probe.truth[i];
            self.max_error = Some(self.max_error.unwrap_or(0.0).max(error.abs()));
            self.squares += probe.weights[i] * error * error;
            self.weights += probe.weights[i];
        }
    }

    fn judge(self, nonfinite_stored: u64, rises_documented: bool) -> Columns {
        let [low, high] = self.range.unwrap_or([0.0, 1.0]);
        let mut problems = Vec::new();
        if self.nonfinite > 0 {
            problems.push(format!("{} values of T are not finite", self.nonfinite));
        }
        if nonfinite_stored > 0 {
            problems.push(format!("{nonfinite_stored} stored values are not finite"));
        }
        if low < -TOLERANCE || high > 1.0 + TOLERANCE {
            problems.push(format!("T is in {low:.3}…{high:.3}"));
        }
        let rises = self.rises > 0;
        if rises && !rises_documented {
            problems.push(format!("T rises with depth, by {:.2e}", self.largest_rise));
        }
        let verdict = match (problems.is_empty(), rises) {
            (false, _) => FormVerdict::Breaks,
            (true, true) => FormVerdict::Rings,
            (true, false) => FormVerdict::Ok,
        };
        Columns {
            verdict,
            reason: (!problems.is_empty()).then(|| problems.join("; ")),
            nonfinite: self.nonfinite,
            nonfinite_stored,
            range: self.range,
            rises: self.rises,
            largest_rise: self.largest_rise.max(0.0),
            max_error: self.max_error,
            weighted_rmse: (self.weights > 0.0).then(|| (self.squares / self.weights).sqrt()),
        }
    }
}
