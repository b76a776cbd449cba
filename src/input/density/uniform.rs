//! Density field with the same value everywhere.

use super::{DensityField, DensityTwin, DeviceField, Filter, Surroundings};
use crate::container::Container;
use crate::error::Result;
use crate::gpu::{Gpu, Inputs, UniformValue};
use crate::problem::{MAX_MAGNITUDE, Problem, check};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::path::Path;

/// A homogeneous medium.
// The schema has no description here: that of `density` says the same.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline, description = "")]
pub struct Uniform {
    /// Density, ≥ 0.
    pub value: f64,
}

impl DensityField for Uniform {
    fn validate(&self, _container: &Container) -> Result<(), Problem> {
        check("/density/uniform/value", self.value, "0…1e12", |v| {
            (0.0..=MAX_MAGNITUDE).contains(&v)
        })
    }

    fn shader(&self) -> Cow<'static, str> {
        "density/uniform.wgsl".into()
    }

    fn build(&self, _gpu: &Gpu, _around: &Surroundings) -> Result<DeviceField> {
        let mut inputs = Inputs::default();
        inputs.uniform("field", [("value", UniformValue::F32(self.value as f32))]);
        Ok(DeviceField::new(self, inputs))
    }

    fn twin(
        &self,
        _container: &Container,
        _extinction_per_m: f64,
        _filter: Filter,
    ) -> Result<Option<Box<dyn DensityTwin>>> {
        Ok(Some(Box::new(Everywhere(self.value))))
    }

    fn is_uniform(&self) -> bool {
        true
    }

    fn examples(_container: &Container, _folder: &Path) -> Result<Vec<Self>> {
        Ok(vec![Self { value: 0.5 }])
    }
}

/// Twin of a uniform field.
struct Everywhere(f64);

impl DensityTwin for Everywhere {
    fn density(&self, _p: DVec3) -> f64 {
        self.0
    }
}
