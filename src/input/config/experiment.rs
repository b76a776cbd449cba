//! The experiment file: which scenes, sizes, suns and method settings to measure.
//!
//! ```json
//! { "name": "quick", "image": {"width": 160, "height": 90}, "runs": 5, "discard": 1,
//!   "scenes": [{"scene": "scenes/cumulus.json", "set": {"/density/procedural/decks/0/coverage": [0.3, 0.5]}}],
//!   "sun_elevation_deg": [60, 12],
//!   "methods": [{"method": "srm", "steps": [6, 10, 20]}],
//!   "flicker": ["pan", "sun"] }
//! ```
//!
//! `flicker` is optional: each cell is rendered again in 16 frames of each movement named, a camera pan of one pixel a
//! frame, a sun that rises by 1°, a dolly of one texel a frame, and compared with the truth of each frame ([`Track`]).
//!
//! `"decompose": true` is optional too: each cell's error is split into model, sampling and precision with f64 pictures
//! that the oracle renders after the timed rounds.
//!
//! `reconstruct`, absent = `"full"`: reconstructions of pictures from marched pixels
//! ([`crate::scene::ReconstructionInfo`]). `ghosting`, `"pan"`, `"dolly"` or both, absent = none: cells whose
//! reconstruction uses earlier frames are compared with their full render in each of 16 frames of a moving camera
//! ([`CameraTrack`]).
//!
//! A scene is a path relative to the experiment file, or that of a built-in scene, or a whole scene written in its place.
//!
//! Every other value that can vary is one value or a list; lists multiply. A value that is itself an array
//! (a position) is varied by a list of arrays. Values of a parameter that does not apply make no cells of their own; a list
//! of them that applies nowhere is refused.

use super::document::Document;
use super::locate;
use super::matrix::MAX_CELLS;
use super::scenes::{SceneAxis, SceneEntry, scenes};
use crate::error::Result;
use crate::scene::{CameraTrack, ImageSize, Track, check_name};
use schemars::JsonSchema;
use serde::{Deserialize, de::DeserializeOwned};
use serde_json::Value;
use std::path::Path;

/// Scene member behind the shorthand `sun_elevation_deg`.
const SUN_POINTER: &str = "/sun/elevation_deg";
/// Scene member behind the shorthand `view_steps`.
pub(super) const STEPS_POINTER: &str = "/march/steps";
/// Largest image side, pixels: what every wgpu adapter can allocate (`Limits::default`).
const MAX_SIDE: u32 = 8192;
/// Most timed rounds, and most discarded ones.
pub(super) const MAX_RUNS: u32 = 10_000;

/// A checked experiment file; [`super::expand`] makes the matrix of it.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Shown in reports, 1 to 200 characters.
    pub name: String,
    /// Image sizes; outer to the methods, inner to scenes and suns. Never empty.
    pub images: Vec<ImageSize>,
    /// Timed rounds that count, 1…10 000.
    pub runs: u32,
    /// Rounds run before them and thrown away, 1…10 000: the first run of a pipeline also pays for caches and clocks.
    pub discard: u32,
    /// Movements along which every cell's flicker is measured after its timed rounds; empty = none. Not an axis of the
    /// matrix: all of them are recorded in one cell.
    pub flicker: Vec<Track>,
    /// Movements along which ghosting is measured after the timed rounds, for every cell whose reconstruction uses
    /// earlier frames; empty = none. Not an axis of the matrix either.
    pub ghosting: Vec<CameraTrack>,
    /// Split every cell's error into model, sampling and precision after its timed rounds.
    pub decompose: bool,
    /// Scenes in file order. Never empty.
    pub scenes: Vec<SceneEntry>,
    /// Method settings in file order; checked against the catalogue by [`super::expand`]. Never empty.
    pub methods: Vec<MethodEntry>,
    /// Ids of reconstructions (each with its pointer in the experiment), the fastest axis of the matrix; checked
    /// against the catalogue by [`super::expand`]. Empty = every pixel is marched.
    pub reconstruct: Vec<(String, Value)>,
    document: Document,
}

