//! A rendered picture in linear radiance, and its files.

//mod exr_file;
//mod png_file;
//mod tonemap;

//pub use exr_file::{read_frame, write_frame};
//pub use png_file::{false_colour, write_png, FALSE_COLOUR_STOPS};
//pub use tonemap::{Exposure, tone_map};

/// One render: `width × height` pixels, row 0 at the top, linear sRGB primaries.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// RGB = full radiance (sun, ambient, background); A = opacity of the medium in `[0, 1]`.
    pub radiance: Vec<[f32; 4]>,
    /// RGB = radiance of sunlight scattered once by the medium, nothing else;
    /// A = V, the light transmittance averaged over the view ray with weight σT (0 where there is no medium).
    pub sun: Vec<[f32; 4]>,
}
