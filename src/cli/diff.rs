//! `occlab diff`.

use super::{print_path, say};
use occlab::Error;
use occlab::frame::{PictureFile, false_colour, read_picture, write_png};
use occlab::metrics::{compare, delta_luminance, mean_sun};
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(clap::Args)]
pub struct Diff {
    /// The picture taken for true: EXR or PNG; FILE.exr:NAME takes a layer or part. An EXR is compared over its display
    /// window: outside its data window there is nothing, overscan is cut.
    reference: PathBuf,
    /// The picture compared with it.
    test: PathBuf,
    /// Signed difference: blue = too dark, red = too bright.
    #[arg(long, short, value_name = "FILE.png")]
    out: Option<PathBuf>,
    /// Difference, as a multiple of the reference's mean, that gets the end colours.
    #[arg(long, default_value_t = 1.0)]
    scale: f32,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

impl Diff {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let (reference, test) = (read_picture(&self.reference)?, read_picture(&self.test)?);
        for note in notes(&reference, &test) {
            eprintln!("{note}");
        }
        let (reference, test) = (reference.frame, test.frame);
        let comparison = compare(&reference, &test).map_err(Error::from)?;
        let mut numbers = serde_json::to_value(comparison.error)?;
        numbers["cloud_pixel_fraction"] = comparison.cloud_pixel_fraction.into();
        if self.json {
            say(serde_json::to_string_pretty(&numbers)?)?;
        } else if let Some(map) = numbers.as_object() {
            for (name, value) in map.iter().filter(|(_, v)| !v.is_null()) {
                say(format!("{name:<22} {value}"))?;
            }
        }
        if let Some(out) = &self.out {
            let scale = self.scale * mean_sun(&reference).map_err(Error::from)? as f32;
            let delta = delta_luminance(&reference, &test)?;
            write_png(
                out,
                reference.width,
                reference.height,
                &false_colour(reference.width, reference.height, &delta, scale),
            )?;
            print_path(out)?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Notes on how the two pictures were read and aligned.
fn notes(reference: &PictureFile, test: &PictureFile) -> Vec<String> {
    let mut notes = reference.notes.clone();
    notes.extend(
        test.notes
            .iter()
            .filter(|n| !reference.notes.contains(n))
            .cloned(),
    );
    if reference.corner != test.corner {
        let at = |[x, y]: [i32; 2]| format!("({x}, {y})");
        notes.push(format!(
            "the pictures begin at {} and {} of their files' coordinates: compared corner on corner",
            at(reference.corner),
            at(test.corner)
        ));
    }
    notes
}
