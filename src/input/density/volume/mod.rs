//! A volume imported from a file.

mod bounds;
mod device;
mod numpy;
mod twin;

pub use numpy::{Grid, MAX_AXIS, MAX_VOXELS, file_of, load, save};

use super::lattice::lattice_hash;
use super::{DensityField, DensityTwin, DeviceField, Filter, Surroundings};
use crate::container::Container;
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::problem::{Problem, check};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Longest path of a volume's file, bytes: what Linux opens.
const MAX_PATH_BYTES: usize = 4096;

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

impl DensityField for Volume {
    fn validate(&self, container: &Container) -> Result<(), Problem> {
        check(
            "/density/volume/up_axis",
            f64::from(self.up_axis),
            "0, 1 or 2",
            |a| a <= 2.0,
        )?;
        self.check_path()?;
        match container {
            Container::Box { .. } => Ok(()),
            Container::Shell { .. } => Err(Problem::new(
                "/container",
                "an imported volume fills a `box` container, not a `shell`",
            )),
        }
    }

    fn shader(&self) -> Cow<'static, str> {
        "density/volume.wgsl".into()
    }

    fn build(&self, gpu: &Gpu, around: &Surroundings) -> Result<DeviceField> {
        device::build(gpu, self, corners(around.container)?)
    }

    fn twin(
        &self,
        container: &Container,
        _extinction_per_m: f64,
        _filter: Filter,
    ) -> Result<Option<Box<dyn DensityTwin>>> {
        let corners = corners(container)?;
        Ok(Some(Box::new(twin::Voxels::new(load(self)?, corners))))
    }

    fn input_file(&self) -> Option<&Path> {
        Some(&self.path)
    }

    fn input_file_mut(&mut self) -> Option<&mut PathBuf> {
        Some(&mut self.path)
    }

    /// A third of the voxels holds medium; the array's axes differ in length, and each of them points up in one
    /// example.
    fn examples(container: &Container, folder: &Path) -> Result<Vec<Self>> {
        if corners(container).is_err() {
            return Ok(Vec::new());
        }
        let size = [11, 7, 9];
        let voxels: u32 = size.iter().product();
        let path = folder.join("example.npy");
        let values = (0..voxels).map(|i| {
            let value = f64::from(lattice_hash([i, 0, 0], 1)[0]) / f64::from(u32::MAX);
            (3.0 * value - 2.0).max(0.0) as f32
        });
        let file = std::fs::File::create(&path).map_err(Error::writing(&path))?;
        save(std::io::BufWriter::new(file), size, values).map_err(Error::writing(&path))?;
        let turned = |up_axis| Self {
            path: path.clone(),
            up_axis,
        };
        Ok((0..3).map(turned).collect())
    }
}

impl Volume {
    /// Refuses a path that the file system does not accept or that a record cannot hold: JSON is UTF-8.
    fn check_path(&self) -> Result<(), Problem> {
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

/// Smallest and largest corner of the box that a volume fills, metres.
fn corners(container: &Container) -> Result<[[f64; 3]; 2]> {
    match *container {
        Container::Box { min_m, max_m } => Ok([min_m, max_m]),
        Container::Shell { .. } => Err(Error::input(
            "scene",
            "a volume needs a box container",
            "Use a `box` container.",
        )),
    }
}
