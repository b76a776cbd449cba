//! Pure functions on f32 images.
