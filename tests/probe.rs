//! `occlab probe`: curves along one light column, without an adapter.

#[path = "common/program.rs"]
mod program;

use program::{occlab, refused, stderr, without_adapter, workplace};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Output;

fn probe(folder: &Path, options: &[&str]) -> Output {
    without_adapter(&mut occlab(folder))
        .args([
            "probe",
            "-s",
            "slab.json",
            "--width",
            "24",
            "--height",
            "16",
        ])
        .args(options)
        .output()
        .unwrap()
}

/// Columns of the table by name, and the marks as text.
fn table(path: &Path) -> (BTreeMap<String, Vec<f64>>, Vec<String>) {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let names: Vec<_> = lines.next().unwrap().split(',').collect();
    let (mut columns, mut marks) = (BTreeMap::<String, Vec<f64>>::new(), Vec::new());
    for line in lines {
        for (name, field) in names.iter().zip(line.split(',')) {
            match *name {
                "marks" => marks.push(field.to_owned()),
                name => columns
                    .entry(name.to_owned())
                    .or_default()
                    .push(field.parse().unwrap()),
            }
        }
    }
    (columns, marks)
}

#[test]
fn the_truth_of_a_column_is_its_closed_form_and_every_method_has_a_curve() {
    let folder = workplace(|_, _| {});
    for place in [["--pixel", "12,8"], ["--column", "0.5,0.5"]] {
        let output = probe(folder.path(), &place);
        assert!(output.status.success(), "{}", stderr(&output));
        let (columns, marks) = table(&folder.path().join("probe.csv"));
        let (depths, truth) = (&columns["depth_m"], &columns["truth"]);
        assert_eq!(truth[0], 1.0);
        assert!(truth.windows(2).all(|t| t[1] <= t[0]), "not monotone");
        for (depth_m, t) in depths.iter().zip(truth) {
            assert!((t - (-0.005 * depth_m).exp()).abs() < 1e-9);
        }
        for method in occlab::occlusion::REGISTRY {
            let curve = &columns[method.info().id];
            assert_eq!(curve.len(), depths.len());
            assert!(curve.iter().all(|t| (0.0..=1.0).contains(t)));
        }
        assert!(columns["none"].iter().all(|t| *t == 1.0));
        let srm = columns["srm"].iter().zip(truth);
        assert!(srm.into_iter().all(|(a, b)| (a - b).abs() < 1e-9));
        assert_eq!(marks.len(), depths.len());
        let svg = std::fs::read_to_string(folder.path().join("probe.svg")).unwrap();
        assert!(svg.contains("Computed by the f64 oracle") && svg.contains("fom"));
    }
}

/// A shell-thin dense layer in an empty box: a Fourier series rings, a Beer map ends at its τ_max.
#[test]
fn ringing_and_the_clamp_are_marked() {
    let folder = workplace(|s, _| {
        s["density"] = serde_json::json!({"volume": {"path": "cube.npy", "up_axis": 1}});
    });
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    let mut header = "{'descr': '<f4', 'fortran_order': False, 'shape': (16, 16, 16), }".to_owned();
    header.push_str(&" ".repeat(63 - (10 + header.len()) % 64));
    header.push('\n');
    bytes.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
    bytes.extend(header.as_bytes());
    for i in 0..16 * 16 * 16 {
        let layer = (i / 16) % 16;
        bytes.extend((if layer == 10 { 1.0_f32 } else { 0.0 }).to_le_bytes());
    }
    std::fs::write(folder.path().join("cube.npy"), bytes).unwrap();
    let place = ["--column", "0.5,0.5", "--sun-elevation", "80"];
    let output = probe(folder.path(), &[&place[..], &["-o", "thin.svg"]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let (columns, marks) = table(&folder.path().join("thin.csv"));
    assert!(marks.iter().any(|m| m.contains("fom:outside")), "{marks:?}");
    let clamped = marks.iter().position(|m| m.contains("bsm:clamped"));
    let from = clamped.expect("the clamp is marked");
    let bsm = &columns["bsm"];
    assert!(bsm[from..].iter().all(|t| (t - bsm[from]).abs() < 1e-8));
    assert!(bsm[from - 1] > bsm[from] && bsm[from] < 1.0);
    let svg = std::fs::read_to_string(folder.path().join("thin.svg")).unwrap();
    assert!(svg.contains("τ_max") && svg.contains("rises"));
}

#[test]
fn methods_and_their_settings_are_chosen() {
    let folder = workplace(|_, _| {});
    let chosen = [
        "--pixel",
        "12,8",
        "-m",
        "alq",
        "-m",
        "srm",
        "--set",
        "quantiles=six",
    ];
    let output = probe(folder.path(), &chosen);
    assert!(output.status.success(), "{}", stderr(&output));
    let (columns, _) = table(&folder.path().join("probe.csv"));
    assert!(columns.contains_key("alq") && columns.contains_key("srm"));
    assert!(!columns.contains_key("bsm"));
    let six = columns["alq"].clone();
    let svg = std::fs::read_to_string(folder.path().join("probe.svg")).unwrap();
    assert!(svg.contains("quantiles=six"));
    assert!(probe(folder.path(), &chosen[..4]).status.success());
    let (columns, _) = table(&folder.path().join("probe.csv"));
    assert_ne!(columns["alq"], six, "the setting has no effect");
    let refuse = |options: &[&str], words: &[&str]| {
        refused(
            &probe(folder.path(), &[&chosen[..4], options].concat()),
            words,
        );
    };
    refuse(
        &["--set", "spacing=cubic"],
        &["--set spacing", "none of the methods"],
    );
    refuse(&["--set", "quantiles"], &["NAME=VALUE"]);
    refuse(&["-m", "esmm"], &["no method `esmm`"]);
}

#[test]
fn places_that_do_not_exist_are_one_paragraph() {
    let folder = workplace(|_, _| {});
    let refuse = |options: &[&str], words: &[&str]| refused(&probe(folder.path(), options), words);
    refuse(&["--pixel", "24,0"], &["--pixel", "24×16", "top left"]);
    refuse(&["--pixel", "0,0"], &["no cloud", "0,0"]);
    refuse(&["--pixel", "3"], &["80,45"]);
    refuse(&["--column", "0.5,1.5"], &["--column", "0 to 1"]);
    refuse(&["--column", "NaN,0.5"], &["--column", "0 to 1"]);
    refuse(&["--column", "0,0"], &["--column", "nothing of the layer"]);
    refuse(&["--pixel", "1,1", "--column", "0,0"], &["--column"]);
    refuse(&[], &["--pixel", "--column"]);
    refuse(&["--pixel", "12,8", "-o", "a.png"], &["--out", ".svg"]);
}
