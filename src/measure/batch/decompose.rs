//! Decomposition of a cell's error into model, sampling and precision.
//!
//! With f64 pictures by the oracle, Δ = picture − truth = model + sampling + precision + truth difference, where
//!
//! - model = method with ample steps and texels − truth: the error of its encoding;
//! - sampling = method at the cell's own steps and texels − the same with ample ones;
//! - precision = the cell's picture − the oracle's at the same settings: rounding of stored values (also measured
//!   alone, by a picture of the oracle that rounds nothing else), f32 arithmetic, and in a procedural field the
//!   device's noise and texture filtering as far as the oracle does not emulate them;
//! - truth difference = the oracle's truth − the backend's truth, the same for all methods.

use super::record::Decomposition;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::metrics::{difference, relative_rmse};
use crate::occlusion::MethodSetup;
use crate::oracle::{Filter, Options, Oracle};
use crate::param::ParamValue;
use crate::progress::unwatched;
use crate::scene::{ImageSize, Scene};
use crate::truth::{TruthCache, by_oracle};
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Fewest steps that count as ample; four times the cell's own where these are more.
const AMPLE_STEPS: u32 = 400;
/// Most steps that methods of the registry accept.
const MOST_STEPS: u32 = 1000;
/// Longest edge to which a map is refined, texels.
const MOST_TEXELS: u32 = 1024;
/// Most values per texel of a map that is refined: with more, a finer map costs too much.
const MOST_VALUES: u32 = 64;

/// The numbers, and the signed luminance images of model, sampling and precision.
pub(super) type Parts = (Decomposition, [Vec<f32>; 3]);

/// Pictures by the oracle that the cells of one view share.
pub(super) struct Decomposer {
    oracle: Oracle,
    filter: Option<Filter>,
    truth: Frame,
    /// Pictures with ample sampling, by setup.
    ample: HashMap<String, Frame>,
}

impl Decomposer {
    /// Renders the f64 truth. Devices filter noise textures with weights of few bits: of the filters that the oracle
    /// emulates, the one whose truth is nearest to the backend's is taken.
    pub fn new(
        scene: &Scene,
        image: ImageSize,
        backend_truth: &Frame,
        cache: Option<&TruthCache>,
    ) -> Result<Self> {
        let filters = scene.density.field().filters();
        let mut best: Option<(f64, Self)> = None;
        for &filter in filters {
            let oracle = Oracle::filtered(scene, image, filter)?;
            let truth = by_oracle(&oracle, cache, &mut unwatched)?.frame;
            let distance = relative_rmse(backend_truth, backend_truth, &truth)?;
            if best.as_ref().is_none_or(|(least, _)| distance < *least) {
                let made = Self {
                    oracle,
                    filter: (filters.len() > 1).then_some(filter),
                    truth,
                    ample: HashMap::new(),
                };
                best = Some((distance, made));
            }
            if distance == 0.0 {
                break;
            }
        }
        match best {
            Some((_, made)) => Ok(made),
            None => Err(Error::defect("decompose", "the oracle knows no filter")),
        }
    }

    /// The errors of a cell of method `setup` with `picture`, relative to the backend's truth, and their signed
    /// luminance images in the order model, sampling, precision.
    pub fn measure(
        &mut self,
        setup: &MethodSetup,
        backend_truth: &Frame,
        picture: &Frame,
    ) -> Result<Parts> {
        let exact = self.oracle.render(setup, Options::default())?;
        let stored = self.oracle.render(setup, Options::stored(setup))?;
        let finer = ample(setup)?;
        let key = format!("{} {:?}", finer.method.info().id, finer.params);
        let ample = match self.ample.entry(key) {
            Entry::Occupied(kept) => kept.into_mut(),
            Entry::Vacant(slot) => slot.insert(self.oracle.render(&finer, Options::default())?),
        };
        let rmse = |from, to| relative_rmse(backend_truth, from, to);
        let image = |from, to| difference(backend_truth, from, to);
        let record = Decomposition {
            model_rel_rmse: rmse(&self.truth, ample)?,
            sampling_rel_rmse: rmse(ample, &exact)?,
            precision_rel_rmse: rmse(&exact, picture)?,
            storage_rel_rmse: rmse(&exact, &stored)?,
            truth_rel_rmse: rmse(backend_truth, &self.truth)?,
            ample_steps: finer.params.int("steps").ok(),
            ample_resolution: finer.params.int("resolution").ok(),
            noise_filter: self.filter.map(|filter| filter.name().to_owned()),
        };
        let images = [
            image(&self.truth, ample)?,
            image(ample, &exact)?,
            image(&exact, picture)?,
        ];
        Ok((record, images))
    }
}

