//! Placement of a light map: the rectangle perpendicular to the sun that covers what the camera sees.

use super::{Container, ImageSize, Scene};
use glam::DVec3;

/// The rectangle of a map in the plane perpendicular to the sun.
#[derive(Clone, Debug, PartialEq)]
pub struct MapRectangle {
    /// Unit axes of the plane.
    pub u_axis: DVec3,
    /// See `u_axis`.
    pub v_axis: DVec3,
    /// (p·u, p·v) of the corner of texel (0, 0), metres.
    pub origin_m: [f64; 2],
    /// Edge, metres.
    pub extent_m: f64,
    /// Longest column, metres; 0 when no ray cast through the view meets the layer.
    pub depth_m: f64,
}

/// Rays cast through the picture along x and y, edges included, to find the visible part of the layer.
const RAYS: [i32; 2] = [48, 32];
/// Scale of the rectangle: the visible region bulges between the rays.
const MARGIN: f64 = 1.02;

impl MapRectangle {
    /// The rectangle for what the camera sees of the layer. Its size moves in steps of 2^¼ and its corner in whole
    /// texels, so that a moving camera does not make the map swim.
    pub fn fit(scene: &Scene, image: ImageSize, resolution: u32) -> Self {
        let sun = scene.sun.direction();
        let helper = if sun.y.abs() > 0.9 {
            DVec3::X
        } else {
            DVec3::Y
        };
        let u_axis = helper.cross(sun).normalize();
        let v_axis = sun.cross(u_axis);
        let Some((low, high)) = seen_bounds(scene, image, u_axis, v_axis) else {
            return Self {
                u_axis,
                v_axis,
                // Far away: light at points that the rays missed falls back to a counted march.
                origin_m: [1e30; 2],
                extent_m: 1.0,
                depth_m: 0.0,
            };
        };
        let r = f64::from(resolution);
        // Snapping the corner down costs up to one texel. Few texels leave no room for that: they stay unsnapped.
        let snaps = resolution > 4;
        let room = if snaps { r / (r - 2.0) } else { 1.0 };
        let needed = (high[0] - low[0]).max(high[1] - low[1]).max(1e-9) * MARGIN * room;
        let extent_m = 2f64.powf((needed.log2() * 4.0).ceil() / 4.0);
        let texel_m = extent_m / r;
        let origin_m = [0, 1].map(|i| {
            let centred_m = (low[i] + high[i] - extent_m) / 2.0;
            if snaps {
                (centred_m / texel_m).floor() * texel_m
            } else {
                centred_m
            }
        });
        let far = origin_m.map(|o| o + extent_m);
        let depth_m = scene
            .container
            .longest_column_m(sun, u_axis, v_axis, origin_m, far);
        // Columns are measured in f32 on the device: keep d/depth_m at or below 1.
        Self {
            u_axis,
            v_axis,
            origin_m,
            extent_m,
            depth_m: depth_m * (1.0 + 1e-6),
        }
    }
}

/// Bounds of (p·u, p·v) over the ends of the view's intervals inside the layer.
fn seen_bounds(
    scene: &Scene,
    image: ImageSize,
    u: DVec3,
    v: DVec3,
) -> Option<([f64; 2], [f64; 2])> {
    let position = DVec3::from(scene.camera.position_m);
    let (right, up, forward) = scene.camera.basis();
    let (half_x, half_y) = scene
        .camera
        .half_extent(f64::from(image.width) / f64::from(image.height));
    let far_m = scene.camera.far_m.unwrap_or(1e30);
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let mut include = |p: DVec3| {
        for (i, value) in [p.dot(u), p.dot(v)].into_iter().enumerate() {
            low[i] = low[i].min(value);
            high[i] = high[i].max(value);
        }
    };
    for j in 0..=RAYS[1] {
        for i in 0..=RAYS[0] {
            let x = 2.0 * f64::from(i) / f64::from(RAYS[0]) - 1.0;
            let y = 2.0 * f64::from(j) / f64::from(RAYS[1]) - 1.0;
            let direction = (forward + right * (x * half_x) + up * (y * half_y)).normalize();
            for (start, end) in scene.container.intervals(position, direction, 0.0, far_m) {
                if end > start {
                    include(position + direction * start);
                    include(position + direction * end);
                }
            }
        }
    }
    if low[0] > high[0] {
        return None;
    }
    if let Container::Box { min_m, max_m } = scene.container {
        clip_to_box(&mut low, &mut high, min_m, max_m, u, v);
    }
    Some((low, high))
}

/// Clips the bounds to the box's projection along the sun: columns outside of it are empty.
fn clip_to_box(
    low: &mut [f64; 2],
    high: &mut [f64; 2],
    min_m: [f64; 3],
    max_m: [f64; 3],
    u: DVec3,
    v: DVec3,
) {
    for (i, axis) in [u, v].into_iter().enumerate() {
        let corner = |largest: bool| -> f64 {
            (0..3)
                .map(|k| {
                    if (axis[k] > 0.0) == largest {
                        axis[k] * max_m[k]
                    } else {
                        axis[k] * min_m[k]
                    }
                })
                .sum()
        };
        low[i] = low[i].max(corner(false));
        high[i] = high[i].min(corner(true));
    }
}
