//! The view march in f64: L = Σₖ Tₖ (1 − e^(−σₖΔ)) · albedo · (p(θ) E V(pₖ) + ambient(pₖ)) + T · background.

use super::Oracle;
use super::counted_ray::count;
use super::layer::{LayerRay, UNLIMITED_M, ground_blocks, height_fraction};
use super::light::{Occlusion, Tally};
use crate::cost::{Counts, Samples};
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::progress::Progress;
use crate::scene::{Integration, March, Scene, Subset};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::ControlFlow;

/// Rows for each thread between two calls of the progress callback.
const ROWS_A_THREAD: usize = 4;

/// Values of a pixel, from its view ray.
#[derive(Clone, Copy, Debug)]
pub struct Pixel {
    /// Radiance and opacity.
    pub radiance: [f32; 4],
    /// Sunlight and mean V.
    pub sun: [f32; 4],
    /// 1/mean depth along the optical axis, weighted as light, m⁻¹; 0 where there is no medium.
    pub inverse_depth: f32,
}

/// Light gathered along one view ray, relative to the radiance of its sources.
#[derive(Clone, Copy, Debug, Default)]
struct Gathered {
    /// Σ weight·V.
    lit: f64,
    /// Σ weight.
    weights: f64,
    /// Σ weight·point, metres.
    points_m: DVec3,
    /// Σ weight·ambient, RGB.
    ambient: DVec3,
    /// Transmittance to the background.
    transmittance: f64,
}

/// Interleaved gradient noise in [0, 1), Jimenez 2014.
fn gradient_noise(column: u32, row: u32) -> f64 {
    let phase = f64::from(column) * 0.067_110_56 + f64::from(row) * 0.005_837_15;
    (52.982_918_9 * phase.fract()).fract()
}

/// Phase function of Henyey & Greenstein 1941, sr⁻¹.
fn henyey_greenstein(g: f64, cosine: f64) -> f64 {
    let base = (1.0 - g).powi(2) + 2.0 * g * (1.0 - cosine);
    (1.0 - g * g) / (4.0 * PI * base * base.sqrt())
}

impl Oracle {
    /// Direction of the ray through a pixel's centre.
    pub fn direction(&self, column: u32, row: u32) -> DVec3 {
        let (width, height) = (f64::from(self.image.width), f64::from(self.image.height));
        let (right, up, forward) = self.scene.camera.basis();
        let (half_x, half_y) = self.scene.camera.half_extent(width / height);
        let x = 2.0 * (f64::from(column) + 0.5) / width - 1.0;
        let y = 1.0 - 2.0 * (f64::from(row) + 0.5) / height;
        (forward + right * (x * half_x) + up * (y * half_y)).normalize()
    }

    /// The part of a view ray inside the layer.
    pub(super) fn view_ray(&self, direction: DVec3) -> LayerRay {
        let camera = &self.scene.camera;
        let far_m = camera.far_m.unwrap_or(UNLIMITED_M);
        LayerRay::new(
            &self.scene.container,
            camera.position_m.into(),
            direction,
            (0.0, far_m),
        )
    }

    fn inverse_depth(&self, gathered: &Gathered) -> f64 {
        let camera = &self.scene.camera;
        let (_, _, forward) = camera.basis();
        let mean_m = gathered.points_m / gathered.weights;
        let depth_m = forward.dot(mean_m - DVec3::from(camera.position_m));
        if depth_m > 0.0 { 1.0 / depth_m } else { 0.0 }
    }

    fn phase(&self, cosine: f64) -> f64 {
        let lobes = self.scene.medium.phase.iter();
        lobes
            .map(|lobe| lobe.weight * henyey_greenstein(lobe.g, cosine))
            .sum()
    }

    fn ambient_radiance(&self, p: DVec3) -> DVec3 {
        self.ambient.map_or(DVec3::ZERO, |(base, top)| {
            base.lerp(top, height_fraction(&self.scene.container, p))
        })
    }

    fn background(&self, direction: DVec3) -> DVec3 {
        let Scene {
            container, camera, ..
        } = &self.scene;
        match &self.sky {
            None => DVec3::ZERO,
            Some((_, ground)) if ground_blocks(container, camera.position_m.into(), direction) => {
                *ground
            }
            Some((sky, _)) => sky.radiance(direction).into(),
        }
    }
}

/// Steps over `length_m` of a view ray.
fn view_steps(march: &March, length_m: f64) -> u32 {
    match march.step_m {
        Some(step_m) => (length_m / step_m)
            .ceil()
            .clamp(1.0, f64::from(March::MAX_STEPS)) as u32,
        None => march.steps,
    }
}

