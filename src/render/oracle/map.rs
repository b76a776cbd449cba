//! A light map in f64. Texels are marched at their first look-up: memory grows with the texels that the view needs, not
//! with the map's size. Where a method's passes mix texels, those around are marched with them.

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
use crate::scene::{MapCascades, MapPlace};
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

/// Texels by their place, filled from many threads.
struct Texels(Vec<Mutex<HashMap<u64, Arc<Texel>>>>);

impl Texels {
    fn new() -> Self {
        Self((0..SHARDS).map(|_| Mutex::default()).collect())
    }

    /// The texel at `key`, made where there is none.
    fn get(&self, key: u64, make: impl FnOnce() -> Texel) -> Arc<Texel> {
        let shard = &self.0[key as usize % SHARDS];
        let lock = || shard.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(texel) = lock().get(&key) {
            return texel.clone();
        }
        let texel = Arc::new(make());
        lock().entry(key).or_insert(texel).clone()
    }

    fn sum(&self, of: impl Fn(&Texel) -> u64) -> u64 {
        let shard = |shard: &Mutex<HashMap<_, Arc<Texel>>>| -> u64 {
            let texels = shard.lock().unwrap_or_else(PoisonError::into_inner);
            texels.values().map(|texel| of(texel)).sum()
        };
        self.0.iter().map(shard).sum()
    }
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
    cascades: MapCascades,
    near: NearMarch,
    container: Container,
    field: Arc<OracleField>,
    skip: bool,
    /// Direction toward the sun when the map was filled.
    pub sun: DVec3,
    resolution: u32,
    rules: ColumnRules,
    rule: Rule,
    encoding: Box<dyn Encoding>,
    rounding: Rounding,
    /// As the column pass leaves them.
    columns: Texels,
    /// As passes behind it leave them; empty where there are none.
    mixed: Texels,
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
        if let Some(map) = &plan.map {
            setup.fill_parts(map)?;
        }
        let values = plan.map_values().unwrap_or_default();
        let samples =
            u64::from(image.width) * u64::from(image.height) * u64::from(scene.march.most_steps());
        let square = (2 * u64::from(encoding.mixed_texels()) + 1).pow(2);
        let texels = u64::from(resolution) * u64::from(setup.map_rows()?);
        let texels = texels.min(8 * square * samples);
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
            cascades: MapCascades::new(scene, *image, resolution, setup.map_coverage()?),
            near: NearMarch::new(setup)?,
            container: scene.container.clone(),
            field: oracle.field.clone(),
            skip: options.skip,
            sun: oracle.sun,
            resolution,
            rules: ColumnRules::new(&setup.params)?,
            rule: Rule::new(setup, &plan)?,
            encoding,
            rounding: options.rounding,
            columns: Texels::new(),
            mixed: Texels::new(),
        })
    }

    /// Where the map answers for a point; `None` outside of its rectangles.
    pub fn places(&self, p: DVec3) -> Option<[MapPlace; 2]> {
        self.cascades.places(p)
    }

    /// The march from a point toward the sun before the map is asked.
    pub fn near(&self) -> NearMarch {
        self.near
    }

    /// V at depth `depth_m` of the places that answer for a point.
    pub fn transmittance(&self, places: [MapPlace; 2], depth_m: f64) -> f64 {
        let asked = places.iter().filter(|place| place.share > 0.0);
        asked.map(|p| p.share * self.at(*p, depth_m)).sum()
    }

    /// V at a place and depth, from its rectangle alone.
    fn at(&self, MapPlace { cascade, uv, .. }: MapPlace, depth_m: f64) -> f64 {
        if self.depth_m() <= 0.0 {
            return 1.0;
        }
        let depth = depth_m / self.depth_m();
        let ask = |values: &[f64], length: f64| {
            self.encoding.transmittance(
                values,
                LookUp {
                    depth,
                    length,
                    depth_m: self.depth_m(),
                },
                &self.rounding,
            )
        };
        if self.rule == Rule::Nearest {
            let texel = self.texel(cascade, uv.map(|v| self.clamped((v * self.edge()).floor())));
            return ask(&texel.values, texel.length);
        }
        let taps = self
            .taps(uv)
            .map(|(at, share)| (self.texel(cascade, at), share));
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
        ask(
            &values,
            self.column(cascade, uv).length_m() / self.depth_m(),
        )
    }

    /// L_max, metres.
    fn depth_m(&self) -> f64 {
        self.cascades.depth_m()
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
    fn column(&self, cascade: usize, uv: [f64; 2]) -> LayerRay {
        LayerRay::new(
            &self.container,
            self.cascades.rectangles()[cascade].column_origin(uv),
            -self.sun,
            (-UNLIMITED_M, UNLIMITED_M),
        )
    }

    /// Density samples of all texels marched so far.
    pub fn samples(&self) -> u64 {
        self.columns.sum(|texel| texel.samples)
    }

    /// Values of all texels marched so far that are NaN or infinite.
    pub fn nonfinite_stored(&self) -> u64 {
        let nonfinite = |texel: &Texel| texel.values.iter().filter(|v| !v.is_finite()).count();
        let both = [&self.columns, &self.mixed];
        both.map(|texels| texels.sum(|texel| nonfinite(texel) as u64))
            .iter()
            .sum()
    }

    /// Values of a texel, clamped to the map's edge; `v` counts through all rectangles.
    pub fn stored(&self, [u, v]: [u32; 2]) -> Vec<f64> {
        let last = self.resolution - 1;
        let cascade = (v / self.resolution) as usize;
        let values = match cascade < self.cascades.rectangles().len() {
            true => self.texel(cascade, [u.min(last), v % self.resolution]),
            false => self.texel(self.cascades.rectangles().len() - 1, [u.min(last), last]),
        };
        values.values.to_vec()
    }

    fn texel(&self, cascade: usize, at: [u32; 2]) -> Arc<Texel> {
        match self.encoding.mixed_texels() {
            0 => self.column_texel(cascade, at),
            radius => self
                .mixed
                .get(self.key(cascade, at), || self.mix(cascade, at, radius)),
        }
    }

    fn column_texel(&self, cascade: usize, at: [u32; 2]) -> Arc<Texel> {
        self.columns
            .get(self.key(cascade, at), || self.march(cascade, at))
    }

    fn key(&self, cascade: usize, at: [u32; 2]) -> u64 {
        let row = cascade as u64 * u64::from(self.resolution) + u64::from(at[1]);
        row * u64::from(self.resolution) + u64::from(at[0])
    }

    /// The texel that passes behind the columns make of those within `radius`.
    fn mix(&self, cascade: usize, at: [u32; 2], radius: u32) -> Texel {
        let radius = i64::from(radius);
        let last = i64::from(self.resolution) - 1;
        let near = |center: u32, offset: i64| (i64::from(center) + offset).clamp(0, last) as u32;
        let offsets = (-radius..=radius).flat_map(|j| (-radius..=radius).map(move |i| [i, j]));
        let around: Vec<_> = offsets
            .map(|[i, j]| self.column_texel(cascade, [near(at[0], i), near(at[1], j)]))
            .collect();
        let square: Vec<&[f64]> = around.iter().map(|texel| &*texel.values).collect();
        let values = self.encoding.mix(&square);
        Texel {
            values: self.encoding.stored(values, &self.rounding).into(),
            length: self.column_texel(cascade, at).length,
            samples: 0,
        }
    }

    fn march(&self, cascade: usize, at: [u32; 2]) -> Texel {
        let samples = Cell::new(0);
        let ray = CountedRay {
            field: &self.field,
            skip: self.skip,
            ray: self.column(cascade, at.map(|i| (f64::from(i) + 0.5) / self.edge())),
            samples: &samples,
        };
        let (cell_m, depth_m) = (self.field.cell_m(), self.depth_m());
        let column = Column::march(&ray, &self.rules, cell_m, depth_m);
        let values = self.encoding.encode(&column, &self.rounding);
        Texel {
            values: self.encoding.stored(values, &self.rounding).into(),
            length: column.length_m / self.depth_m(),
            samples: samples.get(),
        }
    }
}
