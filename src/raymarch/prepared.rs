//! A method made ready in a view: kernels, map texture, bind groups; then run as often as wanted.

use super::light_map::{MapRectangle, TexelFormat};
use super::{Progress, Renderer, View};
use crate::batch::record::{Memory, Samples};
use crate::error::{Error, Result};
use crate::gpu::{Defs, Gpu, Inputs, Kernel, Program, Resource, Timer, UniformValue, read_buffer};
use crate::occlusion::MethodSetup;
use crate::occlusion::param::ParamValue;
use std::cell::Cell;
use std::ops::ControlFlow;
use std::rc::Rc;
use std::time::Instant;

/// Times of one run, ms; GPU times are `None` where the adapter has no timestamps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassTimes {
    /// The map pass; `None` without a map.
    pub generate: Option<f64>,
    /// The view march, all tiles.
    pub march: Option<f64>,
    /// Submission to completion, seen from the CPU.
    pub wall: f64,
}

impl PassTimes {
    /// Sum of the passes.
    pub fn total(&self) -> Option<f64> {
        self.march.map(|march| march + self.generate.unwrap_or(0.0))
    }
}

/// What one picture took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// Density samples.
    pub samples: Samples,
    /// Light look-ups in a map.
    pub look_ups: u64,
    /// Of these, outside the map and therefore marched.
    pub fallbacks: u64,
}

/// A dispatch on real GPUs must end well before the driver's watchdog (2 s): tiles aim at this, ms.
const TILE_TARGET_MS: f64 = 400.0;
/// Rows of the first tile of a kernel whose speed is not known yet.
const FIRST_TILE_ROWS: u32 = 8;

/// COPY_DST although nothing is copied there: without it wgpu zeroes the texture in a render pass, and a software adapter
/// (llvmpipe) then defers the timestamps of later compute passes until that frame buffer is flushed.
const MAP_USAGE: wgpu::TextureUsages = wgpu::TextureUsages::STORAGE_BINDING
    .union(wgpu::TextureUsages::TEXTURE_BINDING)
    .union(wgpu::TextureUsages::COPY_SRC)
    .union(wgpu::TextureUsages::COPY_DST);

/// See the module.
pub struct Prepared {
    /// Memory of the method.
    pub memory: Memory,
    map: Option<MapPass>,
    march: Rc<Kernel>,
    groups: Vec<wgpu::BindGroup>,
    tile: wgpu::Buffer,
    timer: Option<Timer>,
    image: [u32; 2],
    tile_rows: Cell<u32>,
    view_steps: u32,
    steps_a_dispatch: u32,
    march_counts: Option<wgpu::Buffer>,
}

struct MapPass {
    kernel: Rc<Kernel>,
    groups: Vec<wgpu::BindGroup>,
    resolution: u32,
    counts: Option<wgpu::Buffer>,
}

impl Prepared {
    pub(super) fn new(
        renderer: &Renderer,
        view: &View,
        setup: &MethodSetup,
        counting: bool,
    ) -> Result<Self> {
        let gpu = &renderer.gpu;
        let plan = setup.method.plan(&setup.params)?;
        let mut defs = view.defs.clone();
        defs.extend(setup.defs(&plan));
        if counting {
            defs.insert("COUNT".into(), None);
        }
        let before = gpu.allocated_bytes();
        let mut inputs = Inputs::default();
        inputs.uniform("params", numeric_params(setup));
        let info = setup.method.info();
        let mut memory = Memory::default();
        let map = match plan.map_values {
            None => None,
            Some(values) => {
                defs.insert("HAS_MAP".into(), None);
                let map = MapTexture::new(gpu, view, setup, values, &mut defs, &mut inputs)?;
                memory = map.memory;
                Some(MapPass::new(
                    renderer,
                    view,
                    info.shader,
                    &defs,
                    &inputs,
                    &map,
                    counting,
                )?)
            }
        };
        memory.allocator_bytes = gpu
            .allocated_bytes()
            .zip(before)
            .map(|(now, before)| now.saturating_sub(before));
        let march = renderer.kernel(&Program {
            entry: "raymarch.wgsl",
            roles: view.roles(info.shader),
            defs,
        })?;
        check_params_read(setup, &march, map.as_ref())?;
        let image = [view.image.width, view.image.height];
        let march_counts = counting.then(|| counts_buffer(gpu, image));
        offer_counts(&mut inputs, march_counts.as_ref());
        let tile = gpu.buffer(
            "tile",
            &[0; 24],
            wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::STORAGE,
        );
        inputs.resource("tile", Resource::Buffer(tile.clone()));
        let groups = march.bind(gpu, &[&inputs, &view.inputs, &view.density.inputs])?;
        Ok(Self {
            memory,
            map,
            march,
            groups,
            tile,
            timer: Timer::new(gpu),
            image,
            tile_rows: Cell::new(FIRST_TILE_ROWS),
            view_steps: view.scene.march.most_steps(),
            steps_a_dispatch: steps_a_dispatch(gpu, view, setup)?,
            march_counts,
        })
    }

