//! Synthetic report for the tests: two scenes, two suns, six methods, a failed cell, a cell without times, a missing
//! picture, and names with markup that must be escaped.

use crate::batch::clock::ClockRecord;
use crate::batch::record::{
    Cell, Decomposition, Measured, Reference, Report, SCHEMA, Times, WallClock,
};
use crate::cost::{Memory, Samples};
use crate::environment::Environment;
use crate::gpu::{Clocks, Extent};
use crate::metrics::{ErrorNumbers, Stats};
use crate::scene::ImageSize;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Scene name that injects a script where it is not escaped.
pub const HOSTILE: &str = "cumulus <script>alert(\"1\")</script> & 'quotes'";
/// The adapter of the report.
pub const ADAPTER: &str = "llvmpipe (LLVM 15.0.6, 256 bits)";
const SCENES: [&str; 2] = [HOSTILE, "Stratus deck, 2 km"];
const SUNS: [f64; 2] = [60.0, 12.5];
const IMAGE: ImageSize = ImageSize {
    width: 640,
    height: 360,
};

fn map(value: Value) -> Map<String, Value> {
    value.as_object().cloned().unwrap_or_default()
}

/// Method, parameters, error at 60°, milliseconds of map and march, values a texel (0 = no map).
fn settings() -> Vec<(&'static str, Value, f64, f64, f64, u64)> {
    let mut out = Vec::new();
    for (spacing, worse) in [("quadratic", 1.0), ("uniform", 2.9)] {
        for (steps, error) in [(6, 0.309), (10, 0.153), (20, 0.055)] {
            let time = 110.0 + 21.0 * f64::from(steps);
            out.push((
                "srm",
                json!({"spacing": spacing, "steps": steps}),
                error * worse,
                0.0,
                time,
                0,
            ));
        }
    }
    for resolution in [256, 512, 1024] {
        let finer = 256.0 / f64::from(resolution);
        let pass = 187.0 / finer / finer / 4.0;
        let params = |extra: Value| {
            let mut p = map(json!({"steps": 100, "resolution": resolution, "storage": "f16"}));
            p.extend(map(extra));
            Value::Object(p)
        };
        out.push((
            "esm",
            params(json!({"c": 11.09})),
            0.340 + 0.02 * finer,
            pass,
            141.0,
            1,
        ));
        out.push((
            "bsm",
            params(json!({"mean": "fitted"})),
            0.370 + 0.02 * finer,
            1.1 * pass,
            149.0,
            3,
        ));
        out.push((
            "fom",
            params(json!({"order": 3})),
            0.250 + 0.03 * finer,
            1.5 * pass,
            163.0,
            7,
        ));
        out.push((
            "floor",
            params(json!({})),
            0.069 * (1.0 + finer),
            1.2 * pass,
            158.0,
            100,
        ));
    }
    out.push(("none", json!({}), 2.4, 0.0, 108.0, 0));
    out
}

/// The report.
pub fn report() -> Report {
    let mut cells = Vec::new();
    for (s, scene) in SCENES.iter().enumerate() {
        for (l, sun) in SUNS.iter().enumerate() {
            for setting in settings() {
                let harder = 1.0 + 0.35 * s as f64 + 0.6 * l as f64;
                cells.push(cell(cells.len(), scene, *sun, harder, &setting));
            }
        }
    }
    cells[13].result = None;
    cells[13].failed = Some(
        "adapter: texture of 2.1 GiB exceeds the limit of 1 GiB; lower `resolution` <b>now</b>"
            .into(),
    );
    if let Some(result) = &mut cells[7].result {
        result.time_ms = Times::default();
    }
    Report {
        schema: SCHEMA.into(),
        environment: Environment {
            adapter: ADAPTER.into(),
            driver: "llvmpipe, Mesa 22.3.6".into(),
            backend: "Vulkan".into(),
            device_type: "Cpu".into(),
            commit: "0.1.0".into(),
            host: "linux x86_64, 2 logical cores".into(),
        },
        sources: String::new(),
        scenes: Vec::new(),
        inputs: Vec::new(),
        experiment: json!({"name": "Six ways to shadow a cloud", "repeats": 9}),
        cells,
        references: references(),
        clock: clock(),
        claims: Vec::new(),
        wall: WallClock {
            total_s: 412.7,
            passes_s: 371.2,
            compile_s: 18.4,
        },
    }
}

