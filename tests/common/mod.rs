//! Scenes, volumes and rendering shared by the integration tests. A test binary opens one adapter.
#![allow(dead_code, reason = "each test binary uses its own part")]

pub mod agreement;
pub mod formula;

use glam::DVec3;
use npyz::WriterBuilder;
use occlab::cost::Counting;
use occlab::cost::Counts;
use occlab::frame::Frame;
use occlab::gpu::Gpu;
use occlab::occlusion::{MethodInfo, MethodSetup};
use occlab::progress::unwatched;
use occlab::raymarch::{DeviceView, Frames, Renderer};
use occlab::scene::ImageSize;
use occlab::scene::{
    Camera, Container, Deck, Density, Detail, Lobe, March, Medium, Procedural, Scene, Sun, Uniform,
    Volume,
};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Mutex, OnceLock};

type Job = Box<dyn FnOnce(&Renderer) + Send>;

/// Ends a test that needs an adapter where there is none; see [`no_adapter`].
#[allow(unused_macros, reason = "each test binary uses its own part")]
macro_rules! needs_adapter {
    () => {
        if common::no_adapter() {
            return;
        }
    };
}

/// Says by name that the running test is skipped, where this machine has no adapter; with OCCLAB_REQUIRE_GPU=1, as CI
/// sets it, the test fails instead.
pub fn no_adapter() -> bool {
    static NONE: OnceLock<bool> = OnceLock::new();
    let none = *NONE.get_or_init(|| occlab::gpu::list_adapters().is_empty());
    if none {
        let thread = std::thread::current();
        let name = thread.name().unwrap_or("a test").to_owned();
        let required = std::env::var_os("OCCLAB_REQUIRE_GPU").is_some_and(|v| v == "1");
        assert!(
            !required,
            "OCCLAB_REQUIRE_GPU is set and there is no adapter"
        );
        // Not println!, which the test harness keeps to itself when a test passes.
        let _ = writeln!(std::io::stderr(), "skipped: no adapter: {name}");
    }
    none
}

/// Runs `job` on the binary's only renderer, which lives on a thread of its own and keeps its compiled kernels.
pub fn on_gpu<R: Send + 'static>(job: impl FnOnce(&Renderer) -> R + Send + 'static) -> R {
    static JOBS: OnceLock<Result<Mutex<Sender<Job>>, String>> = OnceLock::new();
    let jobs = JOBS.get_or_init(start_renderer);
    let jobs = jobs
        .as_ref()
        .unwrap_or_else(|problem| panic!("this test needs an adapter: {problem}"));
    let (send, receive) = channel();
    let boxed: Job = Box::new(move |renderer| {
        let result = catch_unwind(AssertUnwindSafe(|| job(renderer)));
        let _ = send.send(result);
    });
    jobs.lock()
        .unwrap()
        .send(boxed)
        .expect("the renderer's thread lives as long as the tests");
    receive
        .recv()
        .expect("a job always answers")
        .unwrap_or_else(|panic| resume_unwind(panic))
}

fn start_renderer() -> Result<Mutex<Sender<Job>>, String> {
    let (send_jobs, jobs) = channel::<Job>();
    let (send_opened, opened) = channel();
    std::thread::spawn(move || match Gpu::new(None) {
        Err(problem) => send_opened.send(Err(problem.to_string())).unwrap(),
        Ok(gpu) => {
            send_opened.send(Ok(())).unwrap();
            let renderer = Renderer::new(gpu);
            jobs.into_iter().for_each(|job| job(&renderer));
        }
    });
    opened
        .recv()
        .expect("the renderer's thread reports once")
        .map(|()| Mutex::new(send_jobs))
}

pub fn size(width: u32, height: u32) -> ImageSize {
    ImageSize { width, height }
}

/// `id` with parameters written `name=value`, separated by blanks.
pub fn setup(id: &str, params: &str) -> MethodSetup {
    params
        .split_whitespace()
        .fold(MethodSetup::defaults(id).unwrap(), |setup, pair| {
            let (name, value) = pair.split_once('=').unwrap();
            setup.with(name, value).unwrap()
        })
}

/// Whether a method of the registry has a map.
pub fn has_map(id: &str) -> bool {
    let setup = setup(id, "");
    let plan = setup.method.plan(&setup.params).unwrap();
    plan.map_values().is_some()
}

/// Settings at which a method is exact where the longest column of a homogeneous medium has the optical depth `tau`.
pub fn exact_settings(info: &MethodInfo, tau: f64) -> Vec<String> {
    let settings = info.trials.exact.iter();
    settings
        .map(|text| text.replace("{tau}", &tau.to_string()))
        .collect()
}

