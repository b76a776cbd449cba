//! A method made ready on the oracle: V at any point of the scene.

use super::field::Field;
use super::layer::{LayerRay, UNLIMITED_M, ground_blocks};
use super::map::LightMap;
use super::{LightColumn, Oracle};
use crate::error::Result;
use crate::occlusion::MethodSetup;
use crate::occlusion::rounding::Rounding;
use crate::occlusion::twin::{LightRay, March, Twin, fallback};
use crate::raymarch::{Counts, Samples};
use glam::DVec3;
use std::cell::Cell;

/// What the oracle is asked to emulate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Number formats of the method's values; the view march is always f64.
    pub rounding: Rounding,
    /// Skip provably empty space (changes no digit).
    pub skip: bool,
}

impl Default for Options {
    /// Exact, with skipping.
    fn default() -> Self {
        Self {
            rounding: Rounding::EXACT,
            skip: true,
        }
    }
}

/// A method in a scene. Shared between threads; texels of its map are kept.
pub struct Occlusion<'a> {
    pub(super) oracle: &'a Oracle,
    pub(super) skip: bool,
    kind: Kind,
}

enum Kind {
    March(Box<dyn March>),
    Map(Box<LightMap>),
}

/// What one thread counts.
#[derive(Default)]
pub(super) struct Tally {
    pub view: Cell<u64>,
    light: Cell<u64>,
    map: Cell<u64>,
    look_ups: Cell<u64>,
    fallbacks: Cell<u64>,
}

pub(super) fn count(cell: &Cell<u64>) {
    cell.set(cell.get() + 1);
}

impl Tally {
    pub fn counts(&self) -> Counts {
        Counts {
            samples: Samples {
                view: self.view.get(),
                light: self.light.get(),
                map: self.map.get(),
            },
            look_ups: self.look_ups.get(),
            fallbacks: self.fallbacks.get(),
        }
    }
}

/// A way of light through the scene.
struct Way<'a> {
    field: &'a Field,
    skip: bool,
    ray: LayerRay,
    samples: &'a Cell<u64>,
}

impl LightRay for Way<'_> {
    fn length_m(&self) -> f64 {
        self.ray.length_m()
    }

    fn extinction_per_m(&self, s_m: f64) -> f64 {
        let p = self.ray.point(s_m);
        if self.skip && self.field.clear_m(p).is_some() {
            return 0.0;
        }
        count(self.samples);
        self.field.extinction_per_m(p)
    }

    fn clear_m(&self, s_m: f64) -> Option<f64> {
        if !self.skip {
            return None;
        }
        let clear_m = self.field.clear_m(self.ray.point(s_m))?;
        Some(clear_m.min(self.ray.before_gap_m(s_m)))
    }
}

impl<'a> Occlusion<'a> {
    pub(super) fn new(oracle: &'a Oracle, setup: &MethodSetup, options: Options) -> Result<Self> {
        let kind = match setup.method.oracle(&setup.params)? {
            Twin::March(march) => Kind::March(march),
            Twin::Map(encoding) => Kind::Map(Box::new(LightMap::new(
                &oracle.scene,
                oracle.image,
                setup,
                encoding,
                options.rounding,
            )?)),
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

    pub(super) fn counted(&self, p: DVec3, rnd: f64, tally: &Tally) -> f64 {
        let Oracle { scene, sun, .. } = self.oracle;
        if ground_blocks(&scene.container, p, *sun) {
            return 0.0;
        }
        let ray = LayerRay::new(&scene.container, p, *sun, (0.0, UNLIMITED_M));
        let way = |ray, samples| Way {
            field: &self.oracle.field,
            skip: self.skip,
            ray,
            samples,
        };
        match &self.kind {
            Kind::March(march) => march.transmittance(&way(ray, &tally.light), rnd),
            Kind::Map(map) => {
                count(&tally.look_ups);
                let Some(uv) = map.uv(p) else {
                    count(&tally.fallbacks);
                    return fallback(&way(ray, &tally.light));
                };
                map.transmittance(uv, ray.length_m(), &|column| way(column, &tally.map))
            }
        }
    }
}