/// One block for each view; the clock of the last one had not settled.
fn clock() -> Vec<ClockRecord> {
    let views = SCENES.len() * SUNS.len();
    let record = |view: usize| ClockRecord {
        reference: format!("truth-{}-{}", view / SUNS.len(), SUNS[view % SUNS.len()]),
        block: view * settings().len(),
        settled: view + 1 < views,
        warm_up_s: 0.62,
        settled_ms: 4.0,
        probe_rows: 1,
        rounds_ms: vec![4.0, 4.02, 3.99, 4.0 + 0.1 * view as f64],
        clocks: (view == 0).then(|| Clocks {
            readings: 36,
            sm_mhz: Some(Extent {
                min: 1935.0,
                median: 1980.0,
                max: 1980.0,
            }),
            memory_mhz: Some(Extent {
                min: 2619.0,
                median: 2619.0,
                max: 2619.0,
            }),
            power_w: None,
            throttle_reasons: ["sw_power_cap".to_owned()].into(),
        }),
    };
    (0..views).map(record).collect()
}

fn references() -> Vec<Reference> {
    let mut out = Vec::new();
    for (s, scene) in SCENES.iter().enumerate() {
        for (l, sun) in SUNS.iter().enumerate() {
            out.push(Reference {
                id: format!("truth-{s}-{sun}"),
                scene: (*scene).into(),
                sun_elevation_deg: *sun,
                image: IMAGE,
                march_ms: (s == 0 || l == 0).then_some(28_134.5 * (1.0 + 0.2 * s as f64)),
                wall_ms: (s == 0 || l == 0).then_some(28_140.0 * (1.0 + 0.2 * s as f64)),
                light_samples: Some(3_812_345_678),
                view_samples: Some(12_345_678),
                cached: l == 1,
                view_steps: Some(64),
                view_step_rel_rmse: (l == 0).then_some(0.021),
                tracks: Vec::new(),
                files: map(
                    json!({"png": format!("images/truth-{s}-{l}.png"), "exr": format!("images/truth-{s}-{l}.exr")}),
                ),
            });
        }
    }
    out
}

