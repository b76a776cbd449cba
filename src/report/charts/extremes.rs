//! T along a light column where a form breaks or rings: the truth, the form, and the stable form beside it.

use super::super::style::{Marker, Style};
use super::WIDTH;
use super::axis::Axis;
use super::canvas::{Hang, MUTED, SMALL, ink_of, sheet};
use super::plot::{Key, MARGIN, Plot, legend, title};
use crate::error::Result;

/// Height of a chart, px.
const HEIGHT: i32 = 400;
/// Marks depths without a number.
const NOT_FINITE: Style = Style {
    rgb: (0xa3, 0x21, 0x0f),
    marker: Marker::Cross,
};

/// One curve.
pub struct Curve {
    /// What the legend says.
    pub label: String,
    /// Method id.
    pub method: String,
    /// Lengths drawn and skipped in turn, px; empty for a solid line.
    pub pattern: &'static [f64],
    /// Depth as a share of the column, and T; `None` where it is not finite.
    pub points: Vec<(f64, Option<f64>)>,
}

/// The chart; `note` is its caption.
pub fn draw(what: &str, of: &str, note: &str, curves: &[Curve]) -> Result<String> {
    sheet(HEIGHT, |canvas| {
        let top = title(canvas, what, of)?;
        let mut keys: Vec<_> = curves
            .iter()
            .map(|c| (Key::Line(Style::of(&c.method), c.pattern), c.label.clone()))
            .collect();
        let holes = curves
            .iter()
            .any(|c| c.points.iter().any(|(_, t)| t.is_none()));
        if holes {
            keys.push((Key::Marker(NOT_FINITE), "not finite".to_owned()));
        }
        let top = legend(canvas, top, &keys)?;
        let x = Axis::from_zero("depth, share of the column", [0.0, 1.0].into_iter());
        let y = Axis::from_zero("T", [0.0, 1.0].into_iter());
        let plot = Plot::new(top, HEIGHT, 84, x, y);
        plot.draw(canvas)?;
        for curve in curves {
            let style = Style::of(&curve.method);
            let pixel = |(d, t): &(f64, f64)| (plot.px(*d), plot.py(*t));
            let mut run = Vec::new();
            for (d, t) in &curve.points {
                match t {
                    Some(t) => run.push(pixel(&(*d, *t))),
                    None => {
                        canvas.dashed(&run, ink_of(style), 2, curve.pattern)?;
                        run.clear();
                        canvas.marker(pixel(&(*d, 1.0)), 3.0, NOT_FINITE, false)?;
                    }
                }
            }
            canvas.dashed(&run, ink_of(style), 2, curve.pattern)?;
        }
        let note = canvas.fit(note, SMALL, WIDTH - 2 * MARGIN)?;
        canvas.text((MARGIN, HEIGHT - 14), &note, SMALL, MUTED, Hang::Right)
    })
}
