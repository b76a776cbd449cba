//! The error numbers: one row each. A new one is a row here and the function that it names.

use super::metric::{Better, Format, Group, Metric, Origin, Recorded, error_numbers};
use super::pair::Pair;
use super::{linear, nonfinite, perceptual, ssim};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const INFINITY: f64 = f64::INFINITY;

error_numbers! {
    rel_rmse: f64 {
        doc: "√Σ(ΔL)² / √ΣL² of the sun-lit radiance over RGB and cloud pixels; 1 = as large as the picture itself",
        label: "rel_rmse",
        unit: "",
        format: Number,
        range: [0.0, INFINITY],
        better: Lower,
        group: Size,
        from: pair(|pair| pair.linear.rel_rmse),
    }
    bias: f64 {
        doc: "ΣΔL / ΣL = leak + darken; near zero it can hide leak and darken of equal size",
        label: "Bias",
        unit: "",
        format: SignedPercent,
        range: [-INFINITY, INFINITY],
        better: Zero,
        group: Linear,
        from: pair(|pair| pair.linear.bias),
    }
    leak: f64 {
        doc: "Σmax(ΔL, 0) / ΣL: light where there should be shadow",
        label: "Leak",
        unit: "",
        format: SignedPercent,
        range: [0.0, INFINITY],
        better: Lower,
        group: Linear,
        from: pair(|pair| pair.linear.leak),
    }
    darken: f64 {
        doc: "Σmin(ΔL, 0) / ΣL, never positive: shadow where there should be light",
        label: "Darken",
        unit: "",
        format: SignedPercent,
        range: [-INFINITY, 0.0],
        better: Zero,
        group: Linear,
        from: pair(|pair| pair.linear.darken),
    }
    p99_abs: f64 {
        doc: "99th percentile (nearest rank) of |ΔL|, in units of the truth's mean L",
        label: "p99_abs",
        unit: "mean L",
        format: Number,
        range: [0.0, INFINITY],
        better: Lower,
        group: Linear,
        from: pair(|pair| pair.linear.p99_abs),
    }
    max_abs: f64 {
        doc: "largest |ΔL|, in units of the truth's mean L",
        label: "max_abs",
        unit: "mean L",
        format: Number,
        range: [0.0, INFINITY],
        better: Lower,
        group: Linear,
        from: pair(|pair| pair.linear.max_abs),
    }
    transmittance_rmse: f64 {
        doc: "RMSE over cloud pixels of the light transmittance V, which is weighted by σT along the view ray; 0 to 1",
        label: "T RMSE",
        unit: "",
        format: Number,
        range: [0.0, INFINITY],
        better: Lower,
        group: Linear,
        from: pair(linear::transmittance_rmse),
    }
    edge_bias: Option<f64> {
        doc: "ΣΔL / ΣL over edge pixels, the cloud pixels of opacity at most 0.9 in the truth: brighter (> 0) or darker edges; \
            absent where the truth has no lit ones",
        label: "Edge bias",
        unit: "",
        format: SignedPercent,
        range: [-INFINITY, INFINITY],
        better: Zero,
        group: Linear,
        from: pair(|pair| pair.linear.edge_bias),
    }
    floor_rel_rmse: Option<f64> {
        doc: "rel_rmse of the uncompressed column at the same steps and texels: what marching alone costs; absent for methods \
            without a map",
        label: "floor_rel_rmse",
        unit: "",
        format: Number,
        range: [0.0, INFINITY],
        better: Lower,
        group: Size,
        from: floor,
    }
    flicker: Option<f64> {
        doc: "RMS frame-to-frame change of ΔL / mean L over 16 frames of a camera pan of one pixel a frame, which carries even a \
            steady error along; absent where the experiment asks for none",
        label: "Flicker, pan",
        unit: "mean L",
        format: Number,
        range: [0.0, INFINITY],
        better: Lower,
        group: Motion,
        from: track,
    }
    flicker_sun: Option<f64> {
        doc: "RMS frame-to-frame change of ΔL / mean L over 16 frames in which the sun rises by 1° and the camera rests; absent \
            where the experiment asks for none",
        label: "Flicker, sun",
        unit: "mean L",
        format: Number,
        range: [0.0, INFINITY],
        better: Lower,
        group: Motion,
        from: track,
    }
    flicker_dolly: Option<f64> {
        doc: "RMS frame-to-frame change of ΔL / mean L over 16 frames of a camera that moves ahead and to its right by one map \
            texel a frame (256² texels, square fit); absent where the experiment asks for none",
        label: "Flicker, dolly",
        unit: "mean L",
        format: Number,
        range: [0.0, INFINITY],
        better: Lower,
        group: Motion,
        from: track,
    }
    rel_rmse_pan: Option<f64> {
        doc: "rel_rmse over all 16 frames of the camera pan, the age of a map that is filled over several frames included; \
            absent where the experiment asks for none",
        label: "rel_rmse, pan",
        unit: "",
        format: Number,
        range: [0.0, INFINITY],
        better: Lower,
        group: Motion,
        from: track,
    }
    rel_rmse_sun: Option<f64> {
        doc: "rel_rmse over all 16 frames of the moving sun, the age of a map that is filled over several frames included; \
            absent where the experiment asks for none",
        label: "rel_rmse, sun",
        unit: "",
        format: Number,
        range: [0.0, INFINITY],
        better: Lower,
        group: Motion,
        from: track,
    }
    rel_rmse_dolly: Option<f64> {
        doc: "rel_rmse over all 16 frames of the dolly, the age of a map that is filled over several frames included; \
            absent where the experiment asks for none",
        label: "rel_rmse, dolly",
        unit: "",
        format: Number,
        range: [0.0, INFINITY],
        better: Lower,
        group: Motion,
        from: track,
    }
    flip_mean: f64 {
        doc: "mean of FLIP, the perceived difference after one tone map fixed from the truth (LDR, 67 pixels a degree; Andersson \
            et al. 2020); 0 to 1",
        label: "FLIP mean",
        unit: "",
        format: Number,
        range: [0.0, 1.0],
        better: Lower,
        group: Perceptual,
        from: pair(|pair| pair.seen.flip.mean),
    }
    flip_p99: f64 {
        doc: "99th percentile of FLIP (nearest rank); 0 to 1",
        label: "FLIP p99",
        unit: "",
        format: Number,
        range: [0.0, 1.0],
        better: Lower,
        group: Perceptual,
        from: pair(|pair| pair.seen.flip.p99),
    }
    psnr_db: Option<f64> {
        doc: "peak signal-to-noise ratio after one tone map fixed from the truth: −10 log₁₀ of the mean squared difference of RGB, \
            peak 1; absent when the pictures are equal",
        label: "PSNR",
        unit: "dB",
        format: Number,
        range: [0.0, INFINITY],
        better: Higher,
        group: Perceptual,
        from: pair(|pair| perceptual::psnr_db(&pair.seen.truth, &pair.seen.picture)),
    }
    ssim: f64 {
        doc: "structural similarity of the tone-mapped luma (Wang et al. 2004); 1 = equal",
        label: "SSIM",
        unit: "",
        format: Number,
        range: [-1.0, 1.0],
        better: Higher,
        group: Perceptual,
        from: pair(|pair| ssim::ssim(pair.seen.size, &pair.seen.truth, &pair.seen.picture)),
    }
    nonfinite: u64 {
        doc: "channels of the picture, of 8 a pixel, that are NaN or infinite; 0 is right",
        label: "Not finite",
        unit: "channels",
        format: Integer,
        range: [0.0, INFINITY],
        better: Lower,
        group: Validity,
        from: pair(|pair| nonfinite(pair.test)),
    }
}

