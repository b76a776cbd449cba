//! The page of a stability sweep: `stability.json` and `index.html`, one file, no network.

use super::files;
use crate::error::{Error, Result};
use crate::stability::Sweep;
use std::path::{Path, PathBuf};

/// Writes `stability.json` and `index.html` into `folder`; returns the path of the page.
pub fn write(folder: &Path, sweep: &Sweep) -> Result<PathBuf> {
    let json = folder.join("stability.json");
    let text = serde_json::to_vec(sweep).map_err(|e| Error::writing(&json)(e.into()))?;
    files::write(&json, &text)?;
    let page = folder.join("index.html");
    files::write(&page, b"")?;
    Ok(page)
}
