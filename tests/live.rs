//! The worker behind the window: what it sends, in which order, and that its pictures and numbers are those of a batch.

#[macro_use]
mod common;
#[path = "live/shaders.rs"]
mod shaders;

use occlab::backend::Backend;
use occlab::batch;
use occlab::config::load_experiment;
use occlab::frame::Frame;
use occlab::gpu::Gpu;
use occlab::live::{Live, Request, State, Update, What, Where};
use occlab::occlusion::MethodSetup;
use occlab::progress::unwatched;
use occlab::raymarch::{Renderer, Tiling};
use occlab::scene::{ImageSize, MapFit, March, Scene};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

const IMAGE: ImageSize = ImageSize {
    width: 48,
    height: 27,
};

fn scene() -> Scene {
    Scene {
        march: March {
            steps: 32,
            ..March::default()
        },
        ..common::box_scene([0.0; 3], [1000.0; 3], 0.003)
    }
}

fn request(serial: u64, scene: Scene, methods: &[&str]) -> Request {
    Request {
        serial,
        scene,
        image: IMAGE,
        methods: methods.iter().map(|id| common::setup(id, "")).collect(),
        truth: true,
        map_of: None,
        repeat: false,
    }
}

fn live(shaders: Option<&Path>) -> Live {
    Live::start(Gpu::new(None).unwrap(), shaders.map(Into::into), || {})
}

