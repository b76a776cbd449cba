//! Contact sheet: the truth and one cell of every method in one PNG, for a README or a slide.
//!
//! A tile is a heading, the picture, and below it its signed difference from the truth; in the truth's tile the scale
//! of the differences takes that place.

mod layout;

use super::charts::canvas::{GRID, Hang, INK, MUTED, Surface, raster};
use super::files;
use super::format::{ms, number};
use super::style::Style;
use super::view::{CellGroup, ReportView, Shot};
use crate::error::{Error, Result};
use crate::frame::false_colour;
use image::imageops::{self, FilterType};
use image::{Rgb, RgbImage};
use layout::{FINER, FOOT, HEAD, Layout, MARGIN, TOP};
use plotters::prelude::DrawingBackend;
use serde_json::{Map, Value};
use std::path::Path;

/// Prefix of the file names of all sheets.
pub const KIND: &str = "methods";

/// Font sizes in units of the layout.
const HEADING: f64 = 22.0;
const TEXT: f64 = 17.5;

/// The sheet of one case.
pub struct Sheet {
    /// File name, in the folder of the charts.
    pub file: String,
    /// [`CellGroup::number`] of the case it shows.
    pub case: usize,
    /// The PNG.
    pub png: Vec<u8>,
}

/// The sheets of all cases that have pictures.
pub fn all(folder: &Path, view: &ReportView<'_>) -> Result<Vec<Sheet>> {
    let mut out = Vec::new();
    for case in &view.cases {
        if let Some(picture) = draw(folder, view, case)? {
            out.push(Sheet {
                file: format!("{KIND}-{}.png", case.slug),
                case: case.number,
                png: files::png(&picture).map_err(defect)?,
            });
        }
    }
    Ok(out)
}

fn defect(problem: image::ImageError) -> Error {
    Error::defect("contact sheet", problem)
}

/// Representative cell of a method: the median one of its settings by error, for an even number the lower median.
pub fn typical<'a>(case: &CellGroup<'a>, method: &str) -> Option<Shot<'a>> {
    let shots = case.by_error(method);
    shots.get(shots.len().saturating_sub(1) / 2).copied()
}

/// Content of one tile.
struct ContactTile {
    method: String,
    heading: String,
    numbers: String,
    picture: Result<RgbImage, String>,
    /// Signed difference from the truth; `None` for the truth.
    difference: Option<Result<RgbImage, String>>,
}

fn tiles(folder: &Path, view: &ReportView<'_>, case: &CellGroup<'_>) -> Vec<ContactTile> {
    let read = |files: &Map<String, Value>, key: &str| match files.get(key) {
        Some(Value::String(name)) => files::picture(folder, name).map(|(_, picture)| picture),
        _ => Err(format!("the record names no `{key}` picture")),
    };
    let truth = case.reference.map(|reference| ContactTile {
        method: "truth".to_owned(),
        heading: "truth".to_owned(),
        numbers: format!("1000-step reference · {}", ms(reference.march_ms)),
        picture: read(&reference.files, "png"),
        difference: None,
    });
    let shots = case.methods().into_iter().filter_map(|m| typical(case, m));
    let others = shots.map(|shot| ContactTile {
        method: shot.cell.method.clone(),
        heading: view.short(shot.cell),
        numbers: format!(
            "rel_rmse {} · {} · {}",
            number(shot.rel_rmse()),
            ms(shot.time_ms()),
            shot.memory()
        ),
        picture: read(&shot.numbers.files, "png"),
        difference: Some(read(&shot.numbers.files, "diff_png")),
    });
    truth.into_iter().chain(others).collect()
}

/// Draws the sheet of a case; `None` when it has no cell with numbers or no picture can be read.
fn draw(folder: &Path, view: &ReportView<'_>, case: &CellGroup<'_>) -> Result<Option<RgbImage>> {
    let tiles = tiles(folder, view, case);
    let sample = tiles.iter().find_map(|t| t.picture.as_ref().ok());
    let Some(layout) = Layout::new(tiles.len(), sample).filter(|_| !case.shots().is_empty()) else {
        return Ok(None);
    };
    let (width, height) = layout.size();
    let mut sheet = RgbImage::from_pixel(width, height, Rgb([255; 3]));
    for (i, tile) in tiles.iter().enumerate() {
        let (x, y) = layout.corner(i);
        paste(&mut sheet, &layout, &tile.picture, (x, y + layout.px(HEAD)));
        let below = (x, layout.below(y));
        match &tile.difference {
            Some(difference) => paste(&mut sheet, &layout, difference, below),
            None => paste_scale(&mut sheet, &layout, below),
        }
    }
    let ink = write(view, case, &tiles, &layout.enlarged())?;
    print_over(&mut sheet, &ink);
    Ok(Some(sheet))
}

/// Multiplies each pixel of the sheet by the mean of the [`FINER`]² pixels of `ink` that cover it.
fn print_over(sheet: &mut RgbImage, ink: &RgbImage) {
    let stride = 3 * ink.width() as usize;
    let finer = FINER as usize;
    for (x, y, pixel) in sheet.enumerate_pixels_mut() {
        let corner = stride * finer * y as usize + 3 * finer * x as usize;
        for (channel, under) in pixel.0.iter_mut().enumerate() {
            let places = (0..finer * finer).map(|i| i / finer * stride + 3 * (i % finer) + channel);
            let sum: u32 = places
                .filter_map(|place| ink.get(corner + place))
                .map(|v| u32::from(*v))
                .sum();
            *under = (u32::from(*under) * sum / (255 * FINER * FINER)) as u8;
        }
    }
}

