//! Ghosting: what temporal integration adds to the error of each frame of a moving camera.

use super::super::format::number;
use super::super::style::Style;
use super::super::view::{Case, Shot, View};
use super::axis::Axis;
use super::canvas::{ink_of, sheet};
use super::plot::{Key, Plot, caption, legend, title};
use crate::batch::record::Ghosting;
use crate::error::Result;
use crate::scene::CameraTrack;

/// How the lines of one method are told apart.
const PATTERNS: [&[f64]; 4] = [&[], &[7.0, 4.0], &[2.0, 3.0], &[10.0, 3.0, 2.0, 3.0]];

/// A cell with its curve, and how its line looks.
struct Line<'a> {
    shot: Shot<'a>,
    curve: &'a Ghosting,
    style: Style,
    pattern: &'static [f64],
}

/// Heading of a movement's chart.
pub const fn title_of(track: CameraTrack) -> &'static str {
    match track {
        CameraTrack::Pan => "Ghosting on a pan",
        CameraTrack::Dolly => "Ghosting on a dolly",
    }
}

/// The chart of one movement; `None` when no cell was measured along it.
pub fn draw(view: &View<'_>, case: &Case<'_>, track: CameraTrack) -> Result<Option<String>> {
    let lines = lines(case, track);
    let Some(first) = lines.first() else {
        return Ok(None);
    };
    let motion = motion(first.curve);
    let height = 480 + 16 * i32::try_from(lines.len() / 3).unwrap_or(0).min(30);
    let svg = sheet(height, |canvas| {
        let top = title(canvas, title_of(track), &case.short_name)?;
        let key = |l: &Line<'_>| {
            let label = view.short_without(l.shot.cell, &["reconstruct"]);
            (Key::Line(l.style, l.pattern), label)
        };
        let top = legend(canvas, top, &lines.iter().map(key).collect::<Vec<_>>())?;
        let frames = lines.iter().map(|l| l.curve.rel_rmse.len());
        let last = frames.max().unwrap_or(0).saturating_sub(1);
        let x = Axis::from_zero("frame (0: at rest)", [last as f64].into_iter());
        let values = lines.iter().flat_map(|l| l.curve.rel_rmse.iter().copied());
        let y = Axis::from_zero("relative RMSE against the full render", values);
        let plot = Plot::new(top, height, 84, x, y);
        plot.draw(canvas)?;
        for line in &lines {
            let values = line.curve.rel_rmse.iter().enumerate();
            let path: Vec<_> = values
                .map(|(frame, value)| (plot.px(frame as f64), plot.py(*value)))
                .collect();
            canvas.dashed(&path, ink_of(line.style), 2, line.pattern)?;
            path.iter()
                .try_for_each(|at| canvas.marker(*at, 4.0, line.style, false))?;
        }
        let note = format!("{motion} Each frame against its own full render.");
        caption(canvas, view, height, &note)
    })?;
    Ok(Some(svg))
}

fn lines<'a>(case: &Case<'a>, track: CameraTrack) -> Vec<Line<'a>> {
    let mut lines: Vec<Line<'a>> = Vec::new();
    for shot in case.shots() {
        let parts = shot.numbers.reconstruction.as_ref();
        if let Some(curve) = parts.and_then(|parts| parts.ghosting.get(&track)) {
            let method = &shot.cell.method;
            let rank = lines.iter().filter(|l| l.shot.cell.method == *method);
            lines.push(Line {
                shot,
                curve,
                pattern: PATTERNS[rank.count() % PATTERNS.len()],
                style: Style::of(method),
            });
        }
    }
    lines
}

/// How the camera moves from frame to frame, in words.
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