/// Updates up to the first that `last` accepts.
fn until(live: &Live, last: impl Fn(&Update) -> bool) -> Vec<Update> {
    let start = Instant::now();
    let mut all = Vec::new();
    loop {
        for update in live.updates() {
            let over = last(&update);
            all.push(update);
            if over {
                return all;
            }
        }
        assert!(
            start.elapsed() < Duration::from_secs(120),
            "it never came; what came: {all:#?}"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Updates until `request` is served and its methods are compared.
fn served(live: &Live, request: &Request) -> Vec<Update> {
    live.request(request.clone());
    let serial = request.serial;
    let mut all = until(
        live,
        |u| matches!(u, Update::Done { serial: s } if *s == serial),
    );
    let compared = |all: &[Update]| {
        let of_request =
            |u: &&Update| matches!(u, Update::Compared { serial: s, .. } if *s == serial);
        all.iter().filter(of_request).count()
    };
    while request.truth && compared(&all) < request.methods.len() {
        all.extend(until(live, |u| matches!(u, Update::Compared { .. })));
    }
    all
}

fn exact(updates: &[Update], wanted: What) -> &Frame {
    let mut found = updates.iter().filter_map(|u| match u {
        Update::Picture { drawn, .. } if drawn.what == wanted && drawn.is_exact() => {
            Some(&*drawn.frame)
        }
        _ => None,
    });
    found.next().expect("an exact picture")
}

fn rendered(scene: Scene, setup: MethodSetup) -> Frame {
    common::on_gpu(move |renderer| {
        let view = renderer.view(&scene, IMAGE).unwrap();
        let prepared = renderer.prepare_full(&view, &setup).unwrap();
        prepared.run(&renderer.gpu, &mut unwatched).unwrap();
        view.read(&renderer.gpu).unwrap()
    })
}

/// A state, and the experiment that it was saved as.
fn saved(folder: &Path) -> (State, PathBuf) {
    let mut state = State::new(scene()).unwrap();
    state.image = IMAGE;
    let file = folder.join("state.json");
    state.save(&file).unwrap();
    (state, file)
}

#[test]
fn pictures_and_numbers_are_those_of_a_batch() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let (state, file) = saved(folder.path());
    assert_eq!(State::load(&file).unwrap(), state);

    let experiment = load_experiment(&file).unwrap();
    let backend = Backend::Device(Box::new(Renderer::new(Gpu::new(None).unwrap())));
    let report = batch::run(&experiment, &backend, folder.path(), None, &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap();

    let live = live(None);
    let mut request = request(1, state.scene.clone(), &[]);
    request.methods = state.methods.to_vec();
    let updates = served(&live, &request);
    for update in &updates {
        let Update::Compared { method, result, .. } = update else {
            continue;
        };
        let own = &result.as_ref().unwrap().0;
        let cell = report.cells[*method].result.as_ref().unwrap();
        assert_eq!(report.cells[*method].method, ["srm", "bsm"][*method]);
        let mut error = cell.error;
        // A batch also renders the uncompressed column.
        error.floor_rel_rmse = None;
        assert_eq!(own.error, error);
        assert!(own.error.rel_rmse > 0.0);
        assert_eq!(own.cloud_pixel_fraction, cell.cloud_pixel_fraction);
    }
    let truth = MethodSetup::truth(&state.scene).unwrap();
    for (what, setup) in [
        (What::Method(0), &state.methods[0]),
        (What::Method(1), &state.methods[1]),
        (What::Truth, &truth),
    ] {
        let batch = rendered(state.scene.clone(), setup.clone());
        assert_eq!(*exact(&updates, what), batch, "{what:?}");
    }
}

#[test]
fn a_coarse_picture_comes_first_and_what_is_known_is_not_rendered_again() {
    needs_adapter!();
    let live = live(None);
    let first = served(&live, &request(1, scene(), &["srm"]));
    let factors: Vec<_> = first
        .iter()
        .filter_map(|u| match u {
            Update::Picture { drawn, .. } if drawn.what == What::Method(0) => Some(drawn.factor),
            _ => None,
        })
        .collect();
    assert_eq!((factors[0], factors[1]), (4, 1));
    // Another method of the same view: the pictures that are there come at once, exact, with the same times.
    let second = served(&live, &request(2, scene(), &["bsm", "srm"]));
    let costs = |updates: &[Update], wanted| {
        let cost = updates.iter().find_map(|u| match u {
            Update::Picture { drawn, .. } if drawn.what == wanted => drawn.cost,
            _ => None,
        });
        cost.map(|(times, _)| times)
    };
    let known = second.iter().filter(|u| {
        matches!(u, Update::Picture { drawn, .. } if drawn.what == What::Method(1) && !drawn.is_exact())
    });
    assert_eq!(known.count(), 0);
    let time = |u: &[Update], what| {
        u.iter().find_map(|u| match u {
            Update::Picture { drawn, .. } if drawn.what == what && drawn.is_exact() => drawn.cost,
            _ => None,
        })
    };
    assert_eq!(
        time(&first, What::Method(0)).unwrap().0,
        costs(&second, What::Method(1)).unwrap()
    );
}

#[test]
fn the_latest_request_wins_and_earlier_ones_show_one_picture_at_most() {
    needs_adapter!();
    let live = live(None);
    for serial in 1..=30 {
        let mut moved = scene();
        moved.sun.elevation_deg = 20.0 + serial as f64;
        let mut request = request(serial, moved, &["srm", "bsm", "fom"]);
        request.image = ImageSize {
            width: 320,
            height: 180,
        };
        live.request(request);
        std::thread::sleep(Duration::from_millis(3));
    }
    let updates = until(&live, |u| matches!(u, Update::Done { .. }));
    assert!(matches!(updates.last(), Some(Update::Done { serial: 30 })));
    let mut exact = updates.iter().filter_map(|u| match u {
        Update::Picture { serial, drawn } if drawn.is_exact() => Some(*serial),
        _ => None,
    });
    assert!(exact.next().is_some_and(|serial| serial > 1));
}

#[test]
fn the_truth_chosen_as_a_method_is_the_truth() {
    needs_adapter!();
    let live = live(None);
    let mut request = request(1, scene(), &[]);
    request.methods = vec![MethodSetup::truth(&request.scene).unwrap()];
    let updates = served(&live, &request);
    let error = updates.iter().find_map(|u| match u {
        Update::Compared { result, .. } => Some(result.as_ref().unwrap().0.error),
        _ => None,
    });
    assert_eq!(error.unwrap().rel_rmse, 0.0);
}

#[test]
fn tiles_of_any_length_make_the_same_picture() {
    needs_adapter!();
    let mut renderer = Renderer::new(Gpu::new(None).unwrap());
    for (id, params) in [
        ("srm", ""),
        ("bsm", "resolution=100"),
        ("floor", "resolution=33 steps=9"),
    ] {
        let setup = common::setup(id, params);
        let mut pictures = [0.0, 0.5, Tiling::BATCH.target_ms].map(|target_ms| {
            renderer.tiling = Tiling {
                target_ms,
                ..Tiling::BATCH
            };
            let view = renderer.view(&scene(), IMAGE).unwrap();
            let prepared = renderer.prepare_full(&view, &setup).unwrap();
            let mut shares = Vec::new();
            prepared
                .run(&renderer.gpu, &mut |share| {
                    shares.push(share);
                    ControlFlow::Continue(())
                })
                .unwrap();
            assert!(
                shares.is_sorted() && shares.last() == Some(&1.0),
                "{shares:?}"
            );
            // How many a positive aim gives depends on the machine.
            assert!(shares.len() > 3 || target_ms > 0.0);
            view.read(&renderer.gpu).unwrap()
        });
        let last = pictures[2].clone();
        assert!(pictures.iter_mut().all(|p| *p == last), "{id}");
    }
}

#[test]
fn maps_and_probes_are_sent_on_request() {
    needs_adapter!();
    let live = live(None);
    let mut request = request(1, scene(), &["srm", "bsm"]);
    request.map_of = Some(1);
    request.methods[1] = common::setup("bsm", "resolution=64");
    for serial in [1, 2] {
        // On the second request the picture is known, but the map is not kept.
        request.serial = serial;
        let updates = served(&live, &request);
        let texels = updates.iter().find_map(|u| match u {
            Update::Map {
                method: 1, texels, ..
            } => texels.clone(),
            _ => None,
        });
        let texels = texels.expect("a map");
        assert_eq!((texels.resolution, texels.values_a_texel), (64, 3));
        assert!(texels.nonfinite() == 0 && texels.values.iter().any(|v| *v > 0.0));
    }
    let methods = request.methods.clone();
    live.probe(
        &request,
        methods,
        Where::Column([0.5, 0.5], 64, MapFit::Square),
    );
    let updates = until(&live, |u| matches!(u, Update::Probed { .. }));
    let Some(Update::Probed {
        result: Ok(probed), ..
    }) = updates.last()
    else {
        panic!("{updates:?}");
    };
    let ids: Vec<_> = probed.probe.curves.iter().map(|c| c.method).collect();
    assert_eq!(ids, ["srm", "bsm"]);
    live.probe(
        &request,
        Vec::new(),
        Where::Column([7.0, 7.0], 64, MapFit::Square),
    );
    let updates = until(&live, |u| matches!(u, Update::Probed { .. }));
    assert!(matches!(
        updates.last(),
        Some(Update::Probed { result: Err(_), .. })
    ));
}

#[test]
fn a_batch_runs_and_can_be_cancelled_and_pictures_go_on() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let (_, file) = saved(folder.path());
    let live = live(None);
    live.batch(file.clone(), folder.path().join("a"));
    let updates = until(&live, |u| matches!(u, Update::BatchDone(_)));
    let Some(Update::BatchDone(Ok(page))) = updates.last() else {
        panic!("{updates:?}");
    };
    assert!(page.is_file());
    let cells = |u: &&Update| matches!(u, Update::Batch(batch::Event::Cell(_)));
    assert_eq!(updates.iter().filter(cells).count(), 2);

    live.batch(file, folder.path().join("b"));
    until(&live, |u| matches!(u, Update::Batch(_)));
    live.cancel_batch();
    let updates = until(&live, |u| matches!(u, Update::BatchDone(_)));
    assert!(matches!(updates.last(), Some(Update::BatchDone(Err(_)))));
    served(&live, &request(1, scene(), &["srm"]));
}

#[test]
fn an_adapter_that_vanishes_is_said_once() {
    needs_adapter!();
    let gpu = Gpu::new(None).unwrap();
    let device = gpu.device.clone();
    let live = Live::start(gpu, None, || {});
    served(&live, &request(1, scene(), &["srm"]));
    device.destroy();
    live.request(request(2, scene(), &["esm"]));
    let updates = until(&live, |u| matches!(u, Update::Lost(_)));
    assert!(matches!(updates.last(), Some(Update::Lost(m)) if m.contains("vanished")));
}
