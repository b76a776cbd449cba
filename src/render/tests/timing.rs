//! Timestamps are valid: on a CPU adapter a run's passes fill most of its wall time, for the method prepared last and
//! for those prepared before it (a driver that defers timestamps reports almost nothing for the latter).

extern crate occlab_render as occlab;

#[macro_use]
#[path = "../../../tests/common/mod.rs"]
mod common;

use occlab::cost::PassTimes;
use occlab::occlusion::{REGISTRY, Role};
use occlab::progress::unwatched;

#[test]
fn passes_account_for_the_wall_time_of_every_prepared_method() {
    needs_adapter!();
    common::on_gpu(|renderer| {
        let info = &renderer.gpu.info;
        if info.device_type != wgpu::DeviceType::Cpu || !renderer.gpu.has_timestamps() {
            println!("skipped: needs a CPU adapter with timestamps, this is {info:?}");
            return;
        }
        let scene = common::box_scene([0.0; 3], [1000.0; 3], 0.01);
        let view = renderer.view(&scene, common::size(128, 128)).unwrap();
        let compared = REGISTRY.iter().map(|m| m.info());
        let compared = compared.filter(|i| [Role::Practical, Role::Floor].contains(&i.role));
        let ids: Vec<_> = compared.map(|info| info.id).collect();
        let setup = |id: &&str| common::setup(id, "");
        let prepare = |id| renderer.prepare_full(&view, &setup(id)).unwrap();
        let prepared: Vec<_> = ids.iter().map(prepare).collect();
        for round in 0..2 {
            for (id, method) in ids.iter().zip(&prepared) {
                let times = method.run(&renderer.gpu, &mut unwatched).unwrap();
                let share = times.total().unwrap() / times.wall;
                // The rest of the wall time is submission and read-back, and in round 0 the driver's compilation.
                let least = if round == 0 { 0.0 } else { 0.1 };
                assert!(
                    (least..=1.01).contains(&share),
                    "{id}: passes are {share:.3} of the wall time, {times:?}"
                );
            }
        }
    });
}

/// Time grows in proportion to the number of frames in flight: one wait for many frames neither hides part of a frame
/// nor adds the cost of a wait to each. Printed; asserted only where noise cannot matter.
#[test]
fn frames_in_flight_are_all_timed_and_fill_their_wall_time() {
    needs_adapter!();
    common::on_gpu(|renderer| {
        let gpu = &renderer.gpu;
        let scene = common::box_scene([0.0; 3], [1000.0; 3], 0.01);
        let view = renderer.view(&scene, common::size(64, 48)).unwrap();
        println!(
            "{:>8} {:>8} {:>12} {:>12}",
            "method", "frames", "passes, ms", "wall, ms"
        );
        for (id, set) in [("srm", "steps=20"), ("bsm", "resolution=64")] {
            let prepared = renderer
                .prepare_full(&view, &common::setup(id, set))
                .unwrap();
            let one = prepared.run(gpu, &mut unwatched).unwrap();
            let picture = view.read(gpu).unwrap();
            for frames in [1, 2, 4, 8, 16, 160] {
                let mut asked = false;
                let times = prepared.repeat(gpu, frames, || asked = true).unwrap();
                assert!(asked && times.len() == frames as usize);
                let wall_ms: f64 = times.iter().map(|t| t.wall).sum();
                if gpu.has_timestamps() {
                    let passes_ms: f64 = times.iter().filter_map(PassTimes::total).sum();
                    println!("{id:>8} {frames:>8} {passes_ms:>12.3} {wall_ms:>12.3}");
                    assert!(times.iter().all(|t| t.total().is_some_and(|ms| ms > 0.0)));
                    assert!(
                        times
                            .iter()
                            .all(|t| t.generate.is_some() == one.generate.is_some())
                    );
                    assert!(passes_ms <= 1.01 * wall_ms, "{id}: {passes_ms} > {wall_ms}");
                }
            }
            let again = view.read(gpu).unwrap();
            assert_eq!(picture.radiance, again.radiance, "{id}: the same picture");
        }
    });
}
