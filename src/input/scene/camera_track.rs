//! Short movements of the camera, along which ghosting is measured. For flicker: [`Track`].

use super::{ImageSize, Scene, Track};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A movement of the camera in [`Track::FRAMES`] frames; the first frame is the scene as it is.
///
/// On a pan what is seen moves alike at every distance, so that depth plays no part in where it was. On a dolly near cloud
/// moves more than far cloud, and uncovers it. This dolly goes by pixels, [`Track::Dolly`] by texels of a map.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum CameraTrack {
    /// The camera turns as on [`Track::Pan`]: the centre of the picture moves by one pixel a frame.
    Pan,
    /// The camera moves to its right and keeps its direction, so that a point of the optical axis moves by one pixel a
    /// frame: the middle of the axis' first stretch inside the container, or `target_m` where the axis misses it.
    Dolly,
}

impl CameraTrack {
    /// Every track.
    pub const ALL: [Self; 2] = [Self::Pan, Self::Dolly];

    /// Name in experiments, records and progress lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pan => "pan",
            Self::Dolly => "dolly",
        }
    }

    /// Turn of the camera from one frame to the next, degrees; `None` where it does not turn.
    pub fn step_deg(self, scene: &Scene, image: ImageSize) -> Option<f64> {
        match self {
            Self::Pan => Track::Pan.step_deg(scene, image),
            Self::Dolly => None,
        }
    }

    /// Distance the camera moves from one frame to the next, metres; `None` where it stays.
    pub fn step_m(self, scene: &Scene, image: ImageSize) -> Option<f64> {
        match self {
            Self::Pan => None,
            Self::Dolly => Some(dolly_step_m(scene, image)),
        }
    }

    /// The scene at a frame, 0…[`Track::FRAMES`] − 1.
    pub fn scene(self, scene: &Scene, image: ImageSize, frame: u32) -> Scene {
        if self == Self::Pan {
            return Track::Pan.scene(scene, image, frame);
        }
        let mut moved = scene.clone();
        let (right, ..) = scene.camera.basis();
        let way_m = right * (f64::from(frame) * dolly_step_m(scene, image));
        moved.camera.shift(way_m);
        moved
    }
}

/// Edge of a pixel, metres, at the distance of the point that moves by one pixel a frame.
fn dolly_step_m(scene: &Scene, image: ImageSize) -> f64 {
    let camera = &scene.camera;
    let (_, half_y) = camera.half_extent(1.0);
    let (_, _, forward) = camera.basis();
    let position_m = DVec3::from(camera.position_m);
    let far_m = camera.far_m.unwrap_or(f64::INFINITY);
    let stretches = scene.container.intervals(position_m, forward, 0.0, far_m);
    let inside = stretches.into_iter().find(|(start, end)| end > start);
    let distance_m = match inside {
        Some((start_m, end_m)) => (start_m + end_m) / 2.0,
        None => position_m.distance(camera.target_m.into()),
    };
    distance_m * 2.0 * half_y / f64::from(image.height)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    const IMAGE: ImageSize = ImageSize {
        width: 160,
        height: 90,
    };

    fn scene(target_m: [f64; 3]) -> Scene {
        let value = json!({
            "name": "slab",
            "container": {"box": {"min_m": [0, 0, 0], "max_m": [100, 50, 100]}},
            "density": {"uniform": {"value": 1}},
            "medium": {},
            "sun": {"elevation_deg": 60, "azimuth_deg": 0, "irradiance": [1, 1, 1]},
            "camera": {"position_m": [50, 25, -300], "target_m": target_m, "fov_y_deg": 40}
        });
        serde_json::from_value(value).unwrap()
    }

    /// Column at which a scene's camera sees a point.
    fn column(scene: &Scene, point_m: DVec3) -> f64 {
        let (right, _, forward) = scene.camera.basis();
        let (half_x, _) = scene.camera.half_extent(160.0 / 90.0);
        let p = point_m - DVec3::from(scene.camera.position_m);
        (1.0 + p.dot(right) / p.dot(forward) / half_x) * 80.0
    }

    #[test]
    fn the_dolly_moves_the_middle_of_the_layer_by_one_pixel_and_nearer_points_more() {
        let still = scene([50.0, 25.0, 0.0]);
        let moved = CameraTrack::Dolly.scene(&still, IMAGE, 3);
        moved.validate().unwrap();
        let shift = |z| {
            let point_m = DVec3::new(50.0, 25.0, z);
            column(&still, point_m) - column(&moved, point_m)
        };
        assert!((shift(50.0) - 3.0).abs() < 1e-9, "{}", shift(50.0));
        assert!(shift(0.0) > 3.3 && shift(100.0) < 2.7);
        let (old, new) = (still.camera.basis(), moved.camera.basis());
        assert!((old.2 - new.2).length() < 1e-12 && (old.1 - new.1).length() < 1e-12);
    }

    #[test]
    fn past_the_container_the_target_moves_by_one_pixel() {
        let still = scene([250.0, 25.0, -300.0]);
        let moved = CameraTrack::Dolly.scene(&still, IMAGE, 1);
        let target_m = still.camera.target_m.into();
        let shift = column(&still, target_m) - column(&moved, target_m);
        assert!((shift - 1.0).abs() < 1e-9, "{shift}");
    }

    #[test]
    fn a_track_starts_at_the_scene_itself_and_has_one_step() {
        let still = scene([50.0, 25.0, 0.0]);
        for track in CameraTrack::ALL {
            assert_eq!(track.scene(&still, IMAGE, 0), still);
            assert_eq!(json!(track), json!(track.name()));
            let (turn, shift) = (track.step_deg(&still, IMAGE), track.step_m(&still, IMAGE));
            assert!(turn.is_some() != shift.is_some());
        }
        let pan = CameraTrack::Pan.scene(&still, IMAGE, 5);
        assert_eq!(pan, Track::Pan.scene(&still, IMAGE, 5));
    }
}
