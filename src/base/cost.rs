//! Cost of a picture: pass times in ms, counts of density samples and look-ups, memory in bytes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Times of one run, ms; GPU times are `None` where the adapter has no timestamps, or gave invalid ones.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassTimes {
    /// The map pass; `None` without a map.
    pub generate: Option<f64>,
    /// The view march, all tiles.
    pub march: Option<f64>,
    /// The reconstruction passes after the view march; `None` where there are none.
    pub reconstruct: Option<f64>,
    /// CPU time from submission to completion; for frames in flight together, an equal share each, command recording
    /// included.
    pub wall: f64,
    /// Timestamps of some pass are invalid (0, reversed, left over from earlier work, or longer than the wall time):
    /// that pass and the total have no time.
    pub refused: bool,
}

impl PassTimes {
    /// Sum of the passes; `None` where one that ran has no time.
    pub fn total(&self) -> Option<f64> {
        let others = [self.generate, self.reconstruct].into_iter().flatten();
        let march = self.march.filter(|_| !self.refused)?;
        Some(march + others.sum::<f64>())
    }
}

/// Work counted for one picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// Density samples.
    pub samples: Samples,
    /// Light look-ups in a map.
    pub look_ups: u64,
    /// Look-ups that fell outside the map and were marched instead.
    pub fallbacks: u64,
}

/// Whether density samples and look-ups are counted; counting needs a render of its own, which is not timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counting {
    /// Count.
    On,
    /// Only render.
    Off,
}

/// Density samples taken for one picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Samples {
    /// By view rays.
    pub view: u64,
    /// By light rays (secondary marches, fallbacks).
    pub light: u64,
    /// By the map pass.
    pub map: u64,
}

/// Memory of a method, bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Memory {
    /// Values × bytes a value × texels, and what else the view march reads.
    pub payload_bytes: u64,
    /// The textures and buffers as allocated.
    pub map_bytes: u64,
    /// Growth that wgpu's allocator reports; `null` where the backend does not report.
    pub allocator_bytes: Option<u64>,
    /// Part of `map_bytes` that is needed only while the map is made; left out of a record where it is 0.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(skip)]
    pub temporary_bytes: u64,
}

fn is_zero(bytes: &u64) -> bool {
    *bytes == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_total_is_every_pass_and_nothing_without_a_march() {
        let mut times = PassTimes {
            generate: Some(1.0),
            march: Some(2.0),
            reconstruct: Some(4.0),
            wall: 100.0,
            refused: false,
        };
        assert_eq!(times.total(), Some(7.0));
        times.generate = None;
        assert_eq!(times.total(), Some(6.0));
        times.march = None;
        assert_eq!(times.total(), None);
    }
}
