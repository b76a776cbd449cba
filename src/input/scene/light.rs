//! Medium, sun, sky and ambient as a scene describes them.

use super::{MAX_MAGNITUDE, Problem, check, check_all};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the medium interacts with light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Medium {
    /// Extinction at density 1, m⁻¹. Water cloud: 0.04–0.06 (OPAC, Hess et al. 1998).
    /// For a volume that stores extinction in km⁻¹ this is 0.001.
    #[serde(default = "default_extinction")]
    pub extinction_per_m: f64,
    /// Single-scattering albedo, 0…1.
    #[serde(default = "default_albedo")]
    pub albedo: f64,
    /// Henyey–Greenstein lobes; weights must sum to 1.
    #[serde(default = "default_phase")]
    pub phase: Vec<Lobe>,
    /// Factor on the singly scattered sunlight that stands in for the higher orders of scattering in pictures.
    /// The factor scales every method and the truth alike, so that relative errors do not depend on it.
    #[serde(default = "default_gain")]
    pub sun_gain: f64,
}

/// One Henyey–Greenstein lobe (Henyey & Greenstein 1941).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lobe {
    /// Mean cosine, −0.999…0.999; > 0 scatters forward, bright when looking toward the sun.
    pub g: f64,
    /// Share of the scattered light, 0…1.
    pub weight: f64,
}

/// The sun: a directional light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sun {
    /// Elevation above the horizon at the scene's origin, degrees, > 0 and ≤ 90.
    pub elevation_deg: f64,
    /// Azimuth of the direction toward the sun, degrees: 0 is +x, 90 is +z.
    pub azimuth_deg: f64,
    /// Irradiance on a plane perpendicular to the beam, RGB. Absent = derived from the sky's turbidity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub irradiance: Option<[f64; 3]>,
}

/// Sky radiance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Sky {
    /// Preetham, Shirley & Smits 1999; radiance in kcd/m².
    Preetham {
        /// Turbidity, 2 (clear) … 6 (haze).
        turbidity: f64,
        /// Diffuse reflectance of the ground below the horizon, 0…1.
        ground_albedo: f64,
    },
}

/// Ambient radiance at a sample: linear in height from `base` to `top`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Ambient {
    /// The same radiance everywhere (furnace test).
    Uniform {
        /// RGB radiance.
        radiance: [f64; 3],
    },
    /// Multiples of the sky's mean radiance.
    Sky {
        /// Multiple at the layer's base.
        base: f64,
        /// Multiple at the layer's top.
        top: f64,
    },
}

fn default_extinction() -> f64 {
    0.05
}
fn default_albedo() -> f64 {
    1.0
}
fn default_gain() -> f64 {
    1.0
}
fn default_phase() -> Vec<Lobe> {
    vec![
        Lobe {
            g: 0.7,
            weight: 0.6,
        },
        Lobe {
            g: -0.2,
            weight: 0.4,
        },
    ]
}

impl Medium {
    pub(super) fn validate(&self) -> Result<(), Problem> {
        check(
            "/medium/extinction_per_m",
            self.extinction_per_m,
            "0 or more, m⁻¹",
            |v| (0.0..=1e6).contains(&v),
        )?;
        check("/medium/albedo", self.albedo, "0…1", |v| {
            (0.0..=1.0).contains(&v)
        })?;
        check("/medium/sun_gain", self.sun_gain, "above 0", |v| {
            v > 0.0 && v <= 1e6
        })?;
        if self.phase.is_empty() || self.phase.len() > 2 {
            return Err(Problem::new(
                "/medium/phase",
                format!("{} lobes, allowed are 1 or 2", self.phase.len()),
            ));
        }
        for (i, lobe) in self.phase.iter().enumerate() {
            check(
                &format!("/medium/phase/{i}/g"),
                lobe.g,
                "−0.999…0.999 (at ±1 the lobe is a Dirac peak)",
                |v| v.abs() <= 0.999,
            )?;
            check(
                &format!("/medium/phase/{i}/weight"),
                lobe.weight,
                "0…1",
                |v| (0.0..=1.0).contains(&v),
            )?;
        }
        let sum: f64 = self.phase.iter().map(|l| l.weight).sum();
        check("/medium/phase", sum, "weights that sum to 1", |v| {
            (v - 1.0).abs() < 1e-6
        })
    }
}

impl Sun {
    pub(super) fn validate(&self, has_sky: bool) -> Result<(), Problem> {
        check(
            "/sun/elevation_deg",
            self.elevation_deg,
            "above 0° (the sun must be above the horizon) up to 90°",
            |v| v > 0.0 && v <= 90.0,
        )?;
        check(
            "/sun/azimuth_deg",
            self.azimuth_deg,
            "−360…360°",
            |v| v.abs() <= 360.0,
        )?;
        match &self.irradiance {
            Some(rgb) => check_all("/sun/irradiance", rgb, "0…1e12", |v| {
                (0.0..=MAX_MAGNITUDE).contains(&v)
            }),
            None if has_sky => Ok(()),
            None => Err(Problem::new(
                "/sun/irradiance",
                "without a sky the sun's irradiance must be given",
            )),
        }
    }

    /// Unit vector from the scene toward the sun.
    pub fn direction(&self) -> glam::DVec3 {
        let (elevation, azimuth) = (
            self.elevation_deg.to_radians(),
            self.azimuth_deg.to_radians(),
        );
        glam::DVec3::new(
            elevation.cos() * azimuth.cos(),
            elevation.sin(),
            elevation.cos() * azimuth.sin(),
        )
    }
}

impl Sky {
    pub(super) fn validate(&self) -> Result<(), Problem> {
        let Self::Preetham {
            turbidity,
            ground_albedo,
        } = self;
        check("/sky/preetham/turbidity", *turbidity, "1.7…10", |v| {
            (1.7..=10.0).contains(&v)
        })?;
        check(
            "/sky/preetham/ground_albedo",
            *ground_albedo,
            "0…1",
            |v| (0.0..=1.0).contains(&v),
        )
    }
}

impl Ambient {
    pub(super) fn validate(&self, has_sky: bool) -> Result<(), Problem> {
        match self {
            Self::Uniform { radiance } => {
                check_all("/ambient/uniform/radiance", radiance, "0…1e12", |v| {
                    (0.0..=MAX_MAGNITUDE).contains(&v)
                })
            }
            Self::Sky { .. } if !has_sky => Err(Problem::new(
                "/ambient/sky",
                "needs a `sky` to take its radiance from",
            )),
            Self::Sky { base, top } => check_all("/ambient/sky", &[*base, *top], "0…10", |v| {
                (0.0..=10.0).contains(&v)
            }),
        }
    }
}
