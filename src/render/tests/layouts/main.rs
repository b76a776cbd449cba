//! Map layouts and passes that methods may use: a 3-D texture, packed words, a buffer, passes before and after the
//! column pass. The methods are the tests' own, unregistered, and bring their shaders.

extern crate occlab_render as occlab;

#[macro_use]
#[path = "../../../../tests/common/mod.rs"]
mod common;
mod methods;

use common::{
    box_scene, count_view, cube_density, hashed, on_gpu, pixel_ray, relative_rmse, size, write_cube,
};
use methods::{
    BLURRED, BOUNDED, BUFFER, EDGE, FRACTION, LEVELLESS, MIPPED, Method, SLICES, STEPS_A_COLUMN,
    VOLUME, WORD, renamed, setup,
};
use occlab::cost::{Counting, Memory};
use occlab::frame::Frame;
use occlab::occlusion::MethodSetup;
use occlab::oracle::{Options, Oracle};
use occlab::progress::unwatched;
use occlab::raymarch::{DeviceView, Frames, MapTexels, PreparedPasses, Renderer};
use occlab::scene::{ImageSize, Scene};

const IMAGE: ImageSize = ImageSize {
    width: 16,
    height: 12,
};

/// A layer 1 km thick under a vertical sun, seen from inside, so wide that no ray meets a side.
fn layer() -> Scene {
    let mut scene = box_scene([-6000.0, 0.0, -6000.0], [6000.0, 1000.0, 6000.0], 0.0023);
    scene.camera.position_m = [10.0, 480.0, 20.0];
    scene.camera.target_m = [1000.0, 380.0, 400.0];
    scene.camera.fov_y_deg = 60.0;
    scene.camera.far_m = Some(2500.0);
    scene.march.steps = 256;
    scene
}

/// Mean V of a pixel: ∫e^(−σt) e^(−σ(h − t·y))dt / ∫e^(−σt)dt, h from the camera to the top, y the ray's rise.
fn expected_v(scene: &Scene, column: u32, row: u32) -> f64 {
    let rise = pixel_ray(scene, IMAGE, column, row).y;
    let (height, sigma) = (scene.camera.position_m[1], scene.medium.extinction_per_m);
    let above = 1000.0 - height;
    let wall = if rise > 0.0 { above } else { height };
    let length = (wall / rise.abs()).min(2500.0);
    let mean = |sigma: f64| -(-sigma * length).exp_m1() / sigma;
    (-sigma * above).exp() * mean(sigma * (1.0 - rise)) / mean(sigma)
}

fn made(renderer: &Renderer, view: &DeviceView, setup: &MethodSetup) -> PreparedPasses {
    let prepared = renderer.prepare_full(view, setup).unwrap();
    prepared.run(&renderer.gpu, &mut unwatched).unwrap();
    prepared
}

fn texels(renderer: &Renderer, prepared: &PreparedPasses) -> MapTexels {
    prepared.map_texels(&renderer.gpu).unwrap().unwrap()
}

/// Largest error of V in the homogeneous layer: of the method, and of its control.
fn errors(renderer: &Renderer, method: &'static Method, params: &str) -> [f64; 2] {
    let scene = layer();
    let view = renderer.view(&scene, IMAGE).unwrap();
    ["off", "on"].map(|control| {
        made(
            renderer,
            &view,
            &setup(method, &format!("{params} control={control}")),
        );
        let frame = view.read(&renderer.gpu).unwrap();
        let pixels = (0..IMAGE.height).flat_map(|j| (0..IMAGE.width).map(move |i| (i, j)));
        let pairs = frame.sun.iter().zip(pixels);
        pairs
            .map(|(sun, (i, j))| (f64::from(sun[3]) - expected_v(&scene, i, j)).abs())
            .fold(0.0, f64::max)
    })
}

fn check(method: &'static Method, params: &'static str, tolerance: f64) {
    on_gpu(move |renderer| {
        let [error, control] = errors(renderer, method, params);
        println!(
            "{} {params}: {error:.1e}, control {control:.1e}",
            method.info.id
        );
        assert!(
            error <= tolerance,
            "{} {params}: {error:.1e}",
            method.info.id
        );
        assert!(control > 3.0 * tolerance, "{params} control {control:.1e}");
    });
}

