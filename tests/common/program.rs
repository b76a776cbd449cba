//! The program as a child process in a folder of its own, with a small scene and experiment.
#![allow(dead_code, reason = "each test binary uses its own part")]

use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::SystemTime;

pub fn occlab(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_occlab"));
    command
        .current_dir(folder)
        .env("OCCLAB_CACHE", folder.join("cache"))
        .stdin(Stdio::null());
    command
}

/// Hides every driver from the program.
pub fn without_adapter(command: &mut Command) -> &mut Command {
    let hidden = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"].map(|name| (name, "/nonexistent"));
    command.envs(hidden)
}

pub fn scene() -> Value {
    json!({
        "name": "slab",
        "container": {"box": {"min_m": [0, 0, 0], "max_m": [1000, 1000, 1000]}},
        "density": {"uniform": {"value": 1}},
        "medium": {"extinction_per_m": 0.005},
        "sun": {"elevation_deg": 60, "azimuth_deg": 30, "irradiance": [1, 1, 1]},
        "camera": {"position_m": [500, 500, -2500], "target_m": [500, 500, 500], "fov_y_deg": 30}
    })
}

pub fn experiment() -> Value {
    json!({
        "name": "small", "image": {"width": 24, "height": 16}, "runs": 2, "scenes": ["slab.json"],
        "sun_elevation_deg": [60, 40, 20],
        "methods": [{"method": "srm", "steps": [4, 8]}, {"method": "bsm", "resolution": 16, "steps": 8}]
    })
}

/// A folder with a scene and an experiment, changed by `edit`.
pub fn workplace(edit: impl FnOnce(&mut Value, &mut Value)) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let (mut scene, mut experiment) = (scene(), experiment());
    edit(&mut scene, &mut experiment);
    std::fs::write(folder.path().join("slab.json"), scene.to_string()).unwrap();
    std::fs::write(
        folder.path().join("small.json"),
        serde_json::to_string_pretty(&experiment).unwrap(),
    )
    .unwrap();
    folder
}

pub fn batch(folder: &Path) -> Output {
    occlab(folder)
        .args(["batch", "small.json", "--out", "out", "--quiet"])
        .output()
        .unwrap()
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub fn refused(output: &Output, words: &[&str]) {
    let text = stderr(output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    for word in words {
        assert!(text.contains(word), "`{word}` is not in: {text}");
    }
}

pub fn cells(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder.join("out/cells")) else {
        return Vec::new();
    };
    let paths = entries.map(|e| e.unwrap().path());
    paths
        .filter(|p| p.extension().is_some_and(|e| e == "json"))
        .collect()
}

/// Every file with its time of modification.
pub fn modified(paths: impl IntoIterator<Item = PathBuf>) -> Vec<(PathBuf, SystemTime)> {
    let time = |path: &PathBuf| std::fs::metadata(path).unwrap().modified().unwrap();
    paths.into_iter().map(|p| (p.clone(), time(&p))).collect()
}

/// `report.json`.
pub fn report(folder: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("out/report.json")).unwrap()).unwrap()
}
