//! Reprojection on a device. Two pictures are used in turn: a frame reads one and writes the other, without copies.

use super::Reprojection;
use crate::error::Result;
use crate::gpu::{Gpu, Inputs, UniformValue};
use crate::raymarch::{AfterPass, DeviceSequence, Frames};
use crate::scene::{Camera, ImageSize, Pattern};
use crate::shader_defs::Defs;
use glam::{DMat3, DVec3};

/// Pictures used in turn.
const PICTURES: usize = 2;

/// A sequence whose frames reproject the pixels they do not march from the previous picture.
pub(super) struct DeviceReprojection {
    image: ImageSize,
    frames: Frames,
}

impl DeviceReprojection {
    /// A new sequence, without history.
    pub fn new(gpu: &Gpu, image: ImageSize, pattern: Pattern) -> Result<Self> {
        let frames = Frames::new(gpu, image, pattern, PICTURES, true)?;
        Ok(Self { image, frames })
    }
}

impl DeviceSequence for DeviceReprojection {
    fn frames(&self) -> &Frames {
        &self.frames
    }

    fn passes(&self) -> Vec<AfterPass> {
        vec![AfterPass {
            entry: Reprojection::SHADER,
            defs: Defs::new(),
            threads: [self.image.width, self.image.height],
        }]
    }

    fn inputs(&self, camera: &Camera) -> Inputs {
        let before = self.frames.camera_before();
        let mut motion = motion(before.as_ref().unwrap_or(camera), camera, self.image);
        motion.push(("remembers", UniformValue::U32(before.is_some().into())));
        let mut inputs = Inputs::default();
        inputs.uniform("motion", motion);
        if let Some(picture) = self.frames.before() {
            picture.offer(&mut inputs, ["radiance_in", "sun_in", "inverse_depth_in"]);
        }
        inputs
    }
}

/// Matrix A of the directions A·(x, y, 1) of the rays through the points (x, y) of a picture, in pixels; their
/// component along the optical axis is 1.
fn rays(camera: &Camera, image: ImageSize) -> DMat3 {
    let (width, height) = (f64::from(image.width), f64::from(image.height));
    let (right, up, forward) = camera.basis();
    let (half_x, half_y) = camera.half_extent(width / height);
    let (right, up) = (right * half_x, up * half_y);
    DMat3::from_cols(
        right * (2.0 / width),
        up * (-2.0 / height),
        forward - right + up,
    )
}

/// H = A'⁻¹A and e = A'⁻¹(C − C'): a point of depth d behind (x, y) in the picture of camera C, A lies at
/// H·(x, y, 1) + e/d, homogeneous, in that of C', A'. Members of `Motion` in `shaders/reconstruct/temporal.wgsl`.
fn motion(before: &Camera, now: &Camera, image: ImageSize) -> Vec<(&'static str, UniformValue)> {
    let to_before = rays(before, image).inverse();
    let turn = to_before * rays(now, image);
    let shift = to_before * (DVec3::from(now.position_m) - DVec3::from(before.position_m));
    let vector = |v: DVec3| UniformValue::Vec3(v.as_vec3().into());
    vec![
        ("turn_x", vector(turn.x_axis)),
        ("turn_y", vector(turn.y_axis)),
        ("turn_w", vector(turn.z_axis)),
        ("shift", vector(shift)),
        ("size", UniformValue::UVec2([image.width, image.height])),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    const IMAGE: ImageSize = ImageSize {
        width: 160,
        height: 90,
    };

    fn camera(position_m: [f64; 3], target_m: [f64; 3]) -> Camera {
        Camera {
            position_m,
            target_m,
            up: [0.1, 1.0, 0.0],
            fov_y_deg: 40.0,
            far_m: None,
        }
    }

    /// Pixel and depth of a point, from the camera's definition.
    fn project(camera: &Camera, point: DVec3) -> (DVec3, f64) {
        let (right, up, forward) = camera.basis();
        let (half_x, half_y) = camera.half_extent(160.0 / 90.0);
        let p = point - DVec3::from(camera.position_m);
        let depth = p.dot(forward);
        let x = (1.0 + p.dot(right) / depth / half_x) * 80.0;
        let y = (1.0 - p.dot(up) / depth / half_y) * 45.0;
        (DVec3::new(x, y, 1.0), depth)
    }

    fn member(motion: &[(&str, UniformValue)], name: &str) -> DVec3 {
        let value = motion.iter().find(|(n, _)| *n == name).map(|(_, v)| *v);
        match value {
            Some(UniformValue::Vec3(v)) => DVec3::from(v.map(f64::from)),
            other => panic!("{name}: {other:?}"),
        }
    }

    #[test]
    fn a_point_is_found_again_from_where_the_camera_was() {
        let before = camera([10.0, 50.0, -900.0], [0.0, 80.0, 0.0]);
        let now = camera([40.0, 20.0, -870.0], [30.0, 60.0, 10.0]);
        let motion = motion(&before, &now, IMAGE);
        for point in [[0.0, 0.0, 0.0], [200.0, 90.0, 300.0], [-150.0, 20.0, 40.0]] {
            let (pixel, depth) = project(&now, point.into());
            let (expected, depth_before) = project(&before, point.into());
            let far = member(&motion, "turn_x") * pixel.x
                + member(&motion, "turn_y") * pixel.y
                + member(&motion, "turn_w");
            let found = far + member(&motion, "shift") / depth;
            assert!((found / found.z - expected).length() < 1e-3, "{found}");
            assert!((found.z * depth / depth_before - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn a_camera_at_rest_moves_no_pixel_by_a_bit() {
        let image = ImageSize {
            width: 8192,
            height: 8191,
        };
        let still = camera([1e7, 2.0, -3e6], [1e7 + 1.0, 3.0, -3e6]);
        let motion = motion(&still, &still, image);
        let turn = ["turn_x", "turn_y", "turn_w"].map(|n| member(&motion, n).as_vec3());
        assert_eq!(member(&motion, "shift"), DVec3::ZERO);
        for pixel in [[0.5_f32, 0.5], [8191.5, 8190.5], [17.5, 4000.5]] {
            let found = turn[0] * pixel[0] + turn[1] * pixel[1] + turn[2];
            let rounded = [found.x, found.y].map(|v| (v / found.z * 256.0).round() / 256.0);
            assert_eq!(rounded, pixel);
        }
    }
}