type Setting = (&'static str, Value, f64, f64, f64, u64);

fn cell(index: usize, scene: &str, sun: f64, harder: f64, setting: &Setting) -> Cell {
    let (method, params, error, generate, march, values) = setting;
    let s = SCENES.iter().position(|n| *n == scene).unwrap_or(0);
    let texels = params["resolution"].as_u64().map_or(0, |r| r * r);
    let payload = 2 * values * texels;
    let rel_rmse = error * harder;
    let time = |median: f64| Stats {
        median,
        min: 0.97 * median,
        p95: 1.06 * median,
        cv: 0.018,
        n: 9,
    };
    Cell {
        id: format!("{index:016x}"),
        index,
        scene: scene.into(),
        scene_id: String::new(),
        scene_set: Map::new(),
        sun_elevation_deg: sun,
        method: (*method).into(),
        params: map(params.clone()),
        reconstruct: crate::reconstruct::full(),
        backend: "Vulkan (Cpu)".into(),
        image: IMAGE,
        failed: None,
        result: Some(Measured {
            reference: format!("truth-{s}-{sun}"),
            cloud_pixel_fraction: 0.413,
            fallback_fraction: if *values > 0 { 0.0123 } else { 0.0 },
            memory: Memory {
                payload_bytes: payload,
                map_bytes: if *values == 3 || *values == 7 {
                    payload.next_power_of_two()
                } else {
                    payload
                },
                allocator_bytes: None,
                temporary_bytes: 0,
            },
            time_ms: Times {
                generate: (*values > 0).then(|| time(*generate)),
                march: Some(time(*march)),
                reconstruct: None,
                total: Some(time(generate + march)),
                wall: Some(time(generate + march + 1.7)),
            },
            frames_in_flight: 1,
            rounds_total_ms: vec![Some(generate + march); 3],
            rounds_generate_ms: Vec::new(),
            block: 0,
            samples: Samples {
                view: 9_123_456,
                light: if *method == "srm" { 88_123_456 } else { 0 },
                map: values * 1000,
            },
            look_ups: if *values > 0 { 9_000_000 } else { 0 },
            error: errors(rel_rmse, *values > 0),
            decomposition: (scene == HOSTILE).then(|| Decomposition {
                model_rel_rmse: 0.8 * rel_rmse,
                sampling_rel_rmse: 0.3 * rel_rmse,
                precision_rel_rmse: 3e-4 * rel_rmse,
                storage_rel_rmse: 2e-4 * rel_rmse,
                truth_rel_rmse: 2e-5,
                ample_steps: Some(400),
                ample_resolution: (*values > 0).then_some(2 * texels.isqrt() as u32),
                noise_filter: Some("8 bit".into()),
            }),
            reconstruction: None,
            notes: Vec::new(),
            files: map(json!({
                "png": format!("images/cell-{index}.png"), "diff_png": format!("images/cell-{index}-diff.png"),
                "exr": format!("images/cell-{index}.exr"), "diff_scale": 0.5,
            })),
        }),
    }
}

fn errors(rel_rmse: f64, has_map: bool) -> ErrorNumbers {
    ErrorNumbers {
        rel_rmse,
        bias: 0.21 * rel_rmse,
        leak: 0.43 * rel_rmse,
        darken: -0.22 * rel_rmse,
        p99_abs: 3.3 * rel_rmse,
        max_abs: 9.1 * rel_rmse,
        transmittance_rmse: 0.5 * rel_rmse,
        edge_bias: Some(0.3 * rel_rmse),
        floor_rel_rmse: has_map.then_some(0.07),
        flip_mean: (0.2 * rel_rmse).min(1.0),
        flip_p99: (0.5 * rel_rmse).min(1.0),
        psnr_db: Some(20.0 - 8.7 * rel_rmse.ln()),
        ssim: 1.0 - (0.2 * rel_rmse).min(0.9),
        ..ErrorNumbers::default()
    }
}

/// Paints the pictures that the report names, all but those of the cell `without`.
pub fn paint(folder: &Path, report: &Report, without: usize) {
    std::fs::create_dir_all(folder.join("images")).expect("folder");
    for (i, reference) in report.references.iter().enumerate() {
        picture(
            folder,
            reference.files["png"].as_str().expect("name"),
            0.0,
            i as f32,
        );
    }
    for cell in report.cells.iter().filter(|c| c.index != without) {
        if let Some(result) = &cell.result {
            let scene = if cell.scene == HOSTILE { 0.0 } else { 2.0 };
            picture(
                folder,
                result.files["png"].as_str().expect("name"),
                result.error.rel_rmse as f32,
                scene,
            );
            difference(
                folder,
                result.files["diff_png"].as_str().expect("name"),
                result.error.rel_rmse as f32,
                scene,
            );
        }
    }
}

/// Smooth test pattern with the look of a cloud; not a physical model.
fn cloud(x: u32, y: u32, scene: f32) -> f32 {
    let (u, v) = (x as f32 / 320.0, y as f32 / 180.0);
    let blob = |cx: f32, cy: f32, r: f32| {
        (1.0 - ((u - cx).powi(2) * 3.0 + (v - cy).powi(2)) / (r * r)).max(0.0)
    };
    blob(0.3 + 0.1 * scene, 0.55, 0.4) + blob(0.55, 0.5, 0.55) * 0.8 + blob(0.8, 0.62, 0.3)
}

fn picture(folder: &Path, name: &str, error: f32, scene: f32) {
    let paint = |x: u32, y: u32| {
        let c = cloud(x, y, scene).min(1.0);
        let light = 1.0 - (0.6 - 0.3 * error.min(2.0)) * (y as f32 / 180.0);
        let mix = |sky: f32| ((sky * (1.0 - c) + 240.0 * light * c) as i32).clamp(0, 255) as u8;
        image::Rgb([mix(90.0), mix(130.0), mix(190.0)])
    };
    image::RgbImage::from_fn(496, 279, |x, y| paint(x * 2 / 3, y * 2 / 3))
        .save(folder.join(name))
        .expect("picture");
}

fn difference(folder: &Path, name: &str, error: f32, scene: f32) {
    let paint = |x: u32, y: u32| {
        let c = cloud(x, y, scene).min(1.0);
        let d = (c * error * 2.0 * (y as f32 / 180.0 - 0.45)).clamp(-1.0, 1.0);
        let fade = |to: f32| (255.0 + (to - 255.0) * d.abs()) as u8;
        if d > 0.0 {
            image::Rgb([fade(200.0), fade(70.0), fade(10.0)])
        } else {
            image::Rgb([fade(20.0), fade(80.0), fade(170.0)])
        }
    };
    image::RgbImage::from_fn(496, 279, |x, y| paint(x * 2 / 3, y * 2 / 3))
        .save(folder.join(name))
        .expect("picture");
}
