//! Light maps that are filled over several frames, beside the one that is read.

extern crate occlab_render as occlab;

#[macro_use]
#[path = "../../../tests/common/mod.rs"]
mod common;

use common::{box_scene, count_view, lumps, on_gpu, reds, relative_rmse, render_view, setup, size};
use occlab::error::Error;
use occlab::oracle::{Options, Oracle};
use occlab::progress::unwatched;
use occlab::raymarch::Frames;
use occlab::scene::ImageSize;

const IMAGE: ImageSize = ImageSize {
    width: 40,
    height: 32,
};

/// After as many frames as a map takes, the one that was filled in parts is read: all its values are those of a map that
/// is filled at once, and so is the picture.
#[test]
fn at_rest_a_map_filled_in_parts_is_the_whole_map() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let scene = lumps(folder.path());
    on_gpu(move |renderer| {
        let view = renderer.view(&scene, IMAGE).unwrap();
        for params in ["", "fit=warped cascades=3 placement=occupied"] {
            let whole = setup("floor", &format!("resolution=64 steps=12 {params}"));
            let parts = whole.clone().with("fill_frames", "4").unwrap();
            let picture = render_view(renderer, &view, &whole);
            let at_once = renderer.prepare_full(&view, &whole).unwrap();
            at_once.run(&renderer.gpu, &mut unwatched).unwrap();
            let texels = at_once.map_texels(&renderer.gpu).unwrap().unwrap();
            let prepared = renderer.prepare_full(&view, &parts).unwrap();
            assert_eq!(prepared.memory.map_bytes, 2 * at_once.memory.map_bytes);
            for frame in 1..=9 {
                prepared.run(&renderer.gpu, &mut unwatched).unwrap();
                let read = prepared.map_texels(&renderer.gpu).unwrap().unwrap();
                assert!(read == texels, "{params}: the map of frame {frame} differs");
                let now = prepared.picture(&renderer.gpu).unwrap();
                assert!(now == picture, "{params}: frame {frame} differs");
            }
        }
    });
}

/// A frame takes its share of the samples, and its first frame too.
#[test]
fn a_frame_marches_its_part_of_the_columns() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let scene = lumps(folder.path());
    on_gpu(move |renderer| {
        let view = renderer.view(&scene, IMAGE).unwrap();
        let samples = |params: &str| {
            let setup = setup("alq", &format!("resolution=64 steps=12 {params}"));
            count_view(renderer, &view, &setup).samples.map
        };
        let (whole, part) = (samples(""), samples("fill_frames=8"));
        let share = part as f64 / whole as f64;
        assert!((share - 0.125).abs() < 0.02, "{share}");
    });
}

/// While the sun moves, a frame reads the map of an earlier one, on the device as in f64; with its own map the picture is
/// another.
#[test]
fn a_map_of_an_earlier_frame_is_read_along_its_own_sun() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let now = lumps(folder.path());
    let mut before = now.clone();
    before.sun.elevation_deg -= 3.0;
    before.camera.position_m[0] -= 20.0;
    let oracles = [&now, &before].map(|scene| Oracle::new(scene, IMAGE).unwrap());
    on_gpu(move |renderer| {
        let [view, earlier] = [&now, &before].map(|scene| renderer.view(scene, IMAGE).unwrap());
        for params in ["", "cascades=2 near_steps=2 near_m=40"] {
            let params = format!("resolution=64 steps=12 storage=f32 fill_frames=4 {params}");
            let setup = setup("floor", &params);
            let prepared = renderer
                .prepare_with_map_of(&earlier, &view, &setup, &Frames::full())
                .unwrap();
            prepared.run(&renderer.gpu, &mut unwatched).unwrap();
            let device = prepared.picture(&renderer.gpu).unwrap();
            let [current, old] = &oracles;
            let (stale, fresh) = (
                current.prepare_with_map_of(old, &setup, Options::default()),
                current.prepare(&setup, Options::default()),
            );
            let error = |occlusion: occlab::oracle::Occlusion| {
                let (picture, _) = occlusion.render(&mut unwatched).unwrap();
                relative_rmse(reds(&device, &picture))
            };
            let (right, control) = (error(stale.unwrap()), error(fresh.unwrap()));
            println!("{params}: {right:.1e}, control {control:.1e}");
            assert!(right < 1e-3, "{params}: {right:.1e}");
            assert!(
                control > 1e-2,
                "{params}: its own map passed: {control:.1e}"
            );
        }
    });
}

#[test]
fn parts_that_do_not_divide_the_map_are_refused() {
    needs_adapter!();
    let scene = box_scene([0.0; 3], [1.0; 3], 1.0);
    on_gpu(move |renderer| {
        let view = renderer.view(&scene, size(8, 8)).unwrap();
        let setup = setup("esm", "resolution=100 fill_frames=4");
        let error = renderer.prepare_full(&view, &setup).err().unwrap();
        assert!(matches!(error, Error::Input { .. }), "{error}");
        assert!(error.to_string().contains("multiple of 32"), "{error}");
    });
}
