//! A method made ready in a view: kernels, map texture, bind groups; then run as often as wanted.

use super::cost::{Counts, Memory, PassTimes, Samples};
use super::map_pass::{MapPass, MapTexture, counts_buffer, offer_counts};
use super::map_texels::MapTexels;
use super::{Progress, Renderer, View};
use crate::error::{Error, Result};
use crate::gpu::{Gpu, Inputs, Kernel, Program, Resource, Timer, UniformValue, read_buffer};
use crate::occlusion::MethodSetup;
use crate::occlusion::param::ParamValue;
use std::cell::Cell;
use std::ops::ControlFlow;
use std::rc::Rc;
use std::time::Instant;

/// A dispatch on real GPUs must end well before the driver's watchdog (2 s): tiles aim at this, ms.
const TILE_TARGET_MS: f64 = 400.0;
/// Rows of the first tile of a kernel whose speed is not known yet.
const FIRST_TILE_ROWS: u32 = 8;

/// See the module.
pub struct Prepared {
    /// Memory of the method.
    pub memory: Memory,
    map: Option<MapPass>,
    march: Rc<Kernel>,
    /// One for each place that the march may write to.
    groups: Vec<Vec<wgpu::BindGroup>>,
    tile: wgpu::Buffer,
    timer: Option<Timer>,
    /// Threads of the march: pixels, or 2 × 2 blocks of them.
    image: [u32; 2],
    tile_rows: Cell<u32>,
    view_steps: u32,
    steps_a_dispatch: u32,
    march_counts: Option<wgpu::Buffer>,
}

impl Prepared {
    /// `quarters`: empty to march every pixel into the view's own picture; else the places where one pixel of every 2 × 2
    /// block is marched to, see [`super::temporal`].
    pub(super) fn new(
        renderer: &Renderer,
        view: &View,
        setup: &MethodSetup,
        counting: bool,
        quarters: &[Inputs],
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
                    map,
                    counting,
                )?)
            }
        };
        memory.allocator_bytes = gpu
            .allocated_bytes()
            .zip(before)
            .map(|(now, before)| now.saturating_sub(before));
        if !quarters.is_empty() {
            defs.insert("TEMPORAL_2X2".into(), None);
        }
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
        let bind = |into| march.bind(gpu, &[into, &inputs, &view.inputs, &view.density.inputs]);
        let groups = match quarters {
            [] => vec![bind(&Inputs::default())?],
            places => places.iter().map(bind).collect::<Result<_>>()?,
        };
        Ok(Self {
            memory,
            map,
            march,
            groups,
            tile,
            timer: Timer::new(gpu),
            image: match quarters {
                [] => image,
                _ => image.map(|side| side.div_ceil(2)),
            },
            tile_rows: Cell::new(FIRST_TILE_ROWS),
            view_steps: view.scene.march.most_steps(),
            steps_a_dispatch: steps_a_dispatch(gpu, view, setup)?,
            march_counts,
        })
    }

    /// Renders once, tile by tile.
    pub fn run(&self, gpu: &Gpu, progress: Progress) -> Result<PassTimes> {
        self.run_into(gpu, 0, progress)
    }

    /// The same into one of the places given to [`Prepared::new`].
    pub(super) fn run_into(
        &self,
        gpu: &Gpu,
        place: usize,
        progress: Progress,
    ) -> Result<PassTimes> {
        let start = Instant::now();
        let mut times = PassTimes::default();
        if let Some(map) = &self.map {
            times.generate = self.pass(
                gpu,
                &map.kernel,
                &map.groups,
                [map.texture.resolution, map.texture.resolution, 1],
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
                let ms = self.pass(gpu, &self.march, &self.groups[place], [width, rows, 1])?;
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

    /// One pass, timed where the adapter has timestamps.
    pub(super) fn pass(
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

    /// The light map of the last run; `None` for a method without one.
    pub fn map_texels(&self, gpu: &Gpu) -> Result<Option<MapTexels>> {
        let read = |map: &MapPass| MapTexels::read(gpu, &map.texture);
        self.map.as_ref().map(read).transpose()
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