/// The method with `params`, and with `map` if it has one. Maps that are not read by texels have no `lookup`, those
/// that hold no floats no `storage`.
pub fn with_map(id: &str, map: &str, params: &str) -> MethodSetup {
    if !has_map(id) {
        return setup(id, params);
    }
    let defaults = setup(id, "");
    let lacks = |pair: &&str| {
        let (name, _) = pair.split_once('=').unwrap();
        ["lookup", "storage"].contains(&name) && defaults.params.get(name).is_none()
    };
    let pairs = map.split_whitespace().chain(params.split_whitespace());
    let declared: Vec<&str> = pairs.filter(|pair| !lacks(pair)).collect();
    setup(id, &declared.join(" "))
}

/// One picture; the scene must be valid.
pub fn render(scene: &Scene, image: ImageSize, setup: &MethodSetup) -> Frame {
    scene.validate().unwrap();
    let (scene, setup) = (scene.clone(), setup.clone());
    on_gpu(move |renderer| render_view(renderer, &renderer.view(&scene, image).unwrap(), &setup))
}

/// One picture of a view that exists already.
pub fn render_view(renderer: &Renderer, view: &DeviceView, setup: &MethodSetup) -> Frame {
    renderer
        .prepare_full(view, setup)
        .unwrap()
        .run(&renderer.gpu, &mut unwatched)
        .unwrap();
    view.read(&renderer.gpu).unwrap()
}

/// The density samples of one picture.
pub fn count_view(renderer: &Renderer, view: &DeviceView, setup: &MethodSetup) -> Counts {
    let prepared = renderer
        .prepare(view, setup, &Frames::full(), Counting::On)
        .unwrap();
    prepared.run(&renderer.gpu, &mut unwatched).unwrap();
    prepared.counts(&renderer.gpu).unwrap()
}

/// Unit direction of the ray through a pixel's centre, as the camera documents it.
pub fn pixel_ray(scene: &Scene, image: ImageSize, column: u32, row: u32) -> DVec3 {
    let (right, up, forward) = scene.camera.basis();
    let (half_x, half_y) = scene
        .camera
        .half_extent(f64::from(image.width) / f64::from(image.height));
    let x = 2.0 * (f64::from(column) + 0.5) / f64::from(image.width) - 1.0;
    let y = 1.0 - 2.0 * (f64::from(row) + 0.5) / f64::from(image.height);
    (forward + right * (x * half_x) + up * (y * half_y)).normalize()
}

/// Henyey & Greenstein 1941, in f64.
pub fn henyey_greenstein(g: f64, cosine: f64) -> f64 {
    (1.0 - g * g) / (4.0 * std::f64::consts::PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5))
}

/// √(Σ(a − b)²/Σb²).
pub fn relative_rmse(pairs: impl IntoIterator<Item = (f64, f64)>) -> f64 {
    let (error, norm) = pairs.into_iter().fold((0.0, 0.0), |(e, n), (a, b)| {
        (e + (a - b) * (a - b), n + b * b)
    });
    (error / norm).sqrt()
}

/// Red of every pixel of `a` with that of `b`.
pub fn reds<'a>(a: &'a Frame, b: &'a Frame) -> impl Iterator<Item = (f64, f64)> + 'a {
    a.radiance
        .iter()
        .zip(&b.radiance)
        .map(|(a, b)| (f64::from(a[0]), f64::from(b[0])))
}

/// A homogeneous box, sun of irradiance 1, no sky, one isotropic lobe, midpoint steps.
pub fn box_scene(min_m: [f64; 3], max_m: [f64; 3], extinction_per_m: f64) -> Scene {
    let middle: [f64; 3] = std::array::from_fn(|i| 0.5 * (min_m[i] + max_m[i]));
    Scene {
        name: "box".into(),
        container: Container::Box { min_m, max_m },
        density: Density::Uniform(Uniform { value: 1.0 }),
        medium: Medium {
            extinction_per_m,
            albedo: 1.0,
            phase: vec![Lobe {
                g: 0.0,
                weight: 1.0,
            }],
            sun_gain: 1.0,
        },
        sun: Sun {
            elevation_deg: 90.0,
            azimuth_deg: 0.0,
            irradiance: Some([1.0; 3]),
        },
        sky: None,
        ambient: None,
        camera: Camera {
            position_m: [middle[0], middle[1], min_m[2] - 2.0 * (max_m[2] - min_m[2])],
            target_m: middle,
            up: [0.0, 1.0, 0.0],
            fov_y_deg: 30.0,
            far_m: None,
        },
        march: March {
            steps: 64,
            jitter: false,
            ..March::default()
        },
    }
}

