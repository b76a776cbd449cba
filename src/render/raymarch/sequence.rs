//! Sequences of frames on a device: the picture that each frame is marched into, and the reconstruction passes after
//! its march.
//!
//! A reconstruction ([`crate::reconstruct`]) brings a [`DeviceSequence`]; the state that the march of a frame needs is
//! the same for all of them and is kept in its [`Frames`]. A sequence outlives the view of a frame: with a moving
//! camera each frame has its own view, and so its own [`super::PreparedPasses`].

use super::picture::DevicePicture;
use super::{DeviceView, Renderer};
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::gpu::{Flight, Gpu, Inputs, Kernel, Program, Span, UniformValue};
use crate::scene::{Camera, ImageSize, Pattern, Subset};
use crate::shader_defs::Defs;
use std::cell::{Cell, RefCell};
use std::rc::Rc;

/// A pass after the march of a frame. It binds by name the resources of [`DeviceSequence::inputs`], the marched picture
/// (`radiance_out`, `sun_out`, `inverse_depth_out`), the marched pixels (`subset`) and the uniforms of the scene.
#[derive(Clone, Debug)]
pub struct AfterPass {
    /// File with the entry point, path below `shaders/`.
    pub entry: &'static str,
    /// Shader definitions.
    pub defs: Defs,
    /// Threads along x and y.
    pub threads: [u32; 2],
}

/// The device part of a reconstruction: a sequence of frames of one image size.
pub trait DeviceSequence {
    /// State of the sequence: its pictures, its turn and the camera of the last frame.
    fn frames(&self) -> &Frames;

    /// The passes after the march of every frame, in order.
    fn passes(&self) -> Vec<AfterPass> {
        Vec::new()
    }

    /// Further inputs of those passes for the next frame, seen by `camera`.
    fn inputs(&self, _camera: &Camera) -> Inputs {
        Inputs::default()
    }
}

/// State that every sequence of frames has.
pub struct Frames {
    pattern: Pattern,
    /// Pictures used in turn; empty to march into the view's own.
    pictures: Vec<DevicePicture>,
    /// Next frame, modulo [`Frames::turns`].
    turn: Cell<usize>,
    /// Camera of the frame before; `None` at the start of the sequence.
    camera: RefCell<Option<Camera>>,
}

impl Frames {
    /// Frames that march `pattern` into `count` pictures of their own, used in turn, so that a frame can read earlier
    /// ones.
    pub fn new(
        gpu: &Gpu,
        image: ImageSize,
        pattern: Pattern,
        count: usize,
        inverse_depth: bool,
    ) -> Result<Self> {
        let picture = |_| DevicePicture::new(gpu, image, inverse_depth);
        let pictures = (0..count).map(picture).collect();
        gpu.check()?;
        Ok(Self {
            pictures,
            ..Self::in_view(pattern)
        })
    }

    /// Frames that march `pattern` into the picture of their view and keep no history.
    pub fn in_view(pattern: Pattern) -> Self {
        Self {
            pattern,
            pictures: Vec::new(),
            turn: Cell::new(0),
            camera: RefCell::new(None),
        }
    }

    /// Frames that march every pixel, without passes after that.
    pub fn full() -> Rc<dyn DeviceSequence> {
        Rc::new(Self::in_view(Pattern::EVERY))
    }

    /// The pixels that the next frame marches.
    pub fn subset(&self) -> Subset {
        self.pattern.subset(self.turn.get())
    }

    /// The picture that the last frame was marched into, if the sequence has pictures of its own.
    pub fn before(&self) -> Option<&DevicePicture> {
        self.picture(self.turn.get() + self.turns() - 1)
    }

    /// Camera of the last frame; `None` before the first.
    pub fn camera_before(&self) -> Option<Camera> {
        self.camera.borrow().clone()
    }

    /// Bytes of its own pictures.
    pub fn bytes(&self) -> u64 {
        self.pictures.iter().map(DevicePicture::bytes).sum()
    }

    /// Length of the cycle after which the same picture is marched at the same pixels again, frames.
    fn turns(&self) -> usize {
        let (frames, pictures) = (self.pattern.frames(), self.pictures.len().max(1));
        let mut turns = frames;
        while !turns.is_multiple_of(pictures) {
            turns += frames;
        }
        turns
    }

    fn picture(&self, turn: usize) -> Option<&DevicePicture> {
        self.pictures.get(turn % self.pictures.len().max(1))
    }