impl Occlusion<'_> {
    /// The picture and its counts; sums in f64, pixels in f32.
    pub fn render(&self, progress: Progress) -> Result<(Frame, Counts)> {
        let (width, height) = (self.oracle.image.width, self.oracle.image.height);
        let pixels = width as usize * height as usize;
        let mut frame = Frame {
            width,
            height,
            radiance: Vec::with_capacity(pixels),
            sun: Vec::with_capacity(pixels),
        };
        let counts = self.march(Subset::EVERY, progress, |pixels| {
            let radiance = pixels.iter().map(|pixel| pixel.radiance);
            frame.radiance.extend(radiance);
            frame.sun.extend(pixels.iter().map(|pixel| pixel.sun));
        })?;
        Ok((frame, counts))
    }

    /// Marches the pixels of `subset` and returns the counts; `take` is called with the pixels of each row, from the
    /// top.
    pub fn march(
        &self,
        subset: Subset,
        progress: Progress,
        mut take: impl FnMut(Vec<Pixel>),
    ) -> Result<Counts> {
        let rows: Vec<u32> = subset.rows(self.oracle.image).collect();
        let mut counts = Counts::default();
        let mut done = 0;
        for some in rows.chunks(ROWS_A_THREAD * rayon::current_num_threads()) {
            let made: Vec<_> = some.par_iter().map(|row| self.row(subset, *row)).collect();
            for (pixels, tally) in made {
                take(pixels);
                add(&mut counts, &tally);
            }
            done += some.len();
            if progress(done as f64 / rows.len() as f64) == ControlFlow::Break(()) {
                return Err(Error::Stopped);
            }
        }
        counts.samples.map = self.map_samples();
        Ok(counts)
    }

    fn row(&self, subset: Subset, row: u32) -> (Vec<Pixel>, Counts) {
        let tally = Tally::default();
        let pixels = subset
            .columns(self.oracle.image, row)
            .map(|column| self.pixel(column, row, &tally))
            .collect();
        (pixels, tally.counts())
    }

    fn pixel(&self, column: u32, row: u32, tally: &Tally) -> Pixel {
        let oracle = self.oracle;
        let medium = &oracle.scene.medium;
        let direction = oracle.direction(column, row);
        let noise = gradient_noise(column, row);
        let gathered = self.gather(direction, noise, tally);
        let phase = oracle.phase(direction.dot(oracle.sun));
        let sun = oracle.irradiance * (medium.albedo * phase * gathered.lit);
        let radiance = sun
            + gathered.ambient * medium.albedo
            + oracle.background(direction) * gathered.transmittance;
        let mean = if gathered.weights > 0.0 {
            gathered.lit / gathered.weights
        } else {
            0.0
        };
        let pack = |rgb: DVec3, a: f64| rgb.extend(a).as_vec4().to_array();
        Pixel {
            radiance: pack(radiance, 1.0 - gathered.transmittance),
            sun: pack(sun, mean),
            inverse_depth: oracle.inverse_depth(&gathered) as f32,
        }
    }

    fn gather(&self, direction: DVec3, noise: f64, tally: &Tally) -> Gathered {
        let oracle = self.oracle;
        let march = &oracle.scene.march;
        let ray = oracle.view_ray(direction);
        let length_m = ray.length_m();
        let steps = view_steps(march, length_m);
        let step_m = length_m / f64::from(steps);
        let offset = if march.jitter { noise } else { 0.5 };
        let mut sum = Gathered {
            transmittance: 1.0,
            ..Gathered::default()
        };
        if length_m <= 0.0 {
            return sum;
        }
        for k in 0..steps {
            let p = ray.point((f64::from(k) + offset) * step_m);
            if self.skip && oracle.field.clear_m(p).is_some() {
                continue;
            }
            count(&tally.view);
            let thickness = oracle.field.extinction_per_m(p) * step_m;
            if thickness <= 0.0 {
                continue;
            }
            let weight = sum.transmittance
                * match march.integration {
                    Integration::Analytic => -(-thickness).exp_m1(),
                    Integration::Thesis => (-thickness).exp() * thickness,
                };
            let rnd = (noise + 0.618_034 * (f64::from(k) + 1.0)).fract();
            sum.lit += weight * self.counted(p, rnd, tally);
            sum.weights += weight;
            sum.points_m += weight * p;
            sum.ambient += weight * oracle.ambient_radiance(p);
            sum.transmittance *= (-thickness).exp();
            // Below this transmittance no sample can change an f64 sum.
            if sum.transmittance < f64::EPSILON / 2.0 {
                break;
            }
        }
        sum
    }
}

fn add(sum: &mut Counts, more: &Counts) {
    let Samples { view, light, .. } = more.samples;
    sum.samples.view += view;
    sum.samples.light += light;
    sum.look_ups += more.look_ups;
    sum.fallbacks += more.fallbacks;
}
