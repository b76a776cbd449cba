//! Procedural clouds on the device: noise textures, calibrated coverage, occupancy.

use super::occupancy::Occupancy;
use super::{Built, DensityField};
use crate::error::{Error, Result};
use crate::gpu::{Defs, Gpu, Inputs, Kernel, Program, Resource, UniformValue, read_buffer, read_texture};
use crate::scene::{Deck, Procedural};
use std::time::Instant;

/// Edge of the shape texture, texels (Schneider & Vos 2015).
pub const SHAPE_TEXELS: u32 = 128;
/// Edge of the detail texture, texels.
pub const DETAIL_TEXELS: u32 = 32;
/// Edge of the weather map, texels.
pub const WEATHER_TEXELS: u32 = 512;
/// Cells of the occupancy grid along one shape tile: two texels a cell.
const CELLS_PER_TILE: u32 = SHAPE_TEXELS / 2;
/// Columns along one axis, and samples a column, that calibrate coverage.
const CALIBRATION_COLUMNS: u32 = 160;
const CALIBRATION_STEPS: u32 = 96;
/// Optical depth at which a column's opacity is 0.5.
const HALF_OPAQUE_TAU: f32 = std::f32::consts::LN_2;
/// Slack for 8-bit filter weights and texel rounding in the bounds.
const FILTER_SLACK: f32 = 2.0 / 255.0;

pub(super) fn build(
    gpu: &Gpu,
    field: &Procedural,
    container_shader: &'static str,
    scene_inputs: &Inputs,
) -> Result<DensityField> {
    let (start, compiled_s) = (Instant::now(), gpu.compile_s());
    let noise = Noise::generate(gpu, field)?;
    let noise_ms = (start.elapsed().as_secs_f64() - (gpu.compile_s() - compiled_s)) * 1e3;
    let mut inputs = noise.inputs(gpu);
    let calibrator = Calibrator::new(gpu, field, container_shader)?;
    let mut thresholds = Vec::new();
    let mut measured_coverage = Vec::new();
    for (i, deck) in field.decks.iter().enumerate() {
        let (threshold, measured) = calibrator.threshold(gpu, field, i, deck, scene_inputs, &inputs)?;
        thresholds.push(threshold);
        measured_coverage.push(measured);
    }
    inputs.uniform("field", field_values(field, &field.decks, &thresholds, 0));
    let occupancy = Bounds::new(&noise, field, &thresholds).occupancy();
    occupancy.upload(gpu, &mut inputs);
    gpu.check()?;
    Ok(DensityField {
        shader: "density/procedural.wgsl",
        defs: defs(field, field.decks.len()),
        inputs,
        built: Built { noise_ms: Some(noise_ms), empty_fraction: Some(occupancy.empty_fraction()), measured_coverage },
        content_hash: String::new(),
    })
}

fn defs(field: &Procedural, decks: usize) -> Defs {
    let mut defs = Defs::from([("DECKS".into(), Some(decks as i32))]);
    if field.detail.is_some() {
        defs.insert("DETAIL".into(), None);
    }
    if field.precipitation_gain.is_some() {
        defs.insert("PRECIPITATION".into(), None);
    }
    defs
}

/// Members of `Field` in density/procedural.wgsl; deck i of the list is deck `first + i` of the scene.
fn field_values(field: &Procedural, decks: &[Deck], thresholds: &[f64], first: usize) -> Vec<(String, UniformValue)> {
    let number = |v: f64| UniformValue::F32(v as f32);
    let mut values = vec![
        ("weather_frequency_per_m".to_owned(), number(1.0 / field.weather_tile_m)),
        ("shape_frequency_per_m".to_owned(), number(1.0 / field.shape_tile_m)),
        ("precipitation_gain".to_owned(), number(field.precipitation_gain.unwrap_or(0.0))),
    ];
    if let Some(detail) = &field.detail {
        values.push(("detail_frequency_per_m".to_owned(), number(1.0 / detail.tile_m)));
        values.push(("detail_strength".to_owned(), number(detail.strength)));
    }
    for (i, (deck, threshold)) in decks.iter().zip(thresholds).enumerate() {
        let profile = [deck.base_m, deck.top_m, deck.cloud_type[0], deck.cloud_type[1]].map(|v| v as f32);
        let cover = [*threshold, weather_offset(first + i)].map(|v| v as f32);
        values.push((format!("decks[{i}].profile"), UniformValue::Vec4(profile)));
        values.push((format!("decks[{i}].cover"), UniformValue::Vec2(cover)));
    }
    values
}