/// Text of the sheet on white.
fn write(
    view: &ReportView<'_>,
    case: &CellGroup<'_>,
    tiles: &[ContactTile],
    layout: &Layout,
) -> Result<RgbImage> {
    let (width, height) = layout.size();
    raster((width, height), |surface| {
        let left = layout.px(MARGIN);
        let room = width as i32 - 2 * left;
        let line = |y: i32, text: &str, size: f64, color| {
            let text = surface.fit(text, layout.size_of(size), room)?;
            surface.text((left, y), &text, layout.size_of(size), color, Hang::Right)
        };
        line(layout.px(TOP / 2.0), &case.name, 1.1 * HEADING, INK)?;
        for (i, tile) in tiles.iter().enumerate() {
            write_tile(surface, layout, case, tile, layout.corner(i))?;
        }
        let foot = height as i32 - layout.px(FOOT);
        let rule = "Each method: the middle one of its settings by error. rel_rmse: √Σ(ΔL)²/√ΣL². Times: medians.";
        line(foot + layout.px(9.0), rule, TEXT, MUTED)?;
        let adapter = format!("Measured on {}", view.adapter());
        line(foot + layout.px(31.0), &adapter, TEXT, MUTED)
    })
}

fn paste(
    sheet: &mut RgbImage,
    layout: &Layout,
    picture: &Result<RgbImage, String>,
    (x, y): (i32, i32),
) {
    let (width, height) = layout.picture();
    let (width, height) = (width.unsigned_abs(), height.unsigned_abs());
    let scaled = match picture {
        Ok(p) if p.dimensions() == (width, height) => p.clone(),
        Ok(p) if p.width() < width => imageops::resize(p, width, height, FilterType::Nearest),
        Ok(p) => imageops::resize(p, width, height, FilterType::Triangle),
        Err(_) => RgbImage::from_pixel(width, height, Rgb([0xee; 3])),
    };
    imageops::replace(sheet, &scaled, x.into(), y.into());
}

/// Draws the false-colour scale of the differences.
fn paste_scale(sheet: &mut RgbImage, layout: &Layout, (x, y): (i32, i32)) {
    let [left, top, right, bottom] = layout.scale_box((x, y));
    let (width, height) = ((right - left).unsigned_abs(), (bottom - top).unsigned_abs());
    let value = |column: u32| 2.0 * column as f32 / (width.max(2) - 1) as f32 - 1.0;
    let row: Vec<f32> = (0..width).map(value).collect();
    let colours = false_colour(width, 1, &row, 1.0);
    if let Some(line) = RgbImage::from_raw(width, 1, colours) {
        let bar = imageops::resize(&line, width, height, FilterType::Nearest);
        imageops::replace(sheet, &bar, left.into(), top.into());
    }
}

fn write_tile<DB: DrawingBackend>(
    surface: &Surface<DB>,
    layout: &Layout,
    case: &CellGroup<'_>,
    tile: &ContactTile,
    (x, y): (i32, i32),
) -> Result<()> {
    let (heading, text) = (layout.size_of(HEADING), layout.size_of(TEXT));
    let (width, height) = layout.picture();
    let room = layout.tile();
    let first = y + layout.px(14.0);
    let radius = layout.size_of(7.0);
    let style = Style::of(&tile.method);
    surface.marker(
        (x + layout.px(9.0), first - layout.px(1.5)),
        radius,
        style,
        false,
    )?;
    let lead = layout.px(26.0);
    let name = surface.fit(&tile.heading, heading, room - lead)?;
    surface.strong((x + lead, first), &name, heading)?;
    let numbers = surface.fit(&tile.numbers, text, room)?;
    surface.text((x, y + layout.px(42.0)), &numbers, text, INK, Hang::Right)?;
    let at = [(x, y + layout.px(HEAD)), (x, layout.below(y))];
    let notice = |(x, y): (i32, i32), reason: &str| {
        let reason = surface.fit(&format!("Picture missing: {reason}"), text, width - 16)?;
        surface.text((x + 8, y + height / 2), &reason, text, INK, Hang::Right)
    };
    if let Err(reason) = &tile.picture {
        notice(at[0], reason)?;
    }
    match &tile.difference {
        None => write_scale(surface, layout, case, at[1]),
        Some(Err(reason)) => notice(at[1], reason),
        Some(Ok(_)) => {
            let (top, right, bottom) = (at[1].1, x + width - 1, at[1].1 + height - 1);
            let outline = [
                (x, top),
                (right, top),
                (right, bottom),
                (x, bottom),
                (x, top),
            ];
            surface.line(&outline, GRID, layout.px(1.0).unsigned_abs().max(1))
        }
    }
}

fn write_scale<DB: DrawingBackend>(
    surface: &Surface<DB>,
    layout: &Layout,
    case: &CellGroup<'_>,
    at: (i32, i32),
) -> Result<()> {
    let [left, top, right, bottom] = layout.scale_box(at);
    let size = layout.size_of(TEXT);
    let unit = case.diff_scale().map_or("", |_| "ΔL / mean L");
    surface.frame([(left, top), (right, bottom)], MUTED)?;
    for (text, above) in [("difference from the truth", 37.0), (unit, 16.0)] {
        surface.text((left, top - layout.px(above)), text, size, INK, Hang::Right)?;
    }
    let (low, high) = match case.diff_scale() {
        Some(s) => (format!("−{s} darker"), format!("brighter +{s}")),
        None => ("darker".to_owned(), "brighter".to_owned()),
    };
    let y = bottom + layout.px(15.0);
    surface.text((left, y), &low, size, INK, Hang::Right)?;
    surface.text(((left + right) / 2, y), "0", size, INK, Hang::Middle)?;
    surface.text((right, y), &high, size, INK, Hang::Left)
}
