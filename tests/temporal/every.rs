//! Properties that every registered reconstruction must have, on a device and in f64.

use super::common::{self, setup, size};
use super::sequence::{bits, blobs, flight, on_device, on_oracle};
use super::twin::apart;
use occlab::backend::{Backend, Choice};
use occlab::cost::Counting;
use occlab::oracle::{Options, Oracle};
use occlab::progress::unwatched;
use occlab::reconstruct::REGISTRY;
use occlab::scene::{ImageSize, ReconstructionInfo};

#[test]
fn at_rest_the_picture_settles_when_it_says_and_is_the_full_one_where_it_says() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let scene = blobs(folder.path(), true);
    common::on_gpu(move |renderer| {
        for by in REGISTRY {
            let ReconstructionInfo { id, rest, .. } = by.info();
            let (settled, setup) = (rest.frames as usize, setup("srm", "steps=4"));
            let (image, scenes) = (size(33, 22), vec![scene.clone(); settled + 2]);
            for (where_, made) in [
                ("device", on_device(renderer, *by, &scenes, image, &setup)),
                ("oracle", on_oracle(*by, &scenes, image, &setup)),
            ] {
                let last = bits(&made.rebuilt[settled - 1]);
                for frame in &made.rebuilt[settled..] {
                    assert_eq!(bits(frame), last, "{id}, {where_}: it changes still");
                }
                let exact = last == bits(&made.full[0]);
                assert_eq!(exact, rest.exact, "{id}, {where_}");
            }
        }
    });
}

#[test]
fn the_device_and_its_twin_make_the_same_frames_of_a_flight() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let scene = blobs(folder.path(), true);
    let scenes: Vec<_> = (0..6).map(|n| flight(&scene, n, 12.0)).collect();
    common::on_gpu(move |renderer| {
        for by in REGISTRY {
            let (id, image, setup) = (by.info().id, size(41, 30), setup("srm", "steps=6"));
            let twin = on_oracle(*by, &scenes, image, &setup);
            let made = on_device(renderer, *by, &scenes, image, &setup);
            for n in 0..scenes.len() {
                let rebuilt = apart(&twin.rebuilt[n], &made.rebuilt[n]);
                assert!(rebuilt < 1e-4, "{id}, frame {n}: {rebuilt}");
                let control = apart(&twin.rebuilt[n], &made.full[n]);
                assert_eq!(control > 1e-2, !by.info().is_full(), "{id}: {control}");
            }
        }
    });
}

#[test]
fn a_sequence_allocates_the_bytes_that_it_says() {
    needs_adapter!();
    common::on_gpu(|renderer| {
        for by in REGISTRY {
            let (info, image) = (by.info(), size(21, 13));
            let sequence = by.on_device(&renderer.gpu, image).unwrap();
            let bytes = sequence.frames().bytes();
            assert!(bytes >= info.history_bytes(image), "{}", info.id);
            if info.history.is_some() {
                assert_eq!(bytes, info.history_bytes(image), "{}", info.id);
            }
        }
    });
}

#[test]
fn the_smallest_picture_is_rendered_and_a_smaller_one_refused() {
    let backend = Backend::open(Choice::Cpu, None).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let scene = blobs(folder.path(), true);
    for by in REGISTRY {
        let (info, [width, height]) = (by.info(), by.info().smallest);
        let image = size(width, height);
        let view = backend.view(&scene, image).unwrap();
        let sequence = backend.sequence(info, image).unwrap();
        let method = setup("srm", "steps=4");
        let prepared = backend.prepare(&view, &method, &sequence).unwrap();
        for _ in 0..=info.pattern.frames() {
            prepared.run(&mut unwatched).unwrap();
            assert_eq!(prepared.picture().unwrap().width, width);
        }
        let smaller = [(width - 1, height), (width, height - 1)];
        for (width, height) in smaller.into_iter().filter(|(w, h)| w * h > 0) {
            let refused = backend.sequence(info, ImageSize { width, height }).err();
            let message = refused.expect(info.id).to_string();
            assert!(message.contains(info.id), "{message}");
            assert!(message.contains("Choose a larger image"), "{message}");
        }
    }
}

#[test]
fn the_frames_of_a_pattern_take_the_samples_of_its_pixels_and_no_others() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let scene = blobs(folder.path(), true);
    common::on_gpu(move |renderer| {
        let (image, setup) = (size(33, 22), setup("none", ""));
        let oracle = Oracle::new(&scene, image).unwrap();
        let method = oracle.prepare(&setup, Options::default()).unwrap();
        let view = renderer.view(&scene, image).unwrap();
        let full = common::count_view(renderer, &view, &setup).samples.view;
        let (_, twin_full) = method.render(&mut unwatched).unwrap();
        for by in REGISTRY {
            let ReconstructionInfo { id, pattern, .. } = by.info();
            let sequence = by.on_device(&renderer.gpu, image).unwrap();
            let counting = renderer
                .prepare(&view, &setup, &sequence, Counting::On)
                .unwrap();
            let mut twin = by.on_oracle(image);
            let mut twin_sum = 0;
            for _ in 0..pattern.frames() {
                counting.run(&renderer.gpu, &mut unwatched).unwrap();
                let counts = twin.render(&method, &mut unwatched).unwrap();
                twin_sum += counts.samples.view;
            }
            // A pixel keeps its counter until it is marched again: the sum is over all frames.
            let sum = counting.counts(&renderer.gpu).unwrap().samples.view;
            for (sum, full) in [(sum, full), (twin_sum, twin_full.samples.view)] {
                assert!(sum > 0 && sum <= full, "{id}: {sum} of {full}");
                assert_eq!(sum == full, pattern.is_complete(), "{id}: {sum} of {full}");
            }
        }
    });
}
