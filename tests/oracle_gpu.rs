//! Device against oracle: every method of the registry, its variants, three kinds of density.

mod common;

use common::{
    box_scene, cube_density, cumulus, hashed, on_gpu, relative_rmse, render_view, setup, size,
    write_cube,
};
use occlab::frame::Frame;
use occlab::occlusion::MethodSetup;
use occlab::occlusion::rounding::Rounding;
use occlab::oracle::{Options, Oracle};
use occlab::scene::{ImageSize, Scene};

const IMAGE: ImageSize = ImageSize { width: 48, height: 27 };

fn device_options(setup: &MethodSetup) -> Options {
    let storage = setup.params.choice("storage").unwrap_or("f32");
    Options {
        rounding: Rounding {
            truncate_f16: std::env::var("TRUNC").is_ok(),
            ..Rounding::device(storage, false)
        },
        ..Options::default()
    }
}

fn sun_error(device: &Frame, oracle: &Frame) -> f64 {
    let pairs = device.sun.iter().zip(&oracle.sun);
    relative_rmse(pairs.map(|(a, b)| (f64::from(a[0]), f64::from(b[0]))))
}

fn survey(scene: Scene) {
    scene.validate().unwrap();
    on_gpu(move |renderer| {
        let view = renderer.view(&scene, IMAGE).unwrap();
        let start = std::time::Instant::now();
        let oracle = Oracle::new(&scene, IMAGE).unwrap();
        println!("{}: thresholds {:?} {:?} measured {:?}", scene.name, oracle.thresholds(), start.elapsed(), view.density.built);
        let map = "resolution=128 steps=64";
        let list: Vec<(&str, String)> = vec![
            ("none", String::new()),
            ("srm", String::new()),
            ("srm", "spacing=uniform steps=20".into()),
            ("srm", "spacing=uniform_reach reach_m=300".into()),
            ("srm", "spacing=exponential steps=6".into()),
            ("srm", "sampling=end".into()),
            ("srm", "sampling=jittered".into()),
            ("truth", format!("step_m={}", scene.truth_step_m())),
            ("esm", map.into()),
            ("esm", format!("{map} storage=f32")),
            ("esm", format!("{map} lookup=nearest")),
            ("esm", format!("{map} lookup=hardware")),
            ("esm", format!("{map} front=first")),
            ("esm", format!("{map} form=published c=8")),
            ("esm", format!("{map} form=published c=80 storage=f32")),
            ("bsm", map.into()),
            ("bsm", format!("{map} storage=f32")),
            ("bsm", format!("{map} mean=all")),
            ("bsm", format!("{map} mean=fitted")),
            ("bsm", format!("{map} mean=fitted storage=f32")),
            ("bsm", format!("{map} form=published")),
            ("fom", map.into()),
            ("fom", format!("{map} storage=f32")),
            ("fom", format!("{map} bounds=texel")),
            ("fom", format!("{map} order=7 window=lanczos")),
            ("fom", format!("{map} order=5 window=fejer lookup=hardware")),
            ("fom", format!("{map} form=published")),
            ("floor", map.into()),
            ("floor", format!("{map} storage=f32")),
            ("floor", format!("{map} lookup=hardware")),
            ("floor", format!("{map} sampling=end")),
        ];
        for (id, params) in list {
            let setup = setup(id, &params);
            let start = std::time::Instant::now();
            let device = render_view(renderer, &view, &setup);
            let gpu = start.elapsed();
            let start = std::time::Instant::now();
            let cpu = oracle.render(&setup, device_options(&setup)).unwrap();
            println!("{:8} {id:6} {params:60} {:.2e}   gpu {gpu:.1?} cpu {:.1?}", scene.name, sun_error(&device, &cpu), start.elapsed());
        }
    });
}

#[test]
fn uniform_box() {
    let mut scene = box_scene([-300.0, 100.0, -200.0], [400.0, 600.0, 500.0], 0.006);
    (scene.sun.elevation_deg, scene.sun.azimuth_deg) = (35.0, 130.0);
    scene.camera.position_m = [-500.0, 900.0, -1400.0];
    survey(scene);
}

#[test]
fn volume() {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = box_scene([-300.0, 100.0, -200.0], [400.0, 600.0, 500.0], 0.03);
    scene.name = "volume".into();
    scene.density = cube_density(write_cube(folder.path(), 16, |x, y, z| (hashed(x, y, z) - 0.6).max(0.0) * 2.5));
    (scene.sun.elevation_deg, scene.sun.azimuth_deg) = (35.0, 130.0);
    scene.camera.position_m = [-500.0, 900.0, -1400.0];
    survey(scene);
}

#[test]
fn clouds() {
    survey(cumulus());
}
