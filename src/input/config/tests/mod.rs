use super::*;
use crate::param::{Applies, ParamKind, ParamSpec};
use crate::scene::{HistoryInfo, Pattern, ReconstructionInfo, RestInfo};
use serde_json::Value;
use std::path::PathBuf;

mod errors;
mod matrix;
mod scenes;

const STEPS: ParamSpec = ParamSpec {
    name: "steps",
    unit: "",
    doc: "Light steps.",
    kind: ParamKind::Int {
        min: 1,
        max: 50,
        default: 6,
    },
    applies: Applies::Always,
    as_printed: &[],
};
const SPACING: ParamSpec = ParamSpec {
    name: "spacing",
    unit: "m",
    doc: "First step.",
    kind: ParamKind::Float {
        min: 0.0,
        max: 10.0,
        default: 2.0,
    },
    applies: Applies::Always,
    as_printed: &[],
};
const REACH: ParamSpec = ParamSpec {
    name: "reach",
    unit: "m",
    doc: "Length.",
    kind: ParamKind::Int {
        min: 1,
        max: 99,
        default: 10,
    },
    applies: Applies::Choice {
        of: "lookup",
        is: &["hardware"],
    },
    as_printed: &[],
};
const LOOKUP: ParamSpec = ParamSpec {
    name: "lookup",
    unit: "",
    doc: "Filter.",
    kind: ParamKind::Choice {
        options: &["nearest", "hardware"],
        default: "nearest",
    },
    applies: Applies::Always,
    as_printed: &[],
};

static FULL: ReconstructionInfo = ReconstructionInfo {
    id: ReconstructionInfo::FULL,
    title: "Full pictures",
    brief: "every pixel",
    doc: "Every pixel.",
    frame: "A frame marches every pixel.",
    citation: "",
    shaders: &[],
    pattern: Pattern::EVERY,
    smallest: [1, 1],
    history: None,
    rest: RestInfo {
        frames: 1,
        exact: true,
    },
};
static TEMPORAL: ReconstructionInfo = ReconstructionInfo {
    id: "temporal_2x2",
    pattern: Pattern {
        block: [2, 1],
        offsets: &[[0, 0], [1, 0]],
        shear: 0,
    },
    smallest: [2, 2],
    history: Some(HistoryInfo {
        what: "one picture",
        pixel_bytes: 4,
    }),
    ..FULL
};

struct Mock;

impl Catalogue for Mock {
    fn reconstructions(&self) -> Vec<&'static ReconstructionInfo> {
        vec![&FULL, &TEMPORAL]
    }
}

impl MethodCatalogue for Mock {
    fn ids(&self) -> Vec<&str> {
        vec!["none", "srm", "bsm"]
    }
    fn params(&self, id: &str) -> Option<Vec<&'static ParamSpec>> {
        match id {
            "none" => Some(vec![]),
            "srm" => Some(vec![&STEPS, &SPACING]),
            "bsm" => Some(vec![&LOOKUP, &REACH]),
            _ => None,
        }
    }
}

const SCENE: &str = r#"{
  "name": "slab",
  "container": {"box": {"min_m": [0, 0, 0], "max_m": [100, 50, 100]}},
  "density": {"uniform": {"value": 1}},
  "medium": {},
  "sun": {"elevation_deg": 45, "azimuth_deg": 0, "irradiance": [1, 1, 1]},
  "camera": {"position_m": [0, 10, -300], "target_m": [50, 25, 50], "fov_y_deg": 40}
}"#;

const SMALL: &str = r#"{"name": "e", "image": {"width": 16, "height": 9}, "scenes": "slab.json", "methods": "none"}"#;

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("temporary folder"));
        folder.write("slab.json", SCENE);
        folder
    }

    fn write(&self, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).expect("write");
        path
    }

    fn scene_error(&self, from: &str, to: &str) -> String {
        assert!(SCENE.contains(from));
        let path = self.write("bad.json", SCENE.replacen(from, to, 1));
        load_scene(&path).expect_err("must be refused").to_string()
    }

    fn expand(&self, experiment: &Value) -> Result<Matrix> {
        self.expand_text(&experiment.to_string())
    }

    fn expand_text(&self, text: &str) -> Result<Matrix> {
        expand(&load_experiment(&self.write("e.json", text))?, &Mock)
    }

    /// The error of [`SMALL`] with one member replaced or added.
    fn error(&self, member: &str, value: &str) -> String {
        let mut experiment: Value = serde_json::from_str(SMALL).expect("small");
        experiment[member] = Value::Null;
        let text = experiment.to_string().replacen(
            &format!("\"{member}\":null"),
            &format!("\"{member}\":{value}"),
            1,
        );
        self.expand_text(&text).expect_err(&text).to_string()
    }
}

fn has(message: &str, words: &[&str]) {
    for word in words {
        assert!(message.contains(word), "`{word}` is not in: {message}");
    }
}

fn with(members: Value) -> Value {
    let mut experiment: Value = serde_json::from_str(SMALL).expect("small");
    for (key, value) in members.as_object().expect("object") {
        experiment[key] = value.clone();
    }
    experiment
}
