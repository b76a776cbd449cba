//! Placement of a light map: the rectangle perpendicular to the sun that covers what the camera sees, and the texels in it.

use super::{Container, ImageSize, MapWarp, Scene};
use glam::DVec3;

/// How the rectangle of a map is laid around what the view sees of the layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MapFit {
    /// A square of the larger of the two extents.
    Square,
    /// One extent an axis.
    Axes,
    /// One extent an axis, texels denser where the view takes its samples: density to this power in 0…1. See [`MapWarp`].
    Warped(f64),
}

/// The rectangle of a map in the plane perpendicular to the sun.
#[derive(Clone, Debug, PartialEq)]
pub struct MapRectangle {
    /// Unit axes of the plane.
    pub u_axis: DVec3,
    /// See `u_axis`.
    pub v_axis: DVec3,
    /// (p·u, p·v) of the corner of texel (0, 0), metres.
    pub origin_m: [f64; 2],
    /// Edges along both axes, metres.
    pub extent_m: [f64; 2],
    /// Longest column, metres; 0 when no ray cast through the view meets the layer.
    pub depth_m: f64,
    /// Texels of unequal size; `None` = equal.
    pub warp: Option<MapWarp>,
}

/// Rays cast through the picture along x and y, edges included, to find the visible part of the layer.
const RAYS: [u32; 2] = [48, 32];
/// Rays, and samples on each, that stand for the view's samples.
const WARP_RAYS: [u32; 2] = [96, 64];
const WARP_SAMPLES: u32 = 64;
/// Scale of the rectangle: the visible region bulges between the rays.
const MARGIN: f64 = 1.02;

impl MapRectangle {
    /// The rectangle for what the camera sees of the layer. Where texels are equal, its size moves in steps of 2^¼ and its
    /// corner in whole texels, so that a moving camera does not make the map swim.
    pub fn fit(scene: &Scene, image: ImageSize, resolution: u32, fit: MapFit) -> Self {
        let (u_axis, v_axis) = axes(scene);
        let rays = ViewRays::new(scene, image);
        let Some((mut low, mut high)) = seen_bounds(scene, &rays, u_axis, v_axis) else {
            let warp = match fit {
                MapFit::Warped(_) => Some(MapWarp::new(&[], 0.0)),
                _ => None,
            };
            return Self {
                u_axis,
                v_axis,
                // Far away: light at points that the rays missed falls back to a counted march.
                origin_m: [1e30; 2],
                extent_m: [1.0; 2],
                depth_m: 0.0,
                warp,
            };
        };
        let samples: Vec<DVec3> = match fit {
            MapFit::Warped(_) => rays.samples(scene).collect(),
            MapFit::Square | MapFit::Axes => Vec::new(),
        };
        // Equal texels round the extents up, a warp does not.
        for p in &samples {
            for (i, value) in [p.dot(u_axis), p.dot(v_axis)].into_iter().enumerate() {
                low[i] = low[i].min(value);
                high[i] = high[i].max(value);
            }
        }
        let needed = [0, 1].map(|i| (high[i] - low[i]).max(1e-9) * MARGIN);
        let (origin_m, extent_m) = match fit {
            MapFit::Square => {
                let larger = needed[0].max(needed[1]);
                snapped(low, high, [larger; 2], resolution)
            }
            MapFit::Axes => snapped(low, high, needed, resolution),
            MapFit::Warped(_) => {
                let centred = |i: usize| (low[i] + high[i] - needed[i]) / 2.0;
                ([0, 1].map(centred), needed)
            }
        };
        let far = [0, 1].map(|i| origin_m[i] + extent_m[i]);
        let sun = scene.sun.direction();
        let depth_m = scene
            .container
            .longest_column_m(sun, u_axis, v_axis, origin_m, far);
        let mut rectangle = Self {
            u_axis,
            v_axis,
            origin_m,
            extent_m,
            // Columns are measured in f32 on the device: keep d/depth_m at or below 1.
            depth_m: depth_m * (1.0 + 1e-6),
            warp: None,
        };
        if let MapFit::Warped(exponent) = fit {
            let positions: Vec<_> = samples.iter().filter_map(|p| rectangle.uv(*p)).collect();
            rectangle.warp = Some(MapWarp::new(&positions, exponent));
        }
        rectangle
    }

    /// Least and largest distance from the camera at which the view meets the layer, metres; `None` where it does not.
    pub fn seen_range_m(scene: &Scene, image: ImageSize) -> Option<[f64; 2]> {
        let rays = ViewRays::new(scene, image);
        let intervals = rays.edges(scene).map(|(_, interval_m)| interval_m);
        intervals.fold(None, |range, (start_m, end_m)| match range {
            None => Some([start_m, end_m]),
            Some([near_m, far_m]) => Some([near_m.min(start_m), far_m.max(end_m)]),
        })
    }

