//! Temporal integration in f64, from points in space: the twin of `shaders/temporal.wgsl`, whose rules it follows and
//! whose matrices it does without. Pictures are kept in f32, as frames are.

use super::Oracle;
use super::light::{Occlusion, Tally};
use super::march::{Pixel, add};
use crate::cost::Counts;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::progress::Progress;
use crate::raymarch::check_size;
use crate::scene::{Camera, ImageSize, Reconstruct};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::ops::ControlFlow;

/// Positions are rounded to this share of a pixel.
const SUBPIXELS: f64 = 256.0;
/// Disagreement of two depths that counts as another thing, pixels.
const DISOCCLUDED: f64 = 1.0;

/// What a sequence of frames remembers.
pub struct History {
    image: ImageSize,
    /// Next frame, counted modulo 4.
    frame: usize,
    /// The last picture and its camera; `None` at the start of a sequence.
    before: Option<(Vec<Pixel>, Camera)>,
}

impl History {
    /// A history that remembers nothing yet.
    pub fn new(image: ImageSize) -> Result<Self> {
        check_size(image)?;
        Ok(Self {
            image,
            frame: 0,
            before: None,
        })
    }

    /// The picture of the last frame; `None` before the first.
    pub fn picture(&self) -> Option<Frame> {
        let (pixels, _) = self.before.as_ref()?;
        Some(Frame {
            width: self.image.width,
            height: self.image.height,
            radiance: pixels.iter().map(|p| p.radiance).collect(),
            sun: pixels.iter().map(|p| p.sun).collect(),
        })
    }
}

impl Occlusion<'_> {
    /// The next frame of a sequence: one pixel of every 2 × 2 block marched, the others from `history`.
    pub fn render_next(&self, history: &mut History, progress: Progress) -> Result<Counts> {
        let [column, row] = Reconstruct::BAYER_2X2[history.frame];
        let ImageSize { width, height } = history.image;
        let mut counts = Counts::default();
        let rows: Vec<u32> = (row..height).step_by(2).collect();
        let mut marched = Vec::new();
        for some in rows.chunks(4 * rayon::current_num_threads()) {
            let made: Vec<_> = some
                .par_iter()
                .map(|row| self.every_other(column, *row))
                .collect();
            for (pixels, tally) in made {
                marched.push(pixels);
                add(&mut counts, &tally);
            }
            if progress(marched.len() as f64 / rows.len() as f64) == ControlFlow::Break(()) {
                return Err(Error::Stopped);
            }
        }
        counts.samples.map = self.map_samples();
        let frame = Sparse {
            oracle: self.oracle,
            image: history.image,
            first: [column, row],
            marched,
        };
        let pixels = (0..height)
            .flat_map(|row| (0..width).map(move |column| [column, row]))
            .map(|pixel| frame.pixel(pixel, history.before.as_ref()))
            .collect();
        history.before = Some((pixels, self.oracle.scene.camera.clone()));
        history.frame = (history.frame + 1) % 4;
        Ok(counts)
    }

    fn every_other(&self, first: u32, row: u32) -> (Vec<Pixel>, Counts) {
        let tally = Tally::default();
        let columns = (first..self.oracle.image.width).step_by(2);
        let pixels = columns
            .map(|column| self.pixel(column, row, &tally))
            .collect();
        (pixels, tally.counts())
    }
}

/// A frame of which every other pixel of every other row was marched.
struct Sparse<'a> {
    oracle: &'a Oracle,
    image: ImageSize,
    /// Column and row of the first marched pixel.
    first: [u32; 2],
    /// By row and column of marched pixels.
    marched: Vec<Vec<Pixel>>,
}

