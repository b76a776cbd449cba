//! Light columns of a scene: the one behind a pixel, and those of the map's rectangle.

use super::layer::{LayerRay, UNLIMITED_M};
use super::{LightColumn, Oracle};
use crate::scene::{MapFit, MapRectangle};
use glam::DVec3;

/// Samples along a view ray.
const SAMPLES: u32 = 4096;

impl Oracle {
    /// The point at which half of the light scattered along a pixel's ray has been scattered: the median of its σT,
    /// which always lies in cloud; on a ray that ends opaque, where T = ½. `None` where the ray meets no cloud.
    pub fn pixel_point(&self, column: u32, row: u32) -> Option<DVec3> {
        let ray = self.view_ray(self.direction(column, row));
        let step_m = ray.length_m() / f64::from(SAMPLES);
        let point = |k: u32| ray.point((f64::from(k) + 0.5) * step_m);
        let opacities = (0..SAMPLES).scan(0.0, |tau: &mut f64, k| {
            *tau += self.field.extinction_per_m(point(k)) * step_m;
            Some(-(-*tau).exp_m1())
        });
        let opacities: Vec<f64> = opacities.collect();
        let whole = opacities.last().copied().filter(|whole| *whole > 0.0)?;
        let half = opacities.iter().position(|o| *o >= 0.5 * whole)?;
        Some(point(half as u32))
    }

    /// The light column at map coordinates (u, v) in `[0, 1]²` of a map of `resolution` texels in this view, laid as `fit`
    /// says; the first texel is at (0, 0). `None` where it misses the layer.
    pub fn map_column(&self, uv: [f64; 2], resolution: u32, fit: MapFit) -> Option<LightColumn> {
        let map = MapRectangle::fit(&self.scene, self.image, resolution, fit);
        let column = self.column_through(map.column_origin(uv));
        (column.length_m() > 0.0).then_some(column)
    }

    /// d(p): metres inside the layer that sunlight travels before a point.
    pub fn light_depth_m(&self, p: DVec3) -> f64 {
        LayerRay::new(&self.scene.container, p, self.sun, (0.0, UNLIMITED_M)).length_m()
    }

    /// Size of a step of the scene's truth, metres.
    pub fn truth_step_m(&self) -> f64 {
        self.scene.truth_step_m()
    }
}
