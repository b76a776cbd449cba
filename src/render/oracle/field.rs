//! The density field of a scene in f64: its twin and its provably empty space.

use crate::container::Container;
use crate::density::occupancy::Occupancy;
use crate::density::{DensityField, DensityTwin, Filter};
use crate::error::{Error, Result};
use crate::scene::Scene;
use glam::DVec3;

/// Rounding error of a point, as a share of an occupancy cell: an upper bound.
const CELL_SLACK: f64 = 1e-9;
/// The device's, see `grid_distance` in shaders/shared/occupancy.wgsl.
const DEVICE_SLACK: f64 = 1e-3;

/// Density and extinction of a scene.
pub(super) struct OracleField {
    container: Container,
    extinction_per_m: f64,
    twin: Box<dyn DensityTwin>,
    occupancy: Option<Occupancy>,
    filter: Filter,
}

impl OracleField {
    pub fn new(scene: &Scene, filter: Filter) -> Result<Self> {
        let (container, extinction_per_m) = (&scene.container, scene.medium.extinction_per_m);
        let field = scene.density.field();
        let twin = twin(
            field,
            scene.density.name(),
            container,
            extinction_per_m,
            filter,
        )?;
        Ok(Self {
            container: container.clone(),
            extinction_per_m,
            occupancy: twin.occupancy(),
            twin,
            filter,
        })
    }

    /// The same with the margin that the device keeps for the rounding of f32: where steps lie depends on it.
    pub fn empty_m(&self, p: DVec3) -> Option<f64> {
        let margin_m = DEVICE_SLACK * self.cell_m()?;
        Some((self.clear_m(p)? - margin_m).max(0.0))
    }

    /// Edge of the cells of the grid of empty space, metres; `None` without a grid.
    pub fn cell_m(&self) -> Option<f64> {
        Some(self.occupancy.as_ref()?.cell_m)
    }

    /// How its textures are filtered.
    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// Identifies imported data; empty for fields that the scene's JSON determines.
    pub fn content_hash(&self) -> String {
        self.twin.content_hash()
    }

    /// Weather thresholds that give each deck its coverage; empty for fields without decks.
    pub fn thresholds(&self) -> &[f64] {
        self.twin.thresholds()
    }

    /// Extinction at a point, m⁻¹.
    pub fn extinction_per_m(&self, p: DVec3) -> f64 {
        self.twin.density(p) * self.extinction_per_m
    }

    /// Distance around `p` within which extinction is provably 0, metres; `None` where it may be > 0 at `p`.
    pub fn clear_m(&self, p: DVec3) -> Option<f64> {
        let grid = self.occupancy.as_ref()?;
        let cell = (self.container.field_point(p) - DVec3::from(grid.origin_m)) / grid.cell_m;
        let base = cell.floor();
        let mut index = [0; 3];
        for (axis, index) in index.iter_mut().enumerate() {
            let n = grid.size[axis] as i64;
            let mut i = base[axis] as i64;
            if grid.wrap && axis != 1 {
                i = i.rem_euclid(n);
            }
            if !(0..n).contains(&i) {
                return None;
            }
            *index = i as usize;
        }
        let [x, y, z] = index;
        let rings = grid.rings[(z * grid.size[1] + y) * grid.size[0] + x];
        let to_face = (cell - base).min(DVec3::ONE - (cell - base)).min_element();
        // Height changes no faster than the distance travelled, so that field distances bound world distances.
        (rings > 0).then(|| (f64::from(rings - 1) + to_face - CELL_SLACK).max(0.0) * grid.cell_m)
    }
}

/// The twin of a field of kind `name`, or an error that says there is none.
fn twin(
    field: &dyn DensityField,
    name: &str,
    container: &Container,
    extinction_per_m: f64,
    filter: Filter,
) -> Result<Box<dyn DensityTwin>> {
    let twin = field.twin(container, extinction_per_m, filter)?;
    twin.ok_or_else(|| {
        Error::input(
            "scene, at /density",
            format!(
                "a density of kind `{name}` has no f64 twin, so that the oracle cannot render it"
            ),
            "Use an adapter, without splitting errors into their parts, or another density.",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::density::{DeviceField, Surroundings};
    use crate::gpu::Gpu;
    use crate::problem::Problem;
    use std::borrow::Cow;
    use std::path::Path;

    /// A kind that has a device form only.
    struct Untwinned;

    impl DensityField for Untwinned {
        fn validate(&self, _container: &Container) -> Result<(), Problem> {
            Ok(())
        }

        fn shader(&self) -> Cow<'static, str> {
            "density/uniform.wgsl".into()
        }

        fn build(&self, _gpu: &Gpu, _around: &Surroundings) -> Result<DeviceField> {
            Ok(DeviceField::new(self, Default::default()))
        }

        fn examples(_container: &Container, _folder: &Path) -> Result<Vec<Self>> {
            Ok(vec![Self])
        }
    }

    #[test]
    fn a_density_without_a_twin_is_refused_by_name() {
        let container = Container::Box {
            min_m: [0.0; 3],
            max_m: [1.0; 3],
        };
        let made = twin(&Untwinned, "untwinned", &container, 1.0, Filter::Exact);
        let error = made.err().expect("no twin").to_string();
        assert!(
            error.starts_with("scene, at /density: a density of kind `untwinned` has no f64 twin")
        );
    }
}
