//! T(d) along light columns, by the oracle on a thread of its own.

use super::Request;
use super::update::{Sender, Update};
use crate::error::{Error, Result};
use crate::occlusion::MethodSetup;
use crate::oracle::{LightColumn, Oracle};
use crate::probe::Probe;
use crate::scene::MapFit;
use std::sync::{Arc, Mutex, PoisonError};

/// Where a light column is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Where {
    /// Through the cloud seen at a pixel, counted from the top left.
    Pixel([u32; 2]),
    /// At (u, v) in `[0, 1]²` of the light map with this many texels along an edge, laid as its method does.
    Column([f64; 2], u32, MapFit),
}

/// Curves along a light column.
#[derive(Clone, Debug, PartialEq)]
pub struct Probed {
    /// Where.
    pub at: Where,
    /// The curves.
    pub probe: Probe,
    /// Depth of the point that the pixel shows, metres; `None` for a column of the map.
    pub seen_m: Option<f64>,
}

/// The last oracle, reused by the next probe of the same clouds.
pub(super) type Shared = Arc<Mutex<Option<Arc<Oracle>>>>;

/// Probes on a new thread.
pub(super) fn start(
    shared: &Shared,
    request: &Request,
    methods: Vec<MethodSetup>,
    at: Where,
    sender: Sender,
) {
    let (shared, request) = (shared.clone(), request.clone());
    std::thread::spawn(move || {
        let result = oracle(&shared, &request).and_then(|oracle| probe(&oracle, &methods, at));
        sender.send(Update::Probed {
            serial: request.serial,
            result: result.map(Arc::new).map_err(|e| e.to_string()),
        });
    });
}

fn oracle(shared: &Shared, request: &Request) -> Result<Arc<Oracle>> {
    // A poisoned lock means that making an oracle panicked: the slot still holds the one before, or none.
    let mut last = shared.lock().unwrap_or_else(PoisonError::into_inner);
    let made = match &*last {
        Some(oracle) => oracle.again(&request.scene, request.image)?,
        None => Oracle::new(&request.scene, request.image)?,
    };
    Ok(last.insert(Arc::new(made)).clone())
}

fn probe(oracle: &Oracle, methods: &[MethodSetup], at: Where) -> Result<Probed> {
    let (column, seen_m) = find(oracle, at)?;
    Ok(Probed {
        at,
        probe: Probe::of(oracle, &column, methods)?,
        seen_m,
    })
}

/// The column, and the depth of the pixel's point on it.
fn find(oracle: &Oracle, at: Where) -> Result<(LightColumn, Option<f64>)> {
    match at {
        Where::Pixel([x, y]) => {
            let point = oracle.pixel_point(x, y).ok_or_else(|| {
                Error::input(
                    format!("pixel {x}, {y}"),
                    "there is no cloud on its ray",
                    "Click a pixel that shows cloud.",
                )
            })?;
            let seen_m = oracle.light_depth_m(point);
            Ok((oracle.column_through(point), Some(seen_m)))
        }
        Where::Column([u, v], resolution, fit) => {
            let column = oracle.map_column([u, v], resolution, fit).ok_or_else(|| {
                Error::input(
                    format!("map column {u:.3}, {v:.3}"),
                    "the light there meets nothing of the layer",
                    "Click nearer to the middle of the map.",
                )
            })?;
            Ok((column, None))
        }
    }
}
