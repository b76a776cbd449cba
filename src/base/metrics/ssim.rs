//! Structural similarity, written from the paper.
//!
//! Wang, Bovik, Sheikh & Simoncelli, "Image Quality Assessment: From Error Visibility to Structural Similarity", IEEE
//! Transactions on Image Processing 13(4), 2004, eq. 13 to 17.

/// Side of the Gaussian window, pixels (§ III-C).
const WINDOW: usize = 11;
/// Standard deviation of the window, pixels.
const SIGMA: f64 = 1.5;
/// C₁ = (K₁·peak)², K₁ = 0.01, peak 1.
const C1: f64 = 0.01 * 0.01;
/// C₂ = (K₂·peak)², K₂ = 0.03, peak 1.
const C2: f64 = 0.03 * 0.03;

/// Mean structural similarity of the luma of two 8-bit sRGB pictures, in `[−1, 1]`, 1 when they are equal.
///
/// `(2μₓμᵧ + C₁)(2σₓᵧ + C₂) / ((μₓ² + μᵧ² + C₁)(σₓ² + σᵧ² + C₂))`, averaged over every place where the 11×11 window
/// lies inside the picture, at full resolution. A picture under 11 pixels wide or high gets the largest odd window
/// that fits.
pub(super) fn ssim((width, height): (u32, u32), reference: &[u8], test: &[u8]) -> f64 {
    let blur = Blur::new(width as usize, height as usize);
    let (x, y) = (luma(reference), luma(test));
    let product =
        |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a * b).collect() };
    let (mean_x, mean_y) = (blur.apply(&x), blur.apply(&y));
    let (xx, yy, xy) = (
        blur.apply(&product(&x, &x)),
        blur.apply(&product(&y, &y)),
        blur.apply(&product(&x, &y)),
    );
    let local = |i: usize| {
        let (mx, my) = (mean_x[i], mean_y[i]);
        let (var_x, var_y, cov) = (xx[i] - mx * mx, yy[i] - my * my, xy[i] - mx * my);
        ((2.0 * mx * my + C1) * (2.0 * cov + C2))
            / ((mx * mx + my * my + C1) * (var_x + var_y + C2))
    };
    (0..mean_x.len()).map(local).sum::<f64>() / mean_x.len() as f64
}

/// Luma in `[0, 1]` of gamma-encoded RGB (ITU-R BT.601-7, 2011, the weights of the paper's own code).
fn luma(rgb8: &[u8]) -> Vec<f64> {
    let weigh = |p: &[u8; 3]| {
        (0.299 * f64::from(p[0]) + 0.587 * f64::from(p[1]) + 0.114 * f64::from(p[2])) / 255.0
    };
    rgb8.as_chunks::<3>().0.iter().map(weigh).collect()
}

/// A separable Gaussian that keeps only places where the window lies inside the picture.
struct Blur {
    width: usize,
    height: usize,
    along_x: Vec<f64>,
    along_y: Vec<f64>,
}

impl Blur {
    /// Windows for a picture of at least 1×1 pixel.
    fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            along_x: gaussian(width),
            along_y: gaussian(height),
        }
    }

    /// Weighted means of one plane, `(width − n + 1) × (height − m + 1)` of them.
    fn apply(&self, plane: &[f64]) -> Vec<f64> {
        let columns = self.width + 1 - self.along_x.len();
        let rows = self.height + 1 - self.along_y.len();
        let mut across = Vec::with_capacity(columns * self.height);
        for row in plane.chunks_exact(self.width) {
            across.extend(
                row.windows(self.along_x.len())
                    .map(|w| dot(w, &self.along_x)),
            );
        }
        let mut out = vec![0.0; columns * rows];
        for (y, line) in out.chunks_exact_mut(columns).enumerate() {
            for (k, weight) in self.along_y.iter().enumerate() {
                let source = &across[(y + k) * columns..(y + k + 1) * columns];
                line.iter_mut()
                    .zip(source)
                    .for_each(|(sum, v)| *sum += weight * v);
            }
        }
        out
    }
}

/// Gaussian weights of sum 1, as many as the window has, or the largest odd number up to `limit`.
fn gaussian(limit: usize) -> Vec<f64> {
    let size = if limit >= WINDOW {
        WINDOW
    } else {
        limit - (limit + 1) % 2
    };
    let centre = (size / 2) as f64;
    let raw: Vec<f64> = (0..size)
        .map(|i| (-(i as f64 - centre).powi(2) / (2.0 * SIGMA * SIGMA)).exp())
        .collect();
    let sum: f64 = raw.iter().sum();
    raw.into_iter().map(|w| w / sum).collect()
}

/// Σ aᵢbᵢ.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(values: impl Iterator<Item = u8>) -> Vec<u8> {
        values.flat_map(|v| [v, v, v]).collect()
    }

    #[test]
    fn window_sums_to_one_and_shrinks_with_the_picture() {
        for (limit, size) in [(1, 1), (2, 1), (3, 3), (10, 9), (11, 11), (500, 11)] {
            let window = gaussian(limit);
            assert_eq!(window.len(), size);
            assert!((window.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn flat_pictures_follow_the_luminance_term() {
        let (a, b) = (100.0 / 255.0, 140.0 / 255.0);
        let expected = (2.0 * a * b + C1) / (a * a + b * b + C1);
        let flat = |v: u8| grey((0..20 * 15).map(move |_| v));
        assert!((ssim((20, 15), &flat(100), &flat(140)) - expected).abs() < 1e-9);
        assert!((ssim((20, 15), &flat(100), &flat(100)) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn inverted_structure_is_negative() {
        let check = |flip: usize| {
            grey((0..32 * 32).map(move |i| {
                if (i % 32 + i / 32) % 2 == flip {
                    255
                } else {
                    0
                }
            }))
        };
        assert!(ssim((32, 32), &check(0), &check(1)) < -0.9);
        assert!((ssim((32, 32), &check(0), &check(0)) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn agrees_with_an_independent_implementation() {
        // scikit-image 0.26, structural_similarity(gaussian_weights=True, sigma=1.5, use_sample_covariance=False).
        let at = |i: usize| (i % 32, i / 32);
        let one = grey(
            (0..32 * 24)
                .map(at)
                .map(|(x, y)| ((x * 7 + y * 5) % 256) as u8),
        );
        let other = grey(
            (0..32 * 24)
                .map(at)
                .map(|(x, y)| ((x * 7 + y * 5 + x * y % 17 * 3) % 256) as u8),
        );
        assert!((ssim((32, 24), &one, &other) - 0.419_260_171_345_123_17).abs() < 1e-9);
    }
}
