//! Ghosting: error of a picture reconstructed from several frames against one of which every pixel was marched.

use super::linear::readable;
use super::{CLOUD_OPACITY, check_pair, mean_sun};
use crate::error::Result;
use crate::frame::Frame;

/// √Σ(L̂ − L)² / √ΣL² over RGB, L the sun-lit radiance of `full`, L̂ that of `rebuilt`; ≥ 0, dimensionless.
///
/// Pixels count where either picture shows cloud, so that a trail over clear sky is error too. Channels that are not finite
/// are read as 0, as in [`super::compare`].
pub fn ghosting(full: &Frame, rebuilt: &Frame) -> Result<f64> {
    check_pair(full, rebuilt)?;
    mean_sun(full)?;
    let (mut squared, mut scale) = (0.0, 0.0);
    for (i, pixel) in full.radiance.iter().enumerate() {
        if pixel[3].max(rebuilt.radiance[i][3]) > CLOUD_OPACITY {
            for c in 0..3 {
                let light = f64::from(full.sun[i][c]);
                squared += (readable(rebuilt.sun[i][c]) - light).powi(2);
                scale += light.powi(2);
            }
        }
    }
    Ok((squared / scale).sqrt())
}

#[cfg(test)]
mod tests {
    use super::super::relative_rmse;
    use super::super::testing::{cloud, uniform};
    use super::*;

    #[test]
    fn a_trail_over_clear_sky_counts_and_changed_sky_does_not() {
        let full = {
            let mut frame = uniform(4, 1, 0.5);
            for i in [2, 3] {
                (frame.radiance[i], frame.sun[i]) = ([0.1, 0.2, 0.4, 0.0], [0.0; 4]);
            }
            frame
        };
        let mut rebuilt = full.clone();
        (rebuilt.radiance[2], rebuilt.sun[2]) = ([0.5, 0.5, 0.5, 1.0], [0.5; 4]);
        // One pixel of 0.5 too much, two of 0.5 to scale it.
        let expected = 0.5_f64.sqrt();
        assert!((ghosting(&full, &rebuilt).unwrap() - expected).abs() < 1e-12);
        assert_eq!(relative_rmse(&full, &full, &rebuilt).unwrap(), 0.0);
        // The reverse: cloud that is missing.
        assert!((ghosting(&rebuilt, &full).unwrap() - (1.0_f64 / 3.0).sqrt()).abs() < 1e-12);
        let mut sky = full.clone();
        sky.sun[3] = [9.0; 4];
        assert_eq!(ghosting(&full, &sky).unwrap(), 0.0);
    }

    #[test]
    fn over_cloud_alone_it_is_the_relative_error() {
        let (full, rebuilt) = (uniform(4, 2, 0.5), uniform(4, 2, 0.25));
        assert_eq!(ghosting(&full, &rebuilt).unwrap(), 0.5);
        let mut broken = full.clone();
        broken.sun[0][0] = f32::NAN;
        assert!(ghosting(&full, &broken).unwrap() > 0.0);
        assert!(ghosting(&uniform(4, 2, 0.0), &rebuilt).is_err());
        assert!(ghosting(&cloud(4, 2), &cloud(2, 4)).is_err());
    }
}
