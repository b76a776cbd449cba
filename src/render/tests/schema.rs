//! The schema accepts every file that ships, and rejects what the readers reject.

use jsonschema::Validator;
use occlab_render::config::schema;
use occlab_render::reconstruct::Registry;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

fn validator() -> Validator {
    jsonschema::draft202012::new(&schema(&Registry)).expect("a schema")
}

fn json_of(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

fn shipped(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(folder);
    let paths = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path());
    let mut files: Vec<_> = paths
        .filter(|p| p.extension().is_some_and(|e| e == "json"))
        .collect();
    files.sort();
    assert!(!files.is_empty());
    files
}

#[test]
fn every_file_that_ships_is_accepted() {
    let validator = validator();
    let folders = [
        "configs",
        "configs/scenes",
        "configs/witnesses",
        "configs/studies",
        "configs/studies/scenes",
    ];
    for path in folders.iter().flat_map(|folder| shipped(folder)) {
        let file = json_of(&path);
        assert!(validator.is_valid(&file), "{}", path.display());
    }
}

#[test]
fn what_the_readers_refuse_is_refused() {
    let validator = validator();
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let refused = |file: &str, place: &str, member: &str, value: Value| {
        let mut json = json_of(&root.join(file));
        let parent = json.pointer_mut(place).expect("a place of the file");
        parent[member] = value;
        assert!(!validator.is_valid(&json), "{file}: {place}/{member}");
    };
    let quick = "configs/quick.json";
    refused(quick, "", "runes", json!(3));
    refused(quick, "", "runs", json!("$runs"));
    refused(quick, "/image", "width", json!(0.5));
    let study = "configs/studies/m.json";
    refused(study, "", "claim", json!([]));
    refused(study, "/claims/0/checks/0/test/ratio", "between", json!(3));
    refused(study, "/charts/0", "log_x", json!("yes"));
    refused(
        study,
        "/tables/0/rows/0",
        "published",
        json!({"payload_bytes": "many"}),
    );
    refused(study, "/experiments/0/matrix", "name", json!("twice"));
    refused(study, "/experiments/0/matrix/methods/0", "steps", json!(0));
    refused(study, "/experiments/0/matrix/methods/0", "step", json!(10));
    let sweep = "configs/stability.json";
    refused(sweep, "/extremes/0", "full", json!(true));
    refused(sweep, "/image", "width", json!("wide"));
}

#[test]
fn any_value_of_a_study_may_come_from_its_profile() {
    let validator = validator();
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    for (place, member) in [
        ("/charts/0", "log_x"),
        ("/claims/0/checks/0/test/ratio", "between"),
        ("/experiments/0", "matrix"),
        ("/experiments/0/matrix", "runs"),
        ("/experiments/0/matrix/methods/0", "steps"),
        ("", "claims"),
    ] {
        let mut json = json_of(&root.join("configs/studies/m.json"));
        json.pointer_mut(place).expect("a place of the file")[member] = json!("$value");
        assert!(validator.is_valid(&json), "{place}/{member}");
    }
}
