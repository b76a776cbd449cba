//! Errors of the sun-lit radiance, in linear light, over cloud pixels.

use super::pair::Pair;
use super::{CLOUD_OPACITY, EDGE_OPACITY, Unlit};
use crate::frame::{Frame, is_nonfinite, nearest_rank};

/// Errors in linear light; [`super::METRICS`] defines them.
pub(super) struct Linear {
    /// √ΣΔ² / √ΣL².
    pub rel_rmse: f64,
    /// ΣΔ / ΣL.
    pub bias: f64,
    /// Σmax(Δ, 0) / ΣL.
    pub leak: f64,
    /// Σmin(Δ, 0) / ΣL.
    pub darken: f64,
    /// 99th percentile of |Δ| / mean L.
    pub p99_abs: f64,
    /// Largest |Δ| / mean L.
    pub max_abs: f64,
    /// ΣΔ / ΣL of edge pixels; `None` without lit ones.
    pub edge_bias: Option<f64>,
    /// Cloud pixels / pixels.
    pub cloud_pixel_fraction: f64,
}

/// Sums over the cloud pixels, in f64.
#[derive(Default)]
struct Sums {
    /// Σmax(Δ, 0).
    over: f64,
    /// Σmin(Δ, 0).
    under: f64,
    /// ΣΔ².
    squared: f64,
    /// ΣL².
    reference_squared: f64,
    /// ΣΔ of edge pixels.
    edge_delta: f64,
    /// ΣL of edge pixels.
    edge_reference: f64,
    /// Cloud pixels.
    pixels: usize,
}

/// Measures the sun-lit radiance of `test`; both frames have the same size and the reference is finite.
pub(super) fn measure(reference: &Frame, test: &Frame) -> Result<Linear, Unlit> {
    let mean = mean_sun(reference)?;
    let mut sums = Sums::default();
    let mut absolute = Vec::new();
    for (opacity, truth, value) in cloud_pairs(reference, test) {
        sums.pixels += 1;
        let edge = opacity <= EDGE_OPACITY;
        for channel in 0..3 {
            let (l, delta) = (
                f64::from(truth[channel]),
                value[channel] - f64::from(truth[channel]),
            );
            sums.over += delta.max(0.0);
            sums.under += delta.min(0.0);
            sums.squared += delta * delta;
            sums.reference_squared += l * l;
            if edge {
                sums.edge_delta += delta;
                sums.edge_reference += l;
            }
            absolute.push(delta.abs());
        }
    }
    let total = mean * absolute.len() as f64;
    Ok(Linear {
        rel_rmse: (sums.squared / sums.reference_squared).sqrt(),
        bias: (sums.over + sums.under) / total,
        leak: sums.over / total,
        darken: sums.under / total,
        max_abs: absolute.iter().fold(0.0, |a: f64, b| a.max(*b)) / mean,
        p99_abs: nearest_rank(&mut absolute, 0.99).unwrap_or(0.0) / mean,
        edge_bias: (sums.edge_reference > 0.0).then(|| sums.edge_delta / sums.edge_reference),
        cloud_pixel_fraction: sums.pixels as f64 / reference.sun.len() as f64,
    })
}

/// √mean (V̂ − V)² over cloud pixels.
pub(super) fn transmittance_rmse(pair: &Pair<'_>) -> f64 {
    let (mut squared, mut pixels) = (0.0, 0_usize);
    for (_, truth, value) in cloud_pairs(pair.reference, pair.test) {
        squared += (value[3] - f64::from(truth[3])).powi(2);
        pixels += 1;
    }
    (squared / pixels as f64).sqrt()
}

/// Mean L: the reference's sun-lit radiance averaged over the RGB channels of its cloud pixels, > 0, unit of radiance.
///
/// The scale of `p99_abs`, `max_abs`, [`super::Flicker`] and of a false-colour picture. A reference without cloud
/// pixels or without sunlight on them has none.
pub fn mean_sun(reference: &Frame) -> Result<f64, Unlit> {
    let (mut sum, mut channels) = (0.0, 0_usize);
    for (opacity, sun) in reference.radiance.iter().map(|p| p[3]).zip(&reference.sun) {
        if opacity > CLOUD_OPACITY {
            sum += sun[..3].iter().map(|v| f64::from(*v)).sum::<f64>();
            channels += 3;
        }
    }
    let mean = sum / channels as f64;
    if channels == 0 {
        Err(Unlit::NoCloud)
    } else if mean.is_finite() && mean > 0.0 {
        Ok(mean)
    } else {
        Err(Unlit::NoSunlight)
    }
}

