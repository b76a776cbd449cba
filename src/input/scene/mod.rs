//! The scene, in metres: container, density, medium, sun, sky, camera. Deserialised from `configs/scenes/*.json`.
//!
//! A feature that a scene does not name has no texture, no binding and no shader code.

mod camera;
mod camera_track;
mod light;
mod map_cascades;
mod map_rectangle;
mod map_warp;
mod march;
mod navigate;
mod pattern;
mod preetham;
mod reconstruction;
mod track;

pub use camera::{Camera, ImageSize};
pub use camera_track::CameraTrack;
pub use light::{Ambient, Lobe, Medium, Sky, Sun};
pub use map_cascades::{MapCascades, MapCoverage, MapPlace};
pub use map_rectangle::{MapFit, MapRectangle};
pub use map_warp::{MapWarp, WARP_PARTS};
pub use march::{Integration, March};
pub use pattern::{Pattern, Subset};
pub use preetham::{PerezSky, SkyModel};
pub use reconstruction::{HistoryInfo, ReconstructionInfo, RestInfo};
pub use track::Track;

pub use crate::container::{Container, Intervals};
pub use crate::density::{Deck, Density, Detail, Procedural, Uniform, Volume};
pub use crate::problem::Problem;

use crate::problem::{MAX_MAGNITUDE, check, check_all};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A complete scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Shown in reports: 1 to 200 characters, none of them a control character.
    pub name: String,
    /// The region that may hold medium; everything outside is vacuum.
    pub container: Container,
    /// The dimensionless density field inside the container.
    pub density: Density,
    /// Extinction, albedo, phase function.
    pub medium: Medium,
    /// The directional light.
    pub sun: Sun,
    /// Sky radiance behind the clouds; absent = black background.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sky: Option<Sky>,
    /// Ambient radiance that stands in for multiple scattering; absent = none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ambient: Option<Ambient>,
    /// Where it is seen from.
    pub camera: Camera,
    /// How view rays are sampled.
    #[serde(default)]
    pub march: March,
}

impl Scene {
    /// Checks everything that types cannot: ranges, order, finiteness. The error's place is a JSON pointer.
    pub fn validate(&self) -> Result<(), Problem> {
        check_name(&self.name).map_err(|message| Problem::new("/name", message))?;
        self.container.validate()?;
        self.density.field().validate(&self.container)?;
        self.medium.validate()?;
        self.sun.validate(self.sky.is_some())?;
        if let Some(sky) = &self.sky {
            sky.validate()?;
        }
        if let Some(ambient) = &self.ambient {
            ambient.validate(self.sky.is_some())?;
        }
        self.camera.validate()?;
        self.march.validate()
    }

    /// Step of the truth's light march, metres: 10 m in a shell, 1/1000 of the diagonal in a box (at most 10 m).
    pub fn truth_step_m(&self) -> f64 {
        match &self.container {
            Container::Shell { .. } => 10.0,
            Container::Box { min_m, max_m } => {
                let diagonal_m = (0..3)
                    .map(|i| (max_m[i] - min_m[i]).powi(2))
                    .sum::<f64>()
                    .sqrt();
                (diagonal_m / 1000.0).min(10.0)
            }
        }
    }

    /// The file that the scene reads beside its own, if there is one: a volume.
    pub fn input_file(&self) -> Option<&Path> {
        self.density.field().input_file()
    }

    /// [`Scene::input_file`], mutable.
    pub fn input_file_mut(&mut self) -> Option<&mut PathBuf> {
        self.density.field_mut().input_file_mut()
    }

    /// Makes a relative volume path relative to `folder`, the one that holds the scene file.
    pub fn resolve_paths(&mut self, folder: &Path) {
        if let Some(path) = self.input_file_mut()
            && path.is_relative()
        {
            *path = folder.join(&*path);
        }
    }
}

/// Checks a name, which stands in tables, pages, charts and on terminals: it must be short and on one line.
pub fn check_name(name: &str) -> Result<(), String> {
    if name.is_empty() || name.chars().count() > 200 {
        return Err("the name must have 1 to 200 characters".to_owned());
    }
    match name.chars().find(|c| c.is_control()) {
        Some(c) => Err(format!("the name contains the control character {:?}", c)),
        None => Ok(()),
    }
}
