//! A light map laid out on the screen: as it is stored or as it lies in the plane, and lines that show where its texels
//! are small.
//!
//! As stored, every texel has the same size and lines at equal distances in the plane crowd where texels are large. In
//! the plane the lines are boundaries of texels, and crowd where texels are small.

use crate::scene::MapRectangle;
use eframe::egui::{Color32, Mesh, Pos2, Rect, TextureId, Vec2, pos2, vec2};

/// How a map is laid out on the screen; v points downward in both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shape {
    /// A square of equal texels.
    #[default]
    Stored,
    /// The rectangle perpendicular to the sun, to scale.
    Plane,
}

/// Texels of a map in the plane are counted in this many parts along an axis.
const PARTS: u32 = 16;
/// Most lines at equal distances along the longer axis.
const MOST_LINES: u32 = 25;

impl Shape {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Stored, Self::Plane];

    /// Name of the choice.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stored => "As stored",
            Self::Plane => "In the plane",
        }
    }

    /// Help text of the choice.
    pub fn explained(self) -> &'static str {
        match self {
            Self::Stored => "A square of equal texels; lines at equal distances in the plane",
            Self::Plane => "Perpendicular to the sun, to scale; lines between texels",
        }
    }

    /// Size of the largest picture of a map that fits.
    pub fn size(self, map: &MapRectangle, room: Vec2) -> Vec2 {
        let [u_m, v_m] = match self {
            Self::Plane if map.depth_m > 0.0 => map.extent_m,
            _ => [1.0; 2],
        };
        let points = f64::from(room.x) / u_m;
        let points = points.min(f64::from(room.y) / v_m);
        let size = [u_m, v_m].map(|edge_m| ((edge_m * points) as f32).max(1.0));
        vec2(size[0], size[1]).min(room)
    }

    /// Map coordinates at shares of the picture's edges, both in 0…1.
    pub fn uv(self, map: &MapRectangle, share: [f64; 2]) -> [f64; 2] {
        match (self, &map.warp) {
            (Self::Plane, Some(warp)) => warp.forward(share),
            _ => share,
        }
    }

    /// The picture: the texture of the map as it is stored, at `rect`.
    pub fn mesh(self, map: &MapRectangle, texture: TextureId, rect: Rect) -> Mesh {
        let mut mesh = Mesh::with_texture(texture);
        let (Self::Plane, Some(warp)) = (self, &map.warp) else {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            mesh.add_rect_with_uv(rect, whole, Color32::WHITE);
            return mesh;
        };
        // Between two knots of the warp texels are equal.
        let [us, vs] = &warp.knots;
        let at = |i: usize, j: usize| {
            let share = |k: usize, knots: &[f64]| k as f32 / (knots.len() - 1) as f32;
            let corner = rect.lerp_inside(vec2(share(i, us), share(j, vs)));
            (corner, pos2(us[i] as f32, vs[j] as f32))
        };
        for j in 1..vs.len() {
            for i in 1..us.len() {
                let ((low, low_uv), (high, high_uv)) = (at(i - 1, j - 1), at(i, j));
                let (part, uv) = (between(low, high), between(low_uv, high_uv));
                mesh.add_rect_with_uv(part, uv, Color32::WHITE);
            }
        }
        mesh
    }

    /// Lines across both axes, as shares of the picture's edges, and what they mean.
    pub fn lines(self, map: &MapRectangle, resolution: u32) -> ([Vec<f64>; 2], String) {
        match self {
            Self::Plane => {
                let texels = resolution.div_ceil(PARTS).max(1);
                let lines = [0, 1].map(|axis| boundaries(map, axis, resolution, texels));
                let unit = if texels == 1 { "texel" } else { "texels" };
                (lines, format!("lines every {texels} {unit}"))
            }
            Self::Stored => {
                let larger_m = map.extent_m[0].max(map.extent_m[1]);
                let step_m = round_step(larger_m / f64::from(MOST_LINES));
                let lines = [0, 1].map(|axis| multiples(map, axis, step_m));
                (lines, format!("lines every {}", length(step_m)))
            }
        }
    }
}

fn between(low: Pos2, high: Pos2) -> Rect {
    Rect::from_min_max(low, high)
}

