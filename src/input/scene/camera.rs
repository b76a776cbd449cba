//! The camera: a pinhole with one ray through each pixel centre.

use super::{MAX_MAGNITUDE, Problem, check, check_all};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A perspective camera; image +x = forward × up, row 0 at the top.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Position, metres.
    pub position_m: [f64; 3],
    /// A point on the optical axis, metres.
    pub target_m: [f64; 3],
    /// Up vector, any length.
    #[serde(default = "default_up")]
    pub up: [f64; 3],
    /// Vertical field of view, degrees, 0.1…170.
    pub fov_y_deg: f64,
    /// View rays end here, metres; absent = they end where the layer or the ground does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub far_m: Option<f64>,
}

fn default_up() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}

impl Camera {
    pub(super) fn validate(&self) -> Result<(), Problem> {
        check_all("/camera/position_m", &self.position_m, "finite", |v| {
            v.abs() <= 1e9
        })?;
        check_all("/camera/target_m", &self.target_m, "finite", |v| {
            v.abs() <= 1e9
        })?;
        check_all("/camera/up", &self.up, "finite", |_| true)?;
        check("/camera/fov_y_deg", self.fov_y_deg, "0.1…170°", |v| {
            (0.1..=170.0).contains(&v)
        })?;
        if let Some(far_m) = self.far_m {
            check("/camera/far_m", far_m, "1e-9…1e12 m", |v| {
                (1e-9..=MAX_MAGNITUDE).contains(&v)
            })?;
        }
        let (forward, up) = (self.forward(), unit(DVec3::from(self.up)));
        if forward == DVec3::ZERO || up == DVec3::ZERO || forward.cross(up).length() < 1e-9 {
            return Err(Problem::new(
                "/camera/up",
                "up is parallel to the view direction, or the target is the position",
            ));
        }
        Ok(())
    }

    /// Orthonormal (right, up, forward).
    pub fn basis(&self) -> (DVec3, DVec3, DVec3) {
        let forward = self.forward();
        let right = unit(forward.cross(unit(DVec3::from(self.up))));
        (right, right.cross(forward), forward)
    }

    /// Moves the camera and keeps its direction.
    pub(super) fn shift(&mut self, way_m: DVec3) {
        for point_m in [&mut self.position_m, &mut self.target_m] {
            *point_m = (DVec3::from(*point_m) + way_m).into();
        }
    }

    fn forward(&self) -> DVec3 {
        unit(DVec3::from(self.target_m) - DVec3::from(self.position_m))
    }

    /// Half of the image plane's extent at distance 1: (horizontal, vertical).
    pub fn half_extent(&self, aspect: f64) -> (f64, f64) {
        let half_y = (self.fov_y_deg.to_radians() / 2.0).tan();
        (half_y * aspect, half_y)
    }
}

/// The unit vector along `v` whatever its length, even where its square leaves the range of f64; 0 for 0.
fn unit(v: DVec3) -> DVec3 {
    let largest = v.abs().max_element();
    let scaled = v / largest;
    if scaled.is_finite() {
        scaled.normalize_or_zero()
    } else {
        DVec3::ZERO
    }
}

/// Image size in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImageSize {
    /// Columns.
    #[schemars(range(min = 1))]
    pub width: u32,
    /// Rows.
    #[schemars(range(min = 1))]
    pub height: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(target_m: [f64; 3], up: [f64; 3]) -> Camera {
        Camera {
            position_m: [0.0; 3],
            target_m,
            up,
            fov_y_deg: 40.0,
            far_m: None,
        }
    }

    #[test]
    fn directions_of_any_length_give_a_basis_or_an_error() {
        for up in [1e-320, 1e-200, 1.0, 1e200, f64::MAX] {
            for ahead in [1e-300, 1.0, 1e9] {
                let camera = camera([ahead, 0.0, 0.0], [0.0, up, 0.0]);
                match camera.validate() {
                    Ok(()) => assert_eq!(
                        camera.basis(),
                        (DVec3::Z, DVec3::Y, DVec3::X),
                        "up {up:e}, ahead {ahead:e}"
                    ),
                    Err(_) => assert!(up < 1e-300, "up {up:e}, ahead {ahead:e}"),
                }
            }
        }
        for parallel in [1e-300, 1.0, 1e300] {
            assert!(
                camera([1.0, 0.0, 0.0], [parallel, 0.0, 0.0])
                    .validate()
                    .is_err()
            );
        }
    }
}
