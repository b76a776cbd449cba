//! Tiling of a pass over a picture or a map into dispatches of bounded duration: drivers reset a device that is busy
//! for about 2 s, and a window that shares the queue waits for every dispatch before its own.

use crate::error::{Error, Result};
use crate::gpu::{Flight, Gpu, Inputs, Kernel, PassTime, Resource, Span};
use crate::progress::Progress;
use std::cell::Cell;
use std::ops::ControlFlow;

/// Tiling of a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tiling {
    /// Target duration of a tile, ms.
    pub target_ms: f64,
    /// Approximate limit to the tiles of a pass, even if each is then longer than the target: other work in the queue
    /// makes a tile seem slower than it is.
    pub most: u32,
}

impl Tiling {
    /// Nothing else waits for the queue: a dispatch only has to end before the driver resets the device.
    pub const BATCH: Self = Self {
        target_ms: 400.0,
        most: u32::MAX,
    };

    /// A window waits for the same queue: a tile takes about a frame of the screen; on a software adapter, which takes
    /// longer to draw the window itself, a few.
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

/// Density samples a millisecond of the slowest adapter of interest: sizes tiles before the first is timed.
pub(super) const SLOW_SAMPLES_A_MS: f64 = 5e4;

/// Cuts a rectangle of threads into tiles: whole bands while a band fits the target, else parts of a band one workgroup
/// high.
pub(super) struct Tiles {
    tiling: Tiling,
    /// Threads of a tile that takes about the target duration, as estimated so far.
    threads: Cell<f64>,
    /// Duration of the last run.
    taken: Cell<Option<Taken>>,
    uniform: wgpu::Buffer,
    /// Content of the uniform once all recorded work is submitted.
    written: Cell<[u32; 6]>,
}

/// CPU-side duration of a pass in tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Taken {
    /// All tiles, ms.
    all_ms: f64,
    /// The tile that was the slowest for its size, ms a thread.
    worst_ms: f64,
}

/// Rectangle of threads of one dispatch.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Tile {
    origin: [u32; 2],
    size: [u32; 2],
}

/// A pass to be tiled.
pub(super) struct Pass<'a> {
    pub kernel: &'a Kernel,
    pub groups: &'a [wgpu::BindGroup],
    /// Row of the first thread.
    pub first_row: u32,
    /// Threads.
    pub size: [u32; 2],
    /// Iterations of the shader's outer loop, and how many of them a dispatch takes.
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
            taken: Cell::new(None),
            uniform,
            written: Cell::default(),
        }
    }

    /// Runs a pass from the top, waiting for every tile; returns its GPU time. `progress` is called with the finished
    /// share after every tile, and bands of [`BAND_ROWS`](super::BAND_ROWS) rows are finished one after the other.
    pub fn run(&self, gpu: &Gpu, pass: &Pass, progress: Progress) -> Result<PassTime> {
        let [width, height] = pass.size;
        let least = f64::from(width) * f64::from(height) / f64::from(self.tiling.most);
        let mut total = Vec::new();
        let mut taken = Taken::default();
        let mut at = Some([0, 0]);
        while let Some([x, y]) = at {
            let threads = self.threads.get().max(least);
            let tile = cut(pass.size, pass.kernel.workgroup, [x, y], threads);
            let mut flight = Flight::new(gpu);
            let spans = self.record_tile(&mut flight, pass, tile);
            let finished = flight.finish(|| ())?;
            total.push(finished.pass(&spans));
            taken.add(tile, finished.wall_ms);
            self.threads
                .set(next_aim(self.tiling, threads, tile, finished.wall_ms));
            at = next(pass.size, tile);
            let done = at.map_or(f64::from(height), |[x, y]| {
                f64::from(y) + f64::from(x) / f64::from(width) * f64::from(tile.size[1])
            });
            if progress(done / f64::from(height)) == ControlFlow::Break(()) {
                return Err(Error::Stopped);
            }
        }
        self.taken.set(Some(taken));
        Ok(PassTime::sum(&total))
    }

    /// Records a pass without waiting, in one dispatch unless that would exceed the driver's time limit; a software
    /// adapter has none. Durations are known from [`Tiles::run`].
    pub fn record(&self, flight: &mut Flight, pass: &Pass) -> Vec<Span> {
        let threads = match self.taken.get() {
            _ if flight.is_software() => f64::INFINITY,
            Some(taken) => taken.most_threads(self.tiling),
            None => self.threads.get(),
        };
        let mut spans = Vec::new();
        let mut at = Some([0, 0]);
        while let Some(origin) = at {
            let tile = cut(pass.size, pass.kernel.workgroup, origin, threads);
            spans.extend(self.record_tile(flight, pass, tile));
            at = next(pass.size, tile);
        }
        spans
    }

    fn record_tile(&self, flight: &mut Flight, pass: &Pass, tile: Tile) -> Vec<Span> {
        let ([x, y], [width, height]) = (tile.origin, tile.size);
        let [all_steps, steps] = pass.steps;
        let mut spans = Vec::new();
        let mut step = 0;
        while step < all_steps {
            let end = step.saturating_add(steps);
            let values = [x, pass.first_row + y, width, height, step, end];
            let changed = self.written.replace(values) != values;
            let uniform = changed.then(|| (&self.uniform, bytemuck::bytes_of(&values)));
            let threads = [width, height, 1];
            spans.push(flight.dispatch(pass.kernel, pass.groups, threads, uniform));
            step = end;
        }
        spans
    }
}

