//! GPU time of compute passes, by timestamp queries at their begin and end.

use super::context::Gpu;
use super::readback::read_buffer;
use crate::error::Result;

/// Two timestamps for one pass at a time.
pub struct Timer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

impl Timer {
    /// `None` where the adapter has no timestamps: times are then "n/a".
    pub fn new(gpu: &Gpu) -> Option<Self> {
        gpu.has_timestamps().then(|| Self {
            queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("pass times"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: gpu.empty_buffer(
                "pass times",
                256,
                wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            ),
        })
    }

    /// For `ComputePassDescriptor::timestamp_writes`.
    pub fn writes(&self) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        }
    }

    /// Records the copy of the timestamps; after the pass, in the same encoder.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
    }

    /// Duration of the last submitted pass, ms; waits for it.
    pub fn elapsed_ms(&self, gpu: &Gpu) -> Result<f64> {
        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&read_buffer(gpu, &self.resolved, 16)?);
        let span = ticks[1].saturating_sub(ticks[0]) as f64;
        Ok(span * f64::from(gpu.queue.get_timestamp_period()) * 1e-6)
    }
}
