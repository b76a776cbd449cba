//! Provably empty space: a grid of cubic cells with the Chebyshev distance to the nearest cell that may hold medium.
//! See `shaders/shared/occupancy.wgsl` for how marches use it.

use crate::gpu::{Gpu, Inputs, Resource, UniformValue};
use rayon::prelude::*;

/// The grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Occupancy {
    /// Cells along x, y, z.
    pub size: [usize; 3],
    /// Periodic in x and z.
    pub wrap: bool,
    /// Field coordinates of the corner of cell (0, 0, 0), metres.
    pub origin_m: [f64; 3],
    /// Edge of a cell, metres.
    pub cell_m: f64,
    /// 0 = may hold medium; d ≥ 1 = all cells within distance d − 1 are empty. x fastest, then y, then z.
    pub rings: Vec<u8>,
}

impl Occupancy {
    /// From a conservative predicate over cells (`true` = may hold medium).
    pub fn new(
        size: [usize; 3],
        wrap: bool,
        origin_m: [f64; 3],
        cell_m: f64,
        occupied: impl Fn(usize, usize, usize) -> bool + Sync,
    ) -> Self {
        let [nx, ny, _] = size;
        let mut rings = vec![255_u8; size.iter().product()];
        rings
            .par_chunks_mut(nx * ny)
            .enumerate()
            .for_each(|(z, slab)| {
                for (y, row) in slab.chunks_mut(nx).enumerate() {
                    for (x, cell) in row.iter_mut().enumerate() {
                        if occupied(x, y, z) {
                            *cell = 0;
                        }
                    }
                }
            });
        spread_rings(&mut rings, size, wrap);
        Self {
            size,
            wrap,
            origin_m,
            cell_m,
            rings,
        }
    }

    /// Share of cells that are provably empty.
    pub fn empty_fraction(&self) -> f64 {
        self.rings.iter().filter(|r| **r > 0).count() as f64 / self.rings.len().max(1) as f64
    }

    /// Uniform, texture and sampler for `shared/occupancy.wgsl`.
    pub fn upload(&self, gpu: &Gpu, inputs: &mut Inputs) {
        let size = self.size.map(|n| n as u32);
        let format = wgpu::TextureFormat::R8Unorm;
        let view = gpu.texture_3d("occupancy", format, size, &self.rings);
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("occupancy"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_w: wgpu::AddressMode::Repeat,
            ..Default::default()
        });
        inputs.resource("occupancy_cells", Resource::View(view));
        inputs.resource("occupancy_sampler", Resource::Sampler(sampler));
        inputs.uniform(
            "occupancy",
            [
                ("size", UniformValue::Vec3(self.size.map(|n| n as f32))),
                ("wrap", UniformValue::U32(self.wrap.into())),
                (
                    "origin_m",
                    UniformValue::Vec3(self.origin_m.map(|v| v as f32)),
                ),
                ("cell_m", UniformValue::F32(self.cell_m as f32)),
            ],
        );
    }
}

/// Chebyshev distance transform, one axis after the other: d(i) = min over j of max(|i − j|, d(j)).
fn spread_rings(rings: &mut [u8], [nx, ny, nz]: [usize; 3], wrap: bool) {
    rings.par_chunks_mut(nx * ny).for_each(|slab| {
        for row in slab.chunks_mut(nx) {
            let line = row.to_vec();
            (0..nx).for_each(|x| row[x] = nearest(x, nx, wrap, |i| line[i]));
        }
        let plane = slab.to_vec();
        for y in 0..ny {
            for x in 0..nx {
                slab[y * nx + x] = nearest(y, ny, false, |i| plane[i * nx + x]);
            }
        }
    });
    let source = rings.to_vec();
    rings
        .par_chunks_mut(nx * ny)
        .enumerate()
        .for_each(|(z, slab)| {
            for (i, cell) in slab.iter_mut().enumerate() {
                *cell = nearest(z, nz, wrap, |k| source[k * nx * ny + i]);
            }
        });
}

fn nearest(at: usize, n: usize, wrap: bool, value: impl Fn(usize) -> u8) -> u8 {
    let mut best = usize::from(value(at));
    let mut distance = 1;
    while distance < best && distance < n {
        let low = at
            .checked_sub(distance)
            .or_else(|| wrap.then(|| at + n - distance));
        let high = Some(at + distance)
            .filter(|i| *i < n)
            .or_else(|| wrap.then(|| (at + distance) % n));
        for i in [low, high].into_iter().flatten() {
            best = best.min(usize::from(value(i)).max(distance));
        }
        distance += 1;
    }
    best as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance to the nearest occupied cell by looking at all of them.
    fn brute(
        size: [usize; 3],
        wrap: bool,
        occupied: &dyn Fn(usize, usize, usize) -> bool,
        at: [usize; 3],
    ) -> usize {
        let gap = |a: usize, b: usize, n: usize, wrap: bool| {
            let d = a.abs_diff(b);
            if wrap { d.min(n - d) } else { d }
        };
        let mut best = 255;
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    if occupied(x, y, z) {
                        let d = gap(at[0], x, size[0], wrap)
                            .max(gap(at[1], y, size[1], false))
                            .max(gap(at[2], z, size[2], wrap));
                        best = best.min(d);
                    }
                }
            }
        }
        best
    }

    #[test]
    fn rings_are_chebyshev_distances_with_and_without_wrap() {
        let size = [9, 5, 7];
        let occupied = |x: usize, y: usize, z: usize| (x * 7 + y * 13 + z * 29) % 61 == 3;
        for wrap in [false, true] {
            let grid = Occupancy::new(size, wrap, [0.0; 3], 1.0, occupied);
            for (i, ring) in grid.rings.iter().enumerate() {
                let at = [i % 9, i / 9 % 5, i / 45];
                assert_eq!(
                    usize::from(*ring),
                    brute(size, wrap, &occupied, at),
                    "cell {at:?}, wrap {wrap}"
                );
            }
        }
    }

    #[test]
    fn an_empty_grid_is_far_from_everything() {
        let grid = Occupancy::new([4, 4, 4], true, [0.0; 3], 1.0, |_, _, _| false);
        assert!(grid.rings.iter().all(|r| *r == 255));
        assert_eq!(grid.empty_fraction(), 1.0);
    }
}
