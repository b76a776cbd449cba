//! Procedural clouds: parameters and their checks.

mod bounds;
mod calibrate;
mod device;
mod noise;
mod twin;

use super::{Control, ControlValue, DensityField, DensityTwin, DeviceField, Filter, Surroundings};
use crate::container::Container;
use crate::error::Result;
use crate::gpu::Gpu;
use crate::problem::{Problem, check, check_all};
use crate::shader_defs::Defs;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::path::Path;

/// Edge of the shape texture, texels (Schneider & Vos 2015).
const SHAPE_TEXELS: u32 = 128;
/// Edge of the detail texture, texels.
const DETAIL_TEXELS: u32 = 32;
/// Edge of the weather map, texels.
const WEATHER_TEXELS: u32 = 512;
/// Most shape tiles that the decks span in height: a grid of its empty space has 64 cells a tile, and a 3D texture 2048 an
/// axis.
const MAX_TILES_HIGH: f64 = 31.0;
/// Most shape tiles in the whole field, weather tile squared times the decks' height: 64³ cells each, 512 MiB in all.
const MAX_TILES: f64 = 2048.0;

/// Procedural clouds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Procedural {
    /// Seed of all noise.
    #[serde(default)]
    pub seed: u32,
    /// Period of the weather map, metres; a whole multiple of `shape_tile_m`.
    pub weather_tile_m: f64,
    /// Period of the shape noise, metres.
    pub shape_tile_m: f64,
    /// Erosion of the edges by high-frequency noise; absent = none, and no detail texture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detail: Option<Detail>,
    /// Extra extinction where the weather map rains: extinction × (1 + gain × precipitation); absent = none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub precipitation_gain: Option<f64>,
    /// Cloud decks, lowest first; one or two.
    pub decks: Vec<Deck>,
}

/// Erosion by Worley noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Detail {
    /// Period, metres.
    pub tile_m: f64,
    /// Strength, 0…0.9.
    pub strength: f64,
}

/// One layer of clouds inside the container.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Deck {
    /// Height of the deck's base, metres above ground.
    pub base_m: f64,
    /// Height of the deck's top, metres above ground.
    pub top_m: f64,
    /// Share of vertical columns whose opacity exceeds 0.5, in `[0, 1]`; calibrated to ± 0.03.
    pub coverage: f64,
    /// Range the weather map's type channel is mapped to: 0 stratus, 0.5 stratocumulus, 1 cumulus.
    pub cloud_type: [f64; 2],
}

impl DensityField for Procedural {
    fn validate(&self, container: &Container) -> Result<(), Problem> {
        self.validate_numbers()?;
        self.validate_decks(container)?;
        self.validate_extent()
    }

    fn shader(&self) -> Cow<'static, str> {
        device::SHADER.into()
    }

    fn defs(&self) -> Defs {
        device::defs(self, self.decks.len())
    }

    fn build(&self, gpu: &Gpu, around: &Surroundings) -> Result<DeviceField> {
        device::build(gpu, self, around)
    }

    fn twin(
        &self,
        container: &Container,
        extinction_per_m: f64,
        filter: Filter,
    ) -> Result<Option<Box<dyn DensityTwin>>> {
        let clouds = twin::Clouds::new(self, container, extinction_per_m, filter)?;
        Ok(Some(Box::new(clouds)))
    }

    /// Noise is read through the sampler, whose weights have few bits.
    fn filters(&self) -> &'static [Filter] {
        &[Filter::Exact, Filter::EightBit]
    }

    fn seed_mut(&mut self) -> Option<&mut u32> {
        Some(&mut self.seed)
    }

    fn controls(&mut self) -> Vec<Control<'_>> {
        let many = self.decks.len() > 1;
        let decks = self.decks.iter_mut().enumerate();
        let coverage = decks.map(|(i, deck)| Control {
            name: match many {
                true => format!("coverage of deck {}", i + 1),
                false => "coverage".to_owned(),
            },
            doc: "Share of vertical columns whose opacity exceeds 0.5.",
            unit: "",
            value: ControlValue::Real(&mut deck.coverage, 0.0..=1.0),
        });
        let mut controls: Vec<_> = coverage.collect();
        controls.push(Control {
            name: "seed".to_owned(),
            doc: "Of all noise: another sky of the same kind.",
            unit: "",
            value: ControlValue::Whole(&mut self.seed, 0..=9999),
        });
        controls
    }

    /// With and without detail and precipitation, last two decks with both.
    fn examples(container: &Container, _folder: &Path) -> Result<Vec<Self>> {
        let (low_m, high_m) = container.height_range_m();
        let middle_m = 0.5 * (low_m + high_m);
        let deck = |base_m, top_m| Deck {
            base_m,
            top_m,
            coverage: 0.5,
            cloud_type: [0.6, 1.0],
        };
        let shape_tile_m = (2.0 * (high_m - low_m)).clamp(100.0, 1e5);
        let field = |has_detail: bool, precipitation_gain, decks| Self {
            seed: 1,
            weather_tile_m: 2.0 * shape_tile_m,
            shape_tile_m,
            detail: has_detail.then_some(Detail {
                tile_m: (0.125 * shape_tile_m).min(1e4),
                strength: 0.3,
            }),
            precipitation_gain,
            decks,
        };
        let whole = || vec![deck(low_m, high_m)];
        Ok(vec![
            field(false, None, whole()),
            field(true, None, whole()),
            field(false, Some(0.5), whole()),
            field(
                true,
                Some(0.5),
                vec![deck(low_m, middle_m), deck(middle_m, high_m)],
            ),
        ])
    }
}

