//! Pictures of extremes on the device, recorded beside the oracle's verdict.

use super::record::{FormVerdict, SweepPicture};
use crate::error::{Error, Result};
use crate::frame::{Frame, is_nonfinite};
use crate::occlusion::MethodSetup;
use crate::progress::unwatched;
use crate::raymarch::{DeviceView, Renderer};

/// Pixels whose opacity in the truth is less are left out: V is not defined there.
const LEAST_OPACITY: f32 = 1e-6;
/// Tolerance of V outside `[0, 1]`: V is a ratio of two f32 sums.
const TOLERANCE: f64 = 1e-4;

/// Renders a method in a view and inspects the stored bits; a device error is a result, too.
pub(super) fn measure(
    renderer: &Renderer,
    view: &DeviceView,
    setup: &MethodSetup,
    truth: &Frame,
) -> Result<SweepPicture> {
    match render(renderer, view, setup) {
        Ok((frame, nonfinite_stored)) => Ok(judge(&frame, nonfinite_stored, truth)),
        Err(error) if error.concerns_one_cell() => Ok(failed(&error)),
        Err(error) => Err(error),
    }
}

/// The record of a picture that was not made.
pub(super) fn failed(error: &Error) -> SweepPicture {
    SweepPicture {
        verdict: FormVerdict::Failed,
        reason: Some(error.to_string()),
        nonfinite: 0,
        nonfinite_stored: 0,
        range: None,
        max_error: None,
    }
}

/// A picture, and how many values of the map are not finite.
pub(super) fn render(
    renderer: &Renderer,
    view: &DeviceView,
    setup: &MethodSetup,
) -> Result<(Frame, u64)> {
    let prepared = renderer.prepare_full(view, setup)?;
    prepared.run(&renderer.gpu, &mut unwatched)?;
    let frame = view.read(&renderer.gpu)?;
    let texels = prepared.map_texels(&renderer.gpu)?;
    Ok((frame, texels.map_or(0, |texels| texels.nonfinite())))
}

/// Channels that are not finite.
pub(super) fn nonfinite(frame: &Frame) -> u64 {
    let channels = frame.radiance.iter().chain(&frame.sun).flatten();
    channels.filter(|value| is_nonfinite(**value)).count() as u64
}

fn judge(frame: &Frame, nonfinite_stored: u64, truth: &Frame) -> SweepPicture {
    let nonfinite = nonfinite(frame);
    let seen = |i: &usize| truth.radiance[*i][3] > LEAST_OPACITY && !is_nonfinite(frame.sun[*i][3]);
    let (mut range, mut max_error): (Option<[f64; 2]>, Option<f64>) = (None, None);
    for i in (0..frame.sun.len()).filter(seen) {
        let [v, expected] = [frame, truth].map(|f| f64::from(f.sun[i][3]));
        let [low, high] = range.unwrap_or([v, v]);
        range = Some([low.min(v), high.max(v)]);
        max_error = Some(max_error.unwrap_or(0.0).max((v - expected).abs()));
    }
    let mut problems = Vec::new();
    if nonfinite > 0 {
        problems.push(format!("{nonfinite} channels are not finite"));
    }
    if nonfinite_stored > 0 {
        problems.push(format!("{nonfinite_stored} stored values are not finite"));
    }
    if let Some([low, high]) = range
        && (low < -TOLERANCE || high > 1.0 + TOLERANCE)
    {
        problems.push(format!("V is in {low:.3}…{high:.3}"));
    }
    SweepPicture {
        verdict: if problems.is_empty() {
            FormVerdict::Ok
        } else {
            FormVerdict::Breaks
        },
        reason: (!problems.is_empty()).then(|| problems.join("; ")),
        nonfinite,
        nonfinite_stored,
        range,
        max_error,
    }
}
