//! Parts that all charts share: title, legend, axes with grid, lines at the foot.

use super::super::style::Style;
use super::WIDTH;
use super::axis::{Axis, CROWDED, Tick};
use super::canvas::{Canvas, GRID, Hang, INK, MUTED, Px, SMALL, TEXT, TITLE, ink_of};
use super::chart::{DOTTED, Dash};
use crate::error::Result;
use plotters::style::RGBColor;

/// Left and right margin, px.
pub const MARGIN: i32 = 16;
/// Room under a plot for tick labels and the axis title.
const UNDER: i32 = 48;
/// Room for the two caption lines.
const CAPTION: i32 = 44;

/// Symbol of a legend entry.
#[derive(Clone, Debug)]
pub enum Key {
    /// A method's marker.
    Marker(Style),
    /// A method's marker without filling.
    Hollow(Style),
    /// A line of a method's colour; true: with its marker.
    Line(Style, Dash, bool),
    /// A thin grey line; true: with a ring.
    Thin(Dash, bool),
    /// A box with this colour and opacity, 0…1.
    Swatch(RGBColor, f64),
}

/// Dash pattern of the frontier's line, px.
pub const FRONTIER_DASH: Dash = &[5.0, 4.0];

/// Room below a plot, px: tick labels, axis title, lines at the foot.
pub const BELOW: i32 = UNDER + CAPTION;

/// Draws the title `what` and below it scene and sun (`of`); returns the next free row, px.
pub fn title(canvas: &Canvas<'_>, what: &str, of: &str) -> Result<i32> {
    canvas.bold((MARGIN, 20), what, TITLE, Hang::Right)?;
    let of = canvas.fit(of, TEXT, WIDTH - 2 * MARGIN)?;
    canvas.text((MARGIN, 42), &of, TEXT, INK, Hang::Right)?;
    Ok(58)
}

/// Draws the legend in as many rows as needed; returns the next free row, px.
pub fn legend(canvas: &Canvas<'_>, top: i32, entries: &[(Key, String)]) -> Result<i32> {
    let (mut x, mut y) = (MARGIN, top + 9);
    for (key, text) in entries {
        let text = canvas.fit(text, TEXT, 300)?;
        let lead = if matches!(key, Key::Line(..) | Key::Thin(..)) {
            42
        } else {
            20
        };
        let width = lead + canvas.width(&text, TEXT)? + 18;
        if x + width > WIDTH - MARGIN / 2 && x > MARGIN {
            (x, y) = (MARGIN, y + 21);
        }
        draw_key(canvas, (x, y), key)?;
        canvas.text((x + lead, y), &text, TEXT, INK, Hang::Right)?;
        x += width;
    }
    Ok(y + 20)
}

fn draw_key(canvas: &Canvas<'_>, (x, y): Px, key: &Key) -> Result<()> {
    match key {
        Key::Marker(style) => canvas.marker((x + 7, y), 5.0, *style, false),
        Key::Hollow(style) => canvas.marker((x + 7, y), 5.0, *style, true),
        Key::Line(style, dash, marker) => {
            canvas.dashed(&[(x, y), (x + 34, y)], ink_of(*style), 2, dash)?;
            if *marker {
                canvas.marker((x + 17, y), 4.0, *style, false)?;
            }
            Ok(())
        }
        Key::Thin(dash, ring) => {
            canvas.dashed(&[(x, y), (x + 34, y)], MUTED, 1, dash)?;
            if *ring {
                canvas.ring((x + 17, y), 9, INK, 2)?;
            }
            Ok(())
        }
        Key::Swatch(color, alpha) => {
            use plotters::style::Color as _;
            canvas.rect([(x, y - 6), (x + 14, y + 6)], color.mix(*alpha))?;
            canvas.frame([(x, y - 6), (x + 14, y + 6)], *color)
        }
    }
}

/// Draws two lines at the foot: the source of the numbers, and a note. An empty line is left out.
pub fn foot(canvas: &Canvas<'_>, source: &str, height: i32, note: &str) -> Result<()> {
    for (text, y) in [(source, height - 32), (note, height - 14)] {
        if !text.is_empty() {
            let text = canvas.fit(text, SMALL, WIDTH - 2 * MARGIN)?;
            canvas.text((MARGIN, y), &text, SMALL, MUTED, Hang::Right)?;
        }
    }
    Ok(())
}

/// The rectangle of the data with its two axes.
pub struct Plot {
    /// Left, top, right, bottom in px.
    pub bounds: [i32; 4],
    x: Axis,
    y: Axis,
}