/// Boundaries of every `texels`-th texel inside the map, as shares of its extent.
fn boundaries(map: &MapRectangle, axis: usize, resolution: u32, texels: u32) -> Vec<f64> {
    let lines = (1..).map(|i| i * texels).take_while(|i| *i < resolution);
    let share = |i: u32| {
        let uv = [f64::from(i) / f64::from(resolution); 2];
        map.warp.as_ref().map_or(uv, |warp| warp.inverse(uv))[axis]
    };
    lines.map(share).collect()
}

/// Map coordinates of the multiples of a distance in the plane that lie inside the map.
fn multiples(map: &MapRectangle, axis: usize, step_m: f64) -> Vec<f64> {
    if map.depth_m <= 0.0 {
        return Vec::new();
    }
    let (origin_m, extent_m) = (map.origin_m[axis], map.extent_m[axis]);
    let first_m = (origin_m / step_m).ceil() * step_m;
    let positions =
        (0..=MOST_LINES).map(|i| (first_m + f64::from(i) * step_m - origin_m) / extent_m);
    let inside = positions.filter(|position| (0.0..=1.0).contains(position));
    let line = |position: f64| {
        let position = [position; 2];
        map.warp
            .as_ref()
            .map_or(position, |warp| warp.forward(position))[axis]
    };
    inside.map(line).collect()
}

/// The nearest of 1, 2 and 5 times a power of ten, not below `least`.
fn round_step(least: f64) -> f64 {
    let decade = 10f64.powf(least.log10().floor());
    let steps = [1.0, 2.0, 5.0].map(|factor| factor * decade);
    steps
        .into_iter()
        .find(|step| *step >= least)
        .unwrap_or(10.0 * decade)
}

/// The texel at map coordinates, that of the edge beyond it.
pub fn texel_at(uv: [f64; 2], resolution: u32) -> [u32; 2] {
    uv.map(|s| {
        let index = (s * f64::from(resolution)).max(0.0) as u32;
        index.min(resolution.saturating_sub(1))
    })
}

/// Edges of a texel in the plane, metres.
pub fn texel_m(map: &MapRectangle, texel: [u32; 2], resolution: u32) -> [f64; 2] {
    let position = |offset: u32| {
        let uv = texel.map(|i| f64::from(i + offset) / f64::from(resolution));
        map.warp.as_ref().map_or(uv, |warp| warp.inverse(uv))
    };
    let (low, high) = (position(0), position(1));
    [0, 1].map(|axis| (high[axis] - low[axis]) * map.extent_m[axis])
}

/// A round length.
fn length(metres: f64) -> String {
    match metres >= 1000.0 {
        true => format!("{} km", metres / 1000.0),
        false => format!("{metres} m"),
    }
}

