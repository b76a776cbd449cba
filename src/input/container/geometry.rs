//! Intersection of rays with containers in f64: the intervals of `shaders/container/*.wgsl`.

use super::Container;
use glam::DVec3;

/// Intervals `(start, end)` of a ray inside the container, metres along the ray; empty ones have `end <= start`.
pub type Intervals = [(f64, f64); 2];

const NOTHING: Intervals = [(0.0, 0.0); 2];

impl Container {
    /// Clips a ray to the container; a shell's ground ends it.
    pub fn intervals(&self, origin: DVec3, direction: DVec3, t_min: f64, t_max: f64) -> Intervals {
        match *self {
            Self::Shell {
                planet_radius_m,
                base_m,
                top_m,
            } => {
                let roots = |height_m| sphere_roots(origin, direction, planet_radius_m, height_m);
                let Some(outer) = roots(top_m) else {
                    return NOTHING;
                };
                let enter = outer.0.max(t_min);
                let mut leave = outer.1.min(t_max);
                if let Some(ground) = roots(0.0).filter(|g| g.0 >= t_min) {
                    leave = leave.min(ground.0);
                }
                match roots(base_m) {
                    None => [(enter, leave), (leave, leave)],
                    Some(inner) => [(enter, leave.min(inner.0)), (enter.max(inner.1), leave)],
                }
            }
            Self::Box { min_m, max_m } => {
                let (mut enter, mut leave) = (t_min, t_max);
                for i in 0..3 {
                    let (a, b) = (
                        (min_m[i] - origin[i]) / direction[i],
                        (max_m[i] - origin[i]) / direction[i],
                    );
                    if direction[i] == 0.0 {
                        if origin[i] < min_m[i] || origin[i] > max_m[i] {
                            return NOTHING;
                        }
                        continue;
                    }
                    enter = enter.max(a.min(b));
                    leave = leave.min(a.max(b));
                }
                [(enter, leave), (leave, leave)]
            }
        }
    }

    /// Height above ground in a shell, world y in a box, metres.
    pub fn height_m(&self, p: DVec3) -> f64 {
        match *self {
            Self::Box { .. } => p.y,
            Self::Shell {
                planet_radius_m: r, ..
            } => {
                // |p − c| − R without cancellation: (|p − c|² − R²)/(|p − c| + R).
                (p.length_squared() + 2.0 * r * p.y) / ((p + DVec3::Y * r).length() + r)
            }
        }
    }

    /// Coordinates in which density fields are defined, metres: horizontal x and z, height as y.
    pub fn field_point(&self, p: DVec3) -> DVec3 {
        DVec3::new(p.x, self.height_m(p), p.z)
    }

    /// Upper bound of the length of a ray inside the container, metres.
    pub fn longest_path_m(&self) -> f64 {
        match *self {
            Self::Shell {
                planet_radius_m: r,
                base_m,
                top_m,
            } => column_length(r, base_m, top_m, r + base_m),
            Self::Box { min_m, max_m } => (0..3)
                .map(|i| (max_m[i] - min_m[i]).powi(2))
                .sum::<f64>()
                .sqrt(),
        }
    }

    /// Longest column along the sun over a rectangle of the plane spanned by `u` and `v`: `[low, high]` of (p·u, p·v).
    pub fn longest_column_m(
        &self,
        sun: DVec3,
        u: DVec3,
        v: DVec3,
        low: [f64; 2],
        high: [f64; 2],
    ) -> f64 {
        match *self {
            Self::Box { min_m, max_m } => (0..3)
                .map(|i| (max_m[i] - min_m[i]) / sun[i].abs())
                .filter(|l| l.is_finite())
                .fold(f64::INFINITY, f64::min),
            Self::Shell {
                planet_radius_m: r,
                base_m,
                top_m,
            } => {
                // A column's length depends on its distance b from the planet's centre alone. It grows up to the inner
                // sphere's radius and falls from there.
                let centre = [-r * u.y, -r * v.y];
                let nearest = |i: usize| (low[i] - centre[i]).max(centre[i] - high[i]).max(0.0);
                let farthest =
                    |i: usize| (low[i] - centre[i]).abs().max((high[i] - centre[i]).abs());
                let (b_min, b_max) = (nearest(0).hypot(nearest(1)), farthest(0).hypot(farthest(1)));
                column_length(r, base_m, top_m, (r + base_m).clamp(b_min, b_max))
            }
        }
    }
}

/// Length inside the shell of a line that passes the centre at distance `b`, on the sun's side of the ground.
fn column_length(r: f64, base_m: f64, top_m: f64, b: f64) -> f64 {
    let half_chord = |height_m: f64| ((r + height_m - b) * (r + height_m + b)).max(0.0).sqrt();
    let one_side = half_chord(top_m) - half_chord(base_m);
    if b < r { one_side } else { 2.0 * one_side }
}

/// Roots in ascending order; see `shaders/container/shell.wgsl`.
fn sphere_roots(o: DVec3, d: DVec3, r: f64, height_m: f64) -> Option<(f64, f64)> {
    let b = o.dot(d) + r * d.y;
    let c = o.length_squared() + 2.0 * r * (o.y - height_m) - height_m * height_m;
    let discriminant = b * b - c;
    if discriminant <= 0.0 {
        return None;
    }
    let q = -b - discriminant.sqrt().copysign(b);
    Some((q.min(c / q), q.max(c / q)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHELL: Container = Container::Shell {
        planet_radius_m: 2e5,
        base_m: 1000.0,
        top_m: 4000.0,
    };

    fn length(i: Intervals) -> f64 {
        i.iter().map(|(a, b)| (b - a).max(0.0)).sum()
    }

    #[test]
    fn a_vertical_ray_crosses_the_layer_once() {
        let up = SHELL.intervals(DVec3::ZERO, DVec3::Y, 0.0, 1e30);
        assert!((length(up) - 3000.0).abs() < 1e-6);
        let down = SHELL.intervals(DVec3::new(0.0, 9000.0, 0.0), DVec3::NEG_Y, 0.0, 1e30);
        assert!(
            (length(down) - 3000.0).abs() < 1e-6,
            "the ground ends the ray before the far side"
        );
    }

    #[test]
    fn longest_columns_are_those_the_design_quotes() {
        // Upward half of a ray that grazes the inner sphere: 34.9 km; the whole of it: 69.7 km.
        let grazing = SHELL.intervals(DVec3::new(0.0, 1000.0, 0.0), DVec3::X, -1e30, 1e30);
        assert!(
            (length(grazing) - 69_700.0).abs() < 100.0,
            "{}",
            length(grazing)
        );
        let sun = DVec3::X;
        let longest = SHELL.longest_column_m(sun, DVec3::Z, DVec3::Y, [-10.0, 0.0], [10.0, 4000.0]);
        assert!((longest - length(grazing)).abs() < 1.0);
    }

    #[test]
    fn a_box_clips_and_misses() {
        let b = Container::Box {
            min_m: [0.0; 3],
            max_m: [1.0, 2.0, 3.0],
        };
        assert!(
            (length(b.intervals(DVec3::new(0.5, -1.0, 0.5), DVec3::Y, 0.0, 1e30)) - 2.0).abs()
                < 1e-12
        );
        assert_eq!(
            length(b.intervals(DVec3::new(1.5, -1.0, 0.5), DVec3::Y, 0.0, 1e30)),
            0.0
        );
    }
}
