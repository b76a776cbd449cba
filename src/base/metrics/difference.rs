//! Signed differences pixel by pixel, for false-colour pictures and for flicker.

use super::linear::readable;
use super::{CLOUD_OPACITY, check_pair};
use crate::error::Result;
use crate::frame::{Frame, false_colour, is_nonfinite, luminance};

/// |ΔL| / mean L at the end colours of a difference picture: the same scale for every picture.
pub const DIFF_SCALE: f32 = 1.0;

/// The signed error of `test` as RGB, three bytes a pixel: [`delta_luminance`] in false colours that end at
/// ±[`DIFF_SCALE`] × the reference's mean sun-lit luminance.
pub fn difference_picture(reference: &Frame, test: &Frame) -> Result<Vec<u8>> {
    let delta = delta_luminance(reference, test)?;
    let scale = DIFF_SCALE * super::mean_sun(reference)? as f32;
    Ok(false_colour(test.width, test.height, &delta, scale))
}

/// ΔL of each channel of the sun-lit radiance, three values a pixel, unit of radiance: the input of [`super::Flicker`].
///
/// NaN outside the reference's cloud pixels ("no value"); a NaN or infinite channel of the test is read as 0, as in
/// [`super::compare`].
pub fn delta_rgb(reference: &Frame, test: &Frame) -> Result<Vec<f32>> {
    check_pair(reference, test)?;
    let pixels = reference.radiance.iter().zip(&reference.sun).zip(&test.sun);
    let delta = |((view, truth), value): ((&[f32; 4], &[f32; 4]), &[f32; 4])| {
        [0, 1, 2].map(|c| {
            let cloud = view[3] > CLOUD_OPACITY;
            if cloud {
                (readable(value[c]) - f64::from(truth[c])) as f32
            } else {
                f32::NAN
            }
        })
    };
    Ok(pixels.flat_map(delta).collect())
}

/// Luminance of ΔL, one value a pixel, unit of radiance: the input of [`crate::frame::false_colour`].
///
/// 0 outside the reference's cloud pixels; NaN (painted magenta) where the test's sun-lit radiance is not finite.
/// Luminance weights: ITU-R BT.709-6, 2015.
pub fn delta_luminance(reference: &Frame, test: &Frame) -> Result<Vec<f32>> {
    difference(reference, reference, test)
}

/// [`delta_luminance`] of `to` − `from`, both seen at the reference's cloud pixels: one part of an error.
pub fn difference(reference: &Frame, from: &Frame, to: &Frame) -> Result<Vec<f32>> {
    check_pair(reference, from)?;
    check_pair(reference, to)?;
    let pixels = reference.radiance.iter().zip(&from.sun).zip(&to.sun);
    let delta = |((view, from), to): ((&[f32; 4], &[f32; 4]), &[f32; 4])| {
        if [from, to]
            .iter()
            .any(|p| p[..3].iter().any(|v| is_nonfinite(*v)))
        {
            f32::NAN
        } else if view[3] > CLOUD_OPACITY {
            (luminance(*to) - luminance(*from)) as f32
        } else {
            0.0
        }
    };
    Ok(pixels.map(delta).collect())
}

/// √Σ(to − from)² / √ΣL² over RGB and the reference's cloud pixels, L the reference's sun-lit radiance, ≥ 0: `rel_rmse`
/// of one part of an error. Channels that are not finite are read as 0, as in [`super::compare`].
pub fn relative_rmse(reference: &Frame, from: &Frame, to: &Frame) -> Result<f64> {
    check_pair(reference, from)?;
    check_pair(reference, to)?;
    super::mean_sun(reference)?;
    let (mut squared, mut scale) = (0.0, 0.0);
    for (i, view) in reference.radiance.iter().enumerate() {
        if view[3] > CLOUD_OPACITY {
            for c in 0..3 {
                squared += (readable(to.sun[i][c]) - readable(from.sun[i][c])).powi(2);
                scale += f64::from(reference.sun[i][c]).powi(2);
            }
        }
    }
    Ok((squared / scale).sqrt())
}

#[cfg(test)]
mod tests {
    use super::super::testing::{cloud, uniform};
    use super::*;

    #[test]
    fn constant_offset_comes_back() {
        let (truth, test) = (uniform(4, 2, 0.5), uniform(4, 2, 0.25));
        assert_eq!(delta_rgb(&truth, &test).unwrap(), vec![-0.25; 24]);
        assert!(
            delta_luminance(&truth, &test)
                .unwrap()
                .iter()
                .all(|d| (d + 0.25).abs() < 1e-6)
        );
    }

    #[test]
    fn parts_of_an_error_add_up_and_have_its_scale() {
        let (truth, half, test) = (cloud(8, 4), uniform(8, 4, 0.4), uniform(8, 4, 0.7));
        let whole = delta_luminance(&truth, &test).unwrap();
        let parts = [
            difference(&truth, &truth, &half).unwrap(),
            difference(&truth, &half, &test).unwrap(),
        ];
        for (i, whole) in whole.iter().enumerate() {
            assert!((parts[0][i] + parts[1][i] - whole).abs() < 1e-6);
        }
        let error = super::super::compare(&truth, &test).unwrap().error;
        let same = relative_rmse(&truth, &truth, &test).unwrap();
        assert!((same - error.rel_rmse).abs() < 1e-12);
        assert!(relative_rmse(&uniform(4, 4, 0.0), &uniform(4, 4, 0.1), &test).is_err());
    }

    #[test]
    fn sky_and_broken_pixels_are_told_apart() {
        let truth = cloud(4, 1);
        let mut test = truth.clone();
        test.sun[0][1] = f32::NAN;
        let (rgb, lum) = (
            delta_rgb(&truth, &test).unwrap(),
            delta_luminance(&truth, &test).unwrap(),
        );
        assert_eq!(rgb[..3], [0.0, -truth.sun[0][1], 0.0]);
        assert!(rgb[9..].iter().all(|d| d.is_nan()));
        assert!(lum[0].is_nan());
        assert_eq!(lum[1..], [0.0; 3]);
    }

    #[test]
    fn sizes_must_agree() {
        assert!(delta_rgb(&cloud(4, 2), &cloud(2, 4)).is_err());
        assert!(delta_luminance(&cloud(4, 2), &cloud(2, 4)).is_err());
    }
}