impl Taken {
    fn add(&mut self, tile: Tile, ms: f64) {
        let threads = f64::from(tile.size[0]) * f64::from(tile.size[1]);
        self.all_ms += ms;
        self.worst_ms = self.worst_ms.max(ms / threads);
    }

    /// Threads of a tile that stays within the target anywhere in the picture: the cost of rows differs.
    fn most_threads(self, tiling: Tiling) -> f64 {
        match self.all_ms <= tiling.target_ms {
            true => f64::INFINITY,
            false => tiling.target_ms / self.worst_ms.max(1e-9),
        }
    }
}

/// Threads of the tile after one that took `ms`: toward the target, at most doubling. A tile cut by the edge of the
/// rectangle gives the device's speed, but no bound on the size of a tile.
fn next_aim(tiling: Tiling, threads: f64, tile: Tile, ms: f64) -> f64 {
    let taken = f64::from(tile.size[0]) * f64::from(tile.size[1]);
    let fitting = taken * tiling.target_ms / ms.max(0.01);
    fitting.min(2.0 * threads.max(taken))
}

/// Where the tile after `tile` begins; `None` after the last.
fn next([width, height]: [u32; 2], tile: Tile) -> Option<[u32; 2]> {
    let ([x, y], [columns, rows]) = (tile.origin, tile.size);
    match x + columns < width {
        true => Some([x + columns, y]),
        false => (y + rows < height).then_some([0, y + rows]),
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
        while let Some(origin) = at {
            let tile = cut(size, [8, 8, 1], origin, threads(all.len()));
            all.push(tile);
            at = next(size, tile);
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

    #[test]
    fn a_fast_device_soon_takes_a_picture_in_one_tile_and_keeps_to_it() {
        let size = [2560, 1440];
        let all = f64::from(size[0] * size[1]);
        let mut threads = f64::from(size[0] * 8);
        let mut tiles_of_run = Vec::new();
        for _ in 0..3 {
            let mut tiles = 0;
            let mut at = Some([0, 0]);
            while let Some(origin) = at {
                let tile = cut(size, [8, 8, 1], origin, threads);
                let share = f64::from(tile.size[0] * tile.size[1]) / all;
                threads = next_aim(Tiling::BATCH, threads, tile, 5.0 * share);
                at = next(size, tile);
                tiles += 1;
            }
            tiles_of_run.push(tiles);
        }
        assert_eq!(tiles_of_run[1..], [1, 1], "{tiles_of_run:?}");
    }

    #[test]
    fn tiles_that_nobody_waits_for_are_cut_for_the_dearest_rows() {
        let rows = |rows: u32| Tile {
            origin: [0, 0],
            size: [1000, rows],
        };
        let mut taken = Taken::default();
        taken.add(rows(20), 400.0);
        taken.add(rows(160), 40.0);
        let threads = taken.most_threads(Tiling::BATCH);
        assert!((threads - 20_000.0).abs() < 1e-6, "{threads}");
        let mut short = Taken::default();
        short.add(rows(20), 4.0);
        assert_eq!(short.most_threads(Tiling::BATCH), f64::INFINITY);
    }

    #[test]
    fn a_slow_device_is_given_tiles_of_the_aimed_time() {
        let size = [2560, 1440];
        let tile = cut(size, [8, 8, 1], [0, 0], 2560.0 * 400.0);
        let aim = next_aim(Tiling::BATCH, 2560.0 * 400.0, tile, 1600.0);
        assert_eq!(aim, 2560.0 * 100.0);
    }
}
