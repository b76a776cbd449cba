//! `occlab` measures how clouds shadow themselves.
//!
//! World axes: y up, right-handed, origin on the ground under the scene's centre. Units: metres, m⁻¹, degrees in files
//! and radians in code, linear radiance with sRGB primaries.
//!
//! Render one picture, on a device or, where there is none, by the oracle:
//!
//! ```no_run
//! # fn main() -> occlab::Result<()> {
//! use occlab::{backend::{Backend, Choice}, config::load_scene, frame::write_frame};
//! use occlab::{occlusion::MethodSetup, progress::unwatched, scene::ImageSize};
//! let scene = load_scene("configs/scenes/cumulus.json".as_ref())?;
//! let setup = MethodSetup::defaults("bsm")?.with("resolution", "256")?;
//! let image = ImageSize { width: 320, height: 180 };
//! let backend = Backend::open(Choice::Auto, None)?;
//! let (frame, times) = backend.render(&scene, image, &setup, &mut unwatched)?;
//! println!("{}: march {:?} ms", backend.environment().adapter, times.march);
//! write_frame("bsm.exr".as_ref(), &frame)?;
//! # Ok(())
//! # }
//! ```
//!
//! The same picture in f64, from the equations instead of the shaders:
//!
//! ```no_run
//! # fn main() -> occlab::Result<()> {
//! # let (scene, setup): (occlab::scene::Scene, occlab::occlusion::MethodSetup) = todo!();
//! # let image = occlab::scene::ImageSize { width: 320, height: 180 };
//! use occlab::{oracle::{Options, Oracle}, progress::unwatched};
//! let oracle = Oracle::new(&scene, image)?;
//! let (frame, counts) = oracle.prepare(&setup, Options::default())?.render(&mut unwatched)?;
//! # Ok(())
//! # }
//! ```
//!
//! Measure an experiment and read what was recorded:
//!
//! ```no_run
//! # fn main() -> occlab::Result<()> {
//! use occlab::{backend::{Backend, Choice}, batch, config::load_experiment, report};
//! use std::ops::ControlFlow;
//! let experiment = load_experiment("configs/quick.json".as_ref())?;
//! let backend = Backend::open(Choice::Auto, None)?;
//! let folder = "reports/quick".as_ref();
//! let go_on = &mut |event: batch::Event| { println!("{event:?}"); ControlFlow::Continue(()) };
//! let records = batch::run(&experiment, &backend, folder, None, go_on)?;
//! report::write(folder, &records)?;
//! for cell in &records.cells {
//!     if let Some(result) = &cell.result {
//!         println!("{} {:?}: rel_rmse {}", cell.method, cell.params, result.error.rel_rmse);
//!     }
//! }
//! # Ok(())
//! # }
//! ```
//!
#![doc = include_str!("ARCHITECTURE.md")]
pub mod live;
#[cfg(feature = "ui")]
pub mod ui;

#[doc(inline)]
pub use occlab_output::*;