/// V where all columns are equal, so that only depth and storage matter, not interpolation between texels. Tolerances:
/// f16 may be truncated, 2⁻¹⁰ of τ, and a sampler's weights are k/256: 8e-4 of V; an f32 picture is good to 1e-4.
#[test]
fn every_layout_says_what_a_homogeneous_layer_lets_through() {
    needs_adapter!();
    check(&VOLUME, "storage=f16", 8e-4);
    for lookup in ["lookup=nearest", "lookup=hardware", "lookup=blend"] {
        check(&FRACTION, lookup, 1e-4 + 0.37 * 8.0 / 65025.0);
    }
    for lookup in ["lookup=nearest", "lookup=blend"] {
        check(&WORD, lookup, 1e-4);
        check(&BUFFER, lookup, 1e-4);
    }
}

/// Methods that need their own passes; the control leaves the passes out.
#[test]
fn passes_before_and_after_the_columns_run() {
    needs_adapter!();
    check(&BOUNDED, "lookup=blend", 1e-4 + 0.37 / 510.0);
    check(&MIPPED, "storage=f32 lookup=nearest", 1e-4);
    check(&MIPPED, "storage=f16 lookup=hardware", 8e-4);
}

fn memory(payload_bytes: u64, map_bytes: u64, temporary_bytes: u64) -> Memory {
    Memory {
        payload_bytes,
        map_bytes,
        allocator_bytes: None,
        temporary_bytes,
    }
}

/// Memory on every device; a single f16 value takes 2 or 8 bytes, a single fraction 1 or 4.
#[test]
fn bytes_are_those_of_every_texture_and_buffer() {
    needs_adapter!();
    on_gpu(|renderer| {
        let view = renderer.view(&layer(), size(4, 4)).unwrap();
        let bytes = |method, params: &str| {
            let memory = made(renderer, &view, &setup(method, params)).memory;
            Memory {
                allocator_bytes: None,
                ..memory
            }
        };
        let is_one_of = |found: Memory, expected: [Memory; 2]| {
            assert!(expected.contains(&found), "{found:?}");
        };
        let texels = EDGE * EDGE;
        let voxels = texels * u64::from(SLICES);
        is_one_of(
            bytes(&VOLUME, "storage=f16"),
            [2, 8].map(|b| memory(2 * voxels, b * voxels, 0)),
        );
        assert_eq!(bytes(&FRACTION, ""), memory(3 * texels, 4 * texels, 0));
        assert_eq!(bytes(&WORD, ""), memory(4 * texels, 4 * texels, 0));
        let words = 4 * voxels;
        assert_eq!(bytes(&BUFFER, ""), memory(words, words, 0));
        let bounds = 4 * texels / 64;
        is_one_of(
            bytes(&BOUNDED, ""),
            [1, 4].map(|b| memory(texels + bounds, b * texels + bounds, 0)),
        );
        let rows = 4 * texels;
        let blurred = bytes(&BLURRED, "storage=f32");
        assert_eq!(blurred, memory(4 * texels, 4 * texels + rows, rows));
        let levels = 4 * (texels + texels / 4);
        assert_eq!(bytes(&MIPPED, "storage=f32"), memory(levels, levels, 0));
        let plain = common::setup("esm", "resolution=64 storage=f32");
        let esm = made(renderer, &view, &plain).memory;
        assert_eq!((esm.map_bytes, esm.temporary_bytes), (4 * texels, 0));
    });
}

fn lumps(folder: &std::path::Path) -> Scene {
    let value = |x: usize, y: usize, z: usize| {
        let lump = hashed(x / 4, y / 4, z / 4) < 0.4;
        if lump { hashed(x, y, z) } else { 0.0 }
    };
    let mut scene = box_scene([0.0; 3], [900.0, 700.0, 800.0], 0.006);
    scene.density = cube_density(write_cube(folder, 16, value));
    (scene.sun.elevation_deg, scene.sun.azimuth_deg) = (41.0, 67.0);
    scene
}

