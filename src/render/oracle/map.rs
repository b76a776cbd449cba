//! A light map in f64. Texels are marched at their first look-up: memory grows with the texels that the view needs, not
//! with the map's size.

use super::counted_ray::CountedRay;
use super::field::OracleField;
use super::layer::{LayerRay, UNLIMITED_M};
use super::{Options, Oracle};
use crate::error::{Error, Result};
use crate::occlusion::plan::MapLayout;
use crate::occlusion::rounding::Rounding;
use crate::occlusion::twin::{Column, ColumnRules, Encoding, LookUp, NearMarch};
use crate::occlusion::{MethodSetup, Plan};
use crate::scene::Container;
use crate::scene::MapRectangle;
use glam::DVec3;
use std::cell::Cell;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Number of locks over which texels are distributed.
const SHARDS: usize = 64;
/// Largest memory of one map's texels, bytes.
const MAX_BYTES: u64 = 4 << 30;

/// Stored values of a texel.
struct Texel {
    values: Box<[f64]>,
    /// Length of its column over L_max.
    length: f64,
    /// Density samples its march took.
    samples: u64,
}

/// Look-up between texels.
#[derive(Clone, Copy, PartialEq)]
enum Rule {
    Nearest,
    /// Interpolate stored values.
    Hardware,
    /// Interpolate transmittances.
    Blend,
}

impl Rule {
    /// A 3-D texture is always interpolated by the sampler, whatever the parameters.
    fn new(setup: &MethodSetup, plan: &Plan) -> Result<Self> {
        let layout = plan.map.as_ref().map(|map| map.layout);
        if matches!(layout, Some(MapLayout::Volume { .. })) {
            return Ok(Self::Hardware);
        }
        Ok(match setup.params.choice("lookup")? {
            "nearest" => Self::Nearest,
            "hardware" => Self::Hardware,
            _ => Self::Blend,
        })
    }
}

/// A light map whose texels are marched at their first look-up.
pub(super) struct LightMap {
    rectangle: MapRectangle,
    near: NearMarch,
    container: Container,
    field: Arc<OracleField>,
    skip: bool,
    sun: DVec3,
    resolution: u32,
    columns: ColumnRules,
    rule: Rule,
    encoding: Box<dyn Encoding>,
    rounding: Rounding,
    shards: Vec<Mutex<HashMap<u64, Arc<Texel>>>>,
}

impl LightMap {
    pub fn new(
        oracle: &Oracle,
        setup: &MethodSetup,
        encoding: Box<dyn Encoding>,
        options: Options,
    ) -> Result<Self> {
        let Oracle { scene, image, .. } = oracle;
        let resolution = setup.params.int("resolution")?;
        let plan = setup.method.plan(&setup.params)?;
        let values = plan.map_values().unwrap_or_default();
        let samples =
            u64::from(image.width) * u64::from(image.height) * u64::from(scene.march.most_steps());
        let texels = u64::from(resolution).pow(2).min(4 * samples);
        if texels.saturating_mul(8 * u64::from(values)) > MAX_BYTES {
            return Err(Error::input(
                "method",
                format!(
                    "the f64 map could take {texels} texels of {values} values, more than 4 GiB"
                ),
                "Choose a smaller `resolution` or fewer values a texel.",
            ));
        }
        Ok(Self {
            rectangle: MapRectangle::fit(scene, *image, resolution, setup.map_fit()?),
            near: NearMarch::new(setup)?,
            container: scene.container.clone(),
            field: oracle.field.clone(),
            skip: options.skip,
            sun: oracle.sun,
            resolution,
            columns: ColumnRules::new(&setup.params)?,
            rule: Rule::new(setup, &plan)?,
            encoding,
            rounding: options.rounding,
            shards: (0..SHARDS).map(|_| Mutex::default()).collect(),
        })
    }

    /// (u, v) in the rectangle; `None` outside.
    pub fn uv(&self, p: DVec3) -> Option<[f64; 2]> {
        self.rectangle.uv(p)
    }

    /// The march from a point toward the sun before the map is asked.
    pub fn near(&self) -> NearMarch {
        self.near
    }