/// The method with ample sampling: more steps and texels than the cell's own, within bounds.
fn ample(setup: &MethodSetup) -> Result<MethodSetup> {
    let mut ample = setup.clone();
    raise(&mut ample, "steps", |own| {
        own.saturating_mul(4).clamp(AMPLE_STEPS, MOST_STEPS)
    });
    let values = ample.method.plan(&ample.params)?.map_values();
    if values.is_some_and(|values| values <= MOST_VALUES) {
        raise(&mut ample, "resolution", |own| {
            own.saturating_mul(2).min(MOST_TEXELS).max(own)
        });
    }
    Ok(ample)
}

fn raise(setup: &mut MethodSetup, name: &'static str, to: fn(u32) -> u32) {
    if let Ok(own) = setup.params.int(name) {
        setup.params.set(name, ParamValue::Int(to(own).into()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::delta_luminance;
    use crate::occlusion::REGISTRY;
    use serde_json::json;

    fn scene() -> Scene {
        serde_json::from_value(json!({
            "name": "slab",
            "container": {"box": {"min_m": [0, 0, 0], "max_m": [1000, 1000, 1000]}},
            "density": {"uniform": {"value": 1}},
            "medium": {"extinction_per_m": 0.005},
            "sun": {"elevation_deg": 40, "azimuth_deg": 30, "irradiance": [1, 1, 1]},
            "camera": {"position_m": [500, 500, -2500], "target_m": [500, 500, 500], "fov_y_deg": 30}
        }))
        .unwrap()
    }

    /// A picture that differs a little, as a device's does.
    fn off(frame: &Frame, by: f32) -> Frame {
        let mut frame = frame.clone();
        for (i, pixel) in frame.sun.iter_mut().enumerate() {
            pixel[i % 3] *= 1.0 + by * ((i * 7 % 5) as f32 - 2.0);
        }
        frame
    }

    #[test]
    fn the_parts_add_up_to_the_difference_but_for_that_of_the_truths() {
        let image = ImageSize {
            width: 24,
            height: 16,
        };
        let oracle = Oracle::new(&scene(), image).unwrap();
        let exact_truth = oracle
            .render(&oracle.truth().unwrap(), Options::default())
            .unwrap();
        let truth = off(&exact_truth, 1e-4);
        let mut decomposer = Decomposer::new(&scene(), image, &truth, None).unwrap();
        for method in REGISTRY {
            let mut setup = MethodSetup::new(*method);
            let id = method.info().id;
            // In this medium a march from every sample errs only where steps are sampled at their ends.
            let coarse: &[_] = match id {
                "srm" => &[("sampling", "end")],
                _ => &[("steps", "20"), ("resolution", "16")],
            };
            for (name, value) in coarse {
                if setup.params.get(name).is_some() {
                    setup = setup.with(name, value).unwrap();
                }
            }
            let picture = oracle.render(&setup, Options::stored(&setup)).unwrap();
            let picture = off(&picture, 1e-3);
            let (record, parts) = decomposer.measure(&setup, &truth, &picture).unwrap();
            let whole = delta_luminance(&truth, &picture).unwrap();
            let truths = difference(&truth, &truth, &exact_truth).unwrap();
            let scale = crate::metrics::mean_sun(&truth).unwrap() as f32;
            for (i, whole) in whole.iter().enumerate() {
                let sum = parts.iter().map(|part| part[i]).sum::<f32>() + truths[i];
                assert!(
                    (sum - whole).abs() < 1e-5 * scale,
                    "{id} {i}: {sum} {whole}"
                );
            }
            // A homogeneous medium: any march is exact at midpoints, and converges from the ends of steps.
            if id == "srm" {
                assert!(record.model_rel_rmse < 1e-5, "{record:?}");
                assert!(record.storage_rel_rmse == 0.0, "{record:?}");
            }
            if ["esm", "fom"].contains(&id) {
                assert!(record.model_rel_rmse > 0.01, "{id} {record:?}");
                assert!(record.storage_rel_rmse > 0.0, "{id} {record:?}");
            }
            assert!(record.precision_rel_rmse > 1e-4 && record.precision_rel_rmse < 0.01);
            assert!((record.truth_rel_rmse - 1.4e-4).abs() < 1e-4, "{record:?}");
            assert_eq!(record.noise_filter, None);
        }
    }

    #[test]
    fn ample_stays_within_bounds() {
        let fine = MethodSetup::defaults("esm").unwrap();
        let finer = ample(&fine).unwrap();
        assert_eq!(finer.params.int("steps").unwrap(), 400);
        assert_eq!(finer.params.int("resolution").unwrap(), 1024);
        let most = fine.with("resolution", "4096").unwrap();
        let most = most.with("steps", "1000").unwrap();
        let finer = ample(&most).unwrap();
        assert_eq!(finer.params.int("steps").unwrap(), 1000);
        assert_eq!(finer.params.int("resolution").unwrap(), 4096);
        let floor = ample(&MethodSetup::defaults("floor").unwrap()).unwrap();
        assert_eq!(floor.params.int("resolution").unwrap(), 512);
    }
}
