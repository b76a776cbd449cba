//! Layout of a contact sheet, px. Gaps and font sizes are given in units that scale with the tiles.

use image::RgbImage;

/// Largest number of tiles in a row; the tiles are spread evenly over the rows.
const COLUMNS: usize = 4;
/// Smallest width of a picture, px; narrower ones are enlarged by a whole number.
const NARROWEST: u32 = 240;
/// Width and height that a larger picture is shrunk to fit, px.
const ROOM: (u32, u32) = (480, 960);
/// Width of a tile at which one unit is one pixel, px.
const USUAL: f64 = 320.0;
/// Supersampling factor of text, because the rasteriser places letters at whole pixels.
pub const FINER: u32 = 3;

/// Margin of the sheet, units.
pub const MARGIN: f64 = 14.0;
/// Height of the title, units.
pub const TOP: f64 = 48.0;
/// Height of the last two lines, units.
pub const FOOT: f64 = 50.0;
/// Height of the two lines over a picture, units.
pub const HEAD: f64 = 58.0;
/// Gap between tiles of a row, units.
const GAP: f64 = 14.0;
/// Gap under a row of tiles, units.
const UNDER: f64 = 20.0;
/// Gap between a picture and its difference, units.
const BETWEEN: f64 = 4.0;

/// Positions and sizes on a sheet.
pub struct Layout {
    picture: (u32, u32),
    unit: f64,
    /// 1 for the sheet itself, [`FINER`] for the one its text is drawn on.
    scale: u32,
    columns: usize,
    rows: usize,
}

impl Layout {
    /// Layout of `tiles` tiles whose pictures have the size of `sample`; `None` without tiles or pixels.
    pub fn new(tiles: usize, sample: Option<&RgbImage>) -> Option<Self> {
        let (width, height) = sample?.dimensions();
        if tiles == 0 || width == 0 || height == 0 {
            return None;
        }
        let room = |most: u32, size: u32| f64::from(most) / f64::from(size);
        let fit = room(ROOM.0, width).min(room(ROOM.1, height));
        let scale = if fit < 1.0 {
            fit
        } else {
            f64::from(NARROWEST.div_ceil(width)).min(fit.floor())
        };
        let scaled = |n: u32| (f64::from(n) * scale).round().max(1.0) as u32;
        let rows = tiles.div_ceil(COLUMNS);
        Some(Self {
            picture: (scaled(width), scaled(height)),
            unit: f64::from(scaled(width).max(NARROWEST)) / USUAL,
            scale: 1,
            columns: tiles.div_ceil(rows),
            rows,
        })
    }

    /// This layout on a sheet [`FINER`] times as large.
    pub fn enlarged(&self) -> Self {
        Self {
            scale: FINER,
            ..*self
        }
    }

    /// Length in whole pixels of a length in units.
    pub fn px(&self, units: f64) -> i32 {
        self.scale as i32 * (units * self.unit).round() as i32
    }

    /// Font size in px of a size in units.
    pub fn size_of(&self, units: f64) -> f64 {
        f64::from(self.scale) * self.unit * units
    }

    /// Width and height of a picture, px.
    pub fn picture(&self) -> (i32, i32) {
        let (width, height) = self.picture;
        ((self.scale * width) as i32, (self.scale * height) as i32)
    }

    /// Width of a tile, px: that of its picture, or `USUAL` units for its text where that is larger.
    pub fn tile(&self) -> i32 {
        self.picture().0.max(self.px(USUAL))
    }

    /// Horizontal and vertical distance of tiles, px.
    fn pitch(&self) -> (i32, i32) {
        let between = self.px(HEAD) + self.px(BETWEEN) + self.px(UNDER);
        (self.tile() + self.px(GAP), 2 * self.picture().1 + between)
    }

    /// Width and height of the sheet, px.
    pub fn size(&self) -> (u32, u32) {
        let (across, down) = self.pitch();
        let width = 2 * self.px(MARGIN) - self.px(GAP) + across * self.columns as i32;
        let height = self.px(TOP) + self.px(FOOT) + down * self.rows as i32;
        (width.unsigned_abs(), height.unsigned_abs())
    }

    /// Top left corner of a tile.
    pub fn corner(&self, index: usize) -> (i32, i32) {
        let (across, down) = self.pitch();
        let (row, column) = (index / self.columns, index % self.columns);
        let left = self.px(MARGIN) + across * column as i32;
        (left, self.px(TOP) + down * row as i32)
    }

    /// Row in which the difference of a tile that starts at `top` begins.
    pub fn below(&self, top: i32) -> i32 {
        top + self.px(HEAD) + self.px(BETWEEN) + self.picture().1
    }

    /// Left, top, right, bottom of the colour scale that takes the place of a difference, px.
    pub fn scale_box(&self, (x, y): (i32, i32)) -> [i32; 4] {
        let (width, height) = self.picture();
        let middle = y + self.scale as i32 * (height / self.scale as i32 / 2);
        let half = self.px(9.0);
        [x, middle - half, x + width, middle + half]
    }
}
