//! `occlab` measures how clouds shadow themselves.
//!
//! ```text
//! config ─► scene ─► density ─► occlusion ─► raymarch ─► frame ─► metrics ─► batch ─► report
//! (JSON)   (metres)  (field)   (strategy)   (linear HDR)         (numbers)  (records) (charts, page)
//! ```
//!
//! [`oracle`] renders the same scenes and methods in f64 on the CPU: the independent check. [`backend`] is the door to
//! both: a device, or the oracle where there is none. [`study`] stands behind the report: a published comparison done
//! again, from a file of experiments, charts and claims. [`live`] renders while somebody changes their mind; the window
//! (`ui`) only shows what it sends.
//!
//! Dependencies point right to left only. World axes: y up, right-handed, origin on the ground under the scene's
//! centre. Units: metres, m⁻¹, degrees in files and radians in code, linear radiance with sRGB primaries.

#![deny(unsafe_code)]

pub mod backend;
pub mod batch;
pub mod config;
#[cfg(test)]
#[path = "../tests/hostile/damage.rs"]
mod damage;
pub mod density;
pub mod error;
pub mod frame;
pub mod gpu;
pub mod live;
pub mod metrics;
pub mod occlusion;
pub mod oracle;
pub mod probe;
pub mod provenance;
pub mod raymarch;
pub mod report;
pub mod scene;
pub mod stability;
pub mod study;
#[cfg(feature = "ui")]
pub mod ui;

pub use error::{Error, Result};