/// Calls the function of a row.
fn measured<T>(pair: &Pair<'_>, measure: fn(&Pair<'_>) -> T) -> T {
    measure(pair)
}

/// Every error number as lists show them: by [`Group`], then in the order of the record.
pub fn arranged() -> Vec<&'static Metric> {
    let mut metrics: Vec<_> = METRICS.iter().collect();
    metrics.sort_by_key(|metric| metric.group);
    metrics
}

/// The row of `key`; in a constant a key that does not exist is a compile error.
pub const fn metric(key: &str) -> &'static Metric {
    let mut i = 0;
    while i < METRICS.len() {
        if equal(METRICS[i].key.as_bytes(), key.as_bytes()) {
            return &METRICS[i];
        }
        i += 1;
    }
    panic!("no metric has this key")
}

const fn equal(a: &[u8], b: &[u8]) -> bool {
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    i == a.len() && i == b.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use schemars::schema_for;
    use serde_json::{Value, json};

    #[test]
    fn every_row_says_what_it_is() {
        for metric in METRICS {
            assert!(
                metric.doc.len() > 20 && !metric.label.is_empty(),
                "{metric:?}"
            );
            assert!(!metric.doc.contains('\n') && !metric.doc.contains("  "));
            assert!(metric.range[0] < metric.range[1], "{metric:?}");
            let same = |other: &&Metric| other.key == metric.key || other.label == metric.label;
            assert_eq!(METRICS.iter().filter(same).count(), 1, "{metric:?}");
        }
    }

    #[test]
    fn rows_record_and_schema_are_the_same_list() {
        let keys: Vec<&str> = METRICS.iter().map(|metric| metric.key).collect();
        let record = json!(ErrorNumbers::default());
        let members = |value: &Value| -> Vec<String> {
            let members = value.as_object().into_iter().flatten();
            members.map(|(key, _)| key.clone()).collect()
        };
        assert_eq!(members(&record), keys);
        let schema = schema_for!(ErrorNumbers);
        assert_eq!(members(&schema.as_value()["properties"]), keys);
        for (i, metric) in METRICS.iter().enumerate() {
            assert_eq!(
                schema.as_value()["properties"][metric.key]["description"],
                metric.doc
            );
            let mut record = record.clone();
            record[metric.key] = json!(i + 1);
            let numbers: ErrorNumbers = serde_json::from_value(record).unwrap();
            assert_eq!((metric.get)(&numbers), Some((i + 1) as f64), "{metric:?}");
        }
    }

    #[test]
    fn numbers_of_earlier_reports_are_still_there_in_their_order() {
        let known = [
            "rel_rmse",
            "bias",
            "leak",
            "darken",
            "p99_abs",
            "max_abs",
            "transmittance_rmse",
            "edge_bias",
            "floor_rel_rmse",
            "flicker",
            "flicker_sun",
            "flip_mean",
            "flip_p99",
            "psnr_db",
            "ssim",
            "nonfinite",
        ];
        let keys = METRICS.iter().map(|metric| metric.key);
        let kept: Vec<&str> = keys.filter(|key| known.contains(key)).collect();
        assert_eq!(kept, known);
        let earlier: Value = known.iter().map(|key| (*key, json!(1))).collect();
        serde_json::from_value::<ErrorNumbers>(earlier).expect("earlier reports are readable");
    }

    #[test]
    fn lists_show_groups_in_order_and_constants_find_their_row() {
        let groups: Vec<Group> = arranged().iter().map(|metric| metric.group).collect();
        assert!(groups.is_sorted() && groups.len() == METRICS.len());
        const SSIM: &Metric = metric("ssim");
        assert_eq!(SSIM.label, "SSIM");
    }
}
