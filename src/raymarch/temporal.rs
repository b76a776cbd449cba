//! Temporal integration on a device: a frame marches one pixel of every 2 × 2 block and takes the others from the picture
//! before, reprojected; see `shaders/temporal.wgsl` and [`Reconstruct`].
//!
//! Two pictures take turns: a frame reads one and writes the other, so nothing is copied. What outlives a frame is the
//! [`History`]: a camera that moves has a view, and so a [`Temporal`], of its own in every frame.

use super::prepared::{Prepared, fly};
use super::{Renderer, View};
use crate::cost::{Counts, Memory, PassTimes};
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::gpu::{Flight, Gpu, Inputs, Kernel, Program, Resource, Span, UniformValue, read_buffer};
use crate::occlusion::MethodSetup;
use crate::progress::Progress;
use crate::scene::{Camera, ImageSize, Reconstruct};
use glam::{DMat3, DVec3};
use std::cell::{Cell, RefCell};
use std::rc::Rc;

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
    Err(Error::input(
        "image",
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
        let read = |buffer| -> Result<Vec<[f32; 4]>> {
            let bytes = read_buffer(gpu, buffer, bytes)?;
            Ok(bytemuck::pod_collect_to_vec(&bytes))
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
            return Err(Error::defect(
                "temporal_2x2",
                "the history has pictures of another size",
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
        let groups = self.reconstruct_groups(gpu, frame)?;
        let mut times = self.march.run_into(gpu, frame, progress)?;
        let mut flight = Flight::new(gpu);
        let span = self.record_reconstruct(&mut flight, &groups);
        let finished = flight.finish(|| ())?;
        let pass = finished.pass(&[span]);
        times.reconstruct = pass.ms;
        times.refused |= pass.refused;
        times.wall += finished.wall_ms;
        self.history.advance(&self.camera);
        Ok(times)
    }

    /// The next `frames` frames of the sequence without waiting between them, each in one submission; the times of each.
    /// See [`Prepared::repeat`].
    pub fn repeat(
        &self,
        gpu: &Gpu,
        frames: u32,
        meanwhile: impl FnOnce(),
    ) -> Result<Vec<PassTimes>> {
        fly(gpu, frames, meanwhile, |flight| {
            let frame = self.history.frame.get();
            let groups = self.reconstruct_groups(gpu, frame)?;
            let mut spans = self.march.record_into(flight, frame);
            spans.reconstruct = vec![self.record_reconstruct(flight, &groups)];
            self.history.advance(&self.camera);
            Ok(spans)
        })
    }

    /// What the reconstruction of the next frame binds.
    fn reconstruct_groups(&self, gpu: &Gpu, frame: usize) -> Result<Vec<wgpu::BindGroup>> {
        let inputs = self.history.inputs(&self.camera);
        self.kernel.bind(gpu, &[&inputs, &self.outputs[frame]])
    }

    fn record_reconstruct(&self, flight: &mut Flight, groups: &[wgpu::BindGroup]) -> Span {
        let ImageSize { width, height } = self.history.image;
        flight.dispatch(&self.kernel, groups, [width, height, 1], None)
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

#[cfg(test)]
mod tests {
    use super::*;

    const IMAGE: ImageSize = ImageSize {
        width: 160,
        height: 90,
    };

    fn camera(position_m: [f64; 3], target_m: [f64; 3]) -> Camera {
        Camera {
            position_m,
            target_m,
            up: [0.1, 1.0, 0.0],
            fov_y_deg: 40.0,
            far_m: None,
        }
    }

    /// Pixel and depth of a point, from the camera's definition.
    fn project(camera: &Camera, point: DVec3) -> (DVec3, f64) {
        let (right, up, forward) = camera.basis();
        let (half_x, half_y) = camera.half_extent(160.0 / 90.0);
        let p = point - DVec3::from(camera.position_m);
        let depth = p.dot(forward);
        let x = (1.0 + p.dot(right) / depth / half_x) * 80.0;
        let y = (1.0 - p.dot(up) / depth / half_y) * 45.0;
        (DVec3::new(x, y, 1.0), depth)
    }

    fn member(motion: &[(&str, UniformValue)], name: &str) -> DVec3 {
        let value = motion.iter().find(|(n, _)| *n == name).map(|(_, v)| *v);
        match value {
            Some(UniformValue::Vec3(v)) => DVec3::from(v.map(f64::from)),
            other => panic!("{name}: {other:?}"),
        }
    }

    #[test]
    fn a_point_is_found_again_from_where_the_camera_was() {
        let before = camera([10.0, 50.0, -900.0], [0.0, 80.0, 0.0]);
        let now = camera([40.0, 20.0, -870.0], [30.0, 60.0, 10.0]);
        let motion = motion(&before, &now, IMAGE);
        for point in [[0.0, 0.0, 0.0], [200.0, 90.0, 300.0], [-150.0, 20.0, 40.0]] {
            let (pixel, depth) = project(&now, point.into());
            let (expected, depth_before) = project(&before, point.into());
            let far = member(&motion, "turn_x") * pixel.x
                + member(&motion, "turn_y") * pixel.y
                + member(&motion, "turn_w");
            let found = far + member(&motion, "shift") / depth;
            assert!((found / found.z - expected).length() < 1e-3, "{found}");
            assert!((found.z * depth / depth_before - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn a_camera_at_rest_moves_no_pixel_by_a_bit() {
        let image = ImageSize {
            width: 8192,
            height: 8191,
        };
        let still = camera([1e7, 2.0, -3e6], [1e7 + 1.0, 3.0, -3e6]);
        let motion = motion(&still, &still, image);
        let turn = ["turn_x", "turn_y", "turn_w"].map(|n| member(&motion, n).as_vec3());
        assert_eq!(member(&motion, "shift"), DVec3::ZERO);
        for pixel in [[0.5_f32, 0.5], [8191.5, 8190.5], [17.5, 4000.5]] {
            let found = turn[0] * pixel[0] + turn[1] * pixel[1] + turn[2];
            let rounded = [found.x, found.y].map(|v| (v / found.z * 256.0).round() / 256.0);
            assert_eq!(rounded, pixel);
        }
    }
}
