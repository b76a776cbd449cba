//! A pass over a picture or a map in dispatches that end in time: drivers reset a device that is busy for about 2 s, and
//! a window that shares the queue waits for every dispatch before its own.

use super::Progress;
use crate::error::{Error, Result};
use crate::gpu::{Gpu, Inputs, Kernel, Resource, Timer};
use std::cell::Cell;
use std::ops::ControlFlow;
use std::time::Instant;

/// How a pass is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tiling {
    /// Duration that a tile aims at, ms.
    pub target_ms: f64,
    /// About the most tiles of a pass, even when each is then longer: what else waits for the queue stretches the time
    /// that a tile seems to take.
    pub most: u32,
}

impl Tiling {
    /// Nothing else waits for the queue: only the driver's patience counts.
    pub const BATCH: Self = Self {
        target_ms: 400.0,
        most: u32::MAX,
    };

    /// A window waits for the same queue: a frame of the screen a tile; on a software adapter, which needs longer for the
    /// window itself, a few.
    pub fn beside_a_window(gpu: &Gpu) -> Self {
        match gpu.is_software() {
            true => Self {
                target_ms: 60.0,
                most: 24,
            },
            false => Self {
                target_ms: 16.0,
                most: 256,
            },
        }
    }
}
/// Density samples a millisecond that the slowest adapter of interest takes: for tiles before the first was timed.
pub(super) const SLOW_SAMPLES_A_MS: f64 = 5e4;

/// Cuts a rectangle of threads into tiles: whole bands while a band fits the aim, else parts of the lowest band.
pub(super) struct Tiles {
    tiling: Tiling,
    threads: Cell<f64>,
    uniform: wgpu::Buffer,
}

/// What one dispatch covers.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Tile {
    origin: [u32; 2],
    size: [u32; 2],
}

/// A pass to be cut.
pub(super) struct Pass<'a> {
    pub kernel: &'a Kernel,
    pub groups: &'a [wgpu::BindGroup],
    pub timer: Option<&'a Timer>,
    /// Threads.
    pub size: [u32; 2],
    /// Turns of the shader's outer loop, and how many of them a dispatch takes.
    pub steps: [u32; 2],
}

impl Tiles {
    /// Tiles of a pass, the first of about `threads` threads. The kernel finds them in the uniform `tile`.
    pub fn new(gpu: &Gpu, inputs: &mut Inputs, tiling: Tiling, threads: f64) -> Self {
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::STORAGE;
        let uniform = gpu.buffer("tile", &[0; 24], usage);
        inputs.resource("tile", Resource::Buffer(uniform.clone()));
        Self {
            tiling,
            threads: Cell::new(threads),
            uniform,
        }
    }

    /// Runs a pass from the top; its GPU time, ms. `progress` hears the finished share after every tile, and bands of
    /// [`BAND_ROWS`](super::BAND_ROWS) rows are finished one after the other.
    pub fn run(&self, gpu: &Gpu, pass: &Pass, progress: Progress) -> Result<Option<f64>> {
        let [width, height] = pass.size;
        let [all_steps, steps] = pass.steps;
        let least = f64::from(width) * f64::from(height) / f64::from(self.tiling.most);
        let mut total_ms = None;
        let mut at = Some([0, 0]);
        while let Some([x, y]) = at {
            let threads = self.threads.get().max(least);
            let tile = cut(pass.size, pass.kernel.workgroup, [x, y], threads);
            let start = Instant::now();
            let mut step = 0;
            while step < all_steps {
                let end = step.saturating_add(steps);
                let ms = self.dispatch(gpu, pass, tile, [step, end])?;
                total_ms = ms.map(|ms| ms + total_ms.unwrap_or(0.0));
                step = end;
            }
            self.adapt(tile, start.elapsed().as_secs_f64() * 1e3);
            let [columns, rows] = tile.size;
            at = if x + columns < width {
                Some([x + columns, y])
            } else {
                (y + rows < height).then_some([0, y + rows])
            };
            let done = at.map_or(f64::from(height), |[x, y]| {
                f64::from(y) + f64::from(x) / f64::from(width) * f64::from(rows)
            });
            if progress(done / f64::from(height)) == ControlFlow::Break(()) {
                return Err(Error::Stopped);
            }
        }
        Ok(total_ms)
    }

