//! Procedural clouds on the device: noise textures, calibrated coverage, occupancy.

use super::bounds::Bounds;
use super::calibrate::Calibrator;
use super::{DETAIL_TEXELS, Deck, Procedural, SHAPE_TEXELS, WEATHER_TEXELS, weather_offset};
use crate::density::{Built, DeviceField, Surroundings};
use crate::error::Result;
use crate::gpu::{Gpu, Inputs, Kernel, Program, Resource, UniformValue, read_texture};
use crate::shader_defs::Defs;
use std::time::Instant;

/// WGSL file that evaluates the field.
pub(super) const SHADER: &str = "density/procedural.wgsl";

pub(super) fn build(gpu: &Gpu, field: &Procedural, around: &Surroundings) -> Result<DeviceField> {
    let (start, compiled_s) = (Instant::now(), gpu.compile_s());
    let noise = Noise::generate(gpu, field)?;
    let noise_ms = (start.elapsed().as_secs_f64() - (gpu.compile_s() - compiled_s)) * 1e3;
    let mut inputs = noise.inputs(gpu);
    let calibrator = Calibrator::new(gpu, field, around.container_shader)?;
    let mut thresholds = Vec::new();
    let mut measured_coverage = Vec::new();
    for (i, deck) in field.decks.iter().enumerate() {
        let (threshold, measured) =
            calibrator.threshold(gpu, field, i, deck, around.inputs, &inputs)?;
        thresholds.push(threshold);
        measured_coverage.push(measured);
    }
    inputs.uniform("field", field_values(field, &field.decks, &thresholds, 0));
    let occupancy = Bounds::new(&noise.shape, &noise.weather, field, &thresholds).occupancy();
    occupancy.upload(gpu, &mut inputs);
    gpu.check()?;
    Ok(DeviceField {
        built: Built {
            noise_ms: Some(noise_ms),
            empty_fraction: Some(occupancy.empty_fraction()),
            cell_m: Some(occupancy.cell_m),
            measured_coverage,
        },
        ..DeviceField::new(field, inputs)
    })
}

pub(super) fn defs(field: &Procedural, decks: usize) -> Defs {
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
pub(super) fn field_values(
    field: &Procedural,
    decks: &[Deck],
    thresholds: &[f64],
    first: usize,
) -> Vec<(String, UniformValue)> {
    let number = |v: f64| UniformValue::F32(v as f32);
    let mut values = vec![
        (
            "weather_frequency_per_m".to_owned(),
            number(1.0 / field.weather_tile_m),
        ),
        (
            "shape_frequency_per_m".to_owned(),
            number(1.0 / field.shape_tile_m),
        ),
        (
            "precipitation_gain".to_owned(),
            number(field.precipitation_gain.unwrap_or(0.0)),
        ),
    ];
    if let Some(detail) = &field.detail {
        values.push((
            "detail_frequency_per_m".to_owned(),
            number(1.0 / detail.tile_m),
        ));
        values.push(("detail_strength".to_owned(), number(detail.strength)));
    }
    for (i, (deck, threshold)) in decks.iter().zip(thresholds).enumerate() {
        let profile = [
            deck.base_m,
            deck.top_m,
            deck.cloud_type[0],
            deck.cloud_type[1],
        ]
        .map(|v| v as f32);
        let cover = [*threshold, weather_offset(first + i)].map(|v| v as f32);
        values.push((format!("decks[{i}].profile"), UniformValue::Vec4(profile)));
        values.push((format!("decks[{i}].cover"), UniformValue::Vec2(cover)));
    }
    values
}

/// The noise textures and their read-back copies.
struct Noise {
    views: Vec<(&'static str, wgpu::TextureView)>,
    shape: Vec<u8>,
    weather: Vec<u8>,
}

impl Noise {
    fn generate(gpu: &Gpu, field: &Procedural) -> Result<Self> {
        let cube = |n: u32| wgpu::Extent3d {
            width: n,
            height: n,
            depth_or_array_layers: n,
        };
        let flat = wgpu::Extent3d {
            width: WEATHER_TEXELS,
            height: WEATHER_TEXELS,
            depth_or_array_layers: 1,
        };
        let shape = noise_texture(
            gpu,
            "noise/shape.wgsl",
            cube(SHAPE_TEXELS),
            wgpu::TextureDimension::D3,
            field.seed,
        )?;
        let weather = noise_texture(
            gpu,
            "noise/weather.wgsl",
            flat,
            wgpu::TextureDimension::D2,
            field.seed,
        )?;
        let view = |t: &wgpu::Texture| t.create_view(&Default::default());
        let mut views = vec![("shape", view(&shape)), ("weather", view(&weather))];
        if field.detail.is_some() {
            let detail = noise_texture(
                gpu,
                "noise/detail.wgsl",
                cube(DETAIL_TEXELS),
                wgpu::TextureDimension::D3,
                field.seed,
            )?;
            views.push(("detail", view(&detail)));
        }
        Ok(Self {
            views,
            shape: read_texture(gpu, &shape)?,
            weather: read_texture(gpu, &weather)?,
        })
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
    let kernel = Kernel::new(
        gpu,
        &Program {
            entry,
            roles: vec![],
            defs: Defs::new(),
        },
    )?;
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
    inputs.resource(
        "texels",
        Resource::View(texture.create_view(&Default::default())),
    );
    inputs.uniform("noise", [("seed", UniformValue::U32(seed))]);
    let groups = kernel.bind(gpu, &[&inputs])?;
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        kernel.dispatch(
            &mut pass,
            &groups,
            [size.width, size.height, size.depth_or_array_layers],
        );
    }
    gpu.queue.submit([encoder.finish()]);
    gpu.wait()?;
    Ok(texture)
}
