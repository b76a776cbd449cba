//! Light maps: texels of thousands of single columns against the oracle's, memory, and look-ups outside of the map.

extern crate occlab_render as occlab;

#[macro_use]
#[path = "../../../tests/common/mod.rs"]
mod common;

use common::{
    box_scene, count_view, cube_density, has_map, hashed, lumps, on_gpu, reds, relative_rmse,
    render_view, setup, size, write_cube,
};
use occlab::occlusion::rounding::Rounding;
use occlab::occlusion::{MethodSetup, REGISTRY, Trial};
use occlab::oracle::{Options, Oracle};
use occlab::progress::unwatched;
use occlab::scene::ImageSize;

const IMAGE: ImageSize = ImageSize {
    width: 8,
    height: 8,
};
const EDGE: u32 = 64;

/// A variant of every method with a map, and a slightly wrong one.
fn texel_trials() -> impl Iterator<Item = (&'static str, Trial)> {
    REGISTRY.iter().flat_map(|method| {
        let info = method.info();
        let trials = info.trials.texels.iter();
        trials.map(move |trial| (info.id, *trial))
    })
}

fn map(id: &str, params: &str) -> MethodSetup {
    setup(
        id,
        &format!("resolution={EDGE} steps=48 storage=f32 {params}"),
    )
}

/// The oracle's texels, in the device's order of values.
fn expected(oracle: &Oracle, setup: &MethodSetup) -> Vec<f64> {
    let options = Options {
        rounding: Rounding::device("f32", false),
        ..Options::default()
    };
    let method = oracle.prepare(setup, options).unwrap();
    let texels = (0..EDGE * setup.map_rows().unwrap()).map(|i| [i % EDGE, i / EDGE]);
    texels
        .flat_map(|at| method.texel(at).expect("a map"))
        .collect()
}

/// Share of texels with a value farther than `tolerance` of the largest of its kind (f32, √steps·2⁻²⁴ and `exp`: 1e-5).
fn share_apart(measured: &[f32], expected: &[f64], kinds: usize, tolerance: f64) -> f64 {
    assert_eq!(measured.len(), expected.len());
    let largest: Vec<f64> = (0..kinds)
        .map(|kind| {
            let values = expected.iter().skip(kind).step_by(kinds);
            values.fold(1e-30, |most: f64, v| most.max(v.abs()))
        })
        .collect();
    let texels = measured.chunks(kinds).zip(expected.chunks(kinds));
    let apart = texels.filter(|(m, e)| {
        let pairs = m.iter().zip(e.iter()).zip(&largest);
        pairs.into_iter().any(|((m, e), scale)| {
            let error = (f64::from(*m) - e).abs() / scale;
            error.is_nan() || error > tolerance
        })
    });
    apart.count() as f64 / (measured.len() / kinds) as f64
}

/// `first`, `occupied` and texel bounds jump where a sample lies on the surface of the medium, on either side of which a
/// rounded position may fall: at most 1 column in 200.
#[test]
fn columns_hold_what_the_equations_say() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let scene = lumps(folder.path());
    on_gpu(move |renderer| {
        let view = renderer.view(&scene, IMAGE).unwrap();
        let oracle = Oracle::new(&scene, IMAGE).unwrap();
        for (
            id,
            Trial {
                params,
                control: wrong,
            },
        ) in texel_trials()
        {
            let setup = map(id, params);
            let prepared = renderer.prepare_full(&view, &setup).unwrap();
            prepared.run(&renderer.gpu, &mut unwatched).unwrap();
            let texels = prepared.map_texels(&renderer.gpu).unwrap().unwrap();
            assert_eq!(texels.resolution, EDGE);
            let kinds = texels.values_a_texel as usize;
            let apart = |setup: &MethodSetup| {
                share_apart(&texels.values, &expected(&oracle, setup), kinds, 2e-5)
            };
            let (right, control) = (apart(&setup), apart(&map(id, wrong)));
            println!("{id} {params}: {right:.4} of the columns apart, control {control:.3}");
            assert!(right <= 0.005, "{id} {params}: {right}");
            assert!(control > 0.2, "{id} {wrong}: passed for {params}");
        }
    });
}

/// Payload: values × bytes × texels, 1 : 3 : 7 (thesis M). Allocation: no texel has three channels.
#[test]
fn memory_follows_from_values_and_format() {
    needs_adapter!();
    let scene = box_scene([0.0; 3], [1.0; 3], 1.0);
    on_gpu(move |renderer| {
        let single = renderer
            .gpu
            .device
            .features()
            .contains(wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES);
        let view = renderer.view(&scene, size(4, 4)).unwrap();
        let methods = [
            ("esm", "", 1),
            ("bsm", "", 3),
            ("bsm", "tail=dark", 4),
            ("msm", "moments=six", 9),
            ("fom", "", 7),
            ("fom", "bounds=texel", 9),
            ("fom", "order=7", 15),
        ];
        for (id, extra, values) in methods {
            for (storage, bytes) in [("f16", 2), ("f32", 4)] {
                for resolution in [1, 64, 100] {
                    let text = format!("{extra} storage={storage} resolution={resolution}");
                    let memory = renderer
                        .prepare_full(&view, &setup(id, &text))
                        .unwrap()
                        .memory;
                    let texels = resolution * resolution;
                    assert_eq!(memory.payload_bytes, values * bytes * texels, "{id} {text}");
                    let channels = if values == 1 && (single || bytes == 4) {
                        1
                    } else {
                        4 * values.div_ceil(4)
                    };
                    assert_eq!(memory.map_bytes, channels * bytes * texels, "{id} {text}");
                }
            }
        }
        for id in REGISTRY
            .iter()
            .map(|m| m.info().id)
            .filter(|id| !has_map(id))
        {
            let memory = renderer.prepare_full(&view, &setup(id, "")).unwrap().memory;
            assert_eq!((memory.payload_bytes, memory.map_bytes), (0, 0), "{id}");
        }
    });
}

/// A cloud of three pixels, missed by the rays that find the visible part of the layer: every look-up falls outside the
/// map, falls back to a march of six quadratic steps, and is counted.
#[test]
fn what_no_map_covers_is_marched_and_counted() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let mut scene = box_scene([1.0, 0.8, 100.0], [2.0, 1.8, 101.0], 2.0);
    scene.density = cube_density(write_cube(folder.path(), 12, |x, y, z| {
        hashed(x / 3, y / 3, z / 3)
    }));
    (scene.sun.elevation_deg, scene.sun.azimuth_deg) = (50.0, 30.0);
    scene.camera.position_m = [0.0; 3];
    scene.camera.target_m = [0.0, 0.0, 1.0];
    scene.camera.fov_y_deg = 45.0;
    scene.validate().unwrap();
    on_gpu(move |renderer| {
        let view = renderer.view(&scene, size(400, 225)).unwrap();
        let marched = |steps| render_view(renderer, &view, &setup("srm", steps));
        let (six, five) = (marched("steps=6"), marched("steps=5"));
        let bsm = setup("bsm", "resolution=128 steps=64");
        let mapped = render_view(renderer, &view, &bsm);
        let counts = count_view(renderer, &view, &bsm);
        assert!(counts.look_ups > 100 && counts.fallbacks == counts.look_ups);
        let error = relative_rmse(reds(&mapped, &six));
        let control = relative_rmse(reds(&mapped, &five));
        assert!(error <= 1e-6, "{error:.1e}");
        assert!(control > 1e-3, "five steps passed for six: {control:.1e}");
    });
}