    /// Map coordinates (u, v) of a point, in 0…1; `None` outside the rectangle.
    pub fn uv(&self, p: DVec3) -> Option<[f64; 2]> {
        let plane = [p.dot(self.u_axis), p.dot(self.v_axis)];
        let position = [0, 1].map(|i| (plane[i] - self.origin_m[i]) / self.extent_m[i]);
        let inside = position.iter().all(|x| (0.0..=1.0).contains(x));
        inside.then(|| match &self.warp {
            None => position,
            Some(warp) => warp.forward(position),
        })
    }

    /// A point of the column at map coordinates (u, v): the one whose component along the sun is 0.
    pub fn column_origin(&self, uv: [f64; 2]) -> DVec3 {
        let position = match &self.warp {
            None => uv,
            Some(warp) => warp.inverse(uv),
        };
        let plane = [0, 1].map(|i| self.origin_m[i] + position[i] * self.extent_m[i]);
        plane[0] * self.u_axis + plane[1] * self.v_axis
    }
}

/// u is horizontal and v points up along the plane. Both turn continuously with the sun, its azimuth at the zenith included.
fn axes(scene: &Scene) -> (DVec3, DVec3) {
    let sun = scene.sun.direction();
    let horizontal = DVec3::Y.cross(sun);
    let u_axis = match horizontal.length() > 1e-6 {
        true => horizontal.normalize(),
        false => {
            let azimuth = scene.sun.azimuth_deg.to_radians();
            DVec3::Y.cross(DVec3::new(azimuth.cos(), 0.0, azimuth.sin()))
        }
    };
    (u_axis, sun.cross(u_axis))
}

/// Origin and extents of a rectangle around `low`…`high` whose texels snap.
fn snapped(
    low: [f64; 2],
    high: [f64; 2],
    needed: [f64; 2],
    resolution: u32,
) -> ([f64; 2], [f64; 2]) {
    let r = f64::from(resolution);
    // Snapping the corner down costs up to one texel. Few texels leave no room for that: they stay unsnapped.
    let snaps = resolution > 4;
    let room = if snaps { r / (r - 2.0) } else { 1.0 };
    let extent_m = needed.map(|needed| 2f64.powf(((needed * room).log2() * 4.0).ceil() / 4.0));
    let origin_m = [0, 1].map(|i| {
        let centred_m = (low[i] + high[i] - extent_m[i]) / 2.0;
        let texel_m = extent_m[i] / r;
        match snaps {
            true => (centred_m / texel_m).floor() * texel_m,
            false => centred_m,
        }
    });
    (origin_m, extent_m)
}

/// Rays of a picture's image plane.
struct ViewRays {
    position: DVec3,
    basis: (DVec3, DVec3, DVec3),
    half: (f64, f64),
    far_m: f64,
}

impl ViewRays {
    fn new(scene: &Scene, image: ImageSize) -> Self {
        let aspect = f64::from(image.width) / f64::from(image.height);
        Self {
            position: scene.camera.position_m.into(),
            basis: scene.camera.basis(),
            half: scene.camera.half_extent(aspect),
            far_m: scene.camera.far_m.unwrap_or(1e30),
        }
    }

    /// Direction through (x, y) of the image plane, −1…1, y up.
    fn direction(&self, x: f64, y: f64) -> DVec3 {
        let (right, up, forward) = self.basis;
        (forward + right * (x * self.half.0) + up * (y * self.half.1)).normalize()
    }

    /// Directions of a grid of rays over the picture, its edges included, with their intervals inside the layer.
    fn edges<'a>(&'a self, scene: &'a Scene) -> impl Iterator<Item = (DVec3, (f64, f64))> + 'a {
        let place = |i: u32, n: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
        let rays = (0..=RAYS[1]).flat_map(move |j| (0..=RAYS[0]).map(move |i| (i, j)));
        let directions =
            rays.map(move |(i, j)| self.direction(place(i, RAYS[0]), place(j, RAYS[1])));
        directions.flat_map(move |direction| {
            let container = &scene.container;
            let intervals = container.intervals(self.position, direction, 0.0, self.far_m);
            let inside = intervals.into_iter().filter(|(start, end)| end > start);
            inside.map(move |interval| (direction, interval))
        })
    }

    /// Equally spaced samples inside the layer on rays through the middles of a grid over the picture: where a view march
    /// asks for light, were there cloud everywhere.
    fn samples<'a>(&'a self, scene: &'a Scene) -> impl Iterator<Item = DVec3> + 'a {
        let middle = |i: u32, n: u32| (2.0 * f64::from(i) + 1.0) / f64::from(n) - 1.0;
        let rays = (0..WARP_RAYS[1]).flat_map(move |j| (0..WARP_RAYS[0]).map(move |i| (i, j)));
        rays.flat_map(move |(i, j)| {
            let direction = self.direction(middle(i, WARP_RAYS[0]), middle(j, WARP_RAYS[1]));
            let intervals = scene
                .container
                .intervals(self.position, direction, 0.0, self.far_m);
            let length_m: f64 = intervals.iter().map(|(a, b)| (b - a).max(0.0)).sum();
            let samples = if length_m > 0.0 { WARP_SAMPLES } else { 0 };
            (0..samples).map(move |k| {
                let mut s = (f64::from(k) + 0.5) / f64::from(WARP_SAMPLES) * length_m;
                for (start, end) in intervals {
                    if end > start {
                        if s <= end - start {
                            return self.position + direction * (start + s);
                        }
                        s -= end - start;
                    }
                }
                self.position + direction * intervals[0].1
            })
        })
    }
}

