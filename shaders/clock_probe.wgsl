// A fixed amount of arithmetic whose time tells the device's clock: timed before and between rounds, it shows whether the
// device ran as fast at the end of a measurement as at its begin.
//
//   x ← x·a + b, TURNS times a thread, each turn waiting for the one before; nothing is read from memory
//
// The result is stored only where it is negative, which it never is: a compiler cannot know that and leave the work out.
// Cost: threads × TURNS fused multiply-adds; the number of threads is chosen once for each device (gpu/clock_probe.rs).

struct Work {
    a: f32,     // below 1, so that x stays finite
    b: f32,
}

@group(0) @binding(0) var<uniform> work: Work;
@group(0) @binding(1) var<storage, read_write> never: array<f32>;

const TURNS: u32 = 256u;

@compute @workgroup_size(64, 1, 1)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let a = work.a;
    let b = work.b;
    var x = f32(id.x & 1023u) + f32(id.y);
    for (var i = 0u; i < TURNS; i++) {
        x = fma(x, a, b);
    }
    if x < 0.0 {
        never[0] = x;
    }
}
