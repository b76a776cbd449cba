//! Progress callback of a long render, which can also stop it.

use std::ops::ControlFlow;

/// Called with the finished share, 0…1, after every tile; `Break` stops the render.
pub type Progress<'a> = &'a mut dyn FnMut(f64) -> ControlFlow<()>;

/// Progress that is not shown and stops nothing.
pub fn unwatched(_share: f64) -> ControlFlow<()> {
    ControlFlow::Continue(())
}
