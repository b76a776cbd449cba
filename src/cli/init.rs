//! `occlab init`.

use super::say;
use occlab::config::shipped::{Copied, write_out};
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(clap::Args)]
pub struct Init {
    /// Folder to work in, which gets a folder `configs`.
    #[arg(value_name = "DIR", default_value = ".")]
    folder: PathBuf,
}

impl Init {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let files = write_out(&self.folder)?;
        for (path, outcome) in &files {
            let what = match outcome {
                Copied::Written => "written",
                Copied::Same => "there already",
                Copied::Kept => "KEPT: yours differs from the built-in one",
            };
            say(format!("{}: {what}", path.display()))?;
        }
        let count = |wanted| {
            files
                .iter()
                .filter(|(_, outcome)| *outcome == wanted)
                .count()
        };
        let (written, kept) = (count(Copied::Written), count(Copied::Kept));
        eprintln!(
            "{written} of {} files written, {kept} of yours kept as they are; nothing was overwritten",
            files.len()
        );
        Ok(ExitCode::SUCCESS)
    }
}
