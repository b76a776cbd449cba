//! A method made ready in a view: kernels, map texture, bind groups; then run as often as wanted.

use super::frame_spans::{FrameSpans, pass_times};
use super::map_pass::{MapPasses, counts_buffer, offer_counts};
use super::map_texels::MapTexels;
use super::tiles::{Pass, Tiles};
use super::{Renderer, View};
use crate::cost::{Counts, Memory, PassTimes, Samples};
use crate::error::{Error, Result};
use crate::gpu::{Flight, Gpu, Inputs, Kernel, Program, UniformValue, read_buffer};
use crate::occlusion::MethodSetup;
use crate::param::ParamValue;
use crate::progress::Progress;
use std::rc::Rc;
use std::time::Instant;

/// Rows of the first tile of a march, whose speed is not known yet.
const FIRST_TILE_ROWS: u32 = 8;

/// See the module.
pub struct Prepared {
    /// Memory of the method.
    pub memory: Memory,
    map: Option<MapPasses>,
    march: Rc<Kernel>,
    /// One for each place that the march may write to.
    groups: Vec<Vec<wgpu::BindGroup>>,
    tiles: Tiles,
    /// Threads of the march along x, y: pixels, or 2 × 2 blocks of them.
    threads: [u32; 2],
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
        let map = match &plan.map {
            None => None,
            Some(map) => {
                let (defs, inputs) = (&mut defs, &mut inputs);
                let map = MapPasses::new(renderer, view, setup, map, defs, inputs, counting)?;
                memory = map.storage.memory;
                Some(map)
            }
        };
        memory.allocator_bytes = gpu
            .allocated_bytes()
            .zip(before)
            .map(|(now, before)| now.saturating_sub(before));
        if !quarters.is_empty() {
            defs.insert("TEMPORAL_2X2".into(), None);
        }
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
            tiles,
            threads: match quarters {
                [] => image,
                _ => image.map(|side| side.div_ceil(2)),
            },
            view_steps: view.scene.march.most_steps(),
            steps_a_dispatch: steps_a_dispatch(gpu, view, setup)?,
            march_counts,
        })
    }

    /// Renders once, tile by tile; `progress` hears the share of the view march.
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
        let generate = match &self.map {
            None => None,
            Some(map) => Some(map.fill(gpu, &mut |_| progress(0.0))?),
        };
        let march = self.tiles.run(gpu, &self.pass(place), progress)?;
        let wall = start.elapsed().as_secs_f64() * 1e3;
        Ok(pass_times(generate, march, None, wall))
    }

    /// Renders `frames` pictures one after the other without waiting between them, map and march of each in one submission,
    /// as an engine does; the times of each. `meanwhile` is called while they are under way. Run once before: how long a pass
    /// takes, and so whether it must be cut into tiles, is not known earlier.
    pub fn repeat(
        &self,
        gpu: &Gpu,
        frames: u32,
        meanwhile: impl FnOnce(),
    ) -> Result<Vec<PassTimes>> {
        fly(gpu, frames, meanwhile, |flight| {
            Ok(self.record_into(flight, 0))
        })
    }

    /// Records one picture into one of the places given to [`Prepared::new`].
    pub(super) fn record_into(&self, flight: &mut Flight, place: usize) -> FrameSpans {
        let map = self.map.as_ref();
        FrameSpans {
            generate: map.map(|map| map.record(flight)).unwrap_or_default(),
            march: self.tiles.record(flight, &self.pass(place)),
            reconstruct: Vec::new(),
        }
    }

    fn pass(&self, place: usize) -> Pass<'_> {
        Pass {
            kernel: &self.march,
            groups: &self.groups[place],
            size: self.threads,
            steps: [self.view_steps, self.steps_a_dispatch],
        }
    }

    /// The light map of the last run; `None` for a method without one.
    pub fn map_texels(&self, gpu: &Gpu) -> Result<Option<MapTexels>> {
        let read = |map: &MapPasses| MapTexels::read(gpu, &map.storage);
        self.map.as_ref().map(read).transpose()
    }

    /// Counters of the last run; zero unless prepared for counting.
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

/// Hands over `frames` pictures that `record` records, and waits once.
pub(super) fn fly(
    gpu: &Gpu,
    frames: u32,
    meanwhile: impl FnOnce(),
    mut record: impl FnMut(&mut Flight) -> Result<FrameSpans>,
) -> Result<Vec<PassTimes>> {
    let mut flight = Flight::new(gpu);
    let mut spans = Vec::new();
    for _ in 0..frames {
        spans.push(record(&mut flight)?);
        flight.submit();
    }
    let finished = flight.finish(meanwhile)?;
    Ok(spans.iter().map(|s| s.times(&finished, frames)).collect())
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
fn check_params_read(setup: &MethodSetup, march: &Kernel, map: Option<&MapPasses>) -> Result<()> {
    let plan = setup.method.plan(&setup.params)?;
    let of_map = map.into_iter().flat_map(MapPasses::kernels);
    let kernels: Vec<&Kernel> = of_map.chain([march]).collect();
    for (name, value) in setup.params.iter() {
        let read = kernels
            .iter()
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