/// A length to three digits or whole metres.
pub fn metres(length_m: f64) -> String {
    match length_m {
        100_000.0.. => format!("{:.0} km", length_m / 1000.0),
        1000.0.. => format!("{:.1} km", length_m / 1000.0),
        10.0.. => format!("{length_m:.0} m"),
        _ => format!("{length_m:.2} m"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::MapWarp;
    use glam::DVec3;

    /// 8 × 2 km, most samples in the first eighth of u.
    fn map(warped: bool) -> MapRectangle {
        let near = (0..900).map(|i| [f64::from(i) / 7200.0, f64::from(i) / 900.0]);
        let rest = (0..700).map(|i| [0.125 + f64::from(i) / 800.0, f64::from(i) / 700.0]);
        let positions: Vec<_> = near.chain(rest).collect();
        MapRectangle {
            u_axis: DVec3::X,
            v_axis: DVec3::Z,
            origin_m: [-300.0, 100.0],
            extent_m: [8000.0, 2000.0],
            depth_m: 1000.0,
            warp: warped.then(|| MapWarp::new(&positions, 1.0)),
        }
    }

    #[test]
    fn lines_crowd_where_texels_are_large_as_stored_and_where_they_are_small_in_the_plane() {
        for (shape, wanted) in [(Shape::Stored, "500 m"), (Shape::Plane, "4 texels")] {
            let (even, _) = shape.lines(&map(false), 64);
            let ([u, v], words) = shape.lines(&map(true), 64);
            assert_eq!(words, format!("lines every {wanted}"));
            assert!((10..=20).contains(&u.len()) && !v.is_empty());
            assert!(u.is_sorted() && u.iter().chain(&v).all(|x| (0.0..=1.0).contains(x)));
            let steps = |lines: &[f64]| (lines[1] - lines[0], lines[9] - lines[8]);
            let (first, last) = steps(&even[0]);
            assert!((first - last).abs() < 1e-9);
            let (first, last) = steps(&u);
            match shape {
                Shape::Stored => assert!(first > 4.0 * last, "{first} {last}"),
                Shape::Plane => assert!(4.0 * first < last, "{first} {last}"),
            }
        }
        let ([u, v], _) = Shape::Stored.lines(&map(false), 64);
        assert!((u[0] - 300.0 / 8000.0).abs() < 1e-9 && (v[0] - 0.2).abs() < 1e-9);
    }

    #[test]
    fn in_the_plane_a_map_has_its_own_proportions_and_the_pointer_finds_its_texel() {
        let room = vec2(400.0, 300.0);
        assert_eq!(Shape::Stored.size(&map(true), room), vec2(300.0, 300.0));
        assert_eq!(Shape::Plane.size(&map(true), room), vec2(400.0, 100.0));
        let share = [0.1, 0.7];
        assert_eq!(Shape::Stored.uv(&map(true), share), share);
        assert_eq!(Shape::Plane.uv(&map(false), share), share);
        let warped = map(true);
        let uv = Shape::Plane.uv(&warped, share);
        assert!(uv[0] > 0.3, "{uv:?}");
        let rect = Rect::from_min_size(pos2(10.0, 20.0), vec2(800.0, 200.0));
        let mesh = Shape::Plane.mesh(&warped, TextureId::default(), rect);
        assert_eq!(mesh.calc_bounds(), rect);
        for vertex in &mesh.vertices {
            let share = (vertex.pos - rect.min) / rect.size();
            let [u, v] = Shape::Plane.uv(&warped, [share.x, share.y].map(f64::from));
            let apart = vertex.uv - pos2(u as f32, v as f32);
            assert!(apart.length() < 1e-4, "{apart}");
        }
    }

    #[test]
    fn texels_fill_the_rectangle_and_are_small_where_the_samples_are() {
        for warped in [false, true] {
            let map = map(warped);
            let edges = (0..64).map(|i| texel_m(&map, [i, i], 64)[0]);
            assert!((edges.sum::<f64>() - 8000.0).abs() < 1e-6);
            let [first, last] = [0, 63].map(|i| texel_m(&map, [i, 0], 64)[0]);
            assert_eq!(first < 0.5 * last, warped, "{first} {last}");
        }
    }

    #[test]
    fn a_map_of_nothing_has_no_lines_of_the_plane() {
        let mut nothing = map(false);
        (nothing.depth_m, nothing.origin_m, nothing.extent_m) = (0.0, [1e30; 2], [1.0; 2]);
        let ([u, v], _) = Shape::Stored.lines(&nothing, 64);
        assert!(u.is_empty() && v.is_empty());
        assert_eq!(
            Shape::Plane.size(&nothing, vec2(40.0, 30.0)),
            vec2(30.0, 30.0)
        );
        let ([u, _], words) = Shape::Plane.lines(&map(true), 1);
        assert_eq!((u.len(), words.as_str()), (0, "lines every 1 texel"));
    }

    #[test]
    fn distances_are_round() {
        let steps = [1.0, 1.1, 2.5, 7.0, 2100.0].map(round_step);
        assert_eq!(steps, [1.0, 2.0, 5.0, 10.0, 5000.0]);
        assert_eq!([500.0, 2000.0].map(length), ["500 m", "2 km"]);
        let lengths = [0.125, 12.5, 4210.0, 123_456.0].map(metres);
        assert_eq!(lengths, ["0.12 m", "12 m", "4.2 km", "123 km"]);
    }

    #[test]
    fn texels_are_those_under_the_pointer() {
        assert_eq!(texel_at([0.0, 0.999], 512), [0, 511]);
        assert_eq!(texel_at([9.0, -0.1], 512), [511, 0]);
    }
}
