//! Short movements of the camera or the sun, along which flicker is measured. For ghosting: [`super::CameraTrack`].

use super::{ImageSize, MapFit, MapRectangle, Scene};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A movement in [`Track::FRAMES`] frames; the first frame is the scene as it is.
///
/// The pan is the slowest in which every pixel sees new cloud in each frame. It carries the error's own pattern along, so
/// that even an error fixed to the cloud flickers: compare methods of like `rel_rmse`. Under the moving sun the picture
/// rests, and what flickers is the method. 1° of sun is four minutes of a day. On the dolly a map follows the camera by a
/// texel a frame: texels that do not rest on the ground swim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Track {
    /// The camera turns to its right about its own vertical, so that the centre of the picture moves by one pixel a
    /// frame.
    Pan,
    /// The sun rises by 1° in all; it sinks where it would pass the zenith.
    Sun,
    /// The camera keeps its direction and its height and moves ahead and to its right alike, by one texel a frame: a
    /// texel of the map of 256² texels in the `square` fit that the scene's own frame has, whatever the method.
    Dolly,
}

impl Track {
    /// Every track.
    pub const ALL: [Self; 3] = [Self::Pan, Self::Sun, Self::Dolly];
    /// Frames of a track, the scene's own included.
    pub const FRAMES: u32 = 16;
    /// Sun elevation swept, degrees.
    const SWEEP_DEG: f64 = 1.0;
    /// Edge of the map whose texel a dolly moves by.
    const DOLLY_RESOLUTION: u32 = 256;

