//! Drawing surface in pixels, SVG or raster, on plotters: lines, shapes and text.

use super::super::style::Style;
use super::WIDTH;
use crate::error::{Error, Result};
use image::{Rgb, RgbImage};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontTransform, register_font};
use std::cell::RefCell;
use std::sync::OnceLock;

/// A point in pixels, y down.
pub type Px = (i32, i32);

/// Sizes of text, px.
pub const TITLE: f64 = 16.0;
/// Axis titles, legends.
pub const TEXT: f64 = 13.0;
/// Tick labels, captions.
pub const SMALL: f64 = 12.0;

/// Ink of text and axes.
pub const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
/// Captions.
pub const MUTED: RGBColor = RGBColor(0x55, 0x55, 0x55);
/// Grid lines.
pub const GRID: RGBColor = RGBColor(0xe3, 0xe0, 0xd8);

/// Font family that plotters measures text with and writes into the SVG, where the reader's own font replaces it.
const FAMILY: &str = "sans-serif";
/// The SVG backend divides font sizes by this.
const EM: f64 = 1.24;
/// Factor for readers' fonts that are wider than the one text is measured with.
const WIDER: f64 = 1.06;

/// Horizontal alignment of text to its point.
#[derive(Clone, Copy)]
pub enum Hang {
    /// Starts at the point.
    Right,
    /// Centred on the point.
    Middle,
    /// Ends at the point.
    Left,
}

/// A sheet being drawn.
pub struct Surface<DB: DrawingBackend> {
    area: DrawingArea<DB, Shift>,
    width_cache: RefCell<Vec<(String, u64, i32)>>,
}

/// A sheet of SVG.
pub type Canvas<'a> = Surface<SVGBackend<'a>>;

/// Draws a sheet of the usual width and the given height; the SVG text is the result.
pub fn sheet(height: i32, draw: impl FnOnce(&Canvas<'_>) -> Result<()>) -> Result<String> {
    let mut svg = String::new();
    let size = (WIDTH.unsigned_abs(), height.unsigned_abs());
    on(
        SVGBackend::with_string(&mut svg, size),
        |canvas: &Canvas<'_>| {
            canvas.area.fill(&WHITE).map_err(|e| defect(&e))?;
            draw(canvas)
        },
    )?;
    Ok(svg)
}

/// Result of `measure` on an empty sheet, since only a sheet can measure text; nothing is drawn.
pub fn measured<T>(measure: impl FnOnce(&Canvas<'_>) -> Result<T>) -> Result<T> {
    let mut unused = String::new();
    let mut out = None;
    on(
        SVGBackend::with_string(&mut unused, (1, 1)),
        |canvas: &Canvas<'_>| {
            out = Some(measure(canvas)?);
            Ok(())
        },
    )?;
    out.ok_or_else(|| defect(&"a sheet was not measured"))
}

/// A raster sheet of the given size, white where nothing is drawn.
pub fn raster(
    (width, height): (u32, u32),
    draw: impl FnOnce(&Surface<BitMapBackend<'_>>) -> Result<()>,
) -> Result<RgbImage> {
    let mut sheet = RgbImage::from_pixel(width, height, Rgb([255; 3]));
    on(
        BitMapBackend::with_buffer(&mut sheet, (width, height)),
        draw,
    )?;
    Ok(sheet)
}

fn on<DB: DrawingBackend>(
    backend: DB,
    draw: impl FnOnce(&Surface<DB>) -> Result<()>,
) -> Result<()> {
    register()?;
    let surface = Surface {
        area: backend.into_drawing_area(),
        width_cache: RefCell::default(),
    };
    draw(&surface)?;
    surface.area.present().map_err(|e| defect(&e))
}

/// Registers the font that plotters measures text with, which it needs for SVG as well.
fn register() -> Result<()> {
    static DONE: OnceLock<bool> = OnceLock::new();
    let done = *DONE.get_or_init(|| {
        [FontStyle::Normal, FontStyle::Bold]
            .into_iter()
            .all(|style| register_font(FAMILY, style, epaint_default_fonts::UBUNTU_LIGHT).is_ok())
    });
    if done {
        Ok(())
    } else {
        Err(defect(&"the built-in font is not usable"))
    }
}

fn defect(problem: &dyn std::fmt::Display) -> Error {
    Error::defect("charts", problem)
}

/// Text with control characters, which XML does not allow, replaced by U+FFFD.
fn printable(text: &str) -> String {
    text.chars()
        .map(|c| {
            if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') {
                '\u{fffd}'
            } else {
                c
            }
        })
        .collect()
}

impl<DB: DrawingBackend> Surface<DB> {
    /// A line through points.
    pub fn line(&self, points: &[Px], color: impl Color, width: u32) -> Result<()> {
        let style = color.to_rgba().stroke_width(width);
        self.area
            .draw(&PathElement::new(points.to_vec(), style))
            .map_err(|e| defect(&e))
    }

    /// A line through points, broken by `pattern`: lengths drawn and skipped in turn, px; empty for a solid line.
    pub fn dashed(
        &self,
        points: &[Px],
        color: impl Color,
        width: u32,
        pattern: &[f64],
    ) -> Result<()> {
        if pattern.is_empty() {
            return self.line(points, color, width);
        }
        dashes(points, pattern)
            .iter()
            .try_for_each(|dash| self.line(dash, color.to_rgba(), width))
    }

    /// A filled rectangle between two corners.
    pub fn rect(&self, corners: [Px; 2], color: impl Color) -> Result<()> {
        self.area
            .draw(&Rectangle::new(corners, color.to_rgba().filled()))
            .map_err(|e| defect(&e))
    }

