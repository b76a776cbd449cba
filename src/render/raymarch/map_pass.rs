//! The passes that fill a light map: the one that marches its columns, and a method's own before and after it.

use super::light_map::offer_geometry;
use super::map_format::{TexelFormat, defs, usable};
use super::map_storage::MapStorage;
use super::tiles::{Pass, SLOW_SAMPLES_A_MS, Tiles};
use super::{DeviceView, Renderer};
use crate::cost::Memory;
use crate::error::{Error, Result};
use crate::gpu::{Flight, Gpu, Inputs, Kernel, PassTime, Program, Resource, Span};
use crate::occlusion::MethodSetup;
use crate::occlusion::plan::{MapPlan, MethodPass};
use crate::progress::Progress;
use crate::scene::MapCascades;
use crate::shader_defs::Defs;
use std::cell::Cell;
use std::rc::Rc;

/// A light map and the passes that fill it: the whole map in every frame, or a part of a second map, which replaces the
/// one that is read when it is complete.
pub(super) struct MapPasses {
    /// One map, or two that are filled and read in turn.
    maps: Vec<FilledMap>,
    /// Resources of each map, by the names under which it is read.
    inputs: Vec<Inputs>,
    /// Frames over which a map is filled.
    fill_frames: u32,
    state: Cell<FillState>,
    /// Where the texels lie.
    pub cascades: MapCascades,
}

/// A map and its passes, in order of execution.
struct FilledMap {
    storage: MapStorage,
    passes: Vec<MapPass>,
}

/// Progress of filling a map over several frames.
#[derive(Clone, Copy, Default)]
struct FillState {
    /// Whether there is a complete map to read.
    complete: bool,
    /// The map that is read.
    read: usize,
    /// The part of the other map that the next frame fills.
    part: u32,
}

/// One compiled pass with its resources.
struct MapPass {
    kernel: Rc<Kernel>,
    groups: Vec<wgpu::BindGroup>,
    tiles: Tiles,
    threads: [u32; 2],
    counts: Option<wgpu::Buffer>,
}

/// Context shared by the passes of a map.
struct MapContext<'a> {
    renderer: &'a Renderer,
    view: &'a DeviceView,
    setup: &'a MethodSetup,
    defs: &'a Defs,
    inputs: &'a Inputs,
    counting: bool,
}

impl MapPasses {
    /// Allocates the map of a view and compiles its passes. The definitions that the view march needs are added to
    /// `defs`, the geometry of the map to `inputs`.
    pub fn new(
        renderer: &Renderer,
        view: &DeviceView,
        setup: &MethodSetup,
        plan: &MapPlan,
        defs: &mut Defs,
        inputs: &mut Inputs,
        counting: bool,
    ) -> Result<Self> {
        let gpu = &renderer.gpu;
        let fill_frames = setup.fill_parts(plan)?;
        let format = TexelFormat::choose(setup, plan.layout, |format| usable(gpu, format))?;
        defs.extend(self::defs(plan.layout, format));
        let resolution = setup.params.int("resolution")?;
        let cascades = MapCascades::new(&view.scene, view.image, resolution, setup.map_coverage()?);
        let cell_m = view.density.built.cell_m;
        offer_geometry(gpu, &cascades, setup, &view.scene, cell_m, inputs)?;
        let (mut maps, mut read) = (Vec::new(), Vec::new());
        for _ in 0..maps_of(fill_frames) {
            let mut own = inputs.clone();
            let storage = MapStorage::new(gpu, setup, plan, format, &mut own)?;
            let around = MapContext {
                renderer,
                view,
                setup,
                defs,
                inputs: &own,
                counting,
            };
            let passes = around.passes(plan, &storage)?;
            maps.push(FilledMap { storage, passes });
            read.push(own);
        }
        Ok(Self {
            maps,
            inputs: read,
            fill_frames,
            state: Cell::default(),
            cascades,
        })
    }

    /// Memory of all maps.
    pub fn memory(&self) -> Memory {
        self.maps[0].storage.memory
    }

    /// The map that is read.
    pub fn storage(&self) -> &MapStorage {
        &self.maps[self.read()].storage
    }

    /// Index of the map that is read.
    pub fn read(&self) -> usize {
        self.state.get().read
    }

    /// Resources of each map, by the names under which it is read.
    pub fn inputs(&self) -> &[Inputs] {
        &self.inputs
    }

    /// Fills the map, or the next part of it, tile by tile; returns the GPU time of all passes. Where there is no
    /// complete map yet, one is filled before, outside of that time.
    pub fn fill(&self, gpu: &Gpu, progress: Progress) -> Result<PassTime> {
        let mut run = |pass: &MapPass, part| pass.tiles.run(gpu, &pass.pass(part), &mut *progress);
        if !self.state.get().complete && self.fill_frames > 1 {
            for pass in &self.maps[self.read()].passes {
                run(pass, Part::WHOLE)?;
            }
        }
        let passes = self.next();
        let times: Vec<PassTime> = passes
            .map(|(pass, part)| run(pass, part))
            .collect::<Result<_>>()?;
        self.advance();
        Ok(PassTime::sum(&times))
    }

    /// Records what [`Self::fill`] does, without waiting. Needs one [`Self::fill`] before.
    pub fn record(&self, flight: &mut Flight) -> Vec<Span> {
        let record = |(pass, part): (&MapPass, Part)| pass.tiles.record(flight, &pass.pass(part));
        let spans = self.next().flat_map(record).collect();
        self.advance();
        spans
    }

