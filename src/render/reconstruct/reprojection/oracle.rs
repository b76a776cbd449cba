//! Reprojection in f64, from points in space: the twin of `shaders/reconstruct/temporal.wgsl`, with the same rules but
//! without its matrices. Pictures are kept in f32, as frames are.

use super::super::OracleSequence;
use crate::cost::Counts;
use crate::error::Result;
use crate::frame::Frame;
use crate::oracle::{Occlusion, Oracle, Pixel};
use crate::progress::Progress;
use crate::scene::{Camera, ImageSize, Pattern, Subset};
use glam::{DVec2, DVec3};

/// Positions are rounded to 1/256 pixel.
const SUBPIXELS: f64 = 256.0;
/// Reprojection error above which a pixel counts as disoccluded, pixels.
const DISOCCLUDED: f64 = 1.0;

/// A sequence whose frames reproject the pixels they do not march from the previous picture.
pub(super) struct OracleReprojection {
    image: ImageSize,
    pattern: Pattern,
    /// Number of the next frame.
    frame: usize,
    /// The last picture and its camera; `None` at the start of a sequence.
    before: Option<(Vec<Pixel>, Camera)>,
}

impl OracleReprojection {
    /// A new sequence, without history.
    pub fn new(image: ImageSize, pattern: Pattern) -> Self {
        Self {
            image,
            pattern,
            frame: 0,
            before: None,
        }
    }
}

impl OracleSequence for OracleReprojection {
    fn render(&mut self, method: &Occlusion<'_>, progress: Progress) -> Result<Counts> {
        let subset = self.pattern.subset(self.frame);
        let mut marched = Vec::new();
        let counts = method.march(subset, progress, |row| marched.push(row))?;
        let frame = Sparse {
            oracle: method.oracle(),
            subset,
            marched,
        };
        let ImageSize { width, height } = self.image;
        let pixels = (0..height)
            .flat_map(|row| (0..width).map(move |column| [column, row]))
            .map(|pixel| frame.pixel(pixel, self.before.as_ref()))
            .collect();
        self.before = Some((pixels, method.oracle().scene().camera.clone()));
        self.frame += 1;
        Ok(counts)
    }

    fn picture(&self) -> Option<Frame> {
        let (pixels, _) = self.before.as_ref()?;
        Some(Frame {
            width: self.image.width,
            height: self.image.height,
            radiance: pixels.iter().map(|p| p.radiance).collect(),
            sun: pixels.iter().map(|p| p.sun).collect(),
        })
    }
}

/// A frame of which a rectangular grid of pixels was marched.
struct Sparse<'a> {
    oracle: &'a Oracle,
    subset: Subset,
    /// Marched pixels, by their row and column among themselves.
    marched: Vec<Vec<Pixel>>,
}

impl Sparse<'_> {
    fn pixel(&self, pixel: [u32; 2], before: Option<&(Vec<Pixel>, Camera)>) -> Pixel {
        let Subset { block, offset, .. } = self.subset;
        let axes = [0, 1];
        let [x, y] = axes.map(|axis| i64::from(pixel[axis] / block[axis]));
        let marched = self.marched(x, y);
        if axes.map(|axis| pixel[axis] % block[axis]) == offset {
            return *marched;
        }
        let direction = self.oracle.direction(pixel[0], pixel[1]);
        let past = before.and_then(|(pixels, camera)| {
            self.past(pixels, camera, direction, f64::from(marched.inverse_depth))
        });
        past.unwrap_or_else(|| {
            let at = axes.map(|axis| {
                (f64::from(pixel[axis]) - f64::from(offset[axis])) / f64::from(block[axis])
            });
            let mix = blend(DVec2::from(at), |x, y| *self.marched(x, y));
            Pixel {
                inverse_depth: marched.inverse_depth,
                ..mix
            }
        })
    }

    /// The marched pixel at a row and column among themselves, clamped to the grid.
    fn marched(&self, column: i64, row: i64) -> &Pixel {
        let row = &self.marched[clamped(row, self.marched.len())];
        &row[clamped(column, row.len())]
    }

    /// The previous picture's value in a direction, at depth 1/`inverse_depth` along the optical axis; `None` when that
    /// lies outside the picture or behind the camera, or was seen from the other side, or was disoccluded.
    fn past(
        &self,
        pixels: &[Pixel],
        camera: &Camera,
        direction: DVec3,
        inverse_depth: f64,
    ) -> Option<Pixel> {
        let own = &self.oracle.scene().camera;
        let (_, _, forward) = own.basis();
        let ray = direction / direction.dot(forward);
        let moved = DVec3::from(own.position_m) - DVec3::from(camera.position_m);
        // Position relative to the previous camera; an infinitely far point has a direction only.
        let seen_from = |inverse_depth: f64| {
            if inverse_depth > 0.0 {
                moved + ray / inverse_depth
            } else {
                ray
            }
        };
        let at = project(camera, self.oracle.image(), seen_from(inverse_depth))?;
        let at = (at * SUBPIXELS).round() / SUBPIXELS;
        let (width, height) = (
            self.oracle.image().width as usize,
            self.oracle.image().height as usize,
        );
        if at.min_element() < 0.0 || at.x > width as f64 || at.y > height as f64 {
            return None;
        }
        let get = |x: i64, y: i64| pixels[clamped(y, height) * width + clamped(x, width)];
        let held = f64::from(get(at.x as i64, at.y as i64).inverse_depth);
        // Depth on this ray of the history's point; a camera with the opposite view direction saw another side of it.
        let (_, _, forward) = camera.basis();
        let along = ray.dot(forward);
        let depth = (1.0 / held - moved.dot(forward)) / along;
        let inverse_depth = if held > 0.0 { 1.0 / depth } else { 0.0 };
        let ahead = inverse_depth >= 0.0 && along > 0.0;
        let other =
            project(camera, self.oracle.image(), seen_from(inverse_depth)).filter(|_| ahead)?;
        (other.distance(at) <= DISOCCLUDED).then(|| Pixel {
            inverse_depth: inverse_depth as f32,
            ..blend(at - 0.5, get)
        })
    }
}

/// Projection of a point relative to the camera, pixels from the upper left corner; `None` behind it.
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

/// Bilinear interpolation of the pixels that `get` gives; inverse depths are not interpolated.
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
        inverse_depth: 0.0,
    }
}
