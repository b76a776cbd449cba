//! Where the published forms begin to fail, by bisection: on the oracle here, on the device in [`device`].

mod device;

use crate::error::{Error, Result};
use crate::occlusion::rounding::Rounding;
use crate::occlusion::twin::{Column, ColumnRules, Encoding, LightRay, LookUp, Twin};
use crate::occlusion::{MethodSetup, thickness_of_opacity};
use crate::raymarch::Renderer;
use device::DeviceSearch;
use serde::{Deserialize, Serialize};
use std::f64::consts::{E, LN_2};
use std::path::Path;

/// A number at which a form begins to fail, or that it returns where it is wrong.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Threshold {
    /// Method and form.
    pub form: String,
    /// What happens there.
    pub what: String,
    /// The parameter, with its unit if it has one.
    pub parameter: String,
    /// Storage `f16` or `f32`; `-` where it does not matter.
    pub storage: String,
    /// Denormals flushed to zero; `None` where it does not matter.
    pub flush: Option<bool>,
    /// Prediction from the number formats; `None` = never.
    pub predicted: Option<f64>,
    /// Where the prediction comes from.
    pub source: String,
    /// Measured on the oracle; `None` = not up to [`SEARCHED`].
    pub measured: Option<f64>,
    /// Found by the same search on the device, over pictures and stored bits; `None` = not searched there.
    pub device: Option<SearchResult>,
}

/// Result of a search on the device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SearchResult {
    /// The failure begins at this value.
    At(f64),
    /// No failure up to this value.
    NotUpTo(f64),
    /// The device returned an error with this message.
    Failed(String),
}

/// Upper end of the searched range of a parameter.
pub const SEARCHED: f64 = 1e5;
/// Halvings of a bracket on the oracle: f64 resolves no more.
const HALVINGS: u32 = 52;