/// Bounds of (p·u, p·v) over the ends of the view's intervals inside the layer.
fn seen_bounds(scene: &Scene, rays: &ViewRays, u: DVec3, v: DVec3) -> Option<([f64; 2], [f64; 2])> {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let mut include = |p: DVec3| {
        for (i, value) in [p.dot(u), p.dot(v)].into_iter().enumerate() {
            low[i] = low[i].min(value);
            high[i] = high[i].max(value);
        }
    };
    for (direction, (start, end)) in rays.edges(scene) {
        include(rays.position + direction * start);
        include(rays.position + direction * end);
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

#[cfg(test)]
mod tests {
    use super::*;

    const IMAGE: ImageSize = ImageSize {
        width: 160,
        height: 90,
    };

    fn cumulus(elevation_deg: f64) -> Scene {
        let text = include_str!("../../../configs/scenes/cumulus.json");
        let mut scene: Scene = serde_json::from_str(text).unwrap();
        scene.sun.elevation_deg = elevation_deg;
        scene
    }

    #[test]
    fn at_a_low_sun_one_extent_an_axis_is_a_fraction_of_the_square() {
        let scene = cumulus(5.0);
        let area = |fit| {
            let [u_m, v_m] = MapRectangle::fit(&scene, IMAGE, 256, fit).extent_m;
            u_m * v_m
        };
        let square = area(MapFit::Square);
        assert!(area(MapFit::Axes) < 0.25 * square);
        assert!(area(MapFit::Warped(0.5)) < 0.25 * square);
    }

    #[test]
    fn every_fit_covers_every_sample_of_the_view_and_finds_its_column_again() {
        for elevation_deg in [90.0, 60.0, 5.0] {
            let scene = cumulus(elevation_deg);
            let sun = scene.sun.direction();
            let rays = ViewRays::new(&scene, IMAGE);
            for fit in [MapFit::Square, MapFit::Axes, MapFit::Warped(1.0 / 3.0)] {
                let map = MapRectangle::fit(&scene, IMAGE, 256, fit);
                for p in rays.samples(&scene).step_by(97) {
                    let uv = map.uv(p).unwrap_or_else(|| panic!("{fit:?} misses {p}"));
                    let away = p - map.column_origin(uv);
                    let beside = away - sun * away.dot(sun);
                    assert!(
                        beside.length() < 1e-6 * map.extent_m[0],
                        "{fit:?}: {beside}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_warp_makes_texels_smaller_where_the_view_takes_its_samples() {
        let scene = cumulus(30.0);
        let rays = ViewRays::new(&scene, IMAGE);
        // Mean size of a texel along u, weighted as the view's samples.
        let texel_m = |fit| {
            let map = MapRectangle::fit(&scene, IMAGE, 256, fit);
            let sizes = rays.samples(&scene).step_by(53).filter_map(|p| {
                let [u, v] = map.uv(p)?;
                let step = 1e-4;
                let along = map.column_origin([u + step, v]) - map.column_origin([u, v]);
                Some(along.length() / step / 256.0)
            });
            let (sum, n) = sizes.fold((0.0, 0.0), |(sum, n), size| (sum + size, n + 1.0));
            sum / n
        };
        let (even, warped) = (texel_m(MapFit::Axes), texel_m(MapFit::Warped(1.0 / 3.0)));
        assert!(warped < 0.8 * even, "{warped} m, even {even} m");
    }

    #[test]
    fn the_axes_turn_continuously_with_the_sun() {
        let mut before: Option<DVec3> = None;
        for tenth in 0..=900 {
            let (u, v) = axes(&cumulus(f64::from(tenth) / 10.0));
            assert!(u.dot(v).abs() < 1e-12);
            if let Some(before) = before.replace(u) {
                assert!(before.dot(u) > 0.999, "{tenth}");
            }
        }
    }

    #[test]
    fn a_view_of_nothing_has_a_map_without_depth() {
        let mut scene = cumulus(30.0);
        scene.camera.target_m = scene.camera.position_m;
        scene.camera.target_m[1] -= 1.0;
        scene.camera.target_m[0] += 0.01;
        for fit in [MapFit::Square, MapFit::Axes, MapFit::Warped(0.5)] {
            let map = MapRectangle::fit(&scene, IMAGE, 256, fit);
            assert_eq!(map.depth_m, 0.0);
            assert_eq!(map.uv(DVec3::new(0.0, 2000.0, 0.0)), None);
        }
    }
}
