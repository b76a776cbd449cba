//! Containers: the region that a march integrates over.

mod geometry;

pub use geometry::Intervals;

use crate::problem::{Problem, check, check_all};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The region that may hold medium.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Container {
    /// Spherical shell above a spherical ground that blocks sun and view.
    Shell {
        /// Radius of the ground sphere, metres, 1e4…1e9 (thesis M: 200 000).
        planet_radius_m: f64,
        /// Height of the layer's base above ground, metres, > 0.
        base_m: f64,
        /// Height of the layer's top above ground, metres.
        top_m: f64,
    },
    /// Axis-aligned box; no ground.
    Box {
        /// Smallest corner, metres.
        min_m: [f64; 3],
        /// Largest corner, metres.
        max_m: [f64; 3],
    },
}

impl Container {
    /// Checks ranges and order; pointers start at `/container`.
    pub fn validate(&self) -> Result<(), Problem> {
        match self {
            Self::Shell {
                planet_radius_m,
                base_m,
                top_m,
            } => {
                check(
                    "/container/shell/planet_radius_m",
                    *planet_radius_m,
                    "1e4…1e9 m",
                    |v| (1e4..=1e9).contains(&v),
                )?;
                check("/container/shell/base_m", *base_m, "above 0 m", |v| v > 0.0)?;
                check(
                    "/container/shell/top_m",
                    *top_m,
                    "above base_m and at most a tenth of the planet's radius",
                    |v| v > *base_m && v <= planet_radius_m / 10.0,
                )
            }
            Self::Box { min_m, max_m } => {
                check_all("/container/box/min_m", min_m, "finite", |v| v.abs() < 1e9)?;
                check_all("/container/box/max_m", max_m, "finite", |v| v.abs() < 1e9)?;
                (0..3).try_for_each(|i| {
                    check(
                        "/container/box/max_m",
                        max_m[i],
                        "above min_m on every axis",
                        |v| v > min_m[i],
                    )
                })
            }
        }
    }

    /// Heights of base and top: above ground in a shell, world y in a box, metres.
    pub fn height_range_m(&self) -> (f64, f64) {
        match self {
            Self::Shell { base_m, top_m, .. } => (*base_m, *top_m),
            Self::Box { min_m, max_m } => (min_m[1], max_m[1]),
        }
    }
}
