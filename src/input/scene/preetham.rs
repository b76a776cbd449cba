//! Daylight after Preetham, Shirley & Smits 1999, in f64.
//!
//! Sky: F(θ, γ) = (1 + A e^(B/cos θ)) (1 + C e^(Dγ) + E cos² γ) (Perez et al. 1993), one set A…E for luminance Y and
//! the chromaticities x and y; value = zenith · F(θ, γ) / F(0, θs), with θ from the zenith and γ from the sun.
//! Sun: extraterrestrial illuminance × the transmittances of the paper's appendix A.1.
//! Cost: six exponentials a direction.
//!
//! Known weakness (Zotti et al. 2007): with the sun on the horizon the sky is several times too bright. Every method
//! and the truth use the same sky, so comparisons between them hold.

use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Turbidities the sky's fit is evaluated at. Below 2 the luminance fit fails: F(0, θs) tends to 0 near T = 1.63, and
/// the whole sky, divided by it, becomes ten times brighter (Zotti et al. 2007). Above 10 the zenith luminance of a low
/// sun falls to 0 and then below (−0.2155 T + 2.4192 at θs = 90°). The sun's own extinction needs no such limit.
const SKY_TURBIDITY: (f64, f64) = (2.0, 10.0);
/// Smallest cos θ of a sky direction (elevation 0.57°): e^(B/cos θ) has its limit there, and directions at and below
/// the horizon take this value.
const MIN_COS: f64 = 0.01;
/// Illuminance of the sun outside the atmosphere, klx, on a plane perpendicular to the beam.
const EXTRATERRESTRIAL_KLX: f64 = 128.0;
/// Wavelengths that stand for R, G, B, µm.
const WAVELENGTH_UM: [f64; 3] = [0.68, 0.55, 0.44];
/// Ozone absorption at these wavelengths, cm⁻¹ (paper, table 2; 0.44 µm: the entry of 0.445).
const OZONE_PER_CM: [f64; 3] = [0.036, 0.085, 0.003];
/// Ozone column, cm (paper, appendix A.1).
const OZONE_CM: f64 = 0.35;
/// Rows (cos θ) and columns (azimuth) of the quadrature over the upper hemisphere; below 1 % off at any sun.
const QUADRATURE: (usize, usize) = (64, 128);

/// Linear (slope, offset) in turbidity of A…E, each for Y, x, y (paper, appendix A.2).
const PEREZ: [[(f64, f64); 3]; 5] = [
    [(0.1787, -1.4630), (-0.0193, -0.2592), (-0.0167, -0.2608)],
    [(-0.3554, 0.4275), (-0.0665, 0.0008), (-0.0950, 0.0092)],
    [(-0.0227, 5.3251), (-0.0004, 0.2125), (-0.0079, 0.2102)],
    [(0.1206, -2.5771), (-0.0641, -0.8989), (-0.0441, -1.6537)],
    [(-0.0670, 0.3703), (-0.0033, 0.0452), (-0.0109, 0.0529)],
];
/// Zenith x: rows T², T, 1; columns θs³, θs², θs, 1 (paper, appendix A.2).
const ZENITH_X: [[f64; 4]; 3] = [
    [0.00166, -0.00375, 0.00209, 0.0],
    [-0.02903, 0.06377, -0.03202, 0.00394],
    [0.11693, -0.21196, 0.06052, 0.25886],
];
/// Zenith y, as [`ZENITH_X`].
const ZENITH_Y: [[f64; 4]; 3] = [
    [0.00275, -0.00610, 0.00317, 0.0],
    [-0.04214, 0.08970, -0.04153, 0.00516],
    [0.15346, -0.26756, 0.06670, 0.26688],
];

/// Uniform data to evaluate the sky in a shader; `value[c] = zenith[c] · F_c(θ, γ)` for c = Y, x, y.
///
/// The shader takes cos θ = max(direction.y, 0.01) and γ between the given direction and the sun.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerezSky {
    /// Rows A…E; columns Y, x, y, unused (0).
    pub perez: [[f64; 4]; 5],
    /// Zenith Y (kcd/m²), x, y, each already divided by F(0, θs).
    pub zenith: [f64; 3],
}

/// Sky and sun of one turbidity and sun position.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyModel {
    sky: PerezSky,
    turbidity: f64,
    sun_direction: DVec3,
    ground_albedo: f64,
}

impl SkyModel {
    /// `turbidity` 1.7…10 (2 clear, 6 haze; the sky's fit is clamped to 2…10), `sun_direction` toward the sun (y up;
    /// normalised here; a sun below the horizon counts as on it), `ground_albedo` 0…1.
    pub fn new(turbidity: f64, sun_direction: DVec3, ground_albedo: f64) -> Self {
        let sun_direction = sun_direction.normalize_or(DVec3::Y);
        let zenith_angle = sun_direction.y.clamp(0.0, 1.0).acos();
        let fitted = turbidity.clamp(SKY_TURBIDITY.0, SKY_TURBIDITY.1);
        let mut perez = [[0.0; 4]; 5];
        for (row, fits) in perez.iter_mut().zip(PEREZ) {
            for (value, (slope, offset)) in row.iter_mut().zip(fits) {
                *value = slope * fitted + offset;
            }
        }
        let at_zenith = distribution(&perez, 1.0, zenith_angle);
        let zenith = zenith_values(fitted, zenith_angle);
        let zenith = [0, 1, 2].map(|c| zenith[c] / at_zenith[c]);
        Self {
            sky: PerezSky { perez, zenith },
            turbidity,
            sun_direction,
            ground_albedo,
        }
    }

    /// Coefficients for a shader.
    pub fn perez(&self) -> PerezSky {
        self.sky
    }

