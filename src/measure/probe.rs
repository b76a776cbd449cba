//! T(d) of every method along one light column, against the truth.

use crate::error::Result;
use crate::occlusion::{MethodSetup, REGISTRY};
use crate::oracle::{LightColumn, Options, Oracle};

/// Depths of a curve, not counting 0.
pub const STEPS: usize = 512;
/// The truth's cumulative quadrature takes the scene's truth step divided by this, or smaller steps.
const FINER: f64 = 10.0;
/// Most quadrature steps between two depths.
const MOST_PARTS: f64 = 1000.0;
/// Changes of T below this are attributed to rounding.
const ROUNDING: f64 = 1e-6;
/// Values of T that differ by less than this count as equal.
const LEVEL: f64 = 1e-9;

/// Curves over one light column.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// Metres inside the layer from its sun side, ascending from 0.
    pub depths_m: Vec<f64>,
    /// Extinction at these depths, m⁻¹.
    pub extinction_per_m: Vec<f64>,
    /// T(d) of the truth: cumulative midpoint quadrature in f64, at most a tenth of the truth's step.
    pub truth: Vec<f64>,
    /// One curve a method that was asked, in that order.
    pub curves: Vec<MethodCurve>,
}

/// T(d) of a method as the oracle renders it: through the map where the method has one, stored values rounded.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodCurve {
    /// Id of the method.
    pub method: &'static str,
    /// T at each depth.
    pub transmittance: Vec<f64>,
    /// For a series in a map (`fom`), by depth: T has risen since the previous depth, or −ln T exceeds the column's τ.
    pub outside: Vec<bool>,
    /// For a method that stores a largest optical depth (`bsm`): index of the depth from which min(D_max, ·) holds T
    /// constant, where it sets in before the column ends.
    pub clamped_from: Option<usize>,
}

impl Probe {
    /// Asks every method of the registry but the truth, at its defaults.
    pub fn new(oracle: &Oracle, column: &LightColumn) -> Result<Self> {
        let others = REGISTRY.iter().filter(|m| !m.info().is_truth());
        let setups: Vec<_> = others.map(|m| MethodSetup::new(*m)).collect();
        Self::of(oracle, column, &setups)
    }

    /// Asks these methods.
    pub fn of(oracle: &Oracle, column: &LightColumn, setups: &[MethodSetup]) -> Result<Self> {
        let step_m = column.length_m() / STEPS as f64;
        let depths_m: Vec<f64> = (0..=STEPS).map(|i| i as f64 * step_m).collect();
        let truth = truth(oracle, column, step_m);
        let sigma = |depth_m: &f64| oracle.extinction_per_m(column.point(*depth_m));
        let curve = |setup: &MethodSetup| {
            let prepared = oracle.prepare(setup, Options::stored(setup))?;
            curve(setup, prepared.along(column, &depths_m), &truth)
        };
        Ok(Self {
            extinction_per_m: depths_m.iter().map(sigma).collect(),
            curves: setups.iter().map(curve).collect::<Result<_>>()?,
            truth,
            depths_m,
        })
    }

    /// The curves as a table: depth, extinction, truth, one column a method, and the marks of each depth.
    pub fn csv(&self) -> String {
        let ids: Vec<_> = self.curves.iter().map(|c| c.method).collect();
        let mut text = format!("depth_m,extinction_per_m,truth,{},marks\n", ids.join(","));
        for (i, depth_m) in self.depths_m.iter().enumerate() {
            let values = [*depth_m, self.extinction_per_m[i], self.truth[i]].into_iter();
            let values = values.chain(self.curves.iter().map(|c| c.transmittance[i]));
            let marks = self.curves.iter().filter_map(|c| c.mark(i));
            let fields = values.map(|v| v.to_string());
            let marks = marks.collect::<Vec<_>>().join(" ");
            text += &fields.chain([marks]).collect::<Vec<_>>().join(",");
            text.push('\n');
        }
        text
    }
}

impl MethodCurve {
    /// The mark at depth `i`: `fom:outside`, `bsm:clamped`.
    fn mark(&self, i: usize) -> Option<String> {
        if self.outside[i] {
            Some(format!("{}:outside", self.method))
        } else if self.clamped_from.is_some_and(|from| i >= from) {
            Some(format!("{}:clamped", self.method))
        } else {
            None
        }
    }
}

fn truth(oracle: &Oracle, column: &LightColumn, step_m: f64) -> Vec<f64> {
    let parts = (step_m / oracle.truth_step_m() * FINER)
        .ceil()
        .clamp(1.0, MOST_PARTS);
    let part_m = step_m / parts;
    let mut tau = 0.0;
    let mut truth = vec![1.0];
    for i in 0..STEPS {
        for part in 0..parts as u32 {
            let depth_m = i as f64 * step_m + (f64::from(part) + 0.5) * part_m;
            tau += oracle.extinction_per_m(column.point(depth_m)) * part_m;
        }
        truth.push((-tau).exp());
    }
    truth
}

fn curve(setup: &MethodSetup, transmittance: Vec<f64>, truth: &[f64]) -> Result<MethodCurve> {
    let info = setup.method.info();
    let has_map = setup.method.plan(&setup.params)?.map_values().is_some();
    let least = truth.last().copied().unwrap_or(1.0);
    let outside = |i: usize| {
        let t = transmittance[i];
        let rises = i > 0 && t > transmittance[i - 1] + ROUNDING;
        has_map && !info.monotone && (rises || t < least - ROUNDING)
    };
    let outside = (0..transmittance.len()).map(outside).collect();
    Ok(MethodCurve {
        method: info.id,
        clamped_from: info.bounded.then(|| levels_off(&transmittance)).flatten(),
        outside,
        transmittance,
    })
}

/// Index from which the values equal the last, where that is more than one value and not all. Rounding moves the
/// look-up position along a column, and so the weights of texels: hence a tolerance.
fn levels_off(values: &[f64]) -> Option<usize> {
    let last = *values.last()?;
    let first = values.iter().rposition(|v| (v - last).abs() > LEVEL)? + 1;
    (first + 1 < values.len()).then_some(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_that_stays_level_is_clamped_from_there() {
        assert_eq!(levels_off(&[1.0, 0.5, 0.25, 0.25, 0.25]), Some(2));
        assert_eq!(levels_off(&[1.0, 0.5, 0.25]), None);
        assert_eq!(levels_off(&[1.0, 1.0, 1.0]), None);
    }

    #[test]
    fn only_series_in_a_map_are_outside() {
        let values = vec![1.0, 0.4, 0.5, 0.1];
        let truth = [1.0, 0.8, 0.5, 0.3];
        let of = |id| {
            let setup = MethodSetup::defaults(id).unwrap();
            curve(&setup, values.clone(), &truth).unwrap().outside
        };
        assert_eq!(of("fom"), [false, false, true, true]);
        assert!(of("srm").iter().chain(&of("esm")).all(|o| !o));
    }
}
