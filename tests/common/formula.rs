//! Methods along a light ray whose extinction is a formula.

use occlab::occlusion::MethodSetup;
use occlab::occlusion::rounding::Rounding;
use occlab::occlusion::twin::{Column, ColumnRules, LightRay, LookUp, Twin};

/// A light ray whose extinction is a formula.
pub struct Formula<F> {
    pub length_m: f64,
    pub extinction_per_m: F,
}

impl<F: Fn(f64) -> f64> LightRay for Formula<F> {
    fn length_m(&self) -> f64 {
        self.length_m
    }

    fn extinction_per_m(&self, s_m: f64) -> f64 {
        (self.extinction_per_m)(s_m)
    }
}

pub fn marched(setup: &MethodSetup, ray: &dyn LightRay) -> f64 {
    match setup.method.oracle(&setup.params).unwrap() {
        Twin::March(march) => march.transmittance(ray, 0.5),
        Twin::Map(_) => panic!("has a map"),
    }
}

/// V at `depth_m` of a column that is the longest of its map.
pub fn mapped(setup: &MethodSetup, ray: &dyn LightRay, depth_m: f64) -> f64 {
    let Twin::Map(map) = setup.method.oracle(&setup.params).unwrap() else {
        panic!("has no map");
    };
    let (steps, sampling) = (
        setup.params.int("steps").unwrap(),
        setup.params.choice("sampling").unwrap(),
    );
    let column = Column::march(
        ray,
        &ColumnRules::even(steps, sampling),
        None,
        ray.length_m(),
    );
    let values = map.encode(&column, &Rounding::EXACT);
    let look_up = LookUp {
        depth: depth_m / ray.length_m(),
        length: 1.0,
        depth_m: ray.length_m(),
    };
    map.transmittance(&values, look_up, &Rounding::EXACT)
}
