//! Error of a scene's own view steps: truth and methods share it, so that no cell's error contains it.

use super::Task;
use crate::backend::View;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::metrics::{Incomparable, compare};
use crate::occlusion::MethodSetup;
use crate::progress::unwatched;

/// `rel_rmse` of a scene's view steps against four times as many, and the seconds of the passes; see
/// [`super::record::Reference::view_step_rel_rmse`].
pub(super) fn view_step_error(task: &Task, view: &View) -> Result<(Option<f64>, f64)> {
    let camera_m = view.scene.camera.far_m.unwrap_or(f64::INFINITY);
    let longest_m = view.scene.container.longest_path_m().min(camera_m);
    let Some(march) = view.scene.march.quartered(longest_m) else {
        return Ok((None, 0.0));
    };
    let mut finer = view.scene.clone();
    finer.march = march;
    let light = MethodSetup::defaults("srm")?
        .with("spacing", "quadratic")?
        .with("steps", "20")?;
    let (own, own_times) = task
        .backend
        .render(&view.scene, view.image, &light, &mut unwatched)?;
    let (finer, finer_times) = task
        .backend
        .render(&finer, view.image, &light, &mut unwatched)?;
    let passes_s = (own_times.wall + finer_times.wall) * 1e-3;
    Ok((error_of(&finer, &own)?, passes_s))
}

/// `rel_rmse` of the scene's own steps; `None` where nothing of the cloud is lit, so that no relative error is defined.
fn error_of(finer: &Frame, own: &Frame) -> Result<Option<f64>> {
    match compare(finer, own) {
        Ok(comparison) => Ok(Some(comparison.error.rel_rmse)),
        Err(Incomparable::Unlit(_)) => Ok(None),
        Err(Incomparable::NotFinite(channels)) => Err(Error::gpu(
            format!(
                "the picture of four times the view steps has {channels} channels that are NaN or infinite"
            ),
            "Nothing can be measured in this view: try another adapter or driver, or `--backend cpu`.",
        )),
        Err(Incomparable::Unfit(error)) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uniform(level: f32) -> Frame {
        Frame {
            width: 4,
            height: 4,
            radiance: vec![[level, level, level, 1.0]; 16],
            sun: vec![[level; 4]; 16],
        }
    }

    #[test]
    fn a_picture_that_is_not_finite_is_an_error_and_only_an_unlit_one_has_no_number() {
        let lit = uniform(0.5);
        assert_eq!(error_of(&lit, &lit).unwrap(), Some(0.0));
        assert_eq!(error_of(&uniform(0.0), &lit).unwrap(), None);
        let mut broken = lit.clone();
        broken.sun[3] = [f32::NAN; 4];
        let error = error_of(&broken, &lit).unwrap_err();
        assert!(error.to_string().contains("4 channels that are NaN"));
        assert!(error.concerns_one_cell() && error_of(&lit, &broken).is_ok());
        let mut short = lit.clone();
        short.sun.pop();
        assert!(error_of(&short, &lit).is_err());
    }
}
