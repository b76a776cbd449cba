//! Temporal integration on a device: a frame marches one pixel of every 2 × 2 block and takes the others from the picture
//! before, reprojected; see `shaders/temporal.wgsl` and [`Reconstruct`].
//!
//! Two pictures take turns: a frame reads one and writes the other, so nothing is copied. What outlives a frame is the
//! [`History`]: a camera that moves has a view, and so a [`Temporal`], of its own in every frame.

use super::prepared::Prepared;
use super::{Counts, Memory, PassTimes, Progress, Renderer, View};
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::gpu::{Gpu, Inputs, Kernel, Program, Resource, UniformValue, read_buffer};
use crate::occlusion::MethodSetup;
use crate::scene::{Camera, ImageSize, Reconstruct};
use glam::{DMat3, DVec3};
use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::time::Instant;

/// Bytes of radiance or of sunlight of a pixel, and of its nearness.
const RGBA_BYTES: u64 = 16;
const NEARNESS_BYTES: u64 = 4;

/// The pictures that a sequence of frames remembers.
pub struct History {
    image: ImageSize,
    pictures: [Picture; 2],
    /// Next frame, counted modulo 4: it says which pixel of a block is marched, its parity which picture is written.
    frame: Cell<usize>,
    /// Camera of the picture before; `None` at the start of a sequence.
    camera: RefCell<Option<Camera>>,
}

/// What is kept of a frame.
struct Picture {
    radiance: wgpu::Buffer,
    sun: wgpu::Buffer,
    /// 1/mean depth along the optical axis, m⁻¹; 0 where nothing is seen.
    nearness: wgpu::Buffer,
}

impl Picture {
    fn new(gpu: &Gpu, image: ImageSize) -> Self {
        let pixels = u64::from(image.width) * u64::from(image.height);
        let buffer = |name, bytes: u64| {
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
            gpu.empty_buffer(name, pixels * bytes, usage)
        };
        Self {
            radiance: buffer("radiance", RGBA_BYTES),
            sun: buffer("sun", RGBA_BYTES),
            nearness: buffer("nearness", NEARNESS_BYTES),
        }
    }

    /// Offers the buffers under the names that shaders give them.
    fn offer(&self, inputs: &mut Inputs, [radiance, sun, nearness]: [&'static str; 3]) {
        inputs.resource(radiance, Resource::Buffer(self.radiance.clone()));
        inputs.resource(sun, Resource::Buffer(self.sun.clone()));
        inputs.resource(nearness, Resource::Buffer(self.nearness.clone()));
    }
}

/// Bytes of a history of pictures of this size.
pub fn history_bytes(image: ImageSize) -> u64 {
    2 * u64::from(image.width) * u64::from(image.height) * (2 * RGBA_BYTES + NEARNESS_BYTES)
}

/// Refuses pictures without a pixel for each of the four frames.
pub(crate) fn check_size(image: ImageSize) -> Result<()> {
    if image.width >= 2 && image.height >= 2 {
        return Ok(());
    }
    let problem = format!(
        "temporal_2x2 needs 2 × 2 pixels, the picture has {} × {}",
        image.width, image.height
    );
    Err(Error::gpu(
        problem,
        "Choose a larger image, or `\"reconstruct\": \"full\"`.",
    ))
}

impl History {
    /// A history that remembers nothing yet.
    pub fn new(gpu: &Gpu, image: ImageSize) -> Result<Rc<Self>> {
        check_size(image)?;
        let pictures = [Picture::new(gpu, image), Picture::new(gpu, image)];
        gpu.check()?;
        Ok(Rc::new(Self {
            image,
            pictures,
            frame: Cell::new(0),
            camera: RefCell::new(None),
        }))
    }

    /// The picture of the last frame.
    pub fn read(&self, gpu: &Gpu) -> Result<Frame> {
        let ImageSize { width, height } = self.image;
        let bytes = u64::from(width) * u64::from(height) * RGBA_BYTES;
        let last = &self.pictures[(self.frame.get() + 1) % 2];
        let read = |buffer| {
            let bytes = read_buffer(gpu, buffer, bytes)?;
            Ok(bytemuck::pod_collect_to_vec::<u8, [f32; 4]>(&bytes))
        };
        Ok(Frame {
            width,
            height,
            radiance: read(&last.radiance)?,
            sun: read(&last.sun)?,
        })
    }

    /// Where each of four frames writes.
    fn outputs(&self) -> Vec<Inputs> {
        let output = |frame: usize| {
            let mut inputs = Inputs::default();
            let names = ["radiance_out", "sun_out", "nearness_out"];
            self.pictures[frame % 2].offer(&mut inputs, names);
            let pixel = UniformValue::UVec2(Reconstruct::BAYER_2X2[frame]);
            inputs.uniform("quarter", [("pixel", pixel)]);
            inputs
        };
        (0..4).map(output).collect()
    }

