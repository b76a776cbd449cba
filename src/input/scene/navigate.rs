//! Interactive navigation: cameras turned, orbited or moved, the sun dragged or advanced in time. A result that would
//! be invalid leaves the camera as it was.

use super::{Camera, Container, Scene, Sun};
use glam::{DQuat, DVec3};

/// Smallest angle between the view direction and up or down, degrees.
const POLE_DEG: f64 = 1.0;
/// Lowest elevation of the sun during a day, degrees.
const LOWEST_DEG: f64 = 1.0;
/// Rotation of the sun in an hour, degrees.
const DEG_AN_HOUR: f64 = 15.0;

impl Camera {
    /// Turns the view: the target moves round the position, to the right and up, degrees.
    pub fn turned(&self, right_deg: f64, up_deg: f64) -> Self {
        let (position, target) = self.ends();
        let ahead = self.swung(target - position, right_deg, up_deg);
        self.if_valid(position, position + ahead)
    }

    /// Orbits: the position moves round the target, to the right and up, degrees.
    pub fn orbited(&self, right_deg: f64, up_deg: f64) -> Self {
        let (position, target) = self.ends();
        let ahead = self.swung(target - position, -right_deg, -up_deg);
        self.if_valid(target - ahead, target)
    }

    /// Position and target moved by metres to the right, up and forward.
    pub fn moved(&self, [right_m, up_m, forward_m]: [f64; 3]) -> Self {
        let (position, target) = self.ends();
        let (right, up, forward) = self.basis();
        let by = right_m * right + up_m * up + forward_m * forward;
        self.if_valid(position + by, target + by)
    }

    fn ends(&self) -> (DVec3, DVec3) {
        (DVec3::from(self.position_m), DVec3::from(self.target_m))
    }

    /// `ahead` rotated about the up vector, then toward it, no nearer to up or down than [`POLE_DEG`].
    fn swung(&self, ahead: DVec3, right_deg: f64, up_deg: f64) -> DVec3 {
        let Some(pole) = DVec3::from(self.up).try_normalize() else {
            return ahead;
        };
        let ahead = DQuat::from_axis_angle(pole, -right_deg.to_radians()) * ahead;
        let from_pole = ahead.angle_between(pole);
        let poles = POLE_DEG.to_radians();
        let wanted = (from_pole - up_deg.to_radians()).clamp(poles, std::f64::consts::PI - poles);
        match ahead.cross(pole).try_normalize() {
            Some(right) => DQuat::from_axis_angle(right, from_pole - wanted) * ahead,
            None => ahead,
        }
    }

    fn if_valid(&self, position: DVec3, target: DVec3) -> Self {
        let camera = Self {
            position_m: position.into(),
            target_m: target.into(),
            ..self.clone()
        };
        if camera.validate().is_ok() {
            camera
        } else {
            self.clone()
        }
    }
}

impl Sun {
    /// The sun moved by degrees of azimuth and elevation; it stays above the horizon.
    pub fn dragged(&self, azimuth_deg: f64, elevation_deg: f64) -> Self {
        self.at(
            self.azimuth_deg + azimuth_deg,
            self.elevation_deg + elevation_deg,
        )
    }

    /// The sun some hours later: 15° an hour about the horizontal axis +z; after sunset it continues at the opposite
    /// sunrise.
    pub fn later(&self, hours: f64) -> Self {
        let angle = (DEG_AN_HOUR * hours).to_radians();
        let mut toward = DQuat::from_axis_angle(DVec3::Z, angle) * self.direction();
        let elevation = |v: DVec3| v.y.atan2(v.x.hypot(v.z)).to_degrees();
        if toward.x < 0.0 && elevation(toward) < LOWEST_DEG {
            toward.x = -toward.x;
        }
        self.at(
            toward.z.atan2(toward.x).to_degrees(),
            elevation(toward).max(LOWEST_DEG),
        )
    }

    fn at(&self, azimuth_deg: f64, elevation_deg: f64) -> Self {
        let sun = Self {
            azimuth_deg: (azimuth_deg + 180.0).rem_euclid(360.0) - 180.0,
            elevation_deg: elevation_deg.clamp(LOWEST_DEG.min(self.elevation_deg), 90.0),
            irradiance: self.irradiance,
        };
        if sun.azimuth_deg.is_finite() && sun.elevation_deg.is_finite() {
            sun
        } else {
            self.clone()
        }
    }
}