/// One method and the values of its parameters.
#[derive(Clone, Debug)]
pub struct MethodEntry {
    /// Pointer of the entry in the experiment.
    pub place: String,
    /// Pointer of the id in the experiment.
    pub id_place: String,
    /// Method id as written.
    pub id: String,
    /// Name and values (each with its pointer in the experiment), in file order.
    pub params: Vec<(String, Vec<(String, Value)>)>,
}

/// The members and which of them must be there; what varies is checked when the lists are taken apart.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ExperimentFile {
    name: String,
    #[serde(rename = "image")]
    _image: Value,
    #[serde(default = "default_runs")]
    #[schemars(range(min = 1, max = 10000))]
    runs: u32,
    #[serde(default = "default_discard")]
    #[schemars(range(min = 1, max = 10000))]
    discard: u32,
    #[serde(default)]
    flicker: Option<Value>,
    #[serde(default)]
    ghosting: Option<Value>,
    #[serde(default)]
    decompose: bool,
    #[serde(rename = "scenes")]
    _scenes: Value,
    #[serde(default)]
    sun_elevation_deg: Option<Value>,
    #[serde(default)]
    view_steps: Option<Value>,
    #[serde(rename = "methods")]
    _methods: Value,
    #[serde(default)]
    reconstruct: Option<Value>,
}

pub(super) fn default_runs() -> u32 {
    5
}

pub(super) fn default_discard() -> u32 {
    1
}

/// Reads an experiment and the scene files it names (relative to its folder).
pub fn load_experiment(path: &Path) -> Result<Experiment> {
    from_document(Document::read(path)?)
}

/// An experiment from text; `path` is for messages and for what is relative to it, and need not exist.
pub fn parse_experiment(path: &Path, text: String) -> Result<Experiment> {
    from_document(Document::parse(path, text)?)
}

/// An experiment described by `value`, which was derived from file `path` with text `text`: errors name that file, and
/// the place in it where the file has a value at the same pointer.
pub fn experiment_of(path: &Path, text: String, value: Value) -> Result<Experiment> {
    from_document(Document::parse(path, text)?.part(value, ""))
}

impl Experiment {
    /// The file: for error places, and for the copy kept in the report.
    pub fn document(&self) -> &Document {
        &self.document
    }
}

pub(super) fn from_document(document: Document) -> Result<Experiment> {
    let file: ExperimentFile = document.get("")?;
    check_name(&file.name)
        .map_err(|problem| document.error("/name", problem, "Give the experiment a short name."))?;
    let enough = "5 timed runs after 1 discarded are enough for a median.";
    check_count(&document, "/runs", file.runs, enough)?;
    let first = "At least 1, because the first run of a pipeline also pays for caches and clocks.";
    check_count(&document, "/discard", file.discard, first)?;
    check_lists(&document)?;
    let shorthands = shorthands(&document, &file)?;
    let reconstruct = match file.reconstruct {
        None => Vec::new(),
        Some(_) => document.one_or_many("/reconstruct")?,
    };
    let ghosting = match file.ghosting {
        None => Vec::new(),
        Some(_) => distinct(&document, "/ghosting")?,
    };
    let each = |pointer: &str| document.one_or_many(pointer);
    Ok(Experiment {
        images: each("/image")?
            .iter()
            .map(|(place, _)| image(&document, place))
            .collect::<Result<_>>()?,
        scenes: scenes(&document, &each("/scenes")?, &shorthands)?,
        methods: each("/methods")?
            .iter()
            .map(|(place, value)| method(&document, place, value))
            .collect::<Result<_>>()?,
        name: file.name,
        decompose: file.decompose,
        runs: file.runs,
        discard: file.discard,
        flicker: match file.flicker {
            None => Vec::new(),
            Some(_) => distinct(&document, "/flicker")?,
        },
        ghosting,
        reconstruct,
        document,
    })
}

