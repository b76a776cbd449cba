//! A method prepared on the oracle: V at any point of the scene.

use super::counted_ray::{CountedRay, count};
use super::layer::{LayerRay, UNLIMITED_M, ground_blocks};
use super::map::LightMap;
use super::{LightColumn, Oracle};
use crate::cost::{Counts, Samples};
use crate::error::Result;
use crate::occlusion::MethodSetup;
use crate::occlusion::rounding::{FloatFormat, Rounding};
use crate::occlusion::twin::{LightMarch, Twin, fallback};
use glam::DVec3;
use std::cell::Cell;

/// Number formats to emulate, and whether to skip empty space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Number formats of the method's values; the view march is always f64.
    pub rounding: Rounding,
    /// Skip provably empty space (changes no digit).
    pub skip: bool,
}

impl Default for Options {
    /// Exact f64, with skipping.
    fn default() -> Self {
        Self {
            rounding: Rounding::EXACT,
            skip: true,
        }
    }
}

impl Options {
    /// Map values are rounded to the map's format, all else is exact.
    pub fn stored(setup: &MethodSetup) -> Self {
        // A plan that cannot be made is reported when the method is prepared.
        let storage = setup.stored_format().ok().flatten();
        Self {
            rounding: Rounding {
                storage: storage.unwrap_or(FloatFormat::F64),
                ..Rounding::EXACT
            },
            ..Self::default()
        }
    }
}

/// A method in a scene. Shared between threads; marched texels of its map are kept.
pub struct Occlusion<'a> {
    pub(super) oracle: &'a Oracle,
    pub(super) skip: bool,
    kind: LightModel,
}

enum LightModel {
    March(Box<dyn LightMarch>),
    Map(Box<LightMap>),
}

/// Counters of one thread.
#[derive(Default)]
pub(super) struct Tally {
    pub view: Cell<u64>,
    light: Cell<u64>,
    look_ups: Cell<u64>,
    fallbacks: Cell<u64>,
}

impl Tally {
    pub fn counts(&self) -> Counts {
        Counts {
            samples: Samples {
                view: self.view.get(),
                light: self.light.get(),
                // Texels are shared between threads: their map counts them.
                map: 0,
            },
            look_ups: self.look_ups.get(),
            fallbacks: self.fallbacks.get(),
        }
    }
}

impl<'a> Occlusion<'a> {
    pub(super) fn new(
        oracle: &'a Oracle,
        map_of: &Oracle,
        setup: &MethodSetup,
        options: Options,
    ) -> Result<Self> {
        let kind = match setup.method.oracle(&setup.params)? {
            Twin::March(march) => LightModel::March(march),
            Twin::Map(encoding) => {
                LightModel::Map(Box::new(LightMap::new(map_of, setup, encoding, options)?))
            }
        };
        Ok(Self {
            oracle,
            skip: options.skip,
            kind,
        })
    }

    /// V(p), 0 in the ground's shadow; `rnd` in `[0, 1)` is the sample's noise.
    pub fn visibility(&self, p: DVec3, rnd: f64) -> f64 {
        self.counted(p, rnd, &Tally::default())
    }

    /// V at `depths_m` along a light column, metres inside the layer from its sun side.
    pub fn along(&self, column: &LightColumn, depths_m: &[f64]) -> Vec<f64> {
        let at = |depth_m: &f64| self.visibility(column.point(*depth_m), 0.5);
        depths_m.iter().map(at).collect()
    }

    /// Values of texel `(u, v)` of the method's map, rounded as [`Options`] say; `None` without a map.
    pub fn texel(&self, at: [u32; 2]) -> Option<Vec<f64>> {
        match &self.kind {
            LightModel::March(_) => None,
            LightModel::Map(map) => Some(map.stored(at)),
        }
    }

    /// V behind the whole column, as the map stores it; for a method without a map, V at the column's end.
    pub fn behind(&self, column: &LightColumn) -> f64 {
        let p = column.point(column.length_m());
        match &self.kind {
            LightModel::Map(map) => match map.places(p) {
                Some(places) => map.transmittance(places, UNLIMITED_M),
                None => self.visibility(p, 0.5),
            },
            LightModel::March(_) => self.visibility(p, 0.5),
        }
    }

    /// Density samples of the texels marched so far.
    pub(super) fn map_samples(&self) -> u64 {
        match &self.kind {
            LightModel::March(_) => 0,
            LightModel::Map(map) => map.samples(),
        }
    }

    /// Values of the texels marched so far that are NaN or infinite; 0 without a map.
    pub fn nonfinite_stored(&self) -> u64 {
        match &self.kind {
            LightModel::March(_) => 0,
            LightModel::Map(map) => map.nonfinite_stored(),
        }
    }

    /// The scene and picture size.
    pub fn oracle(&self) -> &'a Oracle {
        self.oracle
    }

    pub(super) fn counted(&self, p: DVec3, rnd: f64, tally: &Tally) -> f64 {
        let Oracle { scene, sun, .. } = self.oracle;
        if ground_blocks(&scene.container, p, *sun) {
            return 0.0;
        }
        let layer = LayerRay::new(&scene.container, p, *sun, (0.0, UNLIMITED_M));
        let ray = CountedRay {
            field: &self.oracle.field,
            skip: self.skip,
            ray: layer,
            samples: &tally.light,
        };
        match &self.kind {
            LightModel::March(march) => march.transmittance(&ray, rnd),
            LightModel::Map(map) => {
                count(&tally.look_ups);
                let Some(places) = map.places(p) else {
                    count(&tally.fallbacks);
                    return fallback(&ray);
                };
                let near = map.near();
                let length_m = match map.sun == *sun {
                    true => layer.length_m(),
                    // Columns of an earlier frame's map.
                    false => {
                        let along = (0.0, UNLIMITED_M);
                        LayerRay::new(&scene.container, p, map.sun, along).length_m()
                    }
                };
                let far_m = (length_m - near.reach_m(layer.length_m())).max(0.0);
                let far = map.transmittance(places, far_m);
                near.transmittance(&ray) * far
            }
        }
    }
}
