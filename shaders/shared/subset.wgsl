// The subset of pixels that a frame marches: one pixel of every block.

struct Subset {
    block: vec2u,    // width and height, pixels
    offset: vec2u,   // of the marched pixel inside a block of the first row
    shear: u32,      // columns that it lies further right in each next row of blocks
}

// The pixel of a block, counted in blocks, that is marched.
fn marched_pixel(pixels: Subset, index: vec2u) -> vec2u {
    let column = (pixels.offset.x + pixels.shear * index.y) % pixels.block.x;
    return pixels.block * index + vec2u(column, pixels.offset.y);
}

// Whether a pixel is marched in this frame.
fn is_marched(pixels: Subset, pixel: vec2u) -> bool {
    return all(marched_pixel(pixels, pixel / pixels.block) == pixel);
}
