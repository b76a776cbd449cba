//! Chart of ghosting: error of each frame of a moving camera, reconstructed with a history, against its full render.

use super::super::format::number;
use super::super::view::{CellGroup, ReportView, Shot};
use super::axis::{AxisSpec, Scale};
use super::cells::apart;
use super::chart::{Data, Plane, Point};
use crate::batch::record::{Ghosting, Measured};
use crate::scene::CameraTrack;

/// Curves of one camera track; `None` when no cell was measured along it.
pub fn data(
    view: &ReportView<'_>,
    case: &CellGroup<'_>,
    track: CameraTrack,
) -> Option<(Data, String)> {
    let mut shots = case.shots();
    shots.retain(|shot| curve(shot.numbers, track).is_some());
    let first = curve(shots.first()?.numbers, track)?;
    let note = format!("{} Each frame against its own full render.", motion(first));
    let line = |shot: &Shot<'_>| {
        let errors = curve(shot.numbers, track).map(|curve| &curve.rel_rmse);
        let errors = errors.into_iter().flatten().enumerate();
        errors
            .map(|(frame, error)| Point::at(frame as f64, *error))
            .collect()
    };
    let lines = shots.iter().map(|shot| {
        let label = view.short_without(shot.cell, &["reconstruct"]);
        (label, shot.cell.method.as_str(), line(shot))
    });
    let plane = Plane {
        x: AxisSpec::new("frame (0: at rest)", Scale::Linear),
        y: AxisSpec::new("relative RMSE against the full render", Scale::Linear),
        series: apart(lines),
        levels: Vec::new(),
        places: Vec::new(),
    };
    Some((Data::Plane(plane), note))
}

fn curve(numbers: &Measured, track: CameraTrack) -> Option<&Ghosting> {
    numbers.reconstruction.as_ref()?.ghosting.get(&track)
}

/// Text on the camera's step from frame to frame.
pub fn motion(curve: &Ghosting) -> String {
    match (curve.step_deg, curve.step_m) {
        (Some(step_deg), _) => format!("A turn of {}° a frame: one pixel.", number(step_deg)),
        (None, Some(step_m)) => format!(
            "{} m sideways a frame: one pixel in the middle of the layer.",
            number(step_m)
        ),
        (None, None) => String::new(),
    }
}
