//! Differences as they are seen: ꟻLIP and PSNR of tone-mapped 8-bit pictures.

use crate::frame::nearest_rank;
use nv_flip::{FlipImageRgb8, flip as flip_map};

/// Viewing condition of ꟻLIP, pixels per degree of visual angle: a 0.7 m wide 4K screen seen from 0.7 m, the paper's
/// default.
pub const PIXELS_PER_DEGREE: f32 = 67.0;

/// ꟻLIP over a picture, each in `[0, 1]`.
pub(super) struct Flip {
    /// Mean over pixels.
    pub mean: f64,
    /// 99th percentile over pixels (nearest rank).
    pub p99: f64,
}

/// ꟻLIP for LDR pictures at [`PIXELS_PER_DEGREE`] (Andersson et al. 2020), by the authors' code. Both pictures are 8-bit
/// sRGB of `size`, 3 bytes a pixel.
pub(super) fn flip((width, height): (u32, u32), reference: &[u8], test: &[u8]) -> Flip {
    let image = |bytes: &[u8]| FlipImageRgb8::with_data(width, height, bytes);
    let map = flip_map(image(reference), image(test), PIXELS_PER_DEGREE).to_vec();
    let mut values: Vec<f64> = map.into_iter().map(f64::from).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    Flip {
        mean,
        p99: nearest_rank(&mut values, 0.99).unwrap_or(0.0),
    }
}

/// Peak signal-to-noise ratio, dB: −10 log₁₀ of the mean squared difference of all bytes scaled to `[0, 1]`, peak 1.
///
/// `None` when the pictures are equal (the ratio has no value); otherwise in `[0, ≈ 48 + 10 log₁₀ n]` for n bytes.
pub(super) fn psnr_db(reference: &[u8], test: &[u8]) -> Option<f64> {
    let squared = |(a, b): (&u8, &u8)| u64::from(a.abs_diff(*b)).pow(2);
    let sum: u64 = reference.iter().zip(test).map(squared).sum();
    let mean = sum as f64 / (255.0 * 255.0 * reference.len() as f64);
    (sum > 0).then(|| -10.0 * mean.log10())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn psnr_of_known_offsets() {
        let black = [0_u8; 300];
        assert_eq!(psnr_db(&black, &black), None);
        assert_eq!(psnr_db(&black, &[255; 300]), Some(0.0));
        // One code of 255: 20 log10 255 = 48.1308 dB.
        assert!((psnr_db(&black, &[1; 300]).unwrap() - 48.130_803_6).abs() < 1e-6);
        let mut one = black;
        one[7] = 255;
        assert!((psnr_db(&black, &one).unwrap() - 10.0 * 300_f64.log10()).abs() < 1e-9);
    }

    #[test]
    fn flip_of_equal_and_opposite_pictures() {
        let size = (24, 16);
        let (black, white) = (vec![0_u8; 24 * 16 * 3], vec![255_u8; 24 * 16 * 3]);
        let same = flip(size, &white, &white);
        assert_eq!((same.mean, same.p99), (0.0, 0.0));
        let opposite = flip(size, &black, &white);
        assert!(
            opposite.mean > 0.9 && opposite.mean <= 1.0,
            "{}",
            opposite.mean
        );
        assert!(opposite.p99 >= opposite.mean - 1e-6);
    }

    #[test]
    fn flip_sees_a_local_error() {
        let size = (64, 64);
        let grey = vec![128_u8; 64 * 64 * 3];
        let mut spot = grey.clone();
        for y in 28..36 {
            spot[(y * 64 + 28) * 3..(y * 64 + 36) * 3].fill(255);
        }
        let got = flip(size, &grey, &spot);
        assert!(got.mean > 0.0 && got.mean < 0.1 && got.p99 > 5.0 * got.mean);
    }
}
