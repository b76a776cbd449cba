//! The spans of a ray that may hold medium: twin of `shaders/shared/spans.wgsl`.

use super::twin::LightRay;

/// Parts of a column from one look-up to the next, in cells of the grid of empty space.
const PART_CELLS: f64 = 2.0;
/// Shortest step, in cells: shorter ones cost more than they find.
const STEP_CELLS: f64 = 0.75;
/// Most parts of a ray.
const MOST_PARTS: f64 = 512.0;
/// Parts of the longest column where nothing is known of empty space.
const COARSE_PARTS: f64 = 16.0;
/// Shortest empty distance that is left out, in parts.
pub const LEAST_GAP: f64 = 0.25;
/// Most spans of a ray; the last one holds the gaps of what would be more.
const MOST_SPANS: usize = 16;

/// How finely the columns of a map are searched for empty space, and sampled in what remains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// Length from one look-up to the next where there may be medium, metres.
    pub part_m: f64,
    /// Shortest step, metres; 0 = any.
    pub step_m: f64,
}

impl Grain {
    /// For a map whose longest column is `depth_m`, in a grid of empty space with cells of `cell_m`, where there is one.
    pub fn new(cell_m: Option<f64>, depth_m: f64) -> Self {
        let least_m = depth_m / MOST_PARTS;
        let part_m = cell_m.map_or(depth_m / COARSE_PARTS, |cell_m| PART_CELLS * cell_m);
        Self {
            part_m: part_m.max(least_m),
            step_m: STEP_CELLS * cell_m.unwrap_or_default(),
        }
    }

    /// Steps of a column, of at most `steps`, over `occupied_m` metres; 0 where nothing is occupied.
    pub fn steps(self, steps: u32, occupied_m: f64) -> u32 {
        if occupied_m <= 0.0 {
            return 0;
        }
        // A little less than the quotient: rounding must not decide where the steps fill it exactly.
        let most = (occupied_m / self.step_m.max(1e-20) - 1e-3).ceil();
        most.clamp(1.0, f64::from(steps)) as u32
    }
}

/// The spans of a ray that may hold medium: between them, extinction is provably 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Spans {
    /// Length of the ray, metres.
    length_m: f64,
    /// Near edge of each span, and occupied length before it, metres; both grow.
    spans: Vec<[f64; 2]>,
    /// Length of all spans, metres.
    occupied_m: f64,
}

impl Spans {
    /// Walks the first `length_m` of `ray`, from empty sphere to empty sphere, and by `part_m` metres where there may be
    /// medium or the sphere is small.
    pub fn walk(ray: &dyn LightRay, length_m: f64, part_m: f64) -> Self {
        let part_m = part_m.max(length_m / MOST_PARTS);
        let mut spans: Vec<[f64; 2]> = Vec::new();
        let (mut s_m, mut end_m, mut occupied_m) = (0.0, -1.0, 0.0);
        while s_m < length_m {
            let reach_m = ray.empty_m(s_m).unwrap_or(-1.0);
            if reach_m >= LEAST_GAP * part_m {
                s_m += reach_m;
                continue;
            }
            let next_m = length_m.min(s_m + part_m);
            if s_m > end_m {
                if spans.len() < MOST_SPANS {
                    spans.push([s_m, occupied_m]);
                } else {
                    occupied_m += s_m - end_m;
                }
            }
            occupied_m += next_m - s_m;
            (s_m, end_m) = (next_m, next_m);
        }
        Self {
            length_m,
            spans,
            occupied_m,
        }
    }

    /// Length of the spans, metres.
    pub fn occupied_m(&self) -> f64 {
        self.occupied_m
    }

    /// Distance along the ray after travelling `x_m` metres of the spans alone; the ray's length where there is none.
    pub fn position_m(&self, x_m: f64) -> f64 {
        let after = self.spans.partition_point(|[_, before_m]| *before_m <= x_m);
        match self.spans.get(after.saturating_sub(1)) {
            Some([start_m, before_m]) => start_m + (x_m - before_m),
            None => self.length_m,
        }
    }