    /// Renders once, tile by tile.
    pub fn run(&self, gpu: &Gpu, progress: Progress) -> Result<PassTimes> {
        let start = Instant::now();
        let mut times = PassTimes::default();
        if let Some(map) = &self.map {
            times.generate = self.pass(
                gpu,
                &map.kernel,
                &map.groups,
                [map.resolution, map.resolution, 1],
            )?;
        }
        let [width, height] = self.image;
        let mut row = 0;
        while row < height {
            let rows = self.tile_rows.get().min(height - row);
            let tile_start = Instant::now();
            let mut step = 0;
            while step < self.view_steps {
                let end = step.saturating_add(self.steps_a_dispatch);
                let tile = [0, row, width, rows, step, end];
                gpu.queue
                    .write_buffer(&self.tile, 0, bytemuck::bytes_of(&tile));
                let ms = self.pass(gpu, &self.march, &self.groups, [width, rows, 1])?;
                times.march = ms.map(|ms| ms + times.march.unwrap_or(0.0));
                step = end;
            }
            self.adapt(rows, tile_start.elapsed().as_secs_f64() * 1e3);
            row += rows;
            if progress(f64::from(row) / f64::from(height)) == ControlFlow::Break(()) {
                return Err(Error::Stopped);
            }
        }
        times.wall = start.elapsed().as_secs_f64() * 1e3;
        Ok(times)
    }

    /// Next tile's rows: whole workgroups, at most doubling, toward the target duration.
    fn adapt(&self, rows: u32, ms: f64) {
        let wanted = f64::from(rows) * (TILE_TARGET_MS / ms.max(0.01)).min(2.0);
        let step = self.march.workgroup[1];
        self.tile_rows.set(((wanted as u32) / step).max(1) * step);
    }

    fn pass(
        &self,
        gpu: &Gpu,
        kernel: &Kernel,
        groups: &[wgpu::BindGroup],
        threads: [u32; 3],
    ) -> Result<Option<f64>> {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let timestamp_writes = self.timer.as_ref().map(Timer::writes);
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: None,
                timestamp_writes,
            });
            kernel.dispatch(&mut pass, groups, threads);
        }
        if let Some(timer) = &self.timer {
            timer.resolve(&mut encoder);
        }
        gpu.queue.submit([encoder.finish()]);
        match &self.timer {
            Some(timer) => timer.elapsed_ms(gpu).map(Some),
            None => gpu.wait().map(|()| None),
        }
    }

    /// Counters of the last run; zero unless prepared for counting.
    pub fn counts(&self, gpu: &Gpu) -> Result<Counts> {
        let [view, light, look_ups, fallbacks] = sum_counts(gpu, self.march_counts.as_ref())?;
        let [map, ..] = sum_counts(gpu, self.map.as_ref().and_then(|m| m.counts.as_ref()))?;
        Ok(Counts {
            samples: Samples { view, light, map },
            look_ups,
            fallbacks,
        })
    }
}

/// llvmpipe ends the loops of an invocation after 65 535 turns in all of them together (LP_MAX_TGSI_LOOP_ITERATIONS,
/// without a word): there a view ray is marched in several dispatches. Elsewhere in one.
fn steps_a_dispatch(gpu: &Gpu, view: &View, setup: &MethodSetup) -> Result<u32> {
    const TURNS: f64 = 60_000.0;
    if gpu.info.driver != "llvmpipe" {
        return Ok(u32::MAX);
    }
    let longest_path_m = view.scene.container.longest_path_m();
    let light = setup.method.light_turns(&setup.params, longest_path_m)?;
    let steps = (TURNS / (light + 2.0)).floor();
    if steps < 1.0 {
        let problem = format!(
            "one light ray takes {light:.0} steps, this software adapter ends loops after 65535 turns"
        );
        return Err(Error::gpu(
            problem,
            "Choose longer light steps, or use a GPU.",
        ));
    }
    Ok(steps as u32)
}

impl MapPass {
    fn new(
        renderer: &Renderer,
        view: &View,
        shader: &str,
        defs: &Defs,
        inputs: &Inputs,
        map: &MapTexture,
        counting: bool,
    ) -> Result<Self> {
        let gpu = &renderer.gpu;
        let kernel = renderer.kernel(&Program {
            entry: "generate.wgsl",
            roles: view.roles(shader),
            defs: defs.clone(),
        })?;
        let mut inputs = inputs.clone();
        let counts = counting.then(|| counts_buffer(gpu, [map.resolution; 2]));
        offer_counts(&mut inputs, counts.as_ref());
        let groups = kernel.bind(gpu, &[&inputs, &view.inputs, &view.density.inputs])?;
        Ok(Self {
            kernel,
            groups,
            resolution: map.resolution,
            counts,
        })
    }
}

/// The map as allocated.
struct MapTexture {
    resolution: u32,
    memory: Memory,
}