impl Plot {
    /// A plot from `top` down to the caption of a sheet of `height`, with `left` px for the y axis.
    pub fn new(top: i32, height: i32, left: i32, x: Axis, y: Axis) -> Self {
        Self {
            bounds: [left, top, WIDTH - 24, height - BELOW],
            x,
            y,
        }
    }

    /// Pixel column of a value.
    pub fn px(&self, value: f64) -> i32 {
        let [left, _, right, _] = self.bounds;
        left + (self.x.at(value) * f64::from(right - left)).round() as i32
    }

    /// Pixel row of a value.
    pub fn py(&self, value: f64) -> i32 {
        let [_, top, _, bottom] = self.bounds;
        bottom - (self.y.at(value) * f64::from(bottom - top)).round() as i32
    }

    /// Line right of the separate position of zero on the x axis, if there is one.
    pub fn break_line(&self) -> Vec<Px> {
        let [left, top, right, bottom] = self.bounds;
        let x = |share: f64| left + (share * f64::from(right - left)).round() as i32;
        self.x
            .break_at()
            .map(|s| vec![(x(s), top), (x(s), bottom)])
            .unwrap_or_default()
    }

    /// Grid, frame, tick labels and axis titles.
    pub fn draw(&self, canvas: &Canvas<'_>) -> Result<()> {
        self.draw_x(canvas)?;
        self.draw_y(canvas)?;
        let [left, top, right, bottom] = self.bounds;
        canvas.frame([(left, top), (right, bottom)], INK)
    }

    /// Vertical grid lines and the x axis alone.
    pub fn draw_x(&self, canvas: &Canvas<'_>) -> Result<()> {
        let [left, top, right, bottom] = self.bounds;
        let at = |t: &Tick| left + (t.at * f64::from(right - left)).round() as i32;
        let ticks = self.x.ticks();
        ticks
            .iter()
            .try_for_each(|t| canvas.line(&[(at(t), top), (at(t), bottom)], GRID, 1))?;
        let mut taken: Vec<(i32, i32)> = Vec::new();
        for tick in by_rank(&ticks) {
            let half = canvas.width(&tick.text, SMALL)? / 2;
            let span = (at(tick) - half - 6, at(tick) + half + 6);
            let inside = span.1 < WIDTH && span.0 > 0;
            if inside && taken.iter().all(|t| span.1 < t.0 || span.0 > t.1) {
                canvas.line(&[(at(tick), bottom), (at(tick), bottom + 5)], INK, 1)?;
                canvas.text(
                    (at(tick), bottom + 14),
                    &tick.text,
                    SMALL,
                    INK,
                    Hang::Middle,
                )?;
                taken.push(span);
            }
        }
        canvas.dashed(&self.break_line(), MUTED, 1, DOTTED)?;
        canvas.text(
            ((left + right) / 2, bottom + 35),
            &self.x.title,
            TEXT,
            INK,
            Hang::Middle,
        )
    }

    fn draw_y(&self, canvas: &Canvas<'_>) -> Result<()> {
        let [left, top, right, bottom] = self.bounds;
        let at = |t: &Tick| bottom - (t.at * f64::from(bottom - top)).round() as i32;
        let ticks = self.y.ticks();
        ticks
            .iter()
            .try_for_each(|t| canvas.line(&[(left, at(t)), (right, at(t))], GRID, 1))?;
        let mut taken: Vec<i32> = Vec::new();
        for tick in by_rank(&ticks) {
            if taken.iter().all(|t| (at(tick) - t).abs() >= 17) {
                canvas.line(&[(left - 5, at(tick)), (left, at(tick))], INK, 1)?;
                canvas.text((left - 8, at(tick)), &tick.text, SMALL, INK, Hang::Left)?;
                taken.push(at(tick));
            }
        }
        if let Some(share) = self.y.break_at() {
            let y = bottom - (share * f64::from(bottom - top)).round() as i32;
            canvas.dashed(&[(left, y), (right, y)], MUTED, 1, DOTTED)?;
        }
        canvas.upright((18, (top + bottom) / 2), &self.y.title, TEXT)
    }
}

/// Ticks that may get a label, by rank; those of rank [`CROWDED`] only where there are fewer than four others.
fn by_rank(ticks: &[Tick]) -> Vec<&Tick> {
    let few = ticks.iter().filter(|t| t.rank < CROWDED).count() < 4;
    let mut out: Vec<&Tick> = ticks.iter().filter(|t| few || t.rank < CROWDED).collect();
    out.sort_by_key(|t| t.rank);
    out
}