impl Scene {
    /// Distance to fly in a second, metres: a quarter of the layer's height, or of the box's diagonal.
    pub fn pace_m(&self) -> f64 {
        let extent_m = match &self.container {
            Container::Shell { base_m, top_m, .. } => top_m - base_m,
            Container::Box { min_m, max_m } => (DVec3::from(*max_m) - DVec3::from(*min_m)).length(),
        };
        extent_m / 4.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera {
            position_m: [0.0; 3],
            target_m: [100.0, 0.0, 0.0],
            up: [0.0, 1.0, 0.0],
            fov_y_deg: 45.0,
            far_m: None,
        }
    }

    fn sun(elevation_deg: f64, azimuth_deg: f64) -> Sun {
        Sun {
            elevation_deg,
            azimuth_deg,
            irradiance: None,
        }
    }

    fn near(a: [f64; 3], b: [f64; 3]) {
        let apart_m = (DVec3::from(a) - DVec3::from(b)).length();
        assert!(apart_m < 1e-9, "{a:?} is not {b:?}");
    }

    #[test]
    fn turning_keeps_the_position_and_goes_right_and_up() {
        let right = camera().turned(90.0, 0.0);
        near(right.position_m, [0.0; 3]);
        near(right.target_m, [0.0, 0.0, 100.0]);
        let up = camera().turned(0.0, 30.0);
        near(up.target_m, [100.0 * 0.75f64.sqrt(), 50.0, 0.0]);
    }

    #[test]
    fn orbiting_keeps_the_target_and_the_distance() {
        let right = camera().orbited(90.0, 0.0);
        near(right.target_m, [100.0, 0.0, 0.0]);
        near(right.position_m, [100.0, 0.0, 100.0]);
        let above = camera().orbited(0.0, 30.0);
        near(
            above.position_m,
            [100.0 - 100.0 * 0.75f64.sqrt(), 50.0, 0.0],
        );
    }

    #[test]
    fn moving_goes_along_the_picture() {
        let moved = camera().moved([1.0, 2.0, 3.0]);
        near(moved.position_m, [3.0, 2.0, 1.0]);
        near(moved.target_m, [103.0, 2.0, 1.0]);
    }

    #[test]
    fn no_way_leads_to_a_camera_that_is_not_valid() {
        let mut here = camera();
        for i in 0..200 {
            let by = f64::from(i) * 7.3;
            here = here.turned(by, 40.0).orbited(-by, -55.0).turned(3.0, by);
            assert!(here.validate().is_ok(), "{here:?}");
        }
        assert_eq!(camera().moved([0.0, 0.0, 1e10]), camera());
        assert_eq!(camera().moved([f64::NAN, 0.0, 0.0]), camera());
        assert_eq!(camera().turned(f64::INFINITY, 0.0), camera());
    }

    #[test]
    fn a_dragged_sun_stays_above_the_horizon() {
        for (elevation, by) in [(60.0, -200.0), (0.2, -5.0), (89.0, 10.0)] {
            let dragged = sun(elevation, 350.0).dragged(500.0, by);
            assert!(dragged.validate(true).is_ok(), "{dragged:?}");
        }
        assert_eq!(sun(40.0, 10.0).dragged(5.0, -3.0), sun(37.0, 15.0));
    }

    #[test]
    fn the_sun_rises_culminates_sets_and_rises_again() {
        let noon = sun(30.0, 0.0).later(4.0);
        assert!((noon.elevation_deg - 90.0).abs() < 1e-6, "{noon:?}");
        let sunrise = sun(3.0, 180.0).later(0.5);
        assert!(sunrise.azimuth_deg.abs() < 1e-6, "{sunrise:?}");
        assert!((sunrise.elevation_deg - LOWEST_DEG).abs() < 1e-3);
        let mut sun = sun(60.0, 110.0);
        for _ in 0..500 {
            sun = sun.later(0.13);
            assert!(sun.validate(true).is_ok(), "{sun:?}");
            assert!(sun.elevation_deg >= LOWEST_DEG - 1e-3, "{sun:?}");
        }
    }

    #[test]
    fn the_pace_follows_the_scene() {
        let container = Container::Box {
            min_m: [0.0; 3],
            max_m: [3.0, 0.0, 4.0],
        };
        let scene = Scene {
            container,
            ..crate::config::load_scene("configs/scenes/cumulus.json".as_ref()).unwrap()
        };
        assert_eq!(scene.pace_m(), 1.25);
    }
}
