//! Scenes of an experiment: scene files or inline scenes, each with the values that vary in it.

use super::document::{Document, MAX_FILE_BYTES};
use super::{locate, shipped};
use crate::error::Result;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Map, Value};

const SCENE_REMEDY: &str = "Write \"scenes/name.json\", or {\"scene\": \"scenes/name.json\" or a whole scene, \"set\": {…}}.";

/// One scene file and the values that vary in it.
#[derive(Clone, Debug)]
pub struct SceneEntry {
    /// Pointer of the entry in the experiment.
    pub place: String,
    /// The scene: a file, or a part of the experiment's.
    pub document: Document,
    /// `set`, then `sun_elevation_deg`, then `view_steps`; the first is the slowest in the matrix.
    pub axes: Vec<SceneAxis>,
}

/// A scene member and the values it takes.
#[derive(Clone, Debug)]
pub struct SceneAxis {
    /// JSON pointer into the scene.
    pub target: String,
    /// JSON pointer of the axis in the experiment.
    pub place: String,
    /// Each value with its pointer in the experiment. Never empty.
    pub values: Vec<(String, Value)>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct FileScene {
    scene: Value,
    #[serde(default)]
    set: Map<String, Value>,
}

/// Reads the scene files; their total size is limited to that of one file, [`MAX_FILE_BYTES`].
pub(super) fn scenes(
    document: &Document,
    entries: &[(String, Value)],
    shorthands: &[SceneAxis],
) -> Result<Vec<SceneEntry>> {
    let mut bytes = 0;
    let mut scenes = Vec::with_capacity(entries.len());
    for (place, value) in entries {
        let entry = scene(document, place, value, shorthands)?;
        if entry.document.path() != document.path() {
            bytes += entry.document.text_bytes();
        }
        if bytes > MAX_FILE_BYTES {
            let problem = format!(
                "the scene files up to this one are larger than {} MiB together",
                MAX_FILE_BYTES >> 20
            );
            return Err(document.error(place, problem, "Split the experiment."));
        }
        scenes.push(entry);
    }
    Ok(scenes)
}

fn scene(
    document: &Document,
    place: &str,
    value: &Value,
    shorthands: &[SceneAxis],
) -> Result<SceneEntry> {
    let (scene_place, entry) = match value {
        Value::String(_) => (
            place.to_owned(),
            FileScene {
                scene: value.clone(),
                set: Map::new(),
            },
        ),
        Value::Object(_) => (format!("{place}/scene"), document.get::<FileScene>(place)?),
        other => {
            let problem = format!("{other} is not a scene");
            return Err(document.error(place, problem, SCENE_REMEDY));
        }
    };
    let scene = match &entry.scene {
        Value::String(path) => scene_file(document, &scene_place, path)?,
        Value::Object(_) => document.inside(&scene_place),
        other => {
            let problem = format!("{other} is not a scene");
            return Err(document.error(&scene_place, problem, SCENE_REMEDY));
        }
    };
    let mut axes = entry
        .set
        .keys()
        .map(|target| set_axis(document, place, target, shorthands))
        .collect::<Result<Vec<_>>>()?;
    axes.extend_from_slice(shorthands);
    Ok(SceneEntry {
        place: place.to_owned(),
        document: scene,
        axes,
    })
}

fn scene_file(document: &Document, place: &str, path: &str) -> Result<Document> {
    let folder = document.folder();
    let Some(found) = shipped::scene_of_experiment(folder, path) else {
        let problem = format!("there is no scene file {}", folder.join(path).display());
        let remedy = format!(
            "Paths of scenes are relative to the experiment file; built in: {}.",
            shipped::scene_paths()
        );
        return Err(document.error(place, problem, remedy));
    };
    Document::read(&found)
}

fn set_axis(
    document: &Document,
    place: &str,
    target: &str,
    shorthands: &[SceneAxis],
) -> Result<SceneAxis> {
    let place = format!("{place}/set{}", locate::step(target));
    if !target.starts_with('/') {
        let remedy = "Write the path of the scene member from the top, e.g. \"/sun/azimuth_deg\".";
        return Err(document.error_at_key(
            &place,
            format!("`{target}` is not a JSON pointer"),
            remedy,
        ));
    }
    if let Some(other) = shorthands.iter().find(|axis| axis.target == target) {
        let problem = format!(
            "`{target}` is also given by `{}`",
            other.place.trim_start_matches('/')
        );
        return Err(document.error_at_key(&place, problem, "Keep one of the two."));
    }
    Ok(SceneAxis {
        target: target.to_owned(),
        values: document.one_or_many(&place)?,
        place,
    })
}