/// The second deck reads the weather map elsewhere, so that it does not repeat the first.
fn weather_offset(deck: usize) -> f64 {
    0.37 * deck as f64
}

/// The noise textures and their read-back copies.
struct Noise {
    views: Vec<(&'static str, wgpu::TextureView)>,
    shape: Vec<u8>,
    weather: Vec<u8>,
}

impl Noise {
    fn generate(gpu: &Gpu, field: &Procedural) -> Result<Self> {
        let cube = |n: u32| wgpu::Extent3d { width: n, height: n, depth_or_array_layers: n };
        let flat = wgpu::Extent3d { width: WEATHER_TEXELS, height: WEATHER_TEXELS, depth_or_array_layers: 1 };
        let shape = noise_texture(gpu, "noise/shape.wgsl", cube(SHAPE_TEXELS), wgpu::TextureDimension::D3, field.seed)?;
        let weather = noise_texture(gpu, "noise/weather.wgsl", flat, wgpu::TextureDimension::D2, field.seed)?;
        let view = |t: &wgpu::Texture| t.create_view(&Default::default());
        let mut views = vec![("shape", view(&shape)), ("weather", view(&weather))];
        if field.detail.is_some() {
            let detail =
                noise_texture(gpu, "noise/detail.wgsl", cube(DETAIL_TEXELS), wgpu::TextureDimension::D3, field.seed)?;
            views.push(("detail", view(&detail)));
        }
        Ok(Self { views, shape: read_texture(gpu, &shape)?, weather: read_texture(gpu, &weather)? })
    }

    fn inputs(&self, gpu: &Gpu) -> Inputs {
        let mut inputs = Inputs::default();
        for (name, view) in &self.views {
            inputs.resource(name, Resource::View(view.clone()));
        }
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("repeat"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            address_mode_w: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        inputs.resource("repeat", Resource::Sampler(sampler));
        inputs
    }
}

/// Runs one noise pass.
fn noise_texture(
    gpu: &Gpu,
    entry: &'static str,
    size: wgpu::Extent3d,
    dimension: wgpu::TextureDimension,
    seed: u32,
) -> Result<wgpu::Texture> {
    let kernel = Kernel::new(gpu, &Program { entry, roles: vec![], defs: Defs::new() })?;
    // COPY_DST for the same reason as the light maps: a render pass that zeroes the texture spoils later timestamps.
    let usage = wgpu::TextureUsages::STORAGE_BINDING
        | wgpu::TextureUsages::TEXTURE_BINDING
        | wgpu::TextureUsages::COPY_SRC
        | wgpu::TextureUsages::COPY_DST;
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(entry),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage,
        view_formats: &[],
    });
    let mut inputs = Inputs::default();
    inputs.resource("texels", Resource::View(texture.create_view(&Default::default())));
    inputs.uniform("noise", [("seed", UniformValue::U32(seed))]);
    let groups = kernel.bind(gpu, &[&inputs])?;
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        kernel.dispatch(&mut pass, &groups, [size.width, size.height, size.depth_or_array_layers]);
    }
    gpu.queue.submit([encoder.finish()]);
    gpu.wait()?;
    Ok(texture)
}

/// Finds the weather threshold at which a deck covers the wanted share of columns.
struct Calibrator {
    kernel: Kernel,
    output: wgpu::Buffer,
}

impl Calibrator {
    fn new(gpu: &Gpu, field: &Procedural, container_shader: &'static str) -> Result<Self> {
        let program = Program {
            entry: "noise/columns.wgsl",
            roles: vec![("container", container_shader), ("density", "density/procedural.wgsl")],
            defs: defs(field, 1),
        };
        let size = u64::from(CALIBRATION_COLUMNS).pow(2) * 4;
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        Ok(Self { kernel: Kernel::new(gpu, &program)?, output: gpu.empty_buffer("columns", size, usage) })
    }

