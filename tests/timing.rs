//! Timestamps mean what they say: on a CPU adapter a run's passes fill most of its wall time, for the method prepared
//! last and for those prepared before it (a driver that defers timestamps reports almost nothing for the latter).

#[macro_use]
mod common;

use occlab::raymarch::unwatched;

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
        let ids = ["srm", "esm", "bsm", "fom", "floor"];
        let prepared = ids.map(|id| renderer.prepare(&view, &common::setup(id, "")).unwrap());
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
