//! Two small linear pictures against stored ones. `OCCLAB_BLESS=1 cargo test --test snapshots` stores new ones and
//! fails, so that a storing run never passes; inspect the difference before committing them.

extern crate occlab_render as occlab;

#[macro_use]
#[path = "../../../tests/common/mod.rs"]
mod common;

use common::{box_scene, cube_density, cumulus, hashed, render, setup, size, write_cube};
use occlab::frame::{Frame, read_frame, write_frame};
use occlab::scene::{Ambient, Sky};
use std::path::{Path, PathBuf};

/// Largest relative RMSE over all values of a picture. Other adapters interpolate textures with 8-bit weights and round
/// exp differently: 1e-3. A changed method, medium or camera moves pictures by percents.
const TOLERANCE: f64 = 2e-3;
const HOW_TO_BLESS: &str =
    "run `OCCLAB_BLESS=1 cargo test --release --test snapshots` and review the new file";

fn stored(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/snapshots")
        .join(format!("{name}.exr"))
}

/// All values of radiance, opacity, sunlight and V.
fn values(frame: &Frame) -> impl Iterator<Item = f64> + '_ {
    frame
        .radiance
        .iter()
        .chain(&frame.sun)
        .flatten()
        .map(|v| f64::from(*v))
}

/// What is wrong with `picture`, if anything.
fn compare(picture: &Frame, reference: &Path) -> Result<f64, String> {
    if !reference.exists() {
        return Err(format!(
            "{} is missing: {HOW_TO_BLESS}",
            reference.display()
        ));
    }
    let expected = read_frame(reference).map_err(|e| format!("{e}\n{HOW_TO_BLESS}"))?;
    if (expected.width, expected.height) != (picture.width, picture.height) {
        let sizes = [
            expected.width,
            expected.height,
            picture.width,
            picture.height,
        ];
        return Err(format!(
            "{} is {}×{}, the picture {}×{}: {HOW_TO_BLESS}",
            reference.display(),
            sizes[0],
            sizes[1],
            sizes[2],
            sizes[3]
        ));
    }
    let error = common::relative_rmse(values(picture).zip(values(&expected)));
    // Not `error > TOLERANCE`: a NaN must fail.
    if error <= TOLERANCE {
        Ok(error)
    } else {
        Err(format!(
            "relative RMSE {error:.1e} against {}: if this is wanted, {HOW_TO_BLESS}",
            reference.display()
        ))
    }
}

fn check(name: &str, picture: &Frame) {
    assert!(
        picture.radiance.iter().any(|p| p[3] > 0.3) && picture.sun.iter().any(|p| p[0] > 0.0),
        "{name}: nothing to see"
    );
    let reference = stored(name);
    if std::env::var_os("OCCLAB_BLESS").is_some_and(|v| v == "1") {
        write_frame(&reference, picture).unwrap();
        panic!(
            "{} was written; run the tests again without OCCLAB_BLESS",
            reference.display()
        );
    }
    let error = compare(picture, &reference).unwrap_or_else(|problem| panic!("{name}: {problem}"));
    println!("{name}: relative RMSE {error:.1e}");

    // Negative controls: a picture 1 % brighter, one moved by a pixel, one with a NaN, another size, no reference.
    let mut brighter = picture.clone();
    brighter
        .radiance
        .iter_mut()
        .chain(&mut brighter.sun)
        .flatten()
        .for_each(|v| *v *= 1.01);
    let mut moved = picture.clone();
    moved.radiance.rotate_left(1);
    let mut broken = picture.clone();
    broken.sun[3][3] = f32::NAN;
    for (what, changed) in [("brighter", brighter), ("moved", moved), ("broken", broken)] {
        assert!(
            compare(&changed, &reference).is_err(),
            "{name}: a picture that is {what} passed"
        );
    }
    let short = Frame {
        width: 1,
        height: 1,
        radiance: vec![[0.0; 4]],
        sun: vec![[0.0; 4]],
    };
    assert!(
        compare(&short, &reference)
            .unwrap_err()
            .contains("OCCLAB_BLESS")
    );
    assert!(
        compare(picture, &stored("no such picture"))
            .unwrap_err()
            .contains("OCCLAB_BLESS")
    );
}

#[test]
fn cumulus_with_a_secondary_march() {
    needs_adapter!();
    let mut scene = cumulus();
    scene.sun.irradiance = None;
    scene.sky = Some(Sky::Preetham {
        turbidity: 2.5,
        ground_albedo: 0.15,
    });
    scene.ambient = Some(Ambient::Sky {
        base: 0.5,
        top: 1.0,
    });
    scene.march.jitter = true;
    check(
        "cumulus-srm",
        &render(&scene, size(24, 14), &setup("srm", "")),
    );
}

#[test]
fn volume_with_a_beer_shadow_map() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    // Three balls that fade out toward their surface, so that the rounding of a cell matters little.
    let balls = [
        ([7.0, 6.0, 8.0], 5.0),
        ([12.0, 10.0, 6.0], 4.0),
        ([9.0, 13.0, 11.0], 3.0),
    ];
    let value = |x: usize, y: usize, z: usize| {
        let p = [x as f32, y as f32, z as f32];
        let inside = |(c, r): ([f32; 3], f32)| {
            (1.0 - (0..3).map(|i| (p[i] - c[i]).powi(2)).sum::<f32>() / (r * r)).max(0.0)
        };
        balls.into_iter().map(inside).fold(0.0, f32::max) * (0.5 + hashed(x, y, z))
    };
    let mut scene = box_scene([0.0; 3], [900.0, 800.0, 900.0], 0.02);
    scene.density = cube_density(write_cube(folder.path(), 18, value));
    (scene.sun.elevation_deg, scene.sun.azimuth_deg) = (40.0, 200.0);
    scene.camera.fov_y_deg = 19.0;
    check(
        "volume-bsm",
        &render(
            &scene,
            size(24, 14),
            &setup("bsm", "resolution=64 steps=48"),
        ),
    );
}