    /// The passes of the next frame.
    fn next(&self) -> impl Iterator<Item = (&MapPass, Part)> {
        let FillState { read, part, .. } = self.state.get();
        let filled = (read + 1) % self.maps.len();
        let of = self.fill_frames;
        let passes = self.maps[filled].passes.iter();
        passes.map(move |pass| (pass, Part { index: part, of }))
    }

    fn advance(&self) {
        let state = self.state.get();
        let part = (state.part + 1) % self.fill_frames;
        let read = match part {
            0 => (state.read + 1) % self.maps.len(),
            _ => state.read,
        };
        self.state.set(FillState {
            complete: true,
            read,
            part,
        });
    }

    /// The compiled passes.
    pub fn kernels(&self) -> impl Iterator<Item = &Kernel> {
        self.maps[0].passes.iter().map(|pass| &*pass.kernel)
    }

    /// Counter buffers of the passes that count, of the map that the first frame fills a part of.
    pub fn counts(&self) -> impl Iterator<Item = &wgpu::Buffer> {
        let filled = &self.maps[self.maps.len() - 1];
        filled.passes.iter().filter_map(|pass| pass.counts.as_ref())
    }
}

/// Maps that are allocated: a second one where a map is filled while another is read.
pub(super) fn maps_of(fill_frames: u32) -> u64 {
    match fill_frames {
        1 => 1,
        _ => 2,
    }
}

/// One of several equal parts of a map's rows.
#[derive(Clone, Copy)]
struct Part {
    index: u32,
    of: u32,
}

impl Part {
    const WHOLE: Self = Self { index: 0, of: 1 };
}

impl MapPass {
    fn pass(&self, part: Part) -> Pass<'_> {
        let [columns, rows] = self.threads;
        let rows = rows / part.of;
        Pass {
            kernel: &self.kernel,
            groups: &self.groups,
            first_row: rows * part.index,
            size: [columns, rows],
            steps: [1, 1],
        }
    }
}

impl MapContext<'_> {
    fn passes(&self, plan: &MapPlan, storage: &MapStorage) -> Result<Vec<MapPass>> {
        let own = |pass| self.own_pass(pass, storage);
        let mut passes: Vec<_> = plan.before.iter().map(own).collect::<Result<_>>()?;
        passes.push(self.column_pass([storage.resolution, storage.rows])?);
        for pass in &plan.after {
            passes.push(own(pass)?);
        }
        Ok(passes)
    }

    fn column_pass(&self, texels: [u32; 2]) -> Result<MapPass> {
        let shader = self.setup.method.info().shader;
        let kernel = self.kernel("generate.wgsl", shader, None)?;
        self.bound(kernel, texels, self.inputs.clone())
    }

    fn own_pass(&self, pass: &MethodPass, storage: &MapStorage) -> Result<MapPass> {
        let shader = self.setup.method.info().shader;
        if pass.threads.contains(&0) {
            let problem = format!("its pass `{}` has no invocations", pass.entry);
            return Err(Error::defect(self.setup.method.info().id, problem));
        }
        let kernel = self.kernel(shader, shader, Some(pass.entry))?;
        if kernel.keeps("density_samples") && !kernel.uses("counts") {
            return Err(Error::Shader {
                file: format!("shaders/{shader}"),
                message: format!("`{}` takes density samples and counts none", pass.entry),
            });
        }
        let mut inputs = self.inputs.clone();
        storage.narrow(pass, &mut inputs)?;
        self.bound(kernel, pass.threads, inputs)
    }

    fn kernel(&self, entry: &str, shader: &str, point: Option<&str>) -> Result<Rc<Kernel>> {
        let program = Program {
            entry,
            roles: self.view.roles(shader),
            defs: self.defs.clone(),
        };
        self.renderer
            .method_kernel(self.setup.method.info(), &program, point)
    }

    fn bound(&self, kernel: Rc<Kernel>, threads: [u32; 2], mut inputs: Inputs) -> Result<MapPass> {
        let gpu = &self.renderer.gpu;
        let counting = self.counting && kernel.uses("counts");
        let counts = counting.then(|| counts_buffer(gpu, threads));
        offer_counts(&mut inputs, counts.as_ref());
        let tiling = self.renderer.tiling;
        // Upper bound: as if every invocation marched a column.
        let steps = f64::from(self.setup.params.int("steps")?);
        let first = tiling.target_ms * SLOW_SAMPLES_A_MS / steps;
        let tiles = Tiles::new(gpu, &mut inputs, tiling, first);
        let inputs = [&inputs, &self.view.inputs, &self.view.density.inputs];
        Ok(MapPass {
            groups: kernel.bind(gpu, &inputs)?,
            kernel,
            tiles,
            threads,
            counts,
        })
    }
}

/// Four counters for each of `size` threads.
pub(super) fn counts_buffer(gpu: &Gpu, size: [u32; 2]) -> wgpu::Buffer {
    let bytes = u64::from(size[0]) * u64::from(size[1]) * 16;
    gpu.empty_buffer(
        "counts",
        bytes,
        wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
    )
}

/// Offers the counters of a counting pass.
pub(super) fn offer_counts(inputs: &mut Inputs, buffer: Option<&wgpu::Buffer>) {
    if let Some(buffer) = buffer {
        inputs.resource("counts", Resource::Buffer(buffer.clone()));
    }
}
