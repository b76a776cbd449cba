//! Pictures at rest and in motion, and the shader that marches them.

use super::common::{self, setup, size};
use super::sequence::{bits, blobs, on_device, on_oracle, temporal};
use occlab::frame::Frame;
use occlab::metrics::ghosting;
use occlab::occlusion::REGISTRY;
use occlab::scene::{CameraTrack, Scene};

/// The same frames without reprojection: history stays at its pixels.
fn without_reprojection(full: &[Frame]) -> Vec<Frame> {
    let pattern = temporal().info().pattern;
    let mut picture = full[0].clone();
    let pictures = full.iter().enumerate().map(|(n, frame)| {
        let (marched, image) = (pattern.subset(n), size(frame.width, frame.height));
        for row in marched.rows(image) {
            for column in marched.columns(image, row) {
                let i = (row * frame.width + column) as usize;
                (picture.radiance[i], picture.sun[i]) = (frame.radiance[i], frame.sun[i]);
            }
        }
        picture.clone()
    });
    pictures.collect()
}

/// Mean ghosting of the frames after the first four.
fn mean_ghosting(full: &[Frame], rebuilt: &[Frame]) -> f64 {
    let errors: Vec<f64> = full
        .iter()
        .zip(rebuilt)
        .skip(4)
        .map(|(full, rebuilt)| ghosting(full, rebuilt).unwrap())
        .collect();
    errors.iter().sum::<f64>() / errors.len() as f64
}

#[test]
fn at_rest_four_frames_of_every_method_are_the_full_picture_bit_for_bit() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let scene = blobs(folder.path(), true);
    common::on_gpu(move |renderer| {
        for method in REGISTRY {
            let setup = common::with_map(method.info().id, "resolution=32 steps=12", "");
            let made = on_device(
                renderer,
                temporal(),
                &vec![scene.clone(); 6],
                size(33, 22),
                &setup,
            );
            let equal = |n: usize| bits(&made.rebuilt[n]) == bits(&made.full[n]);
            let id = method.info().id;
            assert!(!equal(2), "{id}: three frames cannot know all of it");
            assert!((3..6).all(equal), "{id}");
        }
    });
}

#[test]
fn at_rest_the_oracle_repeats_its_picture_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let scene = blobs(folder.path(), true);
    let made = on_oracle(
        temporal(),
        &vec![scene; 5],
        size(17, 12),
        &setup("srm", "steps=4"),
    );
    assert_ne!(bits(&made.rebuilt[2]), bits(&made.full[2]));
    for n in 3..5 {
        assert_eq!(bits(&made.rebuilt[n]), bits(&made.full[n]));
    }
}

#[test]
fn reprojection_beats_a_history_that_stays_on_the_screen() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let scene = blobs(folder.path(), false);
    let image = size(96, 64);
    // One depth per ray cannot reproject both sides of a translucent cloud past which the camera moves.
    for (track, most) in [(CameraTrack::Pan, 0.12), (CameraTrack::Dolly, 0.25)] {
        let along = (0..12).map(|n| track.scene(&scene, image, n));
        let scenes: Vec<Scene> = along.collect();
        common::on_gpu(move |renderer| {
            let made = on_device(
                renderer,
                temporal(),
                &scenes,
                image,
                &setup("srm", "steps=6"),
            );
            let ours = mean_ghosting(&made.full, &made.rebuilt);
            let control = mean_ghosting(&made.full, &without_reprojection(&made.full));
            println!("{track:?}: ghosting {ours}, without reprojection {control}");
            assert!(
                ours > 0.0 && ours < most * control,
                "{track:?}: {ours} of {control}"
            );
        });
    }
}

/// Four frames before the cloud, then one of a camera that has been moved.
fn after_a_jump(jump: impl FnOnce(&mut Scene)) -> (Vec<Scene>, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let scene = blobs(folder.path(), true);
    let mut scenes = vec![scene; 5];
    jump(&mut scenes[4]);
    (scenes, folder)
}

#[test]
fn the_other_side_of_a_cloud_has_no_history() {
    needs_adapter!();
    let (scenes, _folder) = after_a_jump(|scene| scene.camera.position_m[2] = 1800.0);
    common::on_gpu(move |renderer| {
        let (setup, image) = (setup("srm", "steps=4"), size(33, 22));
        let turned = on_device(renderer, temporal(), &scenes, image, &setup);
        // A history's fifth frame marches the pixels of its first.
        let fresh = on_device(renderer, temporal(), &scenes[4..], image, &setup);
        assert_eq!(bits(&turned.rebuilt[4]), bits(&fresh.rebuilt[0]));
        assert_ne!(bits(&turned.rebuilt[4]), bits(&turned.full[4]));
    });
}

#[test]
fn cloud_behind_the_camera_is_not_seen_again() {
    needs_adapter!();
    let (scenes, _folder) = after_a_jump(|scene| {
        scene.camera.position_m[2] += 2700.0;
        scene.camera.target_m[2] += 2700.0;
    });
    common::on_gpu(move |renderer| {
        let made = on_device(
            renderer,
            temporal(),
            &scenes,
            size(33, 22),
            &setup("srm", "steps=4"),
        );
        let opacity = |frame: &Frame| frame.radiance.iter().map(|p| p[3]).fold(0.0, f32::max);
        assert!(opacity(&made.rebuilt[3]) > 0.5);
        assert_eq!(
            (opacity(&made.full[4]), opacity(&made.rebuilt[4])),
            (0.0, 0.0)
        );
    });
}

#[test]
fn the_march_of_a_full_picture_holds_nothing_of_it() {
    use occlab::gpu::{Program, Sources, compose};
    use occlab::shader_defs::Defs;
    let names = |defs: Defs| {
        let roles = vec![
            ("container", "container/box.wgsl"),
            ("density", "density/uniform.wgsl"),
            ("occlusion", "occlusion/none.wgsl"),
        ];
        let module = compose(
            &Sources::embedded(),
            &Program {
                entry: "raymarch.wgsl",
                roles,
                defs,
            },
        )
        .unwrap();
        let variables = module.global_variables.iter();
        let bound = variables.filter(|(_, v)| v.binding.is_some());
        let names = bound.filter_map(|(_, v)| v.name.clone());
        names.collect::<Vec<String>>().join(" ")
    };
    let full = names(Defs::new());
    for (define, name) in [("INVERSE_DEPTH", "inverse_depth_out"), ("SUBSET", "subset")] {
        let other = names(Defs::from([(define.into(), None)]));
        assert!(
            !full.contains(name) && other.contains(name),
            "{full} | {other}"
        );
    }
}