    /// Next tile's threads: at most doubling, toward the aim.
    fn adapt(&self, tile: Tile, ms: f64) {
        let threads = f64::from(tile.size[0]) * f64::from(tile.size[1]);
        self.threads
            .set(threads * (self.tiling.target_ms / ms.max(0.01)).min(2.0));
    }

    fn dispatch(
        &self,
        gpu: &Gpu,
        pass: &Pass,
        tile: Tile,
        [from, to]: [u32; 2],
    ) -> Result<Option<f64>> {
        let ([x, y], [width, height]) = (tile.origin, tile.size);
        let values = [x, y, width, height, from, to];
        gpu.queue
            .write_buffer(&self.uniform, 0, bytemuck::bytes_of(&values));
        dispatch(
            gpu,
            pass.timer,
            pass.kernel,
            pass.groups,
            [width, height, 1],
        )
    }
}

/// One dispatch over `threads`, waited for; its GPU time, ms, where there is a timer.
pub(super) fn dispatch(
    gpu: &Gpu,
    timer: Option<&Timer>,
    kernel: &Kernel,
    groups: &[wgpu::BindGroup],
    threads: [u32; 3],
) -> Result<Option<f64>> {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let timestamp_writes = timer.map(Timer::writes);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: None,
            timestamp_writes,
        });
        kernel.dispatch(&mut pass, groups, threads);
    }
    if let Some(timer) = timer {
        timer.resolve(&mut encoder);
    }
    gpu.queue.submit([encoder.finish()]);
    match timer {
        Some(timer) => timer.elapsed_ms(gpu).map(Some),
        None => gpu.wait().map(|()| None),
    }
}

/// The tile at `at` of about `threads` threads, in whole workgroups.
fn cut([width, height]: [u32; 2], workgroup: [u32; 3], [x, y]: [u32; 2], threads: f64) -> Tile {
    let whole = |threads: f64, group: u32| ((threads as u32) / group).max(1).saturating_mul(group);
    let [group_x, group_y, _] = workgroup;
    let band = f64::from(width) * f64::from(group_y);
    let size = if x == 0 && threads >= band {
        let rows = whole(threads / f64::from(width), group_y);
        [width, rows.min(height - y)]
    } else {
        let columns = whole(threads / f64::from(group_y), group_x);
        [columns.min(width - x), group_y.min(height - y)]
    };
    Tile {
        origin: [x, y],
        size,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every tile of a rectangle, in order.
    fn tiles(size: [u32; 2], threads: impl Fn(usize) -> f64) -> Vec<Tile> {
        let mut all = Vec::new();
        let mut at = Some([0, 0]);
        while let Some([x, y]) = at {
            let tile = cut(size, [8, 8, 1], [x, y], threads(all.len()));
            all.push(tile);
            let [columns, rows] = tile.size;
            at = if x + columns < size[0] {
                Some([x + columns, y])
            } else {
                (y + rows < size[1]).then_some([0, y + rows])
            };
        }
        all
    }

    #[test]
    fn every_thread_is_in_one_tile_whatever_the_aim() {
        for size in [[1, 1], [13, 21], [320, 180], [4096, 16]] {
            for threads in [0.0, 1.0, 100.0, 3000.0, 1e12] {
                let growing = |i: usize| threads * 1.7_f64.powi(i as i32 % 9);
                let mut seen = vec![0; (size[0] * size[1]) as usize];
                for tile in tiles(size, growing) {
                    for y in tile.origin[1]..tile.origin[1] + tile.size[1] {
                        for x in tile.origin[0]..tile.origin[0] + tile.size[0] {
                            seen[(y * size[0] + x) as usize] += 1;
                        }
                    }
                }
                assert!(seen.iter().all(|n| *n == 1), "{size:?} {threads}");
            }
        }
    }

    #[test]
    fn a_tile_holds_what_was_asked_in_whole_workgroups() {
        let of = |threads| cut([320, 180], [8, 8, 1], [0, 0], threads).size;
        assert_eq!(of(0.0), [8, 8]);
        assert_eq!(of(1000.0), [120, 8]);
        assert_eq!(of(320.0 * 8.0), [320, 8]);
        assert_eq!(of(320.0 * 31.0), [320, 24]);
        assert_eq!(of(1e9), [320, 180]);
    }
}
