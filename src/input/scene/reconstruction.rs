//! Description of a reconstruction, without its implementation; the registry is `reconstruct`.

use super::{ImageSize, Pattern};
use crate::error::{Error, Result};
use serde::{Serialize, Serializer};

/// A reconstruction: how pictures are made of the pixels that frames march. Records and experiments hold its id.
#[derive(Debug)]
pub struct ReconstructionInfo {
    /// Short name in JSON and in reports.
    pub id: &'static str,
    /// Full name.
    pub title: &'static str,
    /// What is marched and where the rest comes from, in a clause.
    pub brief: &'static str,
    /// The same in sentences that name the source, for the schema of experiments.
    pub doc: &'static str,
    /// What a frame does, in sentences, for the page of a report.
    pub frame: &'static str,
    /// Authors and year; empty where there is nothing to cite.
    pub citation: &'static str,
    /// WGSL files of the passes after the march, below `shaders/`.
    pub shaders: &'static [&'static str],
    /// Which pixels frames march.
    pub pattern: Pattern,
    /// Width and height of the smallest picture.
    pub smallest: [u32; 2],
    /// Data that a frame takes from earlier ones; `None` where each picture is made of its own frame alone.
    pub history: Option<HistoryInfo>,
    /// Convergence of the picture while the camera is at rest.
    pub rest: RestInfo,
}

/// Data that a sequence of frames keeps from one to the next.
#[derive(Clone, Copy, Debug)]
pub struct HistoryInfo {
    /// Name of the data, to follow "bytes of".
    pub what: &'static str,
    /// Bytes a pixel.
    pub pixel_bytes: u64,
}

/// Convergence of the picture while the camera is at rest.
#[derive(Clone, Copy, Debug)]
pub struct RestInfo {
    /// Frames after which the picture no longer changes, at least 1.
    pub frames: u32,
    /// Whether the picture then equals that of marching every pixel, bit for bit.
    pub exact: bool,
}

impl ReconstructionInfo {
    /// Id of the reconstruction that marches every pixel: the one of experiments and records that name none.
    pub const FULL: &'static str = "full";

    /// Whether it is the one that marches every pixel.
    pub fn is_full(&self) -> bool {
        self.id == Self::FULL
    }

    /// Bytes of history for a sequence of pictures of this size.
    pub fn history_bytes(&self, image: ImageSize) -> u64 {
        let pixels = u64::from(image.width) * u64::from(image.height);
        self.history
            .map_or(0, |history| pixels.saturating_mul(history.pixel_bytes))
    }

    /// Refuses pictures that are too small.
    pub fn check_size(&self, image: ImageSize) -> Result<()> {
        let [width, height] = self.smallest;
        if image.width >= width && image.height >= height {
            return Ok(());
        }
        let problem = format!(
            "{} needs {width} × {height} pixels, the picture has {} × {}",
            self.id, image.width, image.height
        );
        let remedy = "Choose a larger image, or `\"reconstruct\": \"full\"`.";
        Err(Error::input("image", problem, remedy))
    }

    /// The share of the pixels that a frame marches, in words: `a quarter`.
    pub fn share(&self) -> String {
        match self.pattern.one_in() {
            1 => "all".to_owned(),
            2 => "half".to_owned(),
            3 => "a third".to_owned(),
            4 => "a quarter".to_owned(),
            n => format!("one in {n}"),
        }
    }
}

impl PartialEq for ReconstructionInfo {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

impl Eq for ReconstructionInfo {}

impl Serialize for ReconstructionInfo {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.id)
    }
}
