//! The passes that fill a light map: the one that marches its columns, and a method's own before and after it.

use super::light_map::offer_geometry;
use super::map_format::{TexelFormat, defs, usable};
use super::map_storage::MapStorage;
use super::tiles::{Pass, SLOW_SAMPLES_A_MS, Tiles};
use super::{DeviceView, Renderer};
use crate::error::{Error, Result};
use crate::gpu::{Flight, Gpu, Inputs, Kernel, PassTime, Program, Resource, Span};
use crate::occlusion::MethodSetup;
use crate::occlusion::plan::{MapPlan, MethodPass};
use crate::progress::Progress;
use crate::scene::MapRectangle;
use crate::shader_defs::Defs;
use std::rc::Rc;

/// A light map and the passes that fill it.
pub(super) struct MapPasses {
    pub storage: MapStorage,
    /// Where its texels lie.
    pub rectangle: MapRectangle,
    /// In order of execution.
    passes: Vec<MapPass>,
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
    /// Allocates a map and compiles its passes. The definitions and inputs that the view march needs are added to
    /// `defs` and `inputs`.
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
        let format = TexelFormat::choose(setup, plan.layout, |format| usable(gpu, format))?;
        defs.extend(self::defs(plan.layout, format));
        let storage = MapStorage::new(gpu, setup, plan, format, inputs)?;
        let fit = setup.map_fit()?;
        let rectangle = MapRectangle::fit(&view.scene, view.image, storage.resolution, fit);
        let cell_m = view.density.built.cell_m;
        offer_geometry(gpu, &rectangle, &storage, setup, cell_m, inputs)?;
        let around = MapContext {
            renderer,
            view,
            setup,
            defs,
            inputs,
            counting,
        };
        let own = |passes: &[MethodPass]| -> Result<Vec<MapPass>> {
            let compiled = passes.iter().map(|pass| around.own_pass(pass, &storage));
            compiled.collect()
        };
        let mut passes = own(&plan.before)?;
        passes.push(around.column_pass(storage.resolution)?);
        passes.extend(own(&plan.after)?);
        Ok(Self {
            storage,
            rectangle,
            passes,
        })
    }

    /// Fills the map, tile by tile; returns the GPU time of all passes.
    pub fn fill(&self, gpu: &Gpu, progress: Progress) -> Result<PassTime> {
        let run = |pass: &MapPass| pass.tiles.run(gpu, &pass.pass(), &mut *progress);
        let times: Vec<PassTime> = self.passes.iter().map(run).collect::<Result<_>>()?;
        Ok(PassTime::sum(&times))
    }

    /// Records all passes without waiting.
    pub fn record(&self, flight: &mut Flight) -> Vec<Span> {
        let record = |pass: &MapPass| pass.tiles.record(flight, &pass.pass());
        self.passes.iter().flat_map(record).collect()
    }

    /// The compiled passes.
    pub fn kernels(&self) -> impl Iterator<Item = &Kernel> {
        self.passes.iter().map(|pass| &*pass.kernel)
    }

    /// Counter buffers of the passes that count.
    pub fn counts(&self) -> impl Iterator<Item = &wgpu::Buffer> {
        self.passes.iter().filter_map(|pass| pass.counts.as_ref())
    }
}

impl MapPass {
    fn pass(&self) -> Pass<'_> {
        Pass {
            kernel: &self.kernel,
            groups: &self.groups,
            size: self.threads,
            steps: [1, 1],
        }
    }
}

impl MapContext<'_> {
    fn column_pass(&self, resolution: u32) -> Result<MapPass> {
        let shader = self.setup.method.info().shader;
        let kernel = self.kernel("generate.wgsl", shader, None)?;
        self.bound(kernel, [resolution; 2], self.inputs.clone())
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
