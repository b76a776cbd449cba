//! A method prepared in a view: kernels, map texture, bind groups. Each run renders the next frame of a sequence.

use super::frame_spans::{FrameSpans, pass_times};
use super::map_pass::{MapPasses, counts_buffer, offer_counts};
use super::map_texels::MapTexels;
use super::sequence::{DeviceSequence, Outputs};
use super::tiles::{Pass, Tiles};
use super::{DeviceView, Renderer};
use crate::cost::{Counts, Memory, PassTimes, Samples};
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::gpu::{Flight, Gpu, Inputs, Kernel, Program, UniformValue, read_buffer};
use crate::occlusion::{MethodSetup, READ_BY_RENDERER};
use crate::param::ParamValue;
use crate::progress::Progress;
use std::rc::Rc;
use std::time::Instant;

/// Rows of the first tile of a march, while its speed is unknown.
const FIRST_TILE_ROWS: u32 = 8;

/// A method in a view, its passes compiled and bound.
pub struct PreparedPasses {
    /// Memory of the method.
    pub memory: Memory,
    map: Option<MapPasses>,
    march: Rc<Kernel>,
    /// Bind groups of the march, for each map that it may read and each turn of the sequence.
    groups: Vec<Vec<Vec<wgpu::BindGroup>>>,
    outputs: Outputs,
    tiles: Tiles,
    view_steps: u32,
    steps_a_dispatch: u32,
    march_counts: Option<wgpu::Buffer>,
}

impl PreparedPasses {
    pub(super) fn new(
        renderer: &Renderer,
        view: &DeviceView,
        map_view: &DeviceView,
        setup: &MethodSetup,
        sequence: &Rc<dyn DeviceSequence>,
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
        let map = match &plan.map {
            None => None,
            Some(map) => {
                let (defs, inputs) = (&mut defs, &mut inputs);
                let map = MapPasses::new(renderer, map_view, setup, map, defs, inputs, counting)?;
                memory = map.memory();
                Some(map)
            }
        };
        memory.allocator_bytes = gpu
            .allocated_bytes()
            .zip(before)
            .map(|(now, before)| now.saturating_sub(before));
        let outputs = Outputs::new(renderer, view, sequence)?;
        outputs.define(&mut defs);
        let program = Program {
            entry: "raymarch.wgsl",
            roles: view.roles(info.shader),
            defs,
        };
        let march = renderer.method_kernel(info, &program, None)?;
        check_params_read(setup, &march, map.as_ref()).map_err(|e| gpu.sources.blame(e))?;
        let image = [view.image.width, view.image.height];
        let march_counts = counting.then(|| counts_buffer(gpu, image));
        offer_counts(&mut inputs, march_counts.as_ref());
        let first_tile = f64::from(image[0]) * f64::from(FIRST_TILE_ROWS);
        let tiles = Tiles::new(gpu, &mut inputs, renderer.tiling, first_tile);
        let none = [Inputs::default()];
        let maps = map.as_ref().map_or(&none[..], MapPasses::inputs);
        let bind = |map| -> Result<Vec<_>> {
            let turns = outputs.turns().iter();
            let scene = [&view.inputs, &view.density.inputs];
            let bind = |into| march.bind(gpu, &[&[into, &inputs, map][..], &scene].concat());
            turns.map(bind).collect()
        };
        let groups = maps.iter().map(bind).collect::<Result<_>>()?;
        Ok(Self {
            memory,
            map,
            march,
            groups,
            outputs,
            tiles,
            view_steps: view.scene.march.most_steps(),
            steps_a_dispatch: steps_a_dispatch(gpu, view, setup)?,
            march_counts,
        })
    }

    /// Renders the next frame, tile by tile; `progress` is called with the share of the view march, 0…1.
    pub fn run(&self, gpu: &Gpu, progress: Progress) -> Result<PassTimes> {
        let after = self.outputs.bind(gpu)?;
        let start = Instant::now();
        let generate = match &self.map {
            None => None,
            Some(map) => Some(map.fill(gpu, &mut |_| progress(0.0))?),
        };
        let march = self.tiles.run(gpu, &self.pass(), progress)?;
        let mut wall = start.elapsed().as_secs_f64() * 1e3;
        let mut reconstruct = None;
        if !after.is_empty() {
            let mut flight = Flight::new(gpu);
            let spans = self.outputs.record(&mut flight, &after);
            let finished = flight.finish(|| ())?;
            reconstruct = Some(finished.pass(&spans));
            wall += finished.wall_ms;
        }
        self.outputs.advance();
        Ok(pass_times(generate, march, reconstruct, wall))
    }