    fn advance(&self, camera: &Camera) {
        self.turn.set((self.turn.get() + 1) % self.turns());
        self.camera.replace(Some(camera.clone()));
    }
}

impl DeviceSequence for Frames {
    fn frames(&self) -> &Frames {
        self
    }
}

/// A sequence in one view: the outputs of the march, and the compiled passes after it.
pub(super) struct Outputs {
    sequence: Rc<dyn DeviceSequence>,
    view: DevicePicture,
    scene: Inputs,
    camera: Camera,
    passes: Vec<(Rc<Kernel>, [u32; 2])>,
    /// Outputs of the march, for each turn.
    turns: Vec<Inputs>,
}

impl Outputs {
    pub fn new(
        renderer: &Renderer,
        view: &DeviceView,
        sequence: &Rc<dyn DeviceSequence>,
    ) -> Result<Self> {
        let frames = sequence.frames();
        let fits = |picture: &DevicePicture| picture.image() == view.image;
        if !frames.pictures.iter().all(fits) {
            let problem = "a sequence of frames has pictures of another size than its view";
            return Err(Error::defect("raymarch", problem));
        }
        let compile = |pass: AfterPass| {
            let program = Program {
                entry: pass.entry,
                roles: Vec::new(),
                defs: pass.defs,
            };
            Ok((renderer.kernel(&program)?, pass.threads))
        };
        let passes = sequence.passes().into_iter().map(compile);
        let output = |turn| {
            let picture = frames.picture(turn).unwrap_or(&view.picture);
            output(picture, frames.pattern.subset(turn))
        };
        Ok(Self {
            sequence: sequence.clone(),
            view: view.picture.clone(),
            scene: view.inputs.clone(),
            camera: view.scene.camera.clone(),
            passes: passes.collect::<Result<_>>()?,
            turns: (0..frames.turns()).map(output).collect(),
        })
    }

    /// Adds the definitions of a march that writes here.
    pub fn define(&self, defs: &mut Defs) {
        let Frames {
            pattern, pictures, ..
        } = self.sequence.frames();
        if *pattern != Pattern::EVERY {
            defs.insert("SUBSET".into(), None);
        }
        if pictures.iter().any(|p| p.inverse_depth().is_some()) {
            defs.insert("INVERSE_DEPTH".into(), None);
        }
    }

    /// Threads of a march that writes here: one for each block of pixels.
    pub fn threads(&self) -> [u32; 2] {
        self.sequence.frames().subset().blocks(self.view.image())
    }

    /// Outputs of the march, for each turn.
    pub fn turns(&self) -> &[Inputs] {
        &self.turns
    }

    /// The turn of the next frame.
    pub fn turn(&self) -> usize {
        self.sequence.frames().turn.get()
    }

    /// Bind groups of the passes of the next frame.
    pub fn bind(&self, gpu: &Gpu) -> Result<Vec<Vec<wgpu::BindGroup>>> {
        let own = self.sequence.inputs(&self.camera);
        let inputs = [&own, &self.turns[self.turn()], &self.scene];
        let passes = self.passes.iter();
        passes
            .map(|(kernel, _)| kernel.bind(gpu, &inputs))
            .collect()
    }

    /// Records the passes of the next frame.
    pub fn record(&self, flight: &mut Flight, groups: &[Vec<wgpu::BindGroup>]) -> Vec<Span> {
        let passes = self.passes.iter().zip(groups);
        let record = |((kernel, [x, y]), groups): (&(Rc<Kernel>, [u32; 2]), &Vec<_>)| {
            flight.dispatch(kernel, groups, [*x, *y, 1], None)
        };
        passes.map(record).collect()
    }

    /// Advances to the next turn once a frame is recorded.
    pub fn advance(&self) {
        self.sequence.frames().advance(&self.camera);
    }

    /// The picture of the last frame.
    pub fn read(&self, gpu: &Gpu) -> Result<Frame> {
        let picture = self.sequence.frames().before();
        picture.unwrap_or(&self.view).read(gpu)
    }
}

fn output(picture: &DevicePicture, subset: Subset) -> Inputs {
    let mut inputs = Inputs::default();
    picture.offer(
        &mut inputs,
        ["radiance_out", "sun_out", "inverse_depth_out"],
    );
    let members = [
        ("block", UniformValue::UVec2(subset.block)),
        ("offset", UniformValue::UVec2(subset.offset)),
        ("shear", UniformValue::U32(subset.shear)),
    ];
    inputs.uniform("subset", members);
    inputs
}
