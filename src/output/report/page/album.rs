//! Embeds pictures of the report folder in the page, or links them.

use super::super::files;
use base64::Engine as _;
use image::imageops::{self, FilterType};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

/// Largest width of an embedded picture, px; wider ones are shrunk to it and linked to the full file.
const WIDEST: u32 = 480;
/// Budget of embedded pictures, characters of their `data:` addresses; beyond it, pictures are only linked.
const BUDGET: usize = 24 << 20;

/// A picture as the page can show it.
pub enum PagePicture {
    /// Part of the page.
    Embedded {
        /// `data:` address.
        uri: String,
        /// The full file, relative to the page.
        link: String,
        /// Width and height over which it is shown.
        size: (u32, u32),
    },
    /// Only linked, because the page's budget is used up.
    Linked {
        /// The full file, relative to the page.
        link: String,
    },
    /// Not readable, with the reason.
    Missing(String),
}

/// Reads pictures and counts the characters that they add to the page.
pub struct Album {
    folder: PathBuf,
    left: usize,
}

impl Album {
    /// Pictures of a report folder.
    pub fn new(folder: &Path) -> Self {
        Self {
            folder: folder.to_owned(),
            left: BUDGET,
        }
    }

    /// The picture a record names under `key`, embedded regardless of the budget.
    pub fn show(&mut self, files: &Map<String, Value>, key: &str) -> PagePicture {
        let name = match files.get(key) {
            Some(Value::String(name)) => name,
            _ => return PagePicture::Missing(format!("the record names no `{key}` picture")),
        };
        match self.read(name) {
            Ok((uri, size)) => {
                self.left = self.left.saturating_sub(uri.len());
                PagePicture::Embedded {
                    uri,
                    link: files::link(name),
                    size,
                }
            }
            Err(reason) => PagePicture::Missing(reason),
        }
    }

    /// [`Self::show`] while the budget allows it, else a link.
    pub fn show_if_room(&mut self, files: &Map<String, Value>, key: &str) -> PagePicture {
        let before = self.left;
        let linked = match files.get(key) {
            Some(Value::String(name)) if before == 0 && self.link(name).is_some() => {
                Some(files::link(name))
            }
            _ => None,
        };
        linked.map_or_else(
            || self.show(files, key),
            |link| PagePicture::Linked { link },
        )
    }

    /// The link to a file that exists inside the folder.
    pub fn link(&self, name: &str) -> Option<String> {
        files::inside(&self.folder, name)
            .ok()
            .filter(|p| p.is_file())
            .map(|_| files::link(name))
    }

    fn read(&self, name: &str) -> Result<(String, (u32, u32)), String> {
        let (bytes, picture) = files::picture(&self.folder, name)?;
        let (width, height) = picture.dimensions();
        if width <= WIDEST {
            return Ok((data_uri(&bytes), (width, height)));
        }
        let small_height = f64::from(height) * f64::from(WIDEST) / f64::from(width);
        let size = (WIDEST, small_height.round().max(1.0) as u32);
        let small = imageops::resize(&picture, size.0, size.1, FilterType::Triangle);
        let png = files::png(&small).map_err(|e| format!("`{name}` cannot be scaled: {e}"))?;
        Ok((data_uri(&png), size))
    }
}

fn data_uri(png: &[u8]) -> String {
    format!(
        "data:image/png;base64,{}",
        base64::engine::general_purpose::STANDARD.encode(png)
    )
}
