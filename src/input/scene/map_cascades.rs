//! Nested rectangles of a light map: points near the camera are read from a smaller rectangle, whose texels are finer.

use super::{ImageSize, MapFit, MapRectangle, Scene};
use glam::DVec3;

/// Extent of a map and distribution of its texels over it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapCoverage {
    /// How each rectangle is laid around what it has to answer for.
    pub fit: MapFit,
    /// Rectangles, at least 1.
    pub cascades: u32,
    /// Reach of a rectangle over that of the next, in 0…1.
    pub ratio: f64,
}

/// The rectangles of a map, the nearest first. All share axes and depth.
#[derive(Clone, Debug, PartialEq)]
pub struct MapCascades {
    rectangles: Vec<MapRectangle>,
    /// Distance from the camera up to which each is asked, metres; the last one's is infinite.
    reaches_m: Vec<f64>,
    camera_m: DVec3,
}

/// A place in a map, and how much it counts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MapPlace {
    /// Index of the rectangle.
    pub cascade: usize,
    /// Map coordinates in it, 0…1.
    pub uv: [f64; 2],
    /// Weight of what is read there, 0…1.
    pub share: f64,
}

impl MapCascades {
    /// Share of its reach over which a rectangle is mixed with the next one.
    const BLEND_SHARE: f64 = 0.1;

    /// The rectangles for what the camera sees of the layer, between the distances `near` and `far`: rectangle i of n
    /// reaches near + (far − near)·ratio^(n − 1 − i), so that each holds the one before it and none is empty.
    pub fn new(scene: &Scene, image: ImageSize, resolution: u32, coverage: MapCoverage) -> Self {
        let last = coverage.cascades.max(1) - 1;
        let [near_m, far_m] = MapRectangle::seen_range_m(scene, image).unwrap_or_default();
        let reach_m = |i: u32| near_m + (far_m - near_m) * coverage.ratio.powi((last - i) as i32);
        let nearer = |i: u32| {
            let mut nearer = scene.clone();
            nearer.camera.far_m = Some(reach_m(i));
            MapRectangle::fit(&nearer, image, resolution, coverage.fit)
        };
        let whole = MapRectangle::fit(scene, image, resolution, coverage.fit);
        let mut rectangles: Vec<_> = (0..last).map(nearer).chain([whole]).collect();
        let depths_m = rectangles.iter().map(|r| r.depth_m);
        let depth_m = depths_m.fold(0.0, f64::max);
        for rectangle in &mut rectangles {
            rectangle.depth_m = depth_m;
        }
        Self {
            rectangles,
            reaches_m: (0..last).map(reach_m).chain([f64::INFINITY]).collect(),
            camera_m: scene.camera.position_m.into(),
        }
    }

    /// The rectangles, the nearest first; at least one.
    pub fn rectangles(&self) -> &[MapRectangle] {
        &self.rectangles
    }

    /// Distance from the camera up to which each rectangle is asked, metres; the last one's is infinite.
    pub fn reaches_m(&self) -> &[f64] {
        &self.reaches_m
    }

    /// Longest column of all rectangles, metres.
    pub fn depth_m(&self) -> f64 {
        self.rectangles[0].depth_m
    }

    /// Where the map answers for a point; `None` outside of all rectangles. The shares add up to 1; that of the second
    /// place is 0 where one rectangle answers alone.
    pub fn places(&self, p: DVec3) -> Option<[MapPlace; 2]> {
        let away_m = p.distance(self.camera_m);
        let place = |cascade: usize| {
            let uv = self.rectangles.get(cascade)?.uv(p)?;
            Some(MapPlace {
                cascade,
                uv,
                share: 0.0,
            })
        };
        let reached = |i: &usize| away_m < self.reaches_m[*i];
        let mut near = (0..self.rectangles.len()).filter(reached).find_map(place)?;
        let reach_m = self.reaches_m[near.cascade];
        let passed = (away_m - reach_m) / (Self::BLEND_SHARE * reach_m) + 1.0;
        let next = place(near.cascade + 1);
        let share = next.map_or(0.0, |_| passed.clamp(0.0, 1.0));
        near.share = 1.0 - share;
        let next = next.unwrap_or_default();
        Some([near, MapPlace { share, ..next }])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const IMAGE: ImageSize = ImageSize {
        width: 160,
        height: 90,
    };

    fn cumulus() -> Scene {
        let text = include_str!("../../../configs/scenes/cumulus.json");
        serde_json::from_str(text).unwrap()
    }

    fn cascades(scene: &Scene, cascades: u32) -> MapCascades {
        let coverage = MapCoverage {
            fit: MapFit::Axes,
            cascades,
            ratio: 0.3,
        };
        MapCascades::new(scene, IMAGE, 256, coverage)
    }

    #[test]
    fn one_cascade_is_the_rectangle_itself() {
        let scene = cumulus();
        let one = cascades(&scene, 1);
        let whole = MapRectangle::fit(&scene, IMAGE, 256, MapFit::Axes);
        assert_eq!(one.rectangles(), [whole]);
    }

    #[test]
    fn each_cascade_reaches_farther_and_covers_more_than_the_one_before() {
        let scene = cumulus();
        let four = cascades(&scene, 4);
        let area = |r: &MapRectangle| r.extent_m[0] * r.extent_m[1];
        for (near, far) in four.rectangles().iter().zip(&four.rectangles()[1..]) {
            assert!(area(near) < 0.7 * area(far));
        }
        assert!(four.reaches_m().windows(2).all(|two| two[0] < two[1]));
    }

    /// Points in front of the camera, from the layer's near side on.
    fn seen(scene: &Scene) -> impl Iterator<Item = DVec3> {
        let [near_m, far_m] = MapRectangle::seen_range_m(scene, IMAGE).unwrap();
        let (_, _, forward) = scene.camera.basis();
        let camera_m = DVec3::from(scene.camera.position_m);
        (0..2000)
            .map(move |k| camera_m + forward * (near_m + (far_m - near_m) * f64::from(k) / 2000.0))
    }

    #[test]
    fn shares_add_up_and_change_without_a_jump() {
        let scene = cumulus();
        let three = cascades(&scene, 3);
        let mut before: Option<[f64; 3]> = None;
        let mut mixed = 0;
        for p in seen(&scene) {
            let Some(places) = three.places(p) else {
                before = None;
                continue;
            };
            let mut shares = [0.0; 3];
            for place in places {
                shares[place.cascade] += place.share;
            }
            assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            mixed += u32::from(shares.iter().all(|s| *s < 1.0));
            if let Some(before) = before.replace(shares) {
                let jump = |i: usize| (shares[i] - before[i]).abs();
                assert!((0..3).all(|i| jump(i) < 0.15), "{before:?} {shares:?}");
            }
        }
        assert!(mixed > 20, "{mixed}");
    }
}