/// The texels after two passes are the means of 3 × 3 of those without.
#[test]
fn a_blur_after_the_columns_is_the_mean_of_neighbours() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let scene = lumps(folder.path());
    on_gpu(move |renderer| {
        let view = renderer.view(&scene, size(8, 8)).unwrap();
        let [blurred, sharp] = ["off", "on"].map(|control| {
            let params = format!("storage=f32 control={control}");
            texels(renderer, &made(renderer, &view, &setup(&BLURRED, &params)))
        });
        let edge = EDGE as i32;
        let at = |texels: &MapTexels, u: i32, v: i32| {
            let inside = [u, v].map(|i| i.clamp(0, edge - 1) as u32);
            f64::from(texels.texel(inside)[0])
        };
        let (mut worst, mut changed) = (0.0_f64, 0);
        for (u, v) in (0..edge).flat_map(|v| (0..edge).map(move |u| (u, v))) {
            let near = (-1..=1).flat_map(|j| (-1..=1).map(move |i| (u + i, v + j)));
            let mean = near.map(|(u, v)| at(&sharp, u, v)).sum::<f64>() / 9.0;
            worst = worst.max((at(&blurred, u, v) - mean).abs());
            changed += usize::from((at(&blurred, u, v) - at(&sharp, u, v)).abs() > 1e-2);
        }
        assert!(worst < 1e-5, "{worst:.1e}");
        assert!(changed > 500, "{changed} texels changed");
    });
}

/// Twins of other layouts: slices between which a fetch interpolates, and values that a word packs.
#[test]
fn twins_agree_with_the_device_in_an_uneven_medium() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let scene = lumps(folder.path());
    on_gpu(move |renderer| {
        let view = renderer.view(&scene, IMAGE).unwrap();
        let oracle = Oracle::new(&scene, IMAGE).unwrap();
        let difference = |device: &MethodSetup, twin: &MethodSetup| {
            made(renderer, &view, device);
            let picture = view.read(&renderer.gpu).unwrap();
            let expected = oracle.render(twin, Options::stored(twin)).unwrap();
            let v = |frame: &Frame| {
                frame
                    .sun
                    .iter()
                    .map(|p| f64::from(p[3]))
                    .collect::<Vec<_>>()
            };
            relative_rmse(v(&picture).into_iter().zip(v(&expected)))
        };
        for (method, params, wrong, tolerance) in [
            (&VOLUME, "storage=f16", "resolution=24", 5e-4),
            (&WORD, "lookup=blend", "resolution=24 lookup=blend", 1e-4),
            (&WORD, "lookup=nearest", "lookup=blend", 1e-4),
        ] {
            let device = setup(method, params);
            let [error, control] =
                [params, wrong].map(|twin| difference(&device, &setup(method, twin)));
            println!(
                "{} {params}: {error:.1e}, control {control:.1e}",
                method.info.id
            );
            assert!(error <= tolerance, "{error:.1e}");
            assert!(control > 2.0 * tolerance, "{control:.1e}");
        }
    });
}

#[test]
fn samples_of_a_pass_before_the_columns_are_counted_with_theirs() {
    needs_adapter!();
    on_gpu(|renderer| {
        let view = renderer.view(&layer(), size(4, 4)).unwrap();
        let [both, columns] = ["off", "on"].map(|control| {
            let setup = setup(&BOUNDED, &format!("control={control}"));
            count_view(renderer, &view, &setup).samples.map
        });
        assert_eq!(columns, EDGE * EDGE * STEPS_A_COLUMN);
        assert_eq!(both, 2 * columns);
    });
}

/// Errors name what a plan, its shader or a device lacks, with the place.
#[test]
fn what_is_missing_is_named() {
    needs_adapter!();
    on_gpu(|renderer| {
        let view = renderer.view(&layer(), size(4, 4)).unwrap();
        let refused = |setup: &MethodSetup, counting: bool| {
            let prepared = match counting {
                true => renderer.prepare(&view, setup, &Frames::full(), Counting::On),
                false => renderer.prepare_full(&view, setup),
            };
            prepared.err().expect("an error").to_string()
        };
        let mut plain = BOUNDED.info.source.to_owned();
        plain = plain.replace("count_samples(texel, map.resolution);", "");
        let silent = renamed(&BOUNDED, "test/silent.wgsl", plain.clone());
        let error = refused(&setup(silent, ""), true);
        assert!(
            error.contains("`bound_tile` takes density samples and counts none"),
            "{error}"
        );
        let nameless = renamed(
            &BOUNDED,
            "test/nameless.wgsl",
            plain.replace("bound_tile", "other"),
        );
        let error = refused(&setup(nameless, ""), false);
        assert!(error.contains("has no entry point `bound_tile`"), "{error}");
        let error = refused(&setup(&LEVELLESS, ""), false);
        assert!(
            error.contains("no level 1 of a texture `map_store`"),
            "{error}"
        );
        let error = refused(&setup(&VOLUME, "resolution=65536"), false);
        assert!(error.contains("the map needs an edge of 65536"), "{error}");
    });
}