    /// (threshold, measured share), by bisection: coverage grows with the threshold.
    fn threshold(
        &self,
        gpu: &Gpu,
        field: &Procedural,
        index: usize,
        deck: &Deck,
        scene_inputs: &Inputs,
        density_inputs: &Inputs,
    ) -> Result<(f64, f64)> {
        let measure = |threshold: f64| self.covered(gpu, field, index, deck, threshold, scene_inputs, density_inputs);
        if deck.coverage <= 0.0 {
            return Ok((0.0, measure(0.0)?));
        }
        let most = measure(1.0)?;
        if deck.coverage >= 1.0 || most <= deck.coverage {
            if (most - deck.coverage).abs() <= 0.03 {
                return Ok((1.0, most));
            }
            return Err(Error::input(
                format!("scene, at /density/procedural/decks/{index}/coverage"),
                format!("coverage {} cannot be reached: at most {most:.2} of the columns of this deck become half opaque", deck.coverage),
                "Make the deck thicker, its type higher, or the extinction larger.",
            ));
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..12 {
            let middle = 0.5 * (low + high);
            if measure(middle)? < deck.coverage { low = middle } else { high = middle }
        }
        let threshold = 0.5 * (low + high);
        Ok((threshold, measure(threshold)?))
    }

    #[expect(clippy::too_many_arguments, reason = "a private closure body: the state of one measurement")]
    fn covered(
        &self,
        gpu: &Gpu,
        field: &Procedural,
        index: usize,
        deck: &Deck,
        threshold: f64,
        scene_inputs: &Inputs,
        density_inputs: &Inputs,
    ) -> Result<f64> {
        let mut inputs = Inputs::default();
        inputs.uniform("field", field_values(field, std::slice::from_ref(deck), &[threshold], index));
        inputs.uniform(
            "columns",
            [
                ("tile_m", UniformValue::F32(field.weather_tile_m as f32)),
                ("base_m", UniformValue::F32(deck.base_m as f32)),
                ("top_m", UniformValue::F32(deck.top_m as f32)),
                ("count", UniformValue::U32(CALIBRATION_COLUMNS)),
                ("steps", UniformValue::U32(CALIBRATION_STEPS)),
            ],
        );
        inputs.resource("optical_depth", Resource::Buffer(self.output.clone()));
        let groups = self.kernel.bind(gpu, &[&inputs, scene_inputs, density_inputs])?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            self.kernel.dispatch(&mut pass, &groups, [CALIBRATION_COLUMNS, CALIBRATION_COLUMNS, 1]);
        }
        gpu.queue.submit([encoder.finish()]);
        let bytes = read_buffer(gpu, &self.output, u64::from(CALIBRATION_COLUMNS).pow(2) * 4)?;
        let columns: Vec<f32> = bytemuck::pod_collect_to_vec(&bytes);
        Ok(columns.iter().filter(|tau| **tau > HALF_OPAQUE_TAU).count() as f64 / columns.len() as f64)
    }
}

/// Upper bounds of the density over cells of the periodic field.
struct Bounds<'a> {
    field: &'a Procedural,
    thresholds: &'a [f64],
    /// Largest `shape` (before the height gradient) of each cell of one shape tile, x fastest.
    billow: Vec<f32>,
    weather: &'a [u8],
    cell_m: f64,
}

impl<'a> Bounds<'a> {
    fn new(noise: &'a Noise, field: &'a Procedural, thresholds: &'a [f64]) -> Self {
        let cell_m = field.shape_tile_m / f64::from(CELLS_PER_TILE);
        Self { field, thresholds, billow: billow_bounds(&noise.shape), weather: &noise.weather, cell_m }
    }

    fn occupancy(&self) -> Occupancy {
        let low_m = self.field.decks.iter().map(|d| d.base_m).fold(f64::INFINITY, f64::min);
        let high_m = self.field.decks.iter().map(|d| d.top_m).fold(0.0, f64::max);
        let first = (low_m / self.cell_m).floor();
        let layers = ((high_m / self.cell_m).ceil() - first) as usize;
        let across = (self.field.weather_tile_m / self.cell_m).round() as usize;
        let columns: Vec<Vec<WeatherBound>> =
            (0..self.field.decks.len()).map(|d| self.weather_bounds(across, d)).collect();
        let n = CELLS_PER_TILE as usize;
        Occupancy::new([across, layers, across], true, [0.0, first * self.cell_m, 0.0], self.cell_m, |x, y, z| {
            let level = first as usize + y;
            let billow = self.billow[((z % n) * n + level % n) * n + x % n];
            self.field.decks.iter().zip(&columns).any(|(deck, columns)| {
                let weather = columns[z * across + x];
                let height = |edge: f64| ((edge * self.cell_m - deck.base_m) / (deck.top_m - deck.base_m)) as f32;
                let gradient = weather.gradient_bound(height(level as f64 - 0.01), height(level as f64 + 1.01));
                billow * gradient + FILTER_SLACK > 1.0 - weather.coverage
            })
        })
    }