impl MapTexture {
    fn new(
        gpu: &Gpu,
        view: &View,
        setup: &MethodSetup,
        values: u32,
        defs: &mut Defs,
        inputs: &mut Inputs,
    ) -> Result<Self> {
        let resolution = setup.params.int("resolution")?;
        let storage = setup.params.choice("storage")?;
        let hardware = setup.params.choice("lookup")? == "hardware";
        let format = TexelFormat::choose(gpu, values, storage, hardware)?;
        let layers = values.div_ceil(format.channels);
        check_limits(gpu, resolution, layers)?;
        defs.insert(format.define.to_owned(), None);
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("light map"),
            size: wgpu::Extent3d {
                width: resolution,
                height: resolution,
                depth_or_array_layers: layers,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: format.texture,
            usage: MAP_USAGE,
            view_formats: &[],
        });
        gpu.check()?;
        let array = wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        };
        inputs.resource("map_texture", Resource::View(texture.create_view(&array)));
        inputs.resource("map_store", Resource::View(texture.create_view(&array)));
        inputs.resource("map_sampler", Resource::Sampler(clamping_sampler(gpu)));
        let rectangle = MapRectangle::fit(&view.scene, view.image, resolution);
        inputs.uniform(
            "map",
            rectangle.uniform(resolution, setup.params.int("steps")?),
        );
        let texels = u64::from(resolution).pow(2);
        let value_bytes = if storage == "f16" { 2 } else { 4 };
        let memory = Memory {
            payload_bytes: u64::from(values) * value_bytes * texels,
            map_bytes: u64::from(layers) * u64::from(format.bytes) * texels,
            allocator_bytes: None,
        };
        Ok(Self { resolution, memory })
    }
}

fn check_limits(gpu: &Gpu, resolution: u32, layers: u32) -> Result<()> {
    let limits = gpu.device.limits();
    let exceeded = |what: &str, wanted: u32, allowed: u32, remedy: &str| {
        Err(Error::gpu(
            format!("the map needs {what} {wanted}, the adapter's limit is {allowed}"),
            remedy,
        ))
    };
    if resolution > limits.max_texture_dimension_2d {
        return exceeded(
            "an edge of",
            resolution,
            limits.max_texture_dimension_2d,
            "Choose a smaller `resolution`.",
        );
    }
    if layers > limits.max_texture_array_layers {
        return exceeded(
            "array layers:",
            layers,
            limits.max_texture_array_layers,
            "Choose fewer `steps` or a lower `order`.",
        );
    }
    Ok(())
}

fn clamping_sampler(gpu: &Gpu) -> wgpu::Sampler {
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("light map"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    })
}

fn numeric_params(setup: &MethodSetup) -> Vec<(&'static str, UniformValue)> {
    let number = |(name, value)| match value {
        ParamValue::Int(v) => Some((name, UniformValue::U32(v as u32))),
        ParamValue::Float(v) => Some((name, UniformValue::F32(v as f32))),
        ParamValue::Choice(_) => None,
    };
    setup.params.iter().filter_map(number).collect()
}

/// A numeric parameter that neither a uniform nor a definition carries would be ignored in silence.
fn check_params_read(setup: &MethodSetup, march: &Kernel, map: Option<&MapPass>) -> Result<()> {
    let plan = setup.method.plan(&setup.params)?;
    let kernels = [Some(march), map.map(|m| &*m.kernel)];
    for (name, value) in setup.params.iter() {
        let read = kernels
            .iter()
            .flatten()
            .any(|k| k.members("params").contains(&name) || k.members("map").contains(&name));
        let defined = plan.defs.contains_key(&name.to_uppercase());
        if !read && !defined && !matches!(value, ParamValue::Choice(_)) {
            let info = setup.method.info();
            return Err(Error::Shader {
                file: format!("shaders/{}", info.shader),
                message: format!("no shader reads the parameter `{name}`"),
            });
        }
    }
    Ok(())
}

fn counts_buffer(gpu: &Gpu, size: [u32; 2]) -> wgpu::Buffer {
    let bytes = u64::from(size[0]) * u64::from(size[1]) * 16;
    gpu.empty_buffer(
        "counts",
        bytes,
        wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
    )
}

fn offer_counts(inputs: &mut Inputs, buffer: Option<&wgpu::Buffer>) {
    if let Some(buffer) = buffer {
        inputs.resource("counts", Resource::Buffer(buffer.clone()));
    }
}

fn sum_counts(gpu: &Gpu, buffer: Option<&wgpu::Buffer>) -> Result<[u64; 4]> {
    let Some(buffer) = buffer else {
        return Ok([0; 4]);
    };
    let rows: Vec<[u32; 4]> =
        bytemuck::pod_collect_to_vec(&read_buffer(gpu, buffer, buffer.size())?);
    Ok(rows.iter().fold([0; 4], |sum, row| {
        std::array::from_fn(|i| sum[i] + u64::from(row[i]))
    }))
}