fn check_count(document: &Document, pointer: &str, count: u32, remedy: &str) -> Result<()> {
    if (1..=MAX_RUNS).contains(&count) {
        return Ok(());
    }
    let problem = format!("the value is {count}, allowed is 1…{MAX_RUNS}");
    Err(document.error(pointer, problem, remedy))
}

/// The lists at the top level multiply: what cannot fit the matrix is refused before it is copied into every scene.
fn check_lists(document: &Document) -> Result<()> {
    let length = |key: &str| match document.value().get(key) {
        Some(Value::Array(list)) => list.len().max(1),
        _ => 1,
    };
    let keys = [
        "scenes",
        "sun_elevation_deg",
        "view_steps",
        "image",
        "methods",
    ];
    let cells = keys
        .iter()
        .fold(1_usize, |n, key| n.saturating_mul(length(key)));
    if cells <= MAX_CELLS {
        return Ok(());
    }
    let lengths: Vec<String> = keys
        .iter()
        .map(|key| format!("{} {key}", length(key)))
        .collect();
    Err(document.error(
        "",
        format!("{} exceed {MAX_CELLS} cells", lengths.join(" × ")),
        "Shorten the lists or split the experiment.",
    ))
}

/// One of a few strings, or a list of them without repeats.
fn distinct<T: DeserializeOwned + JsonSchema + PartialEq>(
    document: &Document,
    pointer: &str,
) -> Result<Vec<T>> {
    let mut words = Vec::new();
    for (place, _) in document.one_or_many(pointer)? {
        let word = document.get(&place)?;
        if words.contains(&word) {
            return Err(document.error(&place, "it is listed twice", "Name each of them once."));
        }
        words.push(word);
    }
    Ok(words)
}

fn shorthands(document: &Document, file: &ExperimentFile) -> Result<Vec<SceneAxis>> {
    let given = [
        ("/sun_elevation_deg", SUN_POINTER, &file.sun_elevation_deg),
        ("/view_steps", STEPS_POINTER, &file.view_steps),
    ];
    given
        .into_iter()
        .filter(|(_, _, value)| value.is_some())
        .map(|(place, target, _)| {
            Ok(SceneAxis {
                target: target.to_owned(),
                place: place.to_owned(),
                values: document.one_or_many(place)?,
            })
        })
        .collect()
}

fn image(document: &Document, place: &str) -> Result<ImageSize> {
    let size: ImageSize = document.get(place)?;
    for (side, pixels) in [("width", size.width), ("height", size.height)] {
        if !(1..=MAX_SIDE).contains(&pixels) {
            let problem = format!("{side} is {pixels} pixels, allowed is 1…{MAX_SIDE}");
            return Err(document.error(
                &format!("{place}/{side}"),
                problem,
                "Choose a size such as 640 × 360.",
            ));
        }
    }
    Ok(size)
}

fn method(document: &Document, place: &str, value: &Value) -> Result<MethodEntry> {
    let remedy = "Write {\"method\": \"id\", \"parameter\": value or list}; `occlab methods` lists ids and parameters.";
    let entry = |id: &String, id_place, params| MethodEntry {
        place: place.to_owned(),
        id: id.clone(),
        id_place,
        params,
    };
    let members = match value {
        Value::String(id) => return Ok(entry(id, place.to_owned(), Vec::new())),
        Value::Object(members) => members,
        other => return Err(document.error(place, format!("{other} is not a method"), remedy)),
    };
    let Some(Value::String(id)) = members.get("method") else {
        return Err(document.error(
            &format!("{place}/method"),
            "the method's id is missing or not a string",
            remedy,
        ));
    };
    let params = members
        .keys()
        .filter(|name| *name != "method")
        .map(|name| {
            Ok((
                name.clone(),
                document.one_or_many(&format!("{place}{}", locate::step(name)))?,
            ))
        })
        .collect::<Result<_>>()?;
    Ok(entry(id, format!("{place}/method"), params))
}
