//! Short movements of the camera or the sun, along which flicker is measured. For ghosting: [`super::CameraTrack`].

use super::{ImageSize, Scene};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A movement in [`Track::FRAMES`] frames; the first frame is the scene as it is.
///
/// The pan is the slowest in which every pixel sees new cloud in each frame. It carries the error's own pattern along, so
/// that even an error fixed to the cloud flickers: compare methods of like `rel_rmse`. Under the moving sun the picture
/// rests, and what flickers is the method. 1° of sun is four minutes of a day.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Track {
    /// The camera turns to its right about its own vertical, so that the centre of the picture moves by one pixel a
    /// frame.
    Pan,
    /// The sun rises by 1° in all; it sinks where it would pass the zenith.
    Sun,
}

impl Track {
    /// Every track.
    pub const ALL: [Self; 2] = [Self::Pan, Self::Sun];
    /// Frames of a track, the scene's own included.
    pub const FRAMES: u32 = 16;
    /// Sun elevation swept, degrees.
    const SWEEP_DEG: f64 = 1.0;

    /// Name in experiments and progress lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pan => "pan",
            Self::Sun => "sun",
        }
    }

    /// Turn of the camera or change of the sun's elevation from one frame to the next, degrees.
    pub fn step_deg(self, scene: &Scene, image: ImageSize) -> f64 {
        match self {
            Self::Pan => {
                let (_, half_y) = scene.camera.half_extent(1.0);
                (2.0 * half_y / f64::from(image.height)).atan().to_degrees()
            }
            Self::Sun => {
                let step_deg = Self::SWEEP_DEG / f64::from(Self::FRAMES - 1);
                let rises = scene.sun.elevation_deg + Self::SWEEP_DEG <= 90.0;
                if rises { step_deg } else { -step_deg }
            }
        }
    }

    /// The scene at a frame, 0…[`Track::FRAMES`] − 1.
    pub fn scene(self, scene: &Scene, image: ImageSize, frame: u32) -> Scene {
        let mut moved = scene.clone();
        if frame == 0 {
            return moved;
        }
        let angle_deg = f64::from(frame) * self.step_deg(scene, image);
        match self {
            Self::Sun => moved.sun.elevation_deg += angle_deg,
            Self::Pan => {
                let (right, up, forward) = scene.camera.basis();
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
    fn a_track_starts_at_the_scene_itself() {
        let still = scene(30.0);
        for track in Track::ALL {
            assert_eq!(track.scene(&still, IMAGE, 0), still);
        }
    }
}