    /// Renders the next `frames` frames without waiting between them, all passes of each in one submission, as an
    /// engine does; returns the times of each. `meanwhile` is called while they are in flight. Call [`Self::run`] once
    /// before: it measures how long the passes take, and so whether they must be cut into tiles.
    pub fn repeat(
        &self,
        gpu: &Gpu,
        frames: u32,
        meanwhile: impl FnOnce(),
    ) -> Result<Vec<PassTimes>> {
        let mut flight = Flight::new(gpu);
        let mut spans = Vec::new();
        for _ in 0..frames {
            let after = self.outputs.bind(gpu)?;
            let map = self.map.as_ref();
            spans.push(FrameSpans {
                generate: map.map(|map| map.record(&mut flight)).unwrap_or_default(),
                march: self.tiles.record(&mut flight, &self.pass()),
                reconstruct: self.outputs.record(&mut flight, &after),
            });
            self.outputs.advance();
            flight.submit();
        }
        let finished = flight.finish(meanwhile)?;
        Ok(spans.iter().map(|s| s.times(&finished, frames)).collect())
    }

    /// Dispatch of the march of the next frame.
    fn pass(&self) -> Pass<'_> {
        Pass {
            kernel: &self.march,
            groups: &self.groups[self.map.as_ref().map_or(0, MapPasses::read)][self.outputs.turn()],
            first_row: 0,
            size: self.outputs.threads(),
            steps: [self.view_steps, self.steps_a_dispatch],
        }
    }

    /// Reads back the picture of the last frame. All methods that march into the view share its picture: read it before
    /// another method runs there.
    pub fn picture(&self, gpu: &Gpu) -> Result<Frame> {
        self.outputs.read(gpu)
    }

    /// Reads back the light map of the last run; `None` for a method without one.
    pub fn map_texels(&self, gpu: &Gpu) -> Result<Option<MapTexels>> {
        let read = |map: &MapPasses| MapTexels::read(gpu, map.storage(), &map.cascades);
        self.map.as_ref().map(read).transpose()
    }

    /// Reads back the counters of the last run; zero unless prepared for counting.
    pub fn counts(&self, gpu: &Gpu) -> Result<Counts> {
        let [view, light, look_ups, fallbacks] = sum_counts(gpu, self.march_counts.as_ref())?;
        let mut map = 0;
        for buffer in self.map.iter().flat_map(MapPasses::counts) {
            let [samples, ..] = sum_counts(gpu, Some(buffer))?;
            map += samples;
        }
        Ok(Counts {
            samples: Samples { view, light, map },
            look_ups,
            fallbacks,
        })
    }
}

/// Steps of a view ray in one dispatch. llvmpipe silently ends the loops of an invocation after 65 535 iterations of
/// all of them together (LP_MAX_TGSI_LOOP_ITERATIONS): there a view ray is marched in several dispatches, elsewhere in
/// one.
fn steps_a_dispatch(gpu: &Gpu, view: &DeviceView, setup: &MethodSetup) -> Result<u32> {
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

/// Refuses a numeric parameter that neither a uniform nor a definition carries: it would silently have no effect.
fn check_params_read(setup: &MethodSetup, march: &Kernel, map: Option<&MapPasses>) -> Result<()> {
    let plan = setup.method.plan(&setup.params)?;
    let of_map = map.into_iter().flat_map(MapPasses::kernels);
    let kernels: Vec<&Kernel> = of_map.chain([march]).collect();
    for (name, value) in setup.params.iter() {
        let read = kernels
            .iter()
            .any(|k| k.members("params").contains(&name) || k.members("map").contains(&name));
        let defined = plan.defs.contains_key(&name.to_uppercase());
        let used = read || defined || READ_BY_RENDERER.contains(&name);
        if !used && !matches!(value, ParamValue::Choice(_)) {
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
