//! The renderer: renders a scene with a method on a device, with pass times, memory and counts. Independent of any
//! window.

mod frame_spans;
mod inputs;
mod light_map;
mod map_format;
mod map_pass;
mod map_storage;
mod map_texels;
mod picture;
mod prepared;
mod sequence;
mod tiles;
mod view;

pub use map_format::{map_defs, planned_memory};
pub use map_texels::MapTexels;
pub use picture::DevicePicture;
pub use prepared::PreparedPasses;
pub use sequence::{AfterPass, DeviceSequence, Frames};
pub use tiles::Tiling;
pub use view::DeviceView;

use crate::cost::Counting;
use crate::density::{DeviceField, Surroundings};
use crate::error::Result;
use crate::gpu::{ClockWatch, Gpu, Kernel, Program, Sources};
use crate::occlusion::{MethodInfo, MethodSetup};
use crate::scene::ImageSize;
use crate::scene::Scene;
use crate::shader_defs::Defs;
use std::cell::{OnceCell, RefCell};
use std::collections::HashMap;
use std::rc::Rc;

/// Rows of a workgroup of the view march: bands of this many rows are finished one after the other from the top.
pub const BAND_ROWS: u32 = 8;

/// Renders on one device and keeps its compiled kernels.
pub struct Renderer {
    /// The device.
    pub gpu: Gpu,
    /// Tiling of the passes of methods prepared from now on.
    pub tiling: Tiling,
    kernels: RefCell<HashMap<KernelKey, Rc<Kernel>>>,
    /// The last density field, with its key: consecutive views often differ in sun or image size alone.
    density: RefCell<Option<(String, Rc<DeviceField>)>>,
    clock_watch: OnceCell<ClockWatch>,
}

/// Key of a compiled kernel: entry file, its entry point where it has several, roles and definitions.
type KernelKey = (String, Option<String>, Vec<(String, String)>, Defs);

impl Renderer {
    /// A renderer on `gpu`.
    pub fn new(gpu: Gpu) -> Self {
        Self {
            gpu,
            tiling: Tiling::BATCH,
            kernels: RefCell::default(),
            density: RefCell::default(),
            clock_watch: OnceCell::new(),
        }
    }

    /// Clock watch of the device; created at the first call.
    pub fn clock_watch(&self) -> Result<&ClockWatch> {
        match self.clock_watch.get() {
            Some(watch) => Ok(watch),
            None => {
                let made = ClockWatch::new(&self.gpu)?;
                Ok(self.clock_watch.get_or_init(|| made))
            }
        }
    }

    /// Replaces the shader texts if `check` accepts the kernels compiled from them; else restores the old ones.
    pub fn reload(
        &mut self,
        sources: Sources,
        check: impl FnOnce(&Self) -> Result<()>,
    ) -> Result<()> {
        let old = std::mem::replace(&mut self.gpu.sources, sources);
        let (kernels, density) = (self.kernels.take(), self.density.take());
        check(self).inspect_err(|_| {
            self.gpu.sources = old;
            *self.kernels.borrow_mut() = kernels;
            *self.density.borrow_mut() = density;
        })
    }

    /// The compiled kernel of a program, from the cache when it was compiled before.
    fn kernel(&self, program: &Program) -> Result<Rc<Kernel>> {
        self.kernel_of(&self.gpu.sources, program, None)
    }

    /// [`Renderer::kernel`] for a program of a method, with the method's own text where the shaders in use have none.
    fn method_kernel(
        &self,
        method: &MethodInfo,
        program: &Program,
        point: Option<&str>,
    ) -> Result<Rc<Kernel>> {
        let sources = &self.gpu.sources;
        match sources.text(method.shader) {
            Ok(_) => self.kernel_of(sources, program, point),
            Err(_) => {
                let with_own = sources.with(method.shader, method.source);
                self.kernel_of(&with_own, program, point)
            }
        }
    }

    fn kernel_of(
        &self,
        sources: &Sources,
        program: &Program,
        point: Option<&str>,
    ) -> Result<Rc<Kernel>> {
        let roles = program
            .roles
            .iter()
            .map(|(a, b)| ((*a).to_owned(), (*b).to_owned()))
            .collect();
        let key = (
            program.entry.to_owned(),
            point.map(str::to_owned),
            roles,
            program.defs.clone(),
        );
        if let Some(kernel) = self.kernels.borrow().get(&key) {
            return Ok(kernel.clone());
        }
        let kernel = Rc::new(Kernel::of(&self.gpu, sources, program, point)?);
        self.kernels.borrow_mut().insert(key, kernel.clone());
        Ok(kernel)
    }

    /// Uploads a scene for pictures of one size.
    pub fn view(&self, scene: &Scene, image: ImageSize) -> Result<DeviceView> {
        let inputs = inputs::scene_inputs(scene, image, true);
        let around = Surroundings {
            container: &scene.container,
            extinction_per_m: scene.medium.extinction_per_m,
            container_shader: view::container_shader(scene),
            inputs: &inputs,
        };
        // Key of the field, as JSON: the calibration also reads container and extinction.
        let key = serde_json::json!([
            scene.density,
            scene.container,
            scene.medium.extinction_per_m
        ])
        .to_string();
        let kept = self
            .density
            .borrow()
            .as_ref()
            .filter(|(k, _)| *k == key)
            .map(|(_, field)| field.clone());
        let density = match kept {
            Some(field) => field,
            None => Rc::new(scene.density.field().build(&self.gpu, &around)?),
        };
        *self.density.borrow_mut() = Some((key, density.clone()));
        DeviceView::new(&self.gpu, scene, image, density, inputs)
    }

    /// Compiles and allocates the passes of a method in a view, for the frames of `sequence`: [`Frames::full`], or that
    /// of a reconstruction. With counting, kernels have counters and are not timed.
    pub fn prepare(
        &self,
        view: &DeviceView,
        setup: &MethodSetup,
        sequence: &Rc<dyn DeviceSequence>,
        counting: Counting,
    ) -> Result<PreparedPasses> {
        let counting = counting == Counting::On;
        PreparedPasses::new(self, view, view, setup, sequence, counting)
    }

    /// [`Renderer::prepare`] with the light map of another view, timed: that of an earlier frame, where the map is filled
    /// over several. The picture is that of `view`, at the size of both.
    pub fn prepare_with_map_of(
        &self,
        map_view: &DeviceView,
        view: &DeviceView,
        setup: &MethodSetup,
        sequence: &Rc<dyn DeviceSequence>,
    ) -> Result<PreparedPasses> {
        PreparedPasses::new(self, view, map_view, setup, sequence, false)
    }

    /// [`Renderer::prepare`] for pictures of which every pixel is marched, timed.
    pub fn prepare_full(&self, view: &DeviceView, setup: &MethodSetup) -> Result<PreparedPasses> {
        self.prepare(view, setup, &Frames::full(), Counting::Off)
    }
}
