//! Buffers and textures copied to the CPU.

use super::context::Gpu;
use crate::error::{Error, Result};

/// The first `size` bytes of a buffer with `COPY_SRC`; waits for the queue.
pub fn read_buffer(gpu: &Gpu, source: &wgpu::Buffer, size: u64) -> Result<Vec<u8>> {
    let staging = gpu.empty_buffer(
        "read-back",
        size,
        wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
    );
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(source, 0, &staging, 0, size);
    gpu.queue.submit([encoder.finish()]);
    map(gpu, &staging)
}

/// Texels of a texture (all layers or slices), rows tightly packed, x fastest.
pub fn read_texture(gpu: &Gpu, source: &wgpu::Texture) -> Result<Vec<u8>> {
    let size = source.size();
    let texel_bytes = source
        .format()
        .block_copy_size(None)
        .ok_or_else(|| Error::defect("read-back", "the texture's format cannot be read back"))?;
    let row_bytes = size.width * texel_bytes;
    let padded_bytes = row_bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let total =
        u64::from(padded_bytes) * u64::from(size.height) * u64::from(size.depth_or_array_layers);
    let staging = gpu.empty_buffer(
        "read-back",
        total,
        wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
    );
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        source.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &staging,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(padded_bytes),
                rows_per_image: Some(size.height),
            },
        },
        size,
    );
    gpu.queue.submit([encoder.finish()]);
    let padded = map(gpu, &staging)?;
    Ok(padded
        .chunks(padded_bytes as usize)
        .flat_map(|row| &row[..row_bytes as usize])
        .copied()
        .collect())
}

fn map(gpu: &Gpu, staging: &wgpu::Buffer) -> Result<Vec<u8>> {
    let (send, receive) = std::sync::mpsc::channel();
    staging.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver lives until the wait below is over; a closed channel then means the wait failed.
        let _ = send.send(result);
    });
    gpu.wait()?;
    let failed = |problem: String| {
        Error::gpu(
            problem,
            "The device may have been lost; run the command again.",
        )
    };
    receive
        .recv()
        .map_err(|e| failed(e.to_string()))?
        .map_err(|e| failed(e.to_string()))?;
    let bytes = staging
        .get_mapped_range(..)
        .map_err(|e| failed(e.to_string()))?
        .to_vec();
    staging.unmap();
    Ok(bytes)
}
