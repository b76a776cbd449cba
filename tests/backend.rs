//! The oracle as a backend, and the program where there is no adapter.

#[macro_use]
mod common;
#[path = "common/program.rs"]
mod program;

use occlab::backend::{Backend, Choice};
use occlab::config::load_scene;
use occlab::cost::Counting;
use occlab::frame::read_frame;
use occlab::gpu::Sources;
use occlab::occlusion::MethodSetup;
use occlab::oracle::{Options, Oracle};
use occlab::progress::unwatched;
use occlab::truth::TruthCache;
use program::{cells, modified, occlab, refused, report, stderr, without_adapter, workplace};
use serde_json::{Value, json};
use std::path::Path;
use std::process::Output;

fn batch(folder: &Path, backend: &str) -> Output {
    without_adapter(&mut occlab(folder))
        .args(["batch", "small.json", "--out", "out", "--quiet"])
        .args(["--backend", backend])
        .output()
        .unwrap()
}

fn cell<'a>(report: &'a Value, method: &str) -> &'a Value {
    let all = report["cells"].as_array().unwrap();
    all.iter().find(|c| c["method"] == method).unwrap()
}

#[test]
fn without_an_adapter_the_whole_matrix_runs_on_the_oracle_and_says_so() {
    let folder = workplace(|_, e| {
        e["sun_elevation_deg"] = json!([60, 20]);
        e["flicker"] = json!("sun");
        e["decompose"] = json!(true);
    });
    let output = batch(folder.path(), "auto");
    let text = stderr(&output);
    assert!(output.status.success(), "{text}");
    assert_eq!(text.lines().count(), 1, "{text}");
    assert!(text.starts_with("no adapter: the oracle"), "{text}");

    let report = report(folder.path());
    let environment = &report["environment"];
    assert_eq!(environment["adapter"], "oracle (f64, CPU)");
    assert!(environment["host"].as_str().unwrap().contains("cores"));
    let all = report["cells"].as_array().unwrap();
    assert_eq!(all.len(), 6);
    for cell in all {
        let result = &cell["result"];
        let times = &result["time_ms"];
        assert_eq!(cell["failed"], Value::Null);
        for pass in ["generate", "march", "total"] {
            assert_eq!(times[pass], Value::Null, "{pass} is not known");
        }
        assert_eq!(times["wall"]["n"], 1, "each cell is rendered once");
        assert!(times["wall"]["median"].as_f64().unwrap() > 0.0);
        assert!(result["samples"]["view"].as_u64().unwrap() > 0);
        assert!(result["error"]["flicker_sun"].is_number());
        assert!(result["decomposition"]["model_rel_rmse"].is_number());
        assert_eq!(result["decomposition"]["truth_rel_rmse"], 0.0);
    }
    // 16² texels of 3 values: 4 channels are allocated.
    let memory = &cell(&report, "bsm")["result"]["memory"];
    assert_eq!(memory["payload_bytes"], 2 * 3 * 256);
    assert_eq!(memory["map_bytes"], 2 * 4 * 256);
    assert!(report["references"][0]["wall_ms"].as_f64().unwrap() > 0.0);
    assert_eq!(report["references"][0]["march_ms"], Value::Null);

    let page = std::fs::read_to_string(folder.path().join("out/index.html")).unwrap();
    assert!(page.contains("No adapter was used") && page.contains("wall time of one picture"));
    assert!(!page.contains("total time of one picture"));

    let before = modified(cells(folder.path()));
    assert!(batch(folder.path(), "cpu").status.success());
    assert_eq!(modified(cells(folder.path())), before, "measured again");
}

#[test]
fn its_cells_are_the_pictures_of_the_oracle() {
    let folder = workplace(|_, e| e["sun_elevation_deg"] = json!(40));
    assert!(batch(folder.path(), "cpu").status.success());
    let report = report(folder.path());
    let mut scene = load_scene(&folder.path().join("slab.json")).unwrap();
    scene.sun.elevation_deg = 40.0;
    let oracle = Oracle::new(&scene, common::size(24, 16)).unwrap();
    for (id, params, options) in [
        ("srm", "steps=4", Options::default()),
        (
            "bsm",
            "steps=8 resolution=16",
            Options::stored(&common::setup("bsm", "")),
        ),
    ] {
        let setup = common::setup(id, params);
        let picture = cell(&report, id)["result"]["files"]["exr"]
            .as_str()
            .unwrap();
        let picture = read_frame(&folder.path().join("out").join(picture)).unwrap();
        assert_eq!(picture, oracle.render(&setup, options).unwrap(), "{id}");
    }
}

#[test]
fn a_device_that_was_asked_for_is_never_replaced() {
    let folder = workplace(|_, _| {});
    refused(
        &batch(folder.path(), "gpu"),
        &["no Vulkan", "mesa-vulkan-drivers"],
    );
    let named = without_adapter(&mut occlab(folder.path()))
        .args([
            "batch",
            "small.json",
            "--out",
            "out",
            "--adapter",
            "GeForce",
        ])
        .output()
        .unwrap();
    refused(&named, &["no Vulkan"]);
    assert!(cells(folder.path()).is_empty());
}

