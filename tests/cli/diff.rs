//! `render` and `diff`: what a method loses, and which layer of a picture is compared.

use super::program::{occlab, refused, stderr, workplace};
use serde_json::{Value, json};
use std::path::Path;

#[test]
fn render_and_diff_measure_what_a_method_loses() {
    let folder = workplace(|_, _| {});
    let render = |method: &str, out: &str| {
        let size = ["--width", "32", "--height", "24", "--quiet"];
        let output = occlab(folder.path())
            .args(["render", "--scene", "slab.json", "-m", method, "-o", out])
            .args(size)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
    };
    render("truth", "truth.exr");
    render("none", "none.exr");
    let diff = |a: &str, b: &str| -> Value {
        let output = occlab(folder.path())
            .args(["diff", a, b, "--json"])
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let equal = diff("truth.exr", "truth.exr");
    assert_eq!(equal["rel_rmse"], json!(0.0));
    let keys = occlab::metrics::METRICS.iter().map(|metric| metric.key);
    let printed = equal.as_object().unwrap().keys().map(String::as_str);
    let printed: Vec<&str> = printed.collect();
    assert_eq!(
        printed,
        keys.chain(["cloud_pixel_fraction"]).collect::<Vec<_>>()
    );
    assert!(
        diff("truth.exr", "none.exr")["leak"].as_f64().unwrap() > 0.1,
        "no shadow at all must leak"
    );
    let bad = occlab(folder.path())
        .args([
            "render",
            "--scene",
            "slab.json",
            "--set",
            "stops=3",
            "-m",
            "srm",
            "-o",
            "a.png",
        ])
        .output();
    refused(&bad.unwrap(), &["stops", "steps"]);
}

/// An EXR of 6 × 4 pixels, one value per channel, stored from `corner` on in a picture that begins at (0, 0).
fn exr_file(path: &Path, corner: (i32, i32), channels: &[(&str, f32)]) {
    use exr::prelude::*;
    let channel =
        |(name, value): &(&str, f32)| AnyChannel::new(*name, FlatSamples::F32(vec![*value; 24]));
    let attributes = LayerAttributes {
        layer_position: corner.into(),
        ..LayerAttributes::default()
    };
    let channels = AnyChannels::sort(channels.iter().map(channel).collect());
    let layer = Layer::new((6, 4), attributes, Encoding::UNCOMPRESSED, channels);
    let image = Image::new(ImageAttributes::with_size((6, 4)), layer);
    image.write().to_file(path).unwrap();
}

#[test]
fn diff_says_which_layer_and_window_it_took_and_takes_the_one_named() {
    let folder = tempfile::tempdir().unwrap();
    let plain = [("R", 1.0), ("G", 1.0), ("B", 1.0)];
    let named = [("glow.R", 0.5), ("glow.G", 0.5), ("glow.B", 0.5)];
    let other = [("key.R", 0.5), ("key.G", 0.5), ("key.B", 0.5)];
    let file = |name: &str, corner, channels: &[(&str, f32)]| {
        exr_file(&folder.path().join(name), corner, channels);
    };
    file("plain.exr", (0, 0), &plain);
    file("glow.exr", (0, 0), &named);
    file("both.exr", (0, 0), &[&plain[..], &named].concat());
    file("open.exr", (0, 0), &[&named[..], &other].concat());
    file("right.exr", (2, 0), &plain);
    let diff = |test: &str| {
        let mut command = occlab(folder.path());
        command.args(["diff", "plain.exr", test, "--json"]);
        command.output().unwrap()
    };
    let cases = [
        ("plain.exr", 0.0, &[][..]),
        ("glow.exr", -0.5, &[]),
        ("both.exr", 0.0, &["both.exr: of 2 layers", "another: glow"]),
        ("both.exr:glow", -0.5, &[]),
        (
            "right.exr",
            -1.0 / 3.0,
            &[
                "right.exr:",
                "6×4 from (2, 0)",
                "overscan was cut",
                "opacity are 0",
            ],
        ),
    ];
    for (test, bias, words) in cases {
        let output = diff(test);
        let notes = stderr(&output);
        assert!(output.status.success(), "{test}: {notes}");
        let numbers: Value = serde_json::from_slice(&output.stdout).unwrap();
        let found = numbers["bias"].as_f64().unwrap();
        assert!((found - bias).abs() < 1e-12, "{test}: {found}");
        assert_eq!(
            notes.lines().count(),
            usize::from(!words.is_empty()),
            "{notes}"
        );
        for word in words {
            assert!(notes.contains(word), "`{word}` is not in: {notes}");
        }
    }
    refused(&diff("open.exr"), &["glow, key", "open.exr:glow"]);
    refused(&diff("both.exr:key"), &["no layer `key`", "glow"]);
}