    /// Bounds of weather over the footprint of every cell column of a deck.
    fn weather_bounds(&self, across: usize, deck_index: usize) -> Vec<WeatherBound> {
        let deck = &self.field.decks[deck_index];
        let n = WEATHER_TEXELS as usize;
        let offset = weather_offset(deck_index);
        // Texels whose filter footprint touches the cell, one more for rounding.
        let span = |cell: usize| {
            let texel = |edge: f64| (edge / across as f64 + offset) * n as f64 - 0.5;
            (texel(cell as f64).floor() as usize).saturating_sub(1)..=texel(cell as f64 + 1.0).floor() as usize + 2
        };
        let kind = |v: u8| deck.cloud_type[0] as f32 + (deck.cloud_type[1] - deck.cloud_type[0]) as f32 * f32::from(v) / 255.0;
        let mut bounds = Vec::with_capacity(across * across);
        for z in 0..across {
            for x in 0..across {
                let mut bound = WeatherBound { coverage: 0.0, type_low: 1.0, type_high: 0.0 };
                for k in span(z) {
                    for i in span(x) {
                        let texel = &self.weather[4 * ((k % n) * n + i % n)..];
                        let coverage = f32::from(texel[0]) / 255.0 + 2.0 * self.thresholds[deck_index] as f32 - 1.0;
                        bound.coverage = bound.coverage.max(coverage.clamp(0.0, 1.0));
                        bound.type_low = bound.type_low.min(kind(texel[2]) - FILTER_SLACK);
                        bound.type_high = bound.type_high.max(kind(texel[2]) + FILTER_SLACK);
                    }
                }
                bounds.push(bound);
            }
        }
        bounds
    }
}

/// Weather over one cell's footprint.
#[derive(Clone, Copy)]
struct WeatherBound {
    coverage: f32,
    type_low: f32,
    type_high: f32,
}

/// The ramps of density/procedural.wgsl, by cloud type 0, 0.5, 1.
const RAMPS: [[f32; 4]; 3] = [[0.02, 0.05, 0.09, 0.11], [0.02, 0.20, 0.48, 0.625], [0.0, 0.0625, 0.45, 1.0]];

impl WeatherBound {
    /// Largest height gradient over heights `low..high` and all types of the footprint.
    fn gradient_bound(&self, low: f32, high: f32) -> f32 {
        if high <= 0.0 || low >= 1.0 {
            return 0.0;
        }
        // Ramps are piecewise linear in type with a knot at 0.5: extremes are at the ends or at the knot.
        let mut ramp = [f32::INFINITY, f32::INFINITY, 0.0_f32, 0.0_f32];
        let mut include = |t: f32| {
            let r = ramp_at(t);
            ramp = [ramp[0].min(r[0]), ramp[1].min(r[1]), ramp[2].max(r[2]), ramp[3].max(r[3])];
        };
        include(self.type_low);
        include(self.type_high);
        if (self.type_low..=self.type_high).contains(&0.5) {
            include(0.5);
        }
        (smoothstep(ramp[0], ramp[1], high) * (1.0 - smoothstep(ramp[2], ramp[3], low)) + 1e-4).min(1.0)
    }
}

fn ramp_at(cloud_type: f32) -> [f32; 4] {
    let lower = (2.0 * cloud_type).clamp(0.0, 1.0);
    let upper = (2.0 * cloud_type - 1.0).clamp(0.0, 1.0);
    std::array::from_fn(|i| {
        let low = RAMPS[0][i] + (RAMPS[1][i] - RAMPS[0][i]) * lower;
        low + (RAMPS[2][i] - low) * upper
    })
}

fn smoothstep(a: f32, b: f32, x: f32) -> f32 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Largest (R − fbm + 1)/(2 − fbm) over each cell of the shape tile: it grows with R and falls with fbm (R ≤ 1), and
/// trilinear samples stay between the texels they are made of. A cell of 2 texels touches 4 along each axis.
fn billow_bounds(shape: &[u8]) -> Vec<f32> {
    let (n, cells) = (SHAPE_TEXELS as usize, CELLS_PER_TILE as usize);
    let mut bounds = vec![0.0; cells * cells * cells];
    for (i, bound) in bounds.iter_mut().enumerate() {
        let cell = [i % cells, i / cells % cells, i / cells / cells];
        let (mut most, mut least) = (0.0_f32, 1.0_f32);
        for dz in 0..4 {
            for dy in 0..4 {
                for dx in 0..4 {
                    let at = |axis: usize, d: usize| (2 * cell[axis] + d + n - 1) % n;
                    let texel = &shape[4 * ((at(2, dz) * n + at(1, dy)) * n + at(0, dx))..];
                    let channel = |c: usize| f32::from(texel[c]) / 255.0;
                    most = most.max(channel(0));
                    least = least.min(0.625 * channel(1) + 0.25 * channel(2) + 0.125 * channel(3));
                }
            }
        }
        *bound = (most - least + 1.0) / (2.0 - least);
    }
    bounds
}