impl Sparse<'_> {
    fn pixel(&self, [column, row]: [u32; 2], before: Option<&(Vec<Pixel>, Camera)>) -> Pixel {
        let block = self.marched(i64::from(column / 2), i64::from(row / 2));
        if [column % 2, row % 2] == self.first {
            return *block;
        }
        let direction = self.oracle.direction(column, row);
        let past = before.and_then(|(pixels, camera)| {
            self.past(pixels, camera, direction, f64::from(block.nearness))
        });
        past.unwrap_or_else(|| {
            let at =
                |pixel: u32, axis: usize| (f64::from(pixel) - f64::from(self.first[axis])) / 2.0;
            let mix = blend(DVec2::new(at(column, 0), at(row, 1)), |x, y| {
                *self.marched(x, y)
            });
            Pixel {
                nearness: block.nearness,
                ..mix
            }
        })
    }

    /// The nearest marched pixel to the given one of them.
    fn marched(&self, column: i64, row: i64) -> &Pixel {
        let row = &self.marched[clamped(row, self.marched.len())];
        &row[clamped(column, row.len())]
    }

    /// What the picture before shows in a direction, at the depth 1/`nearness` along the optical axis; `None` when that
    /// is outside, behind, seen from the other side, or something else.
    fn past(
        &self,
        pixels: &[Pixel],
        camera: &Camera,
        direction: DVec3,
        nearness: f64,
    ) -> Option<Pixel> {
        let own = &self.oracle.scene.camera;
        let (_, _, forward) = own.basis();
        let ray = direction / direction.dot(forward);
        let moved = DVec3::from(own.position_m) - DVec3::from(camera.position_m);
        // Seen from the camera before; the infinitely far has a direction only.
        let seen_from = |nearness: f64| {
            if nearness > 0.0 {
                moved + ray / nearness
            } else {
                ray
            }
        };
        let at = project(camera, self.image, seen_from(nearness))?;
        let at = (at * SUBPIXELS).round() / SUBPIXELS;
        let (width, height) = (self.image.width as usize, self.image.height as usize);
        if at.min_element() < 0.0 || at.x > width as f64 || at.y > height as f64 {
            return None;
        }
        let get = |x: i64, y: i64| pixels[clamped(y, height) * width + clamped(x, width)];
        let held = f64::from(get(at.x as i64, at.y as i64).nearness);
        // Depth on this ray of what the history holds there; a camera that looked the other way saw another side of it.
        let (_, _, forward) = camera.basis();
        let along = ray.dot(forward);
        let depth = (1.0 / held - moved.dot(forward)) / along;
        let nearness = if held > 0.0 { 1.0 / depth } else { 0.0 };
        let ahead = nearness >= 0.0 && along > 0.0;
        let other = project(camera, self.image, seen_from(nearness)).filter(|_| ahead)?;
        (other.distance(at) <= DISOCCLUDED).then(|| Pixel {
            nearness: nearness as f32,
            ..blend(at - 0.5, get)
        })
    }
}

/// Where a camera at the origin sees a point, pixels from the upper left corner; `None` behind it.
fn project(camera: &Camera, image: ImageSize, point: DVec3) -> Option<DVec2> {
    let (width, height) = (f64::from(image.width), f64::from(image.height));
    let (right, up, forward) = camera.basis();
    let (half_x, half_y) = camera.half_extent(width / height);
    let depth = point.dot(forward);
    let x = point.dot(right) / (depth * half_x);
    let y = point.dot(up) / (depth * half_y);
    (depth > 0.0).then(|| DVec2::new((1.0 + x) * 0.5 * width, (1.0 - y) * 0.5 * height))
}

fn clamped(index: i64, count: usize) -> usize {
    index.clamp(0, count as i64 - 1) as usize
}

/// Bilinear interpolation between the pixels that `get` gives; without nearness, which is no colour.
fn blend(at: DVec2, get: impl Fn(i64, i64) -> Pixel) -> Pixel {
    let low = at.floor();
    let part = at - low;
    let (mut radiance, mut sun) = ([0.0_f64; 4], [0.0_f64; 4]);
    for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let weight = |part: f64, second: i64| if second == 1 { part } else { 1.0 - part };
        let weight = weight(part.x, x) * weight(part.y, y);
        if weight > 0.0 {
            let pixel = get(low.x as i64 + x, low.y as i64 + y);
            for c in 0..4 {
                radiance[c] += weight * f64::from(pixel.radiance[c]);
                sun[c] += weight * f64::from(pixel.sun[c]);
            }
        }
    }
    Pixel {
        radiance: radiance.map(|v| v as f32),
        sun: sun.map(|v| v as f32),
        nearness: 0.0,
    }
}