impl Procedural {
    fn validate_numbers(&self) -> Result<(), Problem> {
        check(
            &at("shape_tile_m"),
            self.shape_tile_m,
            "100…100 000 m",
            |v| (100.0..=1e5).contains(&v),
        )?;
        let ratio = self.weather_tile_m / self.shape_tile_m;
        check(
            &at("weather_tile_m"),
            self.weather_tile_m,
            "1 to 16 times shape_tile_m, a whole multiple",
            |_| (1.0..=16.0).contains(&ratio) && (ratio - ratio.round()).abs() < 1e-9,
        )?;
        if let Some(detail) = &self.detail {
            check(&at("detail/tile_m"), detail.tile_m, "10…10 000 m", |v| {
                (10.0..=1e4).contains(&v)
            })?;
            check(&at("detail/strength"), detail.strength, "0…0.9", |v| {
                (0.0..=0.9).contains(&v)
            })?;
        }
        if let Some(gain) = self.precipitation_gain {
            check(&at("precipitation_gain"), gain, "0…10", |v| {
                (0.0..=10.0).contains(&v)
            })?;
        }
        Ok(())
    }

    fn validate_decks(&self, container: &Container) -> Result<(), Problem> {
        if self.decks.is_empty() || self.decks.len() > 2 {
            return Err(Problem::new(
                at("decks"),
                format!("{} decks, allowed are 1 or 2", self.decks.len()),
            ));
        }
        let (low_m, high_m) = container.height_range_m();
        for (i, deck) in self.decks.iter().enumerate() {
            let at = |field: &str| at(&format!("decks/{i}/{field}"));
            check(&at("base_m"), deck.base_m, "inside the container", |v| {
                v >= low_m && v < high_m
            })?;
            check(
                &at("top_m"),
                deck.top_m,
                "above base_m and inside the container",
                |v| v > deck.base_m && v <= high_m,
            )?;
            check(&at("coverage"), deck.coverage, "0…1", |v| {
                (0.0..=1.0).contains(&v)
            })?;
            check_all(&at("cloud_type"), &deck.cloud_type, "0…1", |v| {
                (0.0..=1.0).contains(&v)
            })?;
        }
        Ok(())
    }

    /// The grid of provably empty space covers weather tile × weather tile × decks: it must fit memory and a texture.
    fn validate_extent(&self) -> Result<(), Problem> {
        let low_m = self
            .decks
            .iter()
            .fold(f64::INFINITY, |m, d| m.min(d.base_m));
        let high_m = self.decks.iter().fold(0.0, |m: f64, d| m.max(d.top_m));
        let high = (high_m - low_m) / self.shape_tile_m;
        check(
            "/density/procedural/shape_tile_m",
            high,
            "decks that span at most 31 shape tiles in height",
            |v| v <= MAX_TILES_HIGH,
        )?;
        let tiles = (self.weather_tile_m / self.shape_tile_m).powi(2) * high;
        check(
            "/density/procedural/shape_tile_m",
            tiles,
            "at most 2048 shape tiles in weather_tile_m² × the height that the decks span",
            |v| v <= MAX_TILES,
        )
    }
}

/// JSON pointer of a member of the field in a scene.
fn at(member: &str) -> String {
    format!("/density/procedural/{member}")
}

/// Offset of a deck's weather map, in periods: the second deck must not repeat the first.
fn weather_offset(deck: usize) -> f64 {
    0.37 * deck as f64
}
