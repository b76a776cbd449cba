// Clock probe: a fixed amount of arithmetic whose GPU time tells the device's clock. Timed before and between rounds,
// it shows whether the device ran as fast at the end of a measurement as at its begin.
//
//   x ← x·a + b, TURNS times in each thread, every iteration depending on the one before; no memory reads
//
// The result is stored only where it is negative, which never happens; the compiler cannot know, and keeps the work.
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