    /// The outline of a rectangle.
    pub fn frame(&self, corners: [Px; 2], color: impl Color) -> Result<()> {
        self.area
            .draw(&Rectangle::new(corners, color.to_rgba().stroke_width(1)))
            .map_err(|e| defect(&e))
    }

    /// A ring around a point.
    pub fn ring(&self, at: Px, radius: i32, color: impl Color, width: u32) -> Result<()> {
        self.area
            .draw(&Circle::new(
                at,
                radius,
                color.to_rgba().stroke_width(width),
            ))
            .map_err(|e| defect(&e))
    }

    /// A method's marker with a radius of about `r` px; a hollow one is only an outline.
    pub fn marker(&self, at: Px, r: f64, style: Style, hollow: bool) -> Result<()> {
        let color = ink_of(style);
        let (fill, edge, width) = if hollow {
            (WHITE, color, 2)
        } else {
            (color, INK, 1)
        };
        let Some(corners) = style.corners(r) else {
            self.area
                .draw(&Circle::new(at, r as i32, fill.filled()))
                .map_err(|e| defect(&e))?;
            return self.ring(at, r as i32, edge, width);
        };
        let place = |(x, y): &(f64, f64)| (at.0 + x.round() as i32, at.1 + y.round() as i32);
        let mut points: Vec<Px> = corners.iter().map(place).collect();
        self.area
            .draw(&Polygon::new(points.clone(), fill.filled()))
            .map_err(|e| defect(&e))?;
        points.push(points[0]);
        self.line(&points, edge, width)
    }

    /// Text beside a point, centred on it vertically.
    pub fn text(&self, at: Px, text: &str, size: f64, color: RGBColor, hang: Hang) -> Result<()> {
        self.write(at, text, font(size).color(&color), hang)
    }

    /// Bold text beside a point.
    pub fn bold(&self, at: Px, text: &str, size: f64, hang: Hang) -> Result<()> {
        let font: TextStyle = (FAMILY, size * EM, FontStyle::Bold).into_font().into();
        self.write(at, text, font.color(&INK), hang)
    }

    /// Text with thicker strokes for raster sheets, which have only one font weight: drawn twice with a small offset.
    pub fn strong(&self, at: Px, text: &str, size: f64) -> Result<()> {
        self.text(at, text, size, INK, Hang::Right)?;
        self.text(
            (at.0 + (size / 20.0) as i32, at.1),
            text,
            size,
            INK,
            Hang::Right,
        )
    }

    /// Text centred on a point and rotated to read upwards.
    pub fn upright(&self, at: Px, text: &str, size: f64) -> Result<()> {
        self.write(
            at,
            text,
            font(size).color(&INK).transform(FontTransform::Rotate270),
            Hang::Middle,
        )
    }

    fn write(&self, at: Px, text: &str, style: TextStyle<'_>, hang: Hang) -> Result<()> {
        let h = match hang {
            Hang::Right => HPos::Left,
            Hang::Middle => HPos::Center,
            Hang::Left => HPos::Right,
        };
        let style = style.pos(Pos::new(h, VPos::Center));
        self.area
            .draw_text(&printable(text), &style, at)
            .map_err(|e| defect(&e))
    }

    /// Width of a text, px, with a margin for the reader's font.
    pub fn width(&self, text: &str, size: f64) -> Result<i32> {
        let key = size.to_bits();
        if let Some((_, _, w)) = self
            .width_cache
            .borrow()
            .iter()
            .find(|(t, s, _)| t == text && *s == key)
        {
            return Ok(*w);
        }
        let (w, _) = self
            .area
            .estimate_text_size(&printable(text), &font(size))
            .map_err(|e| defect(&e))?;
        let width = (f64::from(w) * WIDER).ceil() as i32;
        self.width_cache
            .borrow_mut()
            .push((text.to_owned(), key, width));
        Ok(width)
    }

    /// The text, cut to a width of at most `room` px.
    pub fn fit(&self, text: &str, size: f64, room: i32) -> Result<String> {
        let mut out = text.to_owned();
        let mut kept: Vec<char> = text.chars().collect();
        while self.width(&out, size)? > room && kept.len() > 1 {
            kept.truncate((kept.len() * 19 / 20).min(kept.len() - 1));
            out = kept.iter().collect::<String>() + "…";
        }
        Ok(out)
    }
}

/// A method's colour for plotters.
pub fn ink_of(style: Style) -> RGBColor {
    let (r, g, b) = style.rgb;
    RGBColor(r, g, b)
}

fn font(size: f64) -> TextStyle<'static> {
    (FAMILY, size * EM).into_font().into()
}

/// Cuts a line into dashes.
fn dashes(points: &[Px], pattern: &[f64]) -> Vec<Vec<Px>> {
    let mut out = Vec::new();
    let (mut slot, mut left) = (0, pattern[0]);
    for pair in points.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let length = f64::from((b.0 - a.0).pow(2) + (b.1 - a.1).pow(2)).sqrt();
        let at = |s: f64| {
            let lerp =
                |p: i32, q: i32| (f64::from(p) + f64::from(q - p) * s / length).round() as i32;
            (lerp(a.0, b.0), lerp(a.1, b.1))
        };
        let mut s = 0.0;
        while s < length {
            let end = (s + left).min(length);
            if slot % 2 == 0 {
                out.push(vec![at(s), at(end)]);
            }
            left -= end - s;
            s = end;
            if left < 1e-3 {
                slot = (slot + 1) % pattern.len();
                left = pattern[slot].max(1.0);
            }
        }
    }
    out
}