/// First value in `low..=high` at which `fails`: `None` when it does not fail at `high`.
fn bisect(low: f64, high: f64, halvings: u32, fails: impl Fn(f64) -> bool) -> Option<f64> {
    if !fails(high) {
        return None;
    }
    let (mut low, mut high) = (low, high);
    for _ in 0..halvings {
        let middle = 0.5 * (low + high);
        if fails(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some(high)
}

/// Light ray of 1 m whose medium fills the first `share` of it.
struct Slab {
    extinction_per_m: f64,
    share: f64,
}

impl LightRay for Slab {
    fn length_m(&self) -> f64 {
        1.0
    }

    fn extinction_per_m(&self, s_m: f64) -> f64 {
        if s_m < self.share {
            self.extinction_per_m
        } else {
            0.0
        }
    }
}

/// The encoding of a method's map, on the CPU.
struct Map {
    encoding: Box<dyn Encoding>,
}

impl Map {
    fn new(id: &str, params: &[(&str, &str)]) -> Result<Self> {
        let setup = params
            .iter()
            .try_fold(MethodSetup::defaults(id)?, |setup, (name, value)| {
                setup.with(name, value)
            })?;
        match setup.method.oracle(&setup.params)? {
            Twin::Map(encoding) => Ok(Self { encoding }),
            Twin::March(_) => Err(Error::defect("thresholds", format!("`{id}` has no map"))),
        }
    }

    /// Values that a texel stores for a column of 100 steps.
    fn stored(&self, ray: &Slab, rounding: &Rounding) -> Vec<f64> {
        let column = Column::march(ray, &ColumnRules::even(100, "midpoint"), None, 1.0);
        let values = self.encoding.encode(&column, rounding);
        self.encoding.stored(values, rounding)
    }

    /// T at `depth`, 0…1, of a column of 100 steps.
    fn transmittance(&self, ray: &Slab, depth: f64, rounding: &Rounding) -> f64 {
        let look_up = LookUp {
            depth,
            length: 1.0,
            depth_m: 1.0,
        };
        self.encoding
            .transmittance(&self.stored(ray, rounding), look_up, rounding)
    }
}

/// Every threshold; the device's half where there is one. Its scenes' volume is written below `folder`.
pub fn thresholds(renderer: Option<&Renderer>, folder: &Path) -> Result<Vec<Threshold>> {
    let mut out = esm()?;
    out.extend(fom()?);
    out.extend(bsm()?);
    if let Some(renderer) = renderer {
        let device = DeviceSearch::new(renderer, folder)?;
        for threshold in &mut out {
            threshold.device = device.find(threshold);
        }
    }
    Ok(out)
}

const OVERFLOW: &str = "stores inf";
const NAN: &str = "returns NaN";
const THICKNESS: &str = "τ of a step";

fn row(form: &str, what: &str, parameter: &str) -> Threshold {
    Threshold {
        form: form.to_owned(),
        what: what.to_owned(),
        parameter: parameter.to_owned(),
        storage: "-".to_owned(),
        flush: None,
        predicted: None,
        source: String::new(),
        measured: None,
        device: None,
    }
}

/// An empty column: its front is its end, z = 1, so that c is c·z.
const EMPTY: Slab = Slab {
    extinction_per_m: 0.0,
    share: 0.0,
};

fn esm() -> Result<Vec<Threshold>> {
    let mut out = Vec::new();
    let map = |form: &str, c: f64| Map::new("esm", &[("form", form), ("c", &c.to_string())]);
    let fails = |form: &str, rounding: Rounding, nan: bool, c: f64| -> bool {
        // c is in the parameter's range, so that the method exists.
        map(form, c).is_ok_and(|map| match nan {
            true => map.transmittance(&EMPTY, 1.0, &rounding).is_nan(),
            false => map
                .stored(&EMPTY, &rounding)
                .iter()
                .any(|v| v.is_infinite()),
        })
    };
    let stored_ends = [
        ("f16", 65_520_f64.ln(), "ln 65520: f16 rounds to inf"),
        ("f32", 128.0 * LN_2, "128 ln 2: f32 rounds to inf"),
    ];
    for (storage, predicted, source) in stored_ends {
        let rounding = Rounding::device(storage, false);
        out.push(Threshold {
            storage: storage.to_owned(),
            predicted: Some(predicted),
            source: source.to_owned(),
            measured: bisect(1.0, SEARCHED, HALVINGS, |c| {
                fails("published", rounding, false, c)
            }),
            ..row("esm published", OVERFLOW, "c·z")
        });
    }
    let decays = [
        (
            "f16",
            true,
            126.0 * LN_2,
            "126 ln 2: e^(−c) flushes to 0, inf·0",
        ),
        (
            "f32",
            true,
            128.0 * LN_2,
            "128 ln 2: e^(−c) is 0 before e^c is inf",
        ),
        (
            "f16",
            false,
            150.0 * LN_2,
            "150 ln 2: e^(−c) rounds to 0, inf·0",
        ),
        (
            "f32",
            false,
            150.0 * LN_2,
            "150 ln 2: e^(−c) rounds to 0, inf·0",
        ),
    ];
    for (storage, flush, predicted, source) in decays {
        let rounding = Rounding::device(storage, flush);
        out.push(Threshold {
            storage: storage.to_owned(),
            flush: Some(flush),
            predicted: Some(predicted),
            source: source.to_owned(),
            measured: bisect(1.0, SEARCHED, HALVINGS, |c| {
                fails("published", rounding, true, c)
            }),
            ..row("esm published", NAN, "c·z")
        });
    }
    out.push(Threshold {
        storage: "f16".to_owned(),
        flush: Some(true),
        source: "stores z ≤ 1".to_owned(),
        measured: bisect(1.0, SEARCHED, HALVINGS, |c| {
            let rounding = Rounding::device("f16", true);
            fails("stable", rounding, false, c) || fails("stable", rounding, true, c)
        }),
        ..row("esm stable", "stores inf or returns NaN", "c·z")
    });
    Ok(out)
}

fn fom() -> Result<Vec<Threshold>> {
    let mut out = Vec::new();
    let rounding = Rounding::device("f32", true);
    for (form, predicted, source) in [
        (
            "published",
            Some(25.0 * LN_2),
            "25 ln 2: α = 1 − e^(−τ) rounds to 1",
        ),
        ("stable", None, "stores 2σΔs, scaled below 6e4"),
    ] {
        let map = Map::new("fom", &[("form", form)])?;
        // The first of 100 steps holds everything.
        let slab = |tau: f64| Slab {
            extinction_per_m: 100.0 * tau,
            share: 0.01,
        };
        out.push(Threshold {
            predicted,
            source: source.to_owned(),
            measured: bisect(1.0, SEARCHED, HALVINGS, |tau| {
                map.stored(&slab(tau), &rounding)
                    .iter()
                    .any(|v| !v.is_finite())
            }),
            ..row(&format!("fom {form}"), "stores inf or NaN", THICKNESS)
        });
    }
    let of_excess = |excess: f64| thickness_of_opacity(1.0 + excess, &rounding);
    out.push(Threshold {
        predicted: Some(-(2f64.powi(-25))),
        source: "f32 rounds to 1 from 1 − 2⁻²⁵ on".to_owned(),
        measured: bisect(-1e-6, 0.0, HALVINGS, |x| !of_excess(x).is_finite()),
        ..row("fom published", "adds inf", "α − 1")
    });
    out.push(Threshold {
        predicted: Some(2f64.powi(-24)),
        source: "f32 rounds above 1 from 1 + 2⁻²⁴ on: the logarithm of a negative number"
            .to_owned(),
        measured: bisect(0.0, 1e-6, HALVINGS, |x| of_excess(x).is_nan()),
        ..row("fom published", "adds NaN", "α − 1")
    });
    Ok(out)
}

/// Wrong, but finite: what the thesis text returns where the stable form returns 1.
fn bsm() -> Result<Vec<Threshold>> {
    let map = Map::new("bsm", &[("form", "published")])?;
    let rounding = Rounding::device("f32", true);
    let uniform = |tau: f64| Slab {
        extinction_per_m: tau,
        share: 1.0,
    };
    let at = |tau: f64, depth: f64| map.transmittance(&uniform(tau), depth, &rounding);
    let thin = 0.009_f64;
    let largest = (0..=1000u32)
        .map(|k| at(10.0, f64::from(k) / 1000.0))
        .fold(0.0, f64::max);
    Ok(vec![
        Threshold {
            predicted: Some(1.0 / E),
            source: "exp(−od)·od is largest at od = 1".to_owned(),
            measured: Some(largest),
            ..row("bsm published", "largest T of any column, 1 is right", "T")
        },
        Threshold {
            predicted: Some(0.0),
            source: "exp(−od)·od at od = 0".to_owned(),
            measured: Some(at(10.0, 0.0)),
            ..row("bsm published", "T before the cloud, 1 is right", "T")
        },
        Threshold {
            predicted: Some((-thin).exp() * thin),
            source: "front −1: the whole τ = 0.009 lies in front of the column".to_owned(),
            measured: Some(at(thin, 0.0)),
            ..row(
                "bsm published",
                "T before a cloud too thin for a front, 1 is right",
                "T",
            )
        },
    ])
}
