//! From linear radiance to 8-bit sRGB, with one exposure for all pictures that are compared.

use super::png_file::MAGENTA;
use super::{Frame, is_nonfinite, luminance, nearest_rank};

/// Exposed value that the curve maps to 1: four times the value mapped to 1/2 by a curve without a white point.
const WHITE: f32 = 4.0;

/// Exposed value that the curve maps to 0.8, the root of `x(1 + x/16)/(1 + x) = 0.8`.
const BRIGHT: f32 = 2.319_183_6;

/// Factor from radiance to exposed value, dimensionless, > 0.
///
/// The factor comes from the reference and is used unchanged for every picture compared with it, so that a picture which is
/// too dark also looks too dark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure(pub f32);

impl Exposure {
    /// Exposure that puts the 99th percentile (nearest rank) of the picture's luminance at 0.8 after tone mapping.
    ///
    /// Only finite, positive luminances count; a picture without any gets exposure 1.
    pub fn from_reference(reference: &Frame) -> Self {
        let usable = |l: &f64| l.is_finite() && *l > 0.0;
        let mut values: Vec<f64> = reference
            .radiance
            .iter()
            .map(|p| luminance(*p))
            .filter(usable)
            .collect();
        let factor =
            nearest_rank(&mut values, 0.99).map_or(1.0, |bright| f64::from(BRIGHT) / bright);
        Self(factor.clamp(1e-30, 1e30) as f32)
    }
}

/// Tone-mapped 8-bit sRGB of the radiance, three bytes a pixel, rows from the top.
///
/// Each channel x = exposure · radiance goes through `x(1 + x/W²)/(1 + x)` with W = 4, clamped to `[0, 1]` (Reinhard et
/// al. 2002, eq. 4; here by channel, so that the peak is 1 for every hue), then through the sRGB transfer (IEC
/// 61966-2-1:1999). Monotone. Negative radiance is black. A pixel with a NaN or infinite channel is magenta, so that
/// the error is seen.
pub fn tone_map(frame: &Frame, exposure: Exposure) -> Vec<u8> {
    let map = |&[r, g, b, _]: &[f32; 4]| {
        if [r, g, b].into_iter().any(is_nonfinite) {
            MAGENTA
        } else {
            [r, g, b].map(|v| encode(v * exposure.0))
        }
    };
    frame.radiance.iter().flat_map(map).collect()
}

/// The curve and the transfer for one exposed value; an overflow to infinity is white.
fn encode(exposed: f32) -> u8 {
    let light = curve(exposed);
    let code = if light <= 0.003_130_8 {
        12.92 * light
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    };
    (code * 255.0).round() as u8
}

/// Reinhard's curve with a white point, from `[−∞, ∞]` to `[0, 1]`.
fn curve(exposed: f32) -> f32 {
    let x = exposed.clamp(0.0, WHITE);
    (x * (1.0 + x / (WHITE * WHITE)) / (1.0 + x)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(values: &[f32]) -> Frame {
        let radiance: Vec<[f32; 4]> = values.iter().map(|&v| [v, v, v, 1.0]).collect();
        Frame {
            width: values.len() as u32,
            height: 1,
            sun: radiance.clone(),
            radiance,
        }
    }

    #[test]
    fn curve_has_its_fixed_points_and_is_monotone() {
        assert_eq!(curve(0.0), 0.0);
        assert_eq!(curve(-3.0), 0.0);
        assert_eq!(curve(WHITE), 1.0);
        assert_eq!(curve(f32::INFINITY), 1.0);
        assert!((curve(BRIGHT) - 0.8).abs() < 1e-6);
        let values: Vec<f32> = (0..=5000).map(|i| curve(i as f32 * 1e-3)).collect();
        assert!(values.windows(2).all(|w| w[0] <= w[1]));
        assert!(values.iter().all(|v| (0.0..=1.0).contains(v)));
    }

    #[test]
    fn bright_percentile_lands_at_eight_tenths() {
        let values: Vec<f32> = (1..=100).map(|i| i as f32 * 7.0).collect();
        let frame = grey(&values);
        let exposure = Exposure::from_reference(&frame);
        assert!((exposure.0 * 99.0 * 7.0 - BRIGHT).abs() < 1e-4);
        // sRGB code of 0.8 linear is 0.9063.
        assert_eq!(tone_map(&frame, exposure)[98 * 3], 231);
    }

    #[test]
    fn black_and_broken_references_give_a_usable_exposure() {
        assert_eq!(Exposure::from_reference(&grey(&[0.0, 0.0])), Exposure(1.0));
        assert_eq!(
            Exposure::from_reference(&grey(&[f32::NAN, f32::INFINITY, -1.0])),
            Exposure(1.0)
        );
        let sparse = [vec![0.0; 999], vec![BRIGHT]].concat();
        assert!((Exposure::from_reference(&grey(&sparse)).0 - 1.0).abs() < 1e-6);
        assert!(Exposure::from_reference(&grey(&[1e-40])).0.is_finite());
    }

    #[test]
    fn broken_pixels_are_magenta() {
        let got = tone_map(
            &grey(&[f32::NAN, f32::INFINITY, f32::MAX, -1.0]),
            Exposure(10.0),
        );
        assert_eq!(got, [255, 0, 255, 255, 0, 255, 255, 255, 255, 0, 0, 0]);
    }
}
