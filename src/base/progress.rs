//! How a long render tells how far it is, and is stopped.

use std::ops::ControlFlow;

/// Told the finished share, 0…1, after every tile; `Break` stops the render.
pub type Progress<'a> = &'a mut dyn FnMut(f64) -> ControlFlow<()>;

/// Progress that is not shown and stops nothing.
pub fn unwatched(_share: f64) -> ControlFlow<()> {
    ControlFlow::Continue(())
}