    /// V at depth `depth_m`.
    pub fn transmittance(&self, uv: [f64; 2], depth_m: f64) -> f64 {
        if self.rectangle.depth_m <= 0.0 {
            return 1.0;
        }
        let depth = depth_m / self.rectangle.depth_m;
        let ask = |values: &[f64], length: f64| {
            self.encoding.transmittance(
                values,
                LookUp {
                    depth,
                    length,
                    depth_m: self.rectangle.depth_m,
                },
                &self.rounding,
            )
        };
        if self.rule == Rule::Nearest {
            let texel = self.texel(uv.map(|v| self.clamped((v * self.edge()).floor())));
            return ask(&texel.values, texel.length);
        }
        let taps = self.taps(uv).map(|(at, share)| (self.texel(at), share));
        if self.rule == Rule::Blend {
            return taps
                .iter()
                .map(|(texel, share)| share * ask(&texel.values, texel.length))
                .sum();
        }
        let mut values = vec![0.0; taps[0].0.values.len()];
        for (texel, share) in &taps {
            for (sum, value) in values.iter_mut().zip(&texel.values) {
                *sum += share * value;
            }
        }
        ask(&values, self.column(uv).length_m() / self.rectangle.depth_m)
    }

    fn edge(&self) -> f64 {
        f64::from(self.resolution)
    }

    fn clamped(&self, position: f64) -> u32 {
        position.clamp(0.0, self.edge() - 1.0) as u32
    }

    /// The four texels around a point and their bilinear shares; clamped at the map's edge.
    fn taps(&self, uv: [f64; 2]) -> [([u32; 2], f64); 4] {
        let position = uv.map(|v| v * self.edge() - 0.5);
        let low = position.map(f64::floor);
        let share = [position[0] - low[0], position[1] - low[1]];
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|corner: [u32; 2]| {
            let at = [0, 1].map(|i| self.clamped(low[i] + f64::from(corner[i])));
            let weight = |i: usize| {
                if corner[i] == 1 {
                    share[i]
                } else {
                    1.0 - share[i]
                }
            };
            (at, weight(0) * weight(1))
        })
    }

    /// The column through a point of the map, from the sun side.
    fn column(&self, uv: [f64; 2]) -> LayerRay {
        LayerRay::new(
            &self.container,
            self.rectangle.column_origin(uv),
            -self.sun,
            (-UNLIMITED_M, UNLIMITED_M),
        )
    }

    /// Density samples of all texels marched so far.
    pub fn samples(&self) -> u64 {
        self.sum(|texel| texel.samples)
    }

    /// Values of all texels marched so far that are NaN or infinite.
    pub fn nonfinite_stored(&self) -> u64 {
        self.sum(|texel| texel.values.iter().filter(|v| !v.is_finite()).count() as u64)
    }

    fn sum(&self, of: impl Fn(&Texel) -> u64) -> u64 {
        let shard = |shard: &Mutex<HashMap<_, Arc<Texel>>>| -> u64 {
            let texels = shard.lock().unwrap_or_else(PoisonError::into_inner);
            texels.values().map(|texel| of(texel)).sum()
        };
        self.shards.iter().map(shard).sum()
    }

    /// Values of a texel, clamped to the map's edge.
    pub fn stored(&self, at: [u32; 2]) -> Vec<f64> {
        self.texel(at.map(|i| i.min(self.resolution - 1)))
            .values
            .to_vec()
    }

    fn texel(&self, at: [u32; 2]) -> Arc<Texel> {
        let key = u64::from(at[1]) * u64::from(self.resolution) + u64::from(at[0]);
        let shard = &self.shards[key as usize % SHARDS];
        let lock = || shard.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(texel) = lock().get(&key) {
            return texel.clone();
        }
        let texel = Arc::new(self.march(at));
        lock().entry(key).or_insert(texel).clone()
    }

    fn march(&self, at: [u32; 2]) -> Texel {
        let samples = Cell::new(0);
        let ray = CountedRay {
            field: &self.field,
            skip: self.skip,
            ray: self.column(at.map(|i| (f64::from(i) + 0.5) / self.edge())),
            samples: &samples,
        };
        let (cell_m, depth_m) = (self.field.cell_m(), self.rectangle.depth_m);
        let column = Column::march(&ray, &self.columns, cell_m, depth_m);
        let values = self.encoding.encode(&column, &self.rounding);
        Texel {
            values: self.encoding.stored(values, &self.rounding).into(),
            length: column.length_m / self.rectangle.depth_m,
            samples: samples.get(),
        }
    }
}
