//! The three errors of a cell: model, sampling, precision.
//!
//! With f64 pictures by the oracle, Δ = picture − truth = model + sampling + precision + truth difference, where
//!
//! - model = method with ample steps and texels − truth: what its encoding cannot say;
//! - sampling = method at the cell's own steps and texels − the same with ample ones;
//! - precision = the cell's picture − the oracle's at the same settings: number formats, and of a procedural field what
//!   the device's filtering of noise does beyond what the oracle emulates;
//! - truth difference = the oracle's truth − the backend's truth, which no method can help.

use super::record::Decomposition;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::metrics::{difference, relative_rmse};
use crate::occlusion::MethodSetup;
use crate::occlusion::param::ParamValue;
use crate::oracle::{Filter, Options, Oracle, truth};
use crate::raymarch::unwatched;
use crate::scene::{Density, ImageSize, Scene};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;

/// Fewest steps that count as ample; four times the cell's own where these are more.
const AMPLE_STEPS: u32 = 400;
/// Most steps of the registry's methods.
const MOST_STEPS: u32 = 1000;
/// Edge beyond which a map is not refined, texels.
const MOST_TEXELS: u32 = 1024;
/// Values a texel up to which more texels are affordable.
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
    /// knows, the one whose truth is nearer to the backend's is taken.
    pub fn new(
        scene: &Scene,
        image: ImageSize,
        backend_truth: &Frame,
        cache: Option<&Path>,
    ) -> Result<Self> {
        let noise = matches!(scene.density, Density::Procedural(_));
        let filters: &[Filter] = match noise {
            true => &[Filter::Exact, Filter::EightBit],
            false => &[Filter::Exact],
        };
        let mut best: Option<(f64, Self)> = None;
        for &filter in filters {
            let oracle = Oracle::filtered(scene, image, filter)?;
            let truth = truth(&oracle, cache, &mut unwatched)?.frame;
            let distance = relative_rmse(backend_truth, backend_truth, &truth)?;
            if best.as_ref().is_none_or(|(least, _)| distance < *least) {
                let made = Self {
                    oracle,
                    filter: noise.then_some(filter),
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
            None => Err(Error::input(
                "decompose",
                "the oracle knows no filter",
                "This is a defect of the program; please report it.",
            )),
        }
    }

    /// The errors of a cell of method `setup` with `picture`, relative to the backend's truth, and their signed luminance
    /// images in the order model, sampling, precision.
    pub fn measure(
        &mut self,
        setup: &MethodSetup,
        backend_truth: &Frame,
        picture: &Frame,
    ) -> Result<Parts> {
        let exact = self.oracle.render(setup, Options::default())?;
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

/// The method with so many steps and texels that more would hardly matter, within bounds.
fn ample(setup: &MethodSetup) -> Result<MethodSetup> {
    let mut ample = setup.clone();
    raise(&mut ample, "steps", |own| {
        own.saturating_mul(4).clamp(AMPLE_STEPS, MOST_STEPS)
    });
    if ample.method.plan(&ample.params)?.map_values <= Some(MOST_VALUES) {
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
