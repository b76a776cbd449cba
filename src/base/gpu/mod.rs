//! The wgpu layer below the passes: device, shader composition, kernels bound by name, timing, read-back.

mod clock_probe;
mod clock_watch;
mod clocks;
mod context;
mod instance;
mod kernel;
mod lavapipe;
mod readback;
mod reflect;
mod shader;
mod timing;
mod uniform;

pub use clock_probe::{WarmUp, in_flight_ms};
pub use clock_watch::ClockWatch;
pub use clocks::{ClockReading, Clocks, Extent};
pub use context::{AdapterSummary, Gpu, list_adapters};
pub use kernel::{Inputs, Kernel, Resource};
pub use readback::{read_buffer, read_texture};
pub use shader::{Program, Sources, compose, compose_point};
pub use timing::{Flight, FlightTimes, PassTime, Span, Timer};
pub use uniform::{Leaf, Scalar, UniformValue, pack, struct_leaves};