/// Opacity in the reference, reference and test values (RGB sun, V) of each cloud pixel; the test's non-finite channels
/// are read as 0.
fn cloud_pairs<'a>(
    reference: &'a Frame,
    test: &'a Frame,
) -> impl Iterator<Item = (f32, [f32; 4], [f64; 4])> + 'a {
    let opacity = reference.radiance.iter().map(|p| p[3]);
    let pixels = opacity.zip(&reference.sun).zip(&test.sun);
    pixels
        .filter(|((opacity, _), _)| *opacity > CLOUD_OPACITY)
        .map(|((opacity, truth), value)| (opacity, *truth, value.map(readable)))
}

/// A channel of the test as it enters the sums: NaN and infinity count as 0.
pub(super) fn readable(value: f32) -> f64 {
    if is_nonfinite(value) {
        0.0
    } else {
        f64::from(value)
    }
}

#[cfg(test)]
mod tests {
    use super::super::compare;
    use super::super::testing::{cloud, uniform};
    use super::*;

    #[test]
    fn leak_and_darken_do_not_cancel() {
        let truth = uniform(10, 10, 0.5);
        let mut test = truth.clone();
        for (i, pixel) in test.sun.iter_mut().enumerate() {
            let delta = if i % 2 == 0 { 0.25 } else { -0.25 };
            pixel[..3].iter_mut().for_each(|v| *v += delta);
        }
        let got = compare(&truth, &test).unwrap().error;
        assert_eq!((got.bias, got.leak, got.darken), (0.0, 0.25, -0.25));
        assert_eq!((got.rel_rmse, got.max_abs), (0.5, 0.5));
        assert_eq!(got.transmittance_rmse, 0.0);
    }

    #[test]
    fn percentile_ignores_one_pixel_in_a_hundred_and_the_maximum_does_not() {
        let truth = uniform(10, 10, 0.5);
        let mut test = truth.clone();
        test.sun[42] = [2.5, 2.5, 2.5, 0.5];
        let got = compare(&truth, &test).unwrap().error;
        assert_eq!((got.p99_abs, got.max_abs), (0.0, 4.0));
        test.sun[43][0] = 1.0;
        assert_eq!(compare(&truth, &test).unwrap().error.p99_abs, 1.0);
    }

    #[test]
    fn pixels_outside_the_reference_cloud_are_ignored() {
        let truth = cloud(16, 8);
        let mut test = truth.clone();
        for (pixel, sky) in test
            .sun
            .iter_mut()
            .zip(truth.radiance.iter().map(|p| p[3] == 0.0))
        {
            if sky {
                *pixel = [9.0; 4];
            }
        }
        test.radiance.iter_mut().for_each(|p| p[3] = 1.0);
        let got = compare(&truth, &test).unwrap();
        assert_eq!(
            (got.error.rel_rmse, got.error.transmittance_rmse),
            (0.0, 0.0)
        );
        assert_eq!(got.cloud_pixel_fraction, 0.75);
    }

    #[test]
    fn bias_of_edges_is_that_of_thin_cloud_alone() {
        let truth = {
            let mut frame = uniform(4, 1, 0.5);
            let opacities = [0.005, 0.02, EDGE_OPACITY, 0.95];
            for (pixel, opacity) in frame.radiance.iter_mut().zip(opacities) {
                pixel[3] = opacity;
            }
            frame
        };
        let mut test = truth.clone();
        for (pixel, delta) in test.sun.iter_mut().zip([5.0, 0.25, -0.125, 7.0]) {
            pixel[..3].iter_mut().for_each(|v| *v += delta);
        }
        assert_eq!(compare(&truth, &test).unwrap().error.edge_bias, Some(0.125));
        let dense = uniform(4, 1, 0.5);
        assert_eq!(compare(&dense, &dense).unwrap().error.edge_bias, None);
    }

    #[test]
    fn mean_is_over_channels_of_cloud_pixels() {
        let mut frame = uniform(2, 1, 0.0);
        frame.sun[0] = [1.0, 2.0, 3.0, 9.0];
        assert_eq!(mean_sun(&frame).unwrap(), 1.0);
        frame.radiance[1][3] = 0.0;
        assert_eq!(mean_sun(&frame).unwrap(), 2.0);
    }
}
