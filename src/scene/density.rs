//! The density field as a scene describes it.

use super::{Container, MAX_MAGNITUDE, Problem, check, check_all};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Longest path of a volume's file, bytes: what Linux opens.
const MAX_PATH_BYTES: usize = 4096;
/// Most shape tiles that the decks of a procedural field span in height: a grid of its empty space has 64 cells a tile,
/// and a 3D texture 2048 an axis.
const MAX_TILES_HIGH: f64 = 31.0;
/// Most shape tiles in the whole field, weather tile squared times the decks' height: 64³ cells each, 512 MiB in all.
const MAX_TILES: f64 = 2048.0;

/// Where the dimensionless density in `[0, ∞)` comes from; extinction = density × `medium.extinction_per_m`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Density {
    /// The same value everywhere in the container; for analytic checks.
    Uniform {
        /// Density, ≥ 0.
        value: f64,
    },
    /// Weather map, Perlin–Worley shape and Worley erosion (Schneider & Vos 2015, Schneider 2017, Hillaire 2016).
    Procedural(Procedural),
    /// A NumPy array that fills a box container, samples at cell centres, clamped trilinear interpolation.
    Volume(Volume),
}

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

/// An imported volume.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Volume {
    /// `.npy` file of three axes (floats of 16 to 64 bits, integers or bool, in either byte and axis order), or an array of
    /// a `.npz` archive: its only one, or `FILE.npz:NAME`. Relative to the scene file; `--volume` overrides it.
    pub path: PathBuf,
    /// Index (0, 1, 2) of the array axis that points up. Of the others the earlier is world z, the later world x.
    #[schemars(range(max = 2))]
    pub up_axis: u8,
}

impl Density {
    pub(super) fn validate(&self, container: &Container) -> Result<(), Problem> {
        match self {
            Self::Uniform { value } => check("/density/uniform/value", *value, "0…1e12", |v| {
                (0.0..=MAX_MAGNITUDE).contains(&v)
            }),
            Self::Procedural(p) => p.validate(container),
            Self::Volume(v) => {
                check(
                    "/density/volume/up_axis",
                    f64::from(v.up_axis),
                    "0, 1 or 2",
                    |a| a <= 2.0,
                )?;
                v.check_path()?;
                match container {
                    Container::Box { .. } => Ok(()),
                    Container::Shell { .. } => Err(Problem::new(
                        "/container",
                        "an imported volume fills a `box` container, not a `shell`",
                    )),
                }
            }
        }
    }
}

impl Volume {
    /// Refuses a path that no file system takes or that no record can hold: JSON is UTF-8.
    pub(crate) fn check_path(&self) -> Result<(), Problem> {
        let refuse = |message: String| Err(Problem::new("/density/volume/path", message));
        let bytes = self.path.as_os_str().len();
        if bytes > MAX_PATH_BYTES {
            return refuse(format!(
                "the path has {bytes} bytes, at most {MAX_PATH_BYTES} are opened"
            ));
        }
        match self.path.to_str() {
            Some(_) => Ok(()),
            None => refuse(format!(
                "`{}` is not UTF-8, as JSON and so every record is; the file or one of its folders needs another name",
                self.path.display()
            )),
        }
    }
}

impl Procedural {
    fn validate(&self, container: &Container) -> Result<(), Problem> {
        let at = |field: &str| format!("/density/procedural/{field}");
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
        self.validate_extent()
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