    /// What the reconstruction of the next frame, seen by `camera`, reads.
    fn inputs(&self, camera: &Camera) -> Inputs {
        let before = self.camera.borrow();
        let mut motion = motion(before.as_ref().unwrap_or(camera), camera, self.image);
        let pixel = Reconstruct::BAYER_2X2[self.frame.get()];
        motion.push(("pixel", UniformValue::UVec2(pixel)));
        motion.push(("remembers", UniformValue::U32(before.is_some().into())));
        let mut inputs = Inputs::default();
        let names = ["radiance_in", "sun_in", "nearness_in"];
        self.pictures[(self.frame.get() + 1) % 2].offer(&mut inputs, names);
        inputs.uniform("motion", motion);
        inputs
    }

    fn advance(&self, camera: &Camera) {
        self.frame.set((self.frame.get() + 1) % 4);
        self.camera.replace(Some(camera.clone()));
    }
}

/// Directions A·(x, y, 1) of the rays through the points (x, y) of a picture, in pixels: their part along the optical
/// axis is 1.
fn rays(camera: &Camera, image: ImageSize) -> DMat3 {
    let (width, height) = (f64::from(image.width), f64::from(image.height));
    let (right, up, forward) = camera.basis();
    let (half_x, half_y) = camera.half_extent(width / height);
    let (right, up) = (right * half_x, up * half_y);
    DMat3::from_cols(
        right * (2.0 / width),
        up * (-2.0 / height),
        forward - right + up,
    )
}

/// H = A'⁻¹A and e = A'⁻¹(C − C'): a point of depth d behind (x, y) in the picture of camera C, A lies at
/// H·(x, y, 1) + e/d, homogeneous, in that of C', A'. Members of `Motion` in temporal.wgsl.
fn motion(before: &Camera, now: &Camera, image: ImageSize) -> Vec<(&'static str, UniformValue)> {
    let to_before = rays(before, image).inverse();
    let turn = to_before * rays(now, image);
    let shift = to_before * (DVec3::from(now.position_m) - DVec3::from(before.position_m));
    let vector = |v: DVec3| UniformValue::Vec3(v.as_vec3().into());
    vec![
        ("turn_x", vector(turn.x_axis)),
        ("turn_y", vector(turn.y_axis)),
        ("turn_w", vector(turn.z_axis)),
        ("shift", vector(shift)),
        ("size", UniformValue::UVec2([image.width, image.height])),
    ]
}

/// A method made ready in a view, for frames of a sequence.
pub struct Temporal {
    /// Memory of the method, without the history.
    pub memory: Memory,
    march: Prepared,
    kernel: Rc<Kernel>,
    outputs: Vec<Inputs>,
    history: Rc<History>,
    camera: Camera,
}

impl Temporal {
    pub(super) fn new(
        renderer: &Renderer,
        view: &View,
        setup: &MethodSetup,
        history: &Rc<History>,
        counting: bool,
    ) -> Result<Self> {
        if history.image != view.image {
            return Err(Error::input(
                "temporal_2x2",
                "the history has pictures of another size",
                "This is a defect of the program; please report it.",
            ));
        }
        let outputs = history.outputs();
        let march = Prepared::new(renderer, view, setup, counting, &outputs)?;
        let kernel = renderer.kernel(&Program {
            entry: "temporal.wgsl",
            roles: Vec::new(),
            defs: Default::default(),
        })?;
        Ok(Self {
            memory: march.memory,
            march,
            kernel,
            outputs,
            history: history.clone(),
            camera: view.scene.camera.clone(),
        })
    }

    /// The next frame of the sequence: the map, a quarter of the pixels, the rest from the history.
    pub fn run(&self, gpu: &Gpu, progress: Progress) -> Result<PassTimes> {
        let frame = self.history.frame.get();
        let inputs = self.history.inputs(&self.camera);
        let groups = self.kernel.bind(gpu, &[&inputs, &self.outputs[frame]])?;
        let mut times = self.march.run_into(gpu, frame, progress)?;
        let ImageSize { width, height } = self.history.image;
        let start = Instant::now();
        times.reconstruct = self
            .march
            .pass(gpu, &self.kernel, &groups, [width, height, 1])?;
        times.wall += start.elapsed().as_secs_f64() * 1e3;
        self.history.advance(&self.camera);
        Ok(times)
    }

    /// The picture of the sequence's last frame.
    pub fn picture(&self, gpu: &Gpu) -> Result<Frame> {
        self.history.read(gpu)
    }

    /// Counters of the last run; zero unless prepared for counting.
    pub fn counts(&self, gpu: &Gpu) -> Result<Counts> {
        self.march.counts(gpu)
    }
}