    /// The inverse of [`Self::position_m`]: metres of the spans before a distance.
    pub fn before_m(&self, position_m: f64) -> f64 {
        let after = self
            .spans
            .partition_point(|[start_m, _]| *start_m < position_m);
        let end_m = self
            .spans
            .get(after)
            .map_or(self.occupied_m, |next| next[1]);
        match self.spans[..after].last() {
            Some([start_m, before_m]) => end_m.min(before_m + position_m - start_m),
            None => 0.0,
        }
    }
}

/// A ray of which only the spans are there.
pub struct Spanned<'a> {
    /// The whole ray.
    pub ray: &'a dyn LightRay,
    /// Its spans.
    pub spans: &'a Spans,
}

impl LightRay for Spanned<'_> {
    fn length_m(&self) -> f64 {
        self.spans.occupied_m()
    }

    fn extinction_per_m(&self, x_m: f64) -> f64 {
        self.ray.extinction_per_m(self.spans.position_m(x_m))
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

    fn walk(clouds: &Clouds, part_m: f64) -> Spans {
        Spans::walk(clouds, clouds.length_m(), part_m)
    }

    #[test]
    fn all_medium_is_occupied_and_little_else() {
        let clouds = Clouds(vec![(105.0, 301.0), (2000.0, 2011.0), (5000.0, 5120.0)]);
        let spans = walk(&clouds, 10.0);
        for k in 0..51200 {
            let s_m = (f64::from(k) + 0.5) / 10.0;
            if clouds.extinction_per_m(s_m) > 0.0 {
                let again = spans.position_m(spans.before_m(s_m));
                assert!((again - s_m).abs() < 1e-9, "{s_m} {again}");
            }
        }
        let medium_m = 196.0 + 11.0 + 120.0;
        // A span begins at most a quarter of a part early and ends at most a part late.
        assert!(
            (medium_m..medium_m + 38.0).contains(&spans.occupied_m()),
            "{}",
            spans.occupied_m()
        );
    }

    #[test]
    fn what_would_be_too_many_spans_is_one() {
        let cloud = |k: u32| (f64::from(k) * 200.0, f64::from(k) * 200.0 + 20.0);
        let clouds = Clouds((0..25).map(cloud).collect());
        let spans = walk(&clouds, 10.0);
        assert_eq!(spans.spans.len(), MOST_SPANS);
        // All of the ray between the last span and the last cloud.
        assert!(spans.occupied_m() > 9.0 * 200.0, "{}", spans.occupied_m());
        let end_m = spans.position_m(spans.occupied_m());
        assert!((4820.0..4840.0).contains(&end_m), "{end_m}");
    }

    #[test]
    fn steps_are_as_many_as_asked_for_or_of_the_shortest_length() {
        let grain = Grain::new(Some(60.0), 3000.0);
        assert_eq!((grain.part_m, grain.step_m), (120.0, 45.0));
        assert_eq!(Grain::new(Some(1.0), 2048.0).part_m, 4.0);
        assert_eq!(Grain::new(None, 320.0).part_m, 20.0);
        let steps = [0.0, 1.0, 450.0, 451.0, 3000.0].map(|m| grain.steps(50, m));
        assert_eq!(steps, [0, 1, 10, 11, 50]);
        assert_eq!(Grain::new(None, 320.0).steps(50, 1e-3), 50);
    }

    #[test]
    fn position_and_length_before_it_are_each_others_inverse() {
        let spans = walk(&Clouds(vec![(100.0, 300.0), (2000.0, 2100.0)]), 10.0);
        for k in 0..=100 {
            let x_m = (f64::from(k) + 0.37) / 101.0 * spans.occupied_m();
            let again = spans.before_m(spans.position_m(x_m));
            assert!((again - x_m).abs() < 1e-9, "{x_m} {again}");
        }
        // In the gap nothing is added.
        assert_eq!(spans.before_m(900.0), spans.before_m(1500.0));
    }

    #[test]
    fn an_empty_ray_has_no_occupied_length() {
        let spans = walk(&Clouds(vec![(9000.0, 9001.0)]), 10.0);
        assert_eq!((spans.occupied_m(), spans.before_m(700.0)), (0.0, 0.0));
        assert_eq!(spans.position_m(0.5), 5120.0);
    }
}
