//! Searches for thresholds on the device, over small pictures and stored bits.

use super::super::cases::write_volumes;
use super::super::pictures::{nonfinite, render};
use super::{NAN, SearchResult, THICKNESS, Threshold};
use crate::config::{Fill, VolumeFile};
use crate::error::{Error, Result};
use crate::occlusion::MethodSetup;
use crate::raymarch::Renderer;
use crate::scene::{ImageSize, Scene};
use std::path::Path;

/// Searches on the device: tiny scenes under a zenith sun.
pub(super) struct DeviceSearch<'a> {
    renderer: &'a Renderer,
    /// Medium in the last cell of every column: z = 0.99.
    deep: Scene,
    /// A uniform medium, one step a column.
    uniform: Scene,
}

/// Front of the columns of [`DeviceSearch::deep`], over their length: the near edge of the last of 100 steps.
const DEEP_FRONT: f64 = 0.99;
/// Edge of the box, metres.
const EDGE_M: f64 = 1000.0;
/// Halvings on the device: three digits.
const DEVICE_HALVINGS: u32 = 14;
/// Upper end of the searched range of c on the device.
const DEVICE_C: f64 = 200.0;
/// Upper end of the searched range of a step's τ on the device.
const DEVICE_TAU: f64 = 1000.0;

impl<'a> DeviceSearch<'a> {
    pub fn new(renderer: &'a Renderer, folder: &Path) -> Result<Self> {
        let deep = VolumeFile {
            cells: [1, 128, 1],
            fill: vec![Fill {
                from: [0, 0, 0],
                to: [1, 1, 1],
                value: 1.0,
            }],
        };
        let name = "threshold-deep";
        write_volumes(folder, &[(name.to_owned(), deep)].into())?;
        let volume = folder.join("inputs").join(format!("{name}.npy"));
        Ok(Self {
            renderer,
            deep: scene(serde_json::json!({"volume": {"path": volume, "up_axis": 1}}))?,
            uniform: scene(serde_json::json!({"uniform": {"value": 1.0}}))?,
        })
    }

    /// Result of the search for a threshold; `None` where there is nothing to search.
    pub fn find(&self, threshold: &Threshold) -> Option<SearchResult> {
        let form = threshold.form.split(' ').nth(1)?;
        let stored = threshold.what != NAN;
        let found = match (
            threshold.form.split(' ').next()?,
            threshold.parameter.as_str(),
        ) {
            ("esm", _) => self.search(DEVICE_C, |c| {
                let setup = self.setup("esm", form, &threshold.storage)?;
                let setup = setup.with("c", &(c / DEEP_FRONT).to_string())?;
                self.fails(&self.deep, &setup, stored, !stored)
            }),
            ("fom", THICKNESS) => self.search(DEVICE_TAU, |tau| {
                let mut scene = self.uniform.clone();
                scene.medium.extinction_per_m = tau / EDGE_M;
                let setup = self.setup("fom", form, "f32")?.with("steps", "1")?;
                self.fails(&scene, &setup, true, true)
            }),
            _ => return None,
        };
        Some(found.unwrap_or_else(|error| SearchResult::Failed(error.to_string())))
    }

    fn setup(&self, id: &str, form: &str, storage: &str) -> Result<MethodSetup> {
        MethodSetup::defaults(id)?
            .with("form", form)?
            .with("storage", storage)?
            .with("resolution", "4")
    }

    fn fails(&self, scene: &Scene, setup: &MethodSetup, stored: bool, shown: bool) -> Result<bool> {
        let image = ImageSize {
            width: 8,
            height: 8,
        };
        let view = self.renderer.view(scene, image)?;
        let (frame, nonfinite_stored) = render(self.renderer, &view, setup)?;
        Ok(stored && nonfinite_stored > 0 || shown && nonfinite(&frame) > 0)
    }

    /// [`bisect`] with a test that can return an error.
    fn search(&self, high: f64, fails: impl Fn(f64) -> Result<bool>) -> Result<SearchResult> {
        let limit = high;
        if !fails(high)? {
            return Ok(SearchResult::NotUpTo(limit));
        }
        let (mut low, mut high) = (1.0, high);
        for _ in 0..DEVICE_HALVINGS {
            let middle = 0.5 * (low + high);
            if fails(middle)? {
                high = middle;
            } else {
                low = middle;
            }
        }
        Ok(SearchResult::At(high))
    }
}

/// A box under a zenith sun, its lowest metres seen from the side.
fn scene(density: serde_json::Value) -> Result<Scene> {
    let scene = serde_json::json!({
        "name": "threshold",
        "container": {"box": {"min_m": [0, 0, 0], "max_m": [EDGE_M, EDGE_M, EDGE_M]}},
        "density": density,
        "medium": {"extinction_per_m": 1.0},
        "sun": {"elevation_deg": 90, "azimuth_deg": 0, "irradiance": [1, 1, 1]},
        "camera": {"position_m": [500, 6, -1500], "target_m": [500, 6, 500], "fov_y_deg": 0.4},
        "march": {"steps": 16}
    });
    serde_json::from_value(scene).map_err(|e| Error::defect("thresholds", e))
}
