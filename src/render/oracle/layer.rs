//! Rays clipped to the container, addressed by the distance travelled inside it, and height fractions.

use crate::container::{Container, Intervals};
use glam::DVec3;

/// Parameter value that stands for no limit along a ray, metres.
pub(super) const UNLIMITED_M: f64 = 1e30;

/// A ray clipped to the container; gaps are not part of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct LayerRay {
    origin: DVec3,
    direction: DVec3,
    /// Metres along the ray at which each interval begins.
    start_m: [f64; 2],
    /// Lengths of the intervals, metres, ≥ 0.
    inside_m: [f64; 2],
}

impl LayerRay {
    /// The part of a ray between `from_m` and `to_m` that is inside `container`.
    pub fn new(
        container: &Container,
        origin: DVec3,
        direction: DVec3,
        (from_m, to_m): (f64, f64),
    ) -> Self {
        let intervals: Intervals = container.intervals(origin, direction, from_m, to_m);
        Self {
            origin,
            direction,
            start_m: intervals.map(|(start, _)| start),
            inside_m: intervals.map(|(start, end)| (end - start).max(0.0)),
        }
    }

    /// Metres inside.
    pub fn length_m(&self) -> f64 {
        self.inside_m[0] + self.inside_m[1]
    }

    /// The point after `s_m` metres inside.
    pub fn point(&self, s_m: f64) -> DVec3 {
        let [first_m, _] = self.inside_m;
        let t_m = if s_m <= first_m {
            self.start_m[0] + s_m
        } else {
            self.start_m[1] + (s_m - first_m)
        };
        self.origin + self.direction * t_m
    }

    /// Metres between `s_m` and the gap, on either side.
    pub fn distance_to_gap_m(&self, s_m: f64) -> f64 {
        (self.inside_m[0] - s_m).abs()
    }

    /// Metres from `s_m` to the next gap.
    pub fn before_gap_m(&self, s_m: f64) -> f64 {
        if s_m <= self.inside_m[0] {
            self.inside_m[0] - s_m
        } else {
            UNLIMITED_M
        }
    }
}

/// Height as a share of the layer, 0 at its base, 1 at its top.
pub(super) fn height_fraction(container: &Container, p: DVec3) -> f64 {
    let (low_m, high_m) = container.height_range_m();
    ((container.height_m(p) - low_m) / (high_m - low_m)).clamp(0.0, 1.0)
}

/// Whether a ray that starts above ground meets it.
pub(super) fn ground_blocks(container: &Container, p: DVec3, direction: DVec3) -> bool {
    match *container {
        Container::Box { .. } => false,
        Container::Shell {
            planet_radius_m: r, ..
        } => {
            // It meets the sphere when it descends and passes the centre within R: |p − c|² − b² < R².
            let b = p.dot(direction) + r * direction.y;
            let above = p.length_squared() + 2.0 * r * p.y;
            b < 0.0 && b * b > above
        }
    }
}
