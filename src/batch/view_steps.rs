//! What a scene's own view steps cost: the error that truth and methods share, so that no cell shows it.

use super::Task;
use crate::backend::View;
use crate::error::{Error, Result};
use crate::metrics::compare;
use crate::occlusion::MethodSetup;
use crate::raymarch::unwatched;

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
    match compare(&finer, &own) {
        Ok(comparison) => Ok((Some(comparison.error.rel_rmse), passes_s)),
        // Nothing of the cloud is lit: there is no error to speak of, and every cell says the same.
        Err(Error::Input { .. }) => Ok((None, passes_s)),
        Err(error) => Err(error),
    }
}