    /// Name in experiments and progress lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pan => "pan",
            Self::Sun => "sun",
            Self::Dolly => "dolly",
        }
    }

    /// Turn of the camera or change of the sun's elevation from one frame to the next, degrees; `None` where neither
    /// turns.
    pub fn step_deg(self, scene: &Scene, image: ImageSize) -> Option<f64> {
        match self {
            Self::Pan => {
                let (_, half_y) = scene.camera.half_extent(1.0);
                Some((2.0 * half_y / f64::from(image.height)).atan().to_degrees())
            }
            Self::Sun => {
                let step_deg = Self::SWEEP_DEG / f64::from(Self::FRAMES - 1);
                let rises = scene.sun.elevation_deg + Self::SWEEP_DEG <= 90.0;
                Some(if rises { step_deg } else { -step_deg })
            }
            Self::Dolly => None,
        }
    }

    /// Distance the camera moves from one frame to the next, metres; `None` where it stays.
    pub fn step_m(self, scene: &Scene, image: ImageSize) -> Option<f64> {
        let texel_m = || {
            let map = MapRectangle::fit(scene, image, Self::DOLLY_RESOLUTION, MapFit::Square);
            map.extent_m[0] / f64::from(Self::DOLLY_RESOLUTION)
        };
        (self == Self::Dolly).then(texel_m)
    }

    /// The scene at a frame, 0…[`Track::FRAMES`] − 1.
    pub fn scene(self, scene: &Scene, image: ImageSize, frame: u32) -> Scene {
        let mut moved = scene.clone();
        if frame == 0 {
            return moved;
        }
        let steps = f64::from(frame);
        let angle_deg = steps * self.step_deg(scene, image).unwrap_or(0.0);
        let way_m = steps * self.step_m(scene, image).unwrap_or(0.0);
        let (right, up, forward) = scene.camera.basis();
        match self {
            Self::Sun => moved.sun.elevation_deg += angle_deg,
            Self::Dolly => {
                let level = (forward + right).reject_from_normalized(DVec3::Y);
                moved.camera.shift(level.normalize_or(right) * way_m);
            }
            Self::Pan => {
                let position = DVec3::from(scene.camera.position_m);
                let distance_m = DVec3::from(scene.camera.target_m).distance(position);
                let (sine, cosine) = angle_deg.to_radians().sin_cos();
                let turned = forward * cosine + right * sine;
                moved.camera.target_m = (position + turned * distance_m).into();
                moved.camera.up = up.into();
            }
        }
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    const IMAGE: ImageSize = ImageSize {
        width: 160,
        height: 90,
    };

    fn scene(elevation_deg: f64) -> Scene {
        let value = json!({
            "name": "slab",
            "container": {"box": {"min_m": [0, 0, 0], "max_m": [100, 50, 100]}},
            "density": {"uniform": {"value": 1}},
            "medium": {},
            "sun": {"elevation_deg": elevation_deg, "azimuth_deg": 0, "irradiance": [1, 1, 1]},
            "camera": {"position_m": [0, 10, -300], "target_m": [50, 125, 50], "fov_y_deg": 40}
        });
        serde_json::from_value(value).unwrap()
    }

    #[test]
    fn the_pan_moves_the_centre_by_one_pixel_to_the_left_and_does_not_roll() {
        let still = scene(60.0);
        let (right, up, forward) = still.camera.basis();
        let (half_x, _) = still.camera.half_extent(160.0 / 90.0);
        let moved = Track::Pan.scene(&still, IMAGE, 1);
        moved.validate().unwrap();
        let (_, moved_up, moved_forward) = moved.camera.basis();
        let pixels = moved_forward.dot(right) / moved_forward.dot(forward) / half_x * 80.0;
        assert!((pixels - 1.0).abs() < 1e-9, "{pixels}");
        assert!((moved_up - up).length() < 1e-12);
        assert!(moved_forward.dot(up).abs() < 1e-12);
    }

    #[test]
    fn the_sun_sweeps_one_degree_and_stays_in_the_sky() {
        for (start, end) in [(0.5, 1.5), (60.0, 61.0), (89.5, 88.5)] {
            let still = scene(start);
            let last = Track::Sun.scene(&still, IMAGE, Track::FRAMES - 1);
            last.validate().unwrap();
            assert!((last.sun.elevation_deg - end).abs() < 1e-9);
        }
    }

    #[test]
    fn the_dolly_moves_the_ground_by_one_texel_ahead_and_sideways_alike() {
        let still = scene(60.0);
        let map = MapRectangle::fit(&still, IMAGE, 256, MapFit::Square);
        let moved = Track::Dolly.scene(&still, IMAGE, 3);
        moved.validate().unwrap();
        let way_m = DVec3::from(moved.camera.position_m) - DVec3::from(still.camera.position_m);
        assert_eq!(way_m.y, 0.0);
        let texels = way_m.length() / map.extent_m[0] * 256.0;
        assert!((texels - 3.0).abs() < 1e-9, "{texels}");
        let (right, _, forward) = still.camera.basis();
        assert!(way_m.dot(right) > 0.5 * way_m.length());
        assert!(way_m.dot(forward) > 0.3 * way_m.length());
        let turned = moved.camera.basis().2 - forward;
        assert!(turned.length() < 1e-12, "{turned}");
        // Seen from straight above, ahead is down: what is left is the way to the right.
        let mut above = still;
        above.camera.position_m = [50.0, 400.0, 50.0];
        above.camera.target_m = [50.0, 0.0, 50.0];
        above.camera.up = [0.0, 0.0, 1.0];
        let moved = Track::Dolly.scene(&above, IMAGE, 1);
        assert_eq!(moved.camera.position_m[1], 400.0);
        assert!(moved.camera.position_m[0] != 50.0);
    }

    #[test]
    fn a_track_starts_at_the_scene_itself_and_has_one_step() {
        let still = scene(30.0);
        for track in Track::ALL {
            assert_eq!(track.scene(&still, IMAGE, 0), still);
            assert_eq!(json!(track), json!(track.name()));
            let (turn, shift) = (track.step_deg(&still, IMAGE), track.step_m(&still, IMAGE));
            assert!(turn.is_some() != shift.is_some());
        }
    }
}