    /// Sky radiance toward `direction` (unit), linear sRGB, kcd/m², ≥ 0: negative components, outside the sRGB gamut,
    /// become 0. The sun's disc is not part of it. Below the horizon: as at 0.57° elevation.
    pub fn radiance(&self, direction: DVec3) -> [f64; 3] {
        let gamma = direction.dot(self.sun_direction).clamp(-1.0, 1.0).acos();
        let shape = distribution(&self.sky.perez, direction.y.clamp(MIN_COS, 1.0), gamma);
        linear_srgb([0, 1, 2].map(|c| self.sky.zenith[c] * shape[c]))
    }

    /// Illuminance of the direct sun on a plane perpendicular to its beam, linear sRGB, klx: 128 klx of white outside
    /// the atmosphere × e^−(Rayleigh + aerosol + ozone) × relative optical mass; appendix A.1, without mixed gases and
    /// water vapour, which absorb outside the visible.
    pub fn sun_irradiance_klx(&self) -> [f64; 3] {
        let mass = optical_mass(self.sun_direction.y.clamp(0.0, 1.0));
        let aerosol = (0.04608 * self.turbidity - 0.04586).max(0.0);
        [0, 1, 2].map(|c| {
            let rayleigh = 0.008735 * WAVELENGTH_UM[c].powf(-4.08);
            let depth =
                rayleigh + aerosol * WAVELENGTH_UM[c].powf(-1.3) + OZONE_PER_CM[c] * OZONE_CM;
            EXTRATERRESTRIAL_KLX * (-depth * mass).exp()
        })
    }

    /// Mean of the sky's radiance over the solid angle of the upper hemisphere, kcd/m², linear sRGB.
    pub fn mean_radiance(&self) -> [f64; 3] {
        self.hemisphere(|_| 1.0)
    }

    /// Illuminance of a horizontal plane by the sky alone, klx, linear sRGB.
    pub fn sky_irradiance_klx(&self) -> [f64; 3] {
        self.hemisphere(|cos_theta| 2.0 * PI * cos_theta)
    }

    /// Radiance of a diffuse ground lit by sun and sky: albedo/π × (E_sun · sin elevation + E_sky), kcd/m², linear sRGB.
    pub fn ground_radiance(&self) -> [f64; 3] {
        let (sun, sky, sine) = (
            self.sun_irradiance_klx(),
            self.sky_irradiance_klx(),
            self.sun_direction.y.max(0.0),
        );
        [0, 1, 2].map(|c| self.ground_albedo / PI * (sun[c] * sine + sky[c]))
    }

    /// Solid-angle mean of radiance × weight(cos θ); midpoint rule, uniform in cos θ and azimuth.
    fn hemisphere(&self, weight: impl Fn(f64) -> f64) -> [f64; 3] {
        let (rows, columns) = QUADRATURE;
        let mut sum = DVec3::ZERO;
        for row in 0..rows {
            let cos_theta = (row as f64 + 0.5) / rows as f64;
            let sin_theta = (1.0 - cos_theta * cos_theta).sqrt();
            for column in 0..columns {
                let (sin, cos) = (2.0 * PI * (column as f64 + 0.5) / columns as f64).sin_cos();
                let direction = DVec3::new(sin_theta * cos, cos_theta, sin_theta * sin);
                sum += weight(cos_theta) * DVec3::from(self.radiance(direction));
            }
        }
        (sum / (rows * columns) as f64).to_array()
    }
}

/// F(θ, γ) for Y, x, y.
fn distribution(perez: &[[f64; 4]; 5], cos_theta: f64, gamma: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| {
        let [a, b, c, d, e] = [0, 1, 2, 3, 4].map(|row: usize| perez[row][i]);
        (1.0 + a * (b / cos_theta).exp()) * (1.0 + c * (d * gamma).exp() + e * gamma.cos().powi(2))
    })
}

/// Y (kcd/m²), x, y at the zenith.
fn zenith_values(turbidity: f64, zenith_angle: f64) -> [f64; 3] {
    let chi = (4.0 / 9.0 - turbidity / 120.0) * (PI - 2.0 * zenith_angle.min(FRAC_PI_2));
    let luminance = (4.0453 * turbidity - 4.9710) * chi.tan() - 0.2155 * turbidity + 2.4192;
    let powers = [
        zenith_angle.powi(3),
        zenith_angle.powi(2),
        zenith_angle,
        1.0,
    ];
    let chromaticity = |fit: &[[f64; 4]; 3]| {
        let rows = fit
            .iter()
            .map(|row| row.iter().zip(powers).map(|(k, p)| k * p).sum::<f64>());
        rows.zip([turbidity * turbidity, turbidity, 1.0])
            .map(|(row, t)| row * t)
            .sum()
    };
    [
        luminance.max(0.0),
        chromaticity(&ZENITH_X),
        chromaticity(&ZENITH_Y),
    ]
}

/// Relative optical mass for the sine of the elevation (Kasten's formula, paper appendix A.1; 36.5 at the horizon).
fn optical_mass(sine: f64) -> f64 {
    let zenith_deg = sine.acos().to_degrees();
    1.0 / (sine + 0.15 * (93.885 - zenith_deg).powf(-1.253))
}

/// xyY → XYZ → linear sRGB (IEC 61966-2-1), clamped at 0.
fn linear_srgb([luminance, x, y]: [f64; 3]) -> [f64; 3] {
    let (x, z) = (luminance * x / y, luminance * (1.0 - x - y) / y);
    [
        3.2404542 * x - 1.5371385 * luminance - 0.4985314 * z,
        -0.9692660 * x + 1.8760108 * luminance + 0.0415560 * z,
        0.0556434 * x - 0.2040259 * luminance + 1.0572252 * z,
    ]
    .map(|v: f64| v.max(0.0))
}

#[cfg(test)]
mod tests;
