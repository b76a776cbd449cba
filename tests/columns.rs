//! Thousands of single light columns: every texel of a map as the device stored it against the oracle's.

#[macro_use]
mod common;

use common::{box_scene, cube_density, hashed, on_gpu, setup, write_cube};
use occlab::occlusion::MethodSetup;
use occlab::occlusion::rounding::Rounding;
use occlab::oracle::{Options, Oracle};
use occlab::raymarch::unwatched;
use occlab::scene::{ImageSize, Scene};

const IMAGE: ImageSize = ImageSize {
    width: 8,
    height: 8,
};
const EDGE: u32 = 64;

/// A method's variant, and a slightly wrong one.
const CASES: [(&str, &str, &str); 10] = [
    ("esm", "", "front=first"),
    ("esm", "form=published c=8", "form=published c=8.1"),
    ("bsm", "", "mean=all"),
    ("bsm", "mean=all front=first", "mean=all"),
    ("bsm", "mean=fitted", "mean=occupied"),
    ("bsm", "form=published", "form=published mean=all"),
    ("fom", "", "sampling=end"),
    (
        "fom",
        "bounds=texel order=5",
        "bounds=texel order=5 sampling=end",
    ),
    ("fom", "form=published", "form=published sampling=end"),
    ("floor", "", "sampling=end"),
];

fn lumps(folder: &std::path::Path) -> Scene {
    let value = |x: usize, y: usize, z: usize| {
        let lump = hashed(x / 4, y / 4, z / 4) < 0.4;
        if lump { hashed(x, y, z) } else { 0.0 }
    };
    let mut scene = box_scene([0.0; 3], [900.0, 700.0, 800.0], 0.02);
    scene.density = cube_density(write_cube(folder, 16, value));
    (scene.sun.elevation_deg, scene.sun.azimuth_deg) = (41.0, 67.0);
    scene
}

fn map(id: &str, params: &str) -> MethodSetup {
    setup(
        id,
        &format!("resolution={EDGE} steps=48 storage=f32 {params}"),
    )
}

/// The oracle's texels, in the device's order.
fn expected(oracle: &Oracle, setup: &MethodSetup) -> Vec<f64> {
    let options = Options {
        rounding: Rounding::device("f32", false),
        ..Options::default()
    };
    let method = oracle.prepare(setup, options).unwrap();
    let texels = (0..EDGE * EDGE).map(|i| [i % EDGE, i / EDGE]);
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
        for (id, params, wrong) in CASES {
            let setup = map(id, params);
            let prepared = renderer.prepare(&view, &setup).unwrap();
            prepared.run(&renderer.gpu, &mut unwatched).unwrap();
            let texels = prepared.map_texels(&renderer.gpu).unwrap().unwrap();
            assert_eq!(texels.resolution, EDGE);
            let kinds = texels.values_a_texel as usize;
            let apart = |setup: &MethodSetup| {
                share_apart(&texels.values, &expected(&oracle, setup), kinds, 2e-5)
            };
            let (right, control) = (apart(&setup), apart(&map(id, wrong)));
            println!("{id} {params}: {right:.4} of 4096 columns apart, control {control:.3}");
            assert!(right <= 0.005, "{id} {params}: {right}");
            assert!(control > 0.2, "{id} {wrong}: passed for {params}");
        }
    });
}