#[test]
fn an_adapter_for_the_oracle_is_refused() {
    let folder = workplace(|_, _| {});
    let both = occlab(folder.path())
        .args(["batch", "small.json", "--out", "out"])
        .args(["--backend", "cpu", "--adapter", "llvmpipe"])
        .output()
        .unwrap();
    refused(
        &both,
        &["--backend cpu --adapter llvmpipe", "uses no adapter"],
    );
    assert!(cells(folder.path()).is_empty());
}

#[test]
fn render_works_without_an_adapter() {
    let folder = workplace(|_, _| {});
    let output = without_adapter(&mut occlab(folder.path()))
        .args(["render", "--scene", "slab.json", "-m", "esm", "-o", "a.exr"])
        .args(["--width", "12", "--height", "8", "--set", "resolution=8"])
        .output()
        .unwrap();
    let text = stderr(&output);
    assert!(output.status.success(), "{text}");
    assert!(
        text.contains("no adapter") && text.contains("march n/a, wall"),
        "{text}"
    );
    assert!(read_frame(&folder.path().join("a.exr")).is_ok());
}

#[test]
fn truths_of_a_device_and_of_the_oracle_are_kept_apart() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let scene = common::box_scene([0.0; 3], [1000.0; 3], 0.003);
    let truth = |choice| {
        let backend = Backend::open(choice, None).unwrap();
        let view = backend.view(&scene, common::size(24, 16)).unwrap();
        let cache = TruthCache::new(folder.path(), u64::MAX);
        let cache = Some(&cache);
        let truth = backend.truth(&view, cache, Counting::On, &mut unwatched);
        truth.unwrap()
    };
    let (device, oracle) = (truth(Choice::Gpu), truth(Choice::Cpu));
    assert!(!device.cached && !oracle.cached && device.id != oracle.id);
    assert!(truth(Choice::Cpu).cached && truth(Choice::Gpu).cached);
    let pairs = common::reds(&device.frame, &oracle.frame);
    assert!(common::relative_rmse(pairs) < 1e-5);
}

#[test]
fn a_method_may_be_run_again_and_keeps_its_last_picture() {
    let backend = Backend::open(Choice::Cpu, None).unwrap();
    let scene = common::box_scene([0.0; 3], [1000.0; 3], 0.003);
    let view = backend.view(&scene, common::size(8, 6)).unwrap();
    let setup = MethodSetup::defaults("fom")
        .unwrap()
        .with("resolution", "8");
    let method = backend.prepare_full(&view, &setup.unwrap()).unwrap();
    assert!(method.picture().is_err() && method.counts(&mut unwatched).is_err());
    method.run(&mut unwatched).unwrap();
    let (first, counts) = (
        method.picture().unwrap(),
        method.counts(&mut unwatched).unwrap(),
    );
    method.run(&mut unwatched).unwrap();
    assert_eq!(method.picture().unwrap(), first);
    assert_eq!(
        method.counts(&mut unwatched).unwrap(),
        counts,
        "the map is marched anew"
    );
}

#[test]
fn errors_of_another_thread_on_the_same_device_are_its_own() {
    needs_adapter!();
    let gpu = occlab::gpu::Gpu::new(None).unwrap();
    let device = gpu.device.clone();
    let mistake = move || {
        let both_ways = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::MAP_WRITE;
        drop(device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 16,
            usage: both_ways,
            mapped_at_creation: false,
        }));
    };
    std::thread::spawn(mistake.clone()).join().unwrap();
    gpu.check().unwrap();
    mistake();
    assert!(gpu.check().is_err());
    gpu.check().unwrap();
}

#[test]
fn shaders_read_from_a_folder_are_other_sources_unless_they_are_the_same() {
    needs_adapter!();
    let mut backend = Backend::open(Choice::Gpu, None).unwrap();
    let own = backend.sources();
    assert_eq!(own, occlab::provenance::cell_sources());
    let shaders = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let Backend::Device(renderer) = &mut backend else {
        panic!("not a device");
    };
    renderer.gpu.sources = Sources::read(&shaders).unwrap();
    assert_eq!(backend.sources(), own);
    let folder = tempfile::tempdir().unwrap();
    copy(&shaders, folder.path());
    let esm = folder.path().join("occlusion/esm.wgsl");
    let text = std::fs::read_to_string(&esm).unwrap() + "// another\n";
    std::fs::write(&esm, text).unwrap();
    if let Backend::Device(renderer) = &mut backend {
        renderer.gpu.sources = Sources::read(folder.path()).unwrap();
    }
    assert_ne!(backend.sources(), own);
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        match path.is_dir() {
            true => copy(&path, &target),
            false => drop(std::fs::copy(&path, &target).unwrap()),
        }
    }
}
