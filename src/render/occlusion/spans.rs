//! The parts of a ray that may hold medium: twin of `shaders/shared/spans.wgsl`.

use super::twin::LightRay;

/// Most parts of a ray.
const MOST_PARTS: usize = 512;
/// Parts of the longest column where nothing is known of empty space.
const COARSE_PARTS: f64 = 16.0;

/// Length of a part, metres, in a map whose longest column is `depth_m`: that of a cell of the grid of empty space, or more
/// where a column would have too many.
pub fn part_m(cell_m: Option<f64>, depth_m: f64) -> f64 {
    let least = depth_m / MOST_PARTS as f64;
    cell_m.unwrap_or(depth_m / COARSE_PARTS).max(least)
}

/// The occupied parts of a ray: between them, extinction is provably 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Spans {
    /// Length of the ray, metres.
    length_m: f64,
    /// Equal parts of the ray.
    parts: usize,
    /// Indices of the occupied parts, growing.
    occupied: Vec<usize>,
}

impl Spans {
    /// Walks `ray` from empty sphere to empty sphere, in parts of at most `part_m` metres.
    pub fn walk(ray: &dyn LightRay, part_m: f64) -> Self {
        let length_m = ray.length_m();
        let parts = (length_m / part_m.max(1e-300)).ceil();
        let parts = parts.clamp(1.0, MOST_PARTS as f64) as usize;
        let part_m = length_m / parts as f64;
        let mut occupied = Vec::new();
        let mut i = 0;
        while i < parts && length_m > 0.0 {
            let reach_m = ray.empty_m((i as f64 + 0.5) * part_m).unwrap_or(-1.0);
            let covered = reach_m / part_m - 0.5;
            if covered < 0.0 {
                occupied.push(i);
                i += 1;
            } else {
                i += 1 + covered.min(65536.0) as usize;
            }
        }
        Self {
            length_m,
            parts,
            occupied,
        }
    }

    /// Length of the occupied parts, metres.
    pub fn occupied_m(&self) -> f64 {
        self.length_m * self.occupied.len() as f64 / self.parts as f64
    }

    /// Distance along the ray after travelling a share of the occupied length, metres; the ray's length where nothing is
    /// occupied.
    pub fn position_m(&self, share: f64) -> f64 {
        let Some(last) = self.occupied.len().checked_sub(1) else {
            return self.length_m;
        };
        let x = share * self.occupied.len() as f64;
        let i = (x.max(0.0) as usize).min(last);
        (self.occupied[i] as f64 + x - i as f64) / self.parts as f64 * self.length_m
    }

    /// The inverse of [`Self::position_m`]: share of the occupied length before a distance.
    pub fn share_before(&self, position_m: f64) -> f64 {
        let position = position_m / self.length_m.max(1e-300) * self.parts as f64;
        let i = (position.max(0.0) as usize).min(self.parts - 1);
        let before = self.occupied.partition_point(|part| *part < i);
        let own = self.occupied.get(before) == Some(&i);
        let within = if own {
            (position - i as f64).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (before as f64 + within) / self.occupied.len().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Medium between the given distances, and nothing known of the rest but the distance to it.
    struct Clouds(Vec<(f64, f64)>);

    impl LightRay for Clouds {
        fn length_m(&self) -> f64 {
            5120.0
        }

        fn extinction_per_m(&self, s_m: f64) -> f64 {
            f64::from(self.0.iter().any(|(a, b)| (*a..=*b).contains(&s_m)))
        }

        fn empty_m(&self, s_m: f64) -> Option<f64> {
            let distance = |(a, b): &(f64, f64)| (a - s_m).max(s_m - b);
            let nearest = self.0.iter().map(distance).fold(f64::INFINITY, f64::min);
            (nearest > 0.0).then_some(nearest)
        }
    }

    #[test]
    fn every_part_with_medium_is_occupied_and_few_others() {
        let clouds = Clouds(vec![(105.0, 301.0), (2000.0, 2011.0), (5000.0, 5120.0)]);
        let spans = Spans::walk(&clouds, 10.0);
        for k in 0..51200 {
            let s_m = (f64::from(k) + 0.5) / 10.0;
            if clouds.extinction_per_m(s_m) > 0.0 {
                let part = (s_m / 10.0) as usize;
                assert!(spans.occupied.contains(&part), "{s_m}");
            }
        }
        let medium_m = 196.0 + 11.0 + 120.0;
        assert!(
            (medium_m..medium_m + 60.0).contains(&spans.occupied_m()),
            "{}",
            spans.occupied_m()
        );
    }

    #[test]
    fn share_and_position_are_each_others_inverse() {
        let spans = Spans::walk(&Clouds(vec![(100.0, 300.0), (2000.0, 2100.0)]), 10.0);
        for k in 0..=100 {
            // Not on the edges between parts, which are the end of one span and the start of another.
            let share = (f64::from(k) + 0.37) / 101.0;
            let again = spans.share_before(spans.position_m(share));
            assert!((again - share).abs() < 1e-9, "{share} {again}");
        }
    }

    #[test]
    fn an_empty_ray_has_no_occupied_length() {
        let spans = Spans::walk(&Clouds(vec![(9000.0, 9001.0)]), 10.0);
        assert_eq!((spans.occupied_m(), spans.share_before(700.0)), (0.0, 0.0));
        assert_eq!(spans.position_m(0.5), 5120.0);
    }
}