/// A container of each kind, 1 km high, and the shader that plays its role.
pub fn containers() -> [(&'static str, Container); 2] {
    let shell = Container::Shell {
        planet_radius_m: 2e5,
        base_m: 1000.0,
        top_m: 2000.0,
    };
    let solid = Container::Box {
        min_m: [-700.0, 100.0, -500.0],
        max_m: [800.0, 1100.0, 600.0],
    };
    [
        ("container/shell.wgsl", shell),
        ("container/box.wgsl", solid),
    ]
}

/// A procedural field whose periods are powers of two, so that a shift by a period is exact in f32.
pub fn procedural(coverage: f64) -> Procedural {
    Procedural {
        seed: 1,
        weather_tile_m: 8192.0,
        shape_tile_m: 2048.0,
        detail: Some(Detail {
            tile_m: 256.0,
            strength: 0.3,
        }),
        precipitation_gain: Some(0.5),
        decks: vec![Deck {
            base_m: 1024.0,
            top_m: 2048.0,
            coverage,
            cloud_type: [0.6, 1.0],
        }],
    }
}

/// A spherical layer of procedural cumulus under an oblique sun, seen from the ground.
pub fn cumulus() -> Scene {
    let mut scene = box_scene([-1.0; 3], [1.0; 3], 0.03);
    scene.name = "cumulus".into();
    scene.container = Container::Shell {
        planet_radius_m: 2e5,
        base_m: 1024.0,
        top_m: 2048.0,
    };
    scene.density = Density::Procedural(procedural(0.5));
    scene.sun = Sun {
        elevation_deg: 50.0,
        azimuth_deg: 60.0,
        irradiance: Some([1.0; 3]),
    };
    scene.medium.phase = vec![
        Lobe {
            g: 0.7,
            weight: 0.6,
        },
        Lobe {
            g: -0.2,
            weight: 0.4,
        },
    ];
    scene.camera = Camera {
        position_m: [0.0, 2.0, 0.0],
        target_m: [1.0, 2.6, 0.2],
        up: [0.0, 1.0, 0.0],
        fov_y_deg: 50.0,
        far_m: Some(2e4),
    };
    scene
}

/// Writes an f32 cube of `n` cells an edge, value(x, y, z) at cell (x, y, z), as `[z][y][x]`.
pub fn write_cube(folder: &Path, n: usize, value: impl Fn(usize, usize, usize) -> f32) -> PathBuf {
    let path = folder.join("cube.npy");
    let array = npyz::WriteOptions::new()
        .default_dtype()
        .shape(&[n as u64; 3])
        .writer(BufWriter::new(File::create(&path).unwrap()));
    let mut writer = array.begin_nd().unwrap();
    for (z, y) in (0..n).flat_map(|z| (0..n).map(move |y| (z, y))) {
        writer.extend((0..n).map(|x| value(x, y, z))).unwrap();
    }
    writer.finish().unwrap();
    path
}

/// The density of a cube written by [`write_cube`].
/// A box of cells, two fifths of them lumps of random density, under an oblique sun.
pub fn lumps(folder: &Path) -> Scene {
    let value = |x: usize, y: usize, z: usize| {
        let lump = hashed(x / 4, y / 4, z / 4) < 0.4;
        if lump { hashed(x, y, z) } else { 0.0 }
    };
    let mut scene = box_scene([0.0; 3], [900.0, 700.0, 800.0], 0.02);
    scene.density = cube_density(write_cube(folder, 16, value));
    (scene.sun.elevation_deg, scene.sun.azimuth_deg) = (41.0, 67.0);
    scene
}

pub fn cube_density(path: PathBuf) -> Density {
    Density::Volume(Volume { path, up_axis: 1 })
}

/// Pseudo-random number in [0, 1) from three indices (Jarzynski & Olano 2020, pcg3d).
pub fn hashed(x: usize, y: usize, z: usize) -> f32 {
    let mut v = [x as u32, y as u32, z as u32]
        .map(|i| i.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    for round in 0..2 {
        for i in 0..3 {
            v[i] = v[i].wrapping_add(v[(i + 1) % 3].wrapping_mul(v[(i + 2) % 3]));
        }
        if round == 0 {
            v = v.map(|i| i ^ (i >> 16));
        }
    }
    (v[0] >> 8) as f32 / 16_777_216.0
}
