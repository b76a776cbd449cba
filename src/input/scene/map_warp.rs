//! Rectilinear warp of a light map: texels where the view takes its samples.
//!
//! On each axis, the texel density is ∝ p^e, p the density of the view's sample positions; e = ⅓ minimises ∫ p t² dx, the
//! squared texel size t where it is read, for a fixed number of texels ∫ dx/t. Separable warps: Rosen 2012, Rectilinear
//! Texture Warping; texels from the distribution of samples: Lauritzen et al. 2011.

/// Equal parts of an axis; between their ends the warp is linear.
pub const WARP_PARTS: usize = 64;

/// Smallest texel density over the mean one: the map must be invertible where the view takes no sample.
const LEAST_DENSITY: f64 = 0.02;

/// Map coordinate in 0…1 as a function of the position in 0…1, on both axes.
#[derive(Clone, Debug, PartialEq)]
pub struct MapWarp {
    /// Map coordinate at the ends of the parts, on each axis: [`WARP_PARTS`] + 1 numbers from 0 to 1, increasing.
    pub knots: [Vec<f64>; 2],
}

impl MapWarp {
    /// The warp for samples at `positions`, each coordinate in 0…1, with `exponent` e in 0…1; 0 and no positions give equal
    /// texels.
    pub fn new(positions: &[[f64; 2]], exponent: f64) -> Self {
        let knots = [0, 1].map(|axis| {
            let mut counts = [0.0; WARP_PARTS];
            for position in positions {
                counts[part(position[axis])] += 1.0;
            }
            knots(counts.map(|count: f64| {
                if positions.is_empty() {
                    1.0
                } else {
                    count.powf(exponent)
                }
            }))
        });
        Self { knots }
    }

    /// Map coordinates of a position; level outside 0…1.
    pub fn forward(&self, position: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| {
            let knots = &self.knots[axis];
            let i = part(position[axis]);
            let within = (position[axis] * WARP_PARTS as f64 - i as f64).clamp(0.0, 1.0);
            knots[i] + (knots[i + 1] - knots[i]) * within
        })
    }

    /// Position of map coordinates, the inverse of [`Self::forward`].
    pub fn inverse(&self, uv: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| {
            let knots = &self.knots[axis];
            let above = knots.partition_point(|knot| *knot <= uv[axis]);
            let i = above.clamp(1, WARP_PARTS) - 1;
            let within = (uv[axis] - knots[i]) / (knots[i + 1] - knots[i]);
            (i as f64 + within.clamp(0.0, 1.0)) / WARP_PARTS as f64
        })
    }
}

/// The part of an axis that holds a position.
fn part(position: f64) -> usize {
    ((position * WARP_PARTS as f64).max(0.0) as usize).min(WARP_PARTS - 1)
}

/// Running sum of densities, from 0 to 1.
fn knots(densities: [f64; WARP_PARTS]) -> Vec<f64> {
    let mean = densities.iter().sum::<f64>() / WARP_PARTS as f64;
    let densities = densities.map(|density| density.max(LEAST_DENSITY * mean));
    let whole: f64 = densities.iter().sum();
    let sums = densities.iter().scan(0.0, |sum, density| {
        *sum += density;
        Some(*sum / whole)
    });
    let mut knots: Vec<f64> = [0.0].into_iter().chain(sums).collect();
    knots[WARP_PARTS] = 1.0;
    knots
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples on a line: `n` in the first eighth of the first axis for each of the rest; even on the second.
    fn crowded(n: usize) -> Vec<[f64; 2]> {
        let even = (0..6400).map(|i| f64::from(i) / 6400.0);
        let mut positions: Vec<_> = even.clone().map(|x| [x, x]).collect();
        let near = (1..n).flat_map(|_| even.clone().filter(|x| *x < 0.125).map(|x| [x, 8.0 * x]));
        positions.extend(near);
        positions
    }

    #[test]
    fn positions_and_map_coordinates_are_each_others_inverse() {
        let warp = MapWarp::new(&crowded(8), 1.0 / 3.0);
        for i in 0..=1000 {
            let x = f64::from(i) / 1000.0;
            for (a, b) in warp
                .inverse(warp.forward([x, 1.0 - x]))
                .into_iter()
                .zip([x, 1.0 - x])
            {
                assert!((a - b).abs() < 1e-12, "{x}: {a} {b}");
            }
        }
        for knots in &warp.knots {
            assert_eq!((knots[0], knots[WARP_PARTS]), (0.0, 1.0));
            assert!(knots.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }

    #[test]
    fn texel_density_is_the_given_power_of_sample_density() {
        for exponent in [0.0, 1.0 / 3.0, 0.5, 1.0] {
            let warp = MapWarp::new(&crowded(8), exponent);
            let slope = |x: f64| warp.forward([x + 1e-3, 0.5])[0] - warp.forward([x, 0.5])[0];
            let ratio = slope(0.05) / slope(0.8);
            let expected = 8f64.powf(exponent);
            assert!((ratio / expected - 1.0).abs() < 1e-6, "{exponent}: {ratio}");
        }
    }

    #[test]
    fn without_samples_texels_are_equal() {
        let warp = MapWarp::new(&[], 0.5);
        let [u, v] = warp.forward([0.3, 0.7]);
        assert!((u - 0.3).abs() < 1e-12 && (v - 0.7).abs() < 1e-12);
    }

    #[test]
    fn parts_that_no_sample_meets_keep_a_few_texels() {
        let warp = MapWarp::new(&[[0.0, 0.0]], 1.0);
        let [u, _] = warp.forward([0.5, 0.5]);
        assert!((0.5..0.9999).contains(&u), "{u}");
        assert!(
            warp.knots[0]
                .windows(2)
                .all(|pair| pair[1] - pair[0] > 1e-4)
        );
    }
}
