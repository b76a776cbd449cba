//! Description of a method: lists, tables, colours and tests about methods are generated from it.

use crate::param::ParamSpec;

/// Description of a method.
#[derive(Clone, Copy, Debug)]
pub struct MethodInfo {
    /// Short name in JSON, on the command line and in reports.
    pub id: &'static str,
    /// Full name.
    pub title: &'static str,
    /// What a light look-up does, for tables: no full stop.
    pub summary: &'static str,
    /// Values a map texel holds, for tables: `3`, `2n + 1`; `–` without a map.
    pub texel: &'static str,
    /// Artefacts to expect in its pictures, one or two sentences.
    pub expect: &'static str,
    /// Paper, year, equation.
    pub citation: &'static str,
    /// Role in comparisons.
    pub role: Role,
    /// Colour in charts, pages and the window, `0xrrggbb` in sRGB.
    pub colour: u32,
    /// Marker in charts and pages.
    pub marker: Marker,
    /// Path of its WGSL file below `shaders/`.
    pub shader: &'static str,
    /// Text of that file.
    pub source: &'static str,
    /// Parameter lists; together they are the method's parameters.
    pub params: &'static [&'static [ParamSpec]],
    /// V never increases with depth along a light column (with look-up `nearest` and form `stable`).
    pub monotone: bool,
    /// Whether a texel stores a largest optical depth, at which V stops falling with depth.
    pub bounded: bool,
    /// Largest relative RMSE of a picture's sunlight on a device against the oracle, at the same parameters, with
    /// storage rounding emulated and without hardware filtering. Its terms: `tests/oracle_gpu.rs`.
    pub tolerance: f64,
    /// Settings that the tests check.
    pub trials: Trials,
}

impl MethodInfo {
    /// All parameters.
    pub fn specs(&self) -> impl Iterator<Item = &'static ParamSpec> {
        self.params.iter().copied().flatten()
    }

    /// Whether it is the truth, against which the others are measured.
    pub fn is_truth(&self) -> bool {
        self.role == Role::Truth
    }
}

/// Role of a method in comparisons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A renderer could use it.
    Practical,
    /// An uncompressed map: the error that no map of its steps and texels can go below. One method has this role.
    Floor,
    /// V does not depend on the cloud: the cost of the view march alone.
    Unshadowed,
    /// What all others are measured against. One method has this role.
    Truth,
}

/// Shape of a marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// Disc.
    Circle,
    /// Square.
    Square,
    /// Triangle, tip up.
    Up,
    /// Triangle, tip down.
    Down,
    /// Square on its corner.
    Diamond,
    /// Upright cross.
    Plus,
    /// Diagonal cross.
    Cross,
    /// Star with five points.
    Star,
    /// Hexagon.
    Hexagon,
}

/// Settings that the tests check, written `name=value`, separated by blanks.
#[derive(Clone, Copy, Debug)]
pub struct Trials {
    /// Pictures of a voxel volume, on a device against the oracle. Empty only where a method has no parameters.
    pub pictures: &'static [Trial],
    /// Pictures of procedural clouds, likewise. Hardware filters their noise: controls must be farther away.
    pub clouds: &'static [Trial],
    /// Values of texels, on a device against the oracle; empty without a map.
    pub texels: &'static [Trial],
    /// Settings at which V = exp(−σd) in a homogeneous medium; `{tau}` stands for the optical depth of the longest
    /// column. Empty only where V does not depend on the cloud.
    pub exact: &'static [&'static str],
}

/// A setting, and a slightly different one that the same check must refuse: the negative control.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// The setting.
    pub params: &'static str,
    /// The setting that must be told apart from it.
    pub control: &'static str,
}

/// A [`Trial`] in short.
pub const fn trial(params: &'static str, control: &'static str) -> Trial {
    Trial { params, control }
}
