//! The error numbers of a picture.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Error numbers of a picture against its truth; see `metrics` for the definitions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ErrorNumbers {
    /// √Σ(L̂−L)² / √ΣL² over RGB and cloud pixels of the sun-lit radiance.
    pub rel_rmse: f64,
    /// ΣΔL / ΣL.
    pub bias: f64,
    /// Σmax(ΔL, 0) / ΣL: light where there should be shadow.
    pub leak: f64,
    /// Σmin(ΔL, 0) / ΣL: shadow where there should be light (≤ 0).
    pub darken: f64,
    /// 99th percentile of |ΔL| / mean L.
    pub p99_abs: f64,
    /// Largest |ΔL| / mean L.
    pub max_abs: f64,
    /// RMSE of the σT-weighted light transmittance over cloud pixels.
    pub transmittance_rmse: f64,
    /// ΣΔL / ΣL over edge pixels, the cloud pixels of opacity ≤ 0.9 in the truth: brighter (> 0) or darker edges; `null`
    /// where the truth has no lit ones.
    #[serde(default)]
    pub edge_bias: Option<f64>,
    /// `rel_rmse` of the uncompressed column at the same steps and texels; `null` for methods without a map.
    pub floor_rel_rmse: Option<f64>,
    /// RMS frame-to-frame change of ΔL / mean L over a camera pan of 16 frames, one pixel a frame (which
    /// carries even a steady error along); `null` when the experiment asks for none.
    pub flicker: Option<f64>,
    /// The same while the sun rises by 1° in 16 frames and the camera rests.
    pub flicker_sun: Option<f64>,
    /// Mean FLIP (LDR, 67 pixels a degree).
    pub flip_mean: f64,
    /// 99th percentile of FLIP.
    pub flip_p99: f64,
    /// Peak signal-to-noise ratio, dB, tone-mapped, peak 1; `null` when the images are equal.
    pub psnr_db: Option<f64>,
    /// Structural similarity (Wang et al. 2004) of the tone-mapped luma.
    pub ssim: f64,
    /// Channels of the picture that are NaN or infinite.
    pub nonfinite: u64,
}
