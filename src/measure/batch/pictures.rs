//! Pictures of a report folder: linear EXR and tone-mapped PNG of truths and cells, false-colour differences.

use super::store::Store;
use crate::error::Result;
use crate::frame::{Exposure, Frame, false_colour, tone_map, write_frame, write_png};
use crate::metrics::{DIFF_SCALE, difference_picture, mean_sun};
use serde_json::{Map, Value};

/// Writes a frame as `images/NAME.exr` and, at the exposure of `truth`, as `images/NAME.png`; returns both paths.
pub(super) fn write_picture(
    store: &Store,
    name: &str,
    truth: &Frame,
    frame: &Frame,
) -> Result<Map<String, Value>> {
    let (exr, png) = (format!("images/{name}.exr"), format!("images/{name}.png"));
    write_frame(&store.path(&exr), frame)?;
    let pixels = tone_map(frame, Exposure::from_reference(truth));
    write_png(&store.path(&png), frame.width, frame.height, &pixels)?;
    Ok([("exr", exr), ("png", png)]
        .map(|(key, path)| (key.to_owned(), path.into()))
        .into_iter()
        .collect())
}

/// [`write_picture`], and `images/NAME-diff.png` with the signed error.
pub(super) fn write_compared(
    store: &Store,
    name: &str,
    truth: &Frame,
    frame: &Frame,
) -> Result<Map<String, Value>> {
    let mut files = write_picture(store, name, truth, frame)?;
    let diff = format!("images/{name}-diff.png");
    let pixels = difference_picture(truth, frame)?;
    write_png(&store.path(&diff), frame.width, frame.height, &pixels)?;
    files.insert("diff_png".to_owned(), diff.into());
    files.insert("diff_scale".to_owned(), DIFF_SCALE.into());
    Ok(files)
}

/// Writes the parts of a cell's error as `images/NAME-PART.png` at the scale of its difference; adds them to `files`.
pub(super) fn write_parts(
    store: &Store,
    name: &str,
    truth: &Frame,
    parts: &[Vec<f32>; 3],
    files: &mut Map<String, Value>,
) -> Result<()> {
    let scale = DIFF_SCALE * mean_sun(truth)? as f32;
    for (part, delta) in ["model", "sampling", "precision"].into_iter().zip(parts) {
        let path = format!("images/{name}-{part}.png");
        let pixels = false_colour(truth.width, truth.height, delta, scale);
        write_png(&store.path(&path), truth.width, truth.height, &pixels)?;
        files.insert(format!("{part}_png"), path.into());
    }
    Ok(())
}
