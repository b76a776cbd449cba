//! The stability file: small scenes, and cases that set one of their values to an extreme.
//!
//! ```json
//! { "name": "stability", "image": {"width": 12, "height": 8}, "params": {"resolution": 16, "steps": 100},
//!   "volumes": {"spike": {"cells": [8, 100, 8], "fill": [{"from": [4, 60, 4], "to": [5, 61, 5], "value": 1}]}},
//!   "scenes": {"box": { … }},
//!   "extremes": [{"group": "extinction, 1/m", "name": "10", "scene": "box", "set": {"/medium/extinction_per_m": 10}}] }
//! ```
//!
//! A volume is written to `inputs/NAME.npy` of the output folder; scenes name it by that path.

use super::document::{Document, Fault, deserialize};
use super::methods::MethodCatalogue;
use super::{locate, matrix, suggest};
use crate::error::Result;
use crate::param::{ParamSpec, ParamValue, Params};
use crate::scene::{ImageSize, Scene};
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::path::Path;

/// Most cells of a volume that a stability file describes: such volumes are tiny.
const MAX_CELLS: u64 = 1 << 22;
/// Largest image side, pixels.
const MAX_SIDE: u32 = 8192;

/// A checked stability file.
#[derive(Clone, Debug)]
pub struct Stability {
    /// Shown on the page, 1 to 200 characters.
    pub name: String,
    /// Volumes by name.
    pub volumes: BTreeMap<String, VolumeFile>,
    /// Cases in file order. Never empty.
    pub extremes: Vec<Extreme>,
}

/// Parameters by name; each method takes those that it declares.
pub type Settings = BTreeMap<&'static str, ParamValue>;

/// One case: a scene at an extreme.
#[derive(Clone, Debug)]
pub struct Extreme {
    /// Quantity that the case sets, with its unit.
    pub group: String,
    /// Its value, in words.
    pub name: String,
    /// The scene; the reason of the refusal where the file says that it must be refused.
    pub scene: Result<Box<Scene>, String>,
    /// Picture size.
    pub image: ImageSize,
    /// Parameters of every method that declares them.
    pub common: Settings,
    /// Parameters that the case is about: methods that lack one of them do not take part.
    pub params: Settings,
    /// Left out of the quick profile.
    pub full_only: bool,
}

/// A volume: zeros, then boxes of cells.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VolumeFile {
    /// Cells along x, y (up), z.
    pub cells: [u32; 3],
    /// Boxes of one value; later ones win.
    pub fill: Vec<Fill>,
}

/// Cells `from` ≤ index < `to` get `value`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fill {
    /// First cell along x, y, z.
    pub from: [u32; 3],
    /// One past the last.
    pub to: [u32; 3],
    /// Density, finite and ≥ 0.
    pub value: f32,
}

/// The file.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Stability")]
pub(super) struct StabilityFile {
    /// Shown on the page, 1 to 200 characters.
    name: String,
    /// Picture size of cases that give none.
    image: ImageSize,
    /// Parameters of every method that declares them.
    #[serde(default)]
    params: Map<String, Value>,
    /// Volumes by name.
    #[serde(default)]
    volumes: BTreeMap<String, VolumeFile>,
    /// Scenes by name; what a case sets may make them whole.
    scenes: Map<String, Value>,
    /// The cases.
    extremes: Vec<FileExtreme>,
}

/// A case.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Extreme")]
struct FileExtreme {
    /// What is pushed, with its unit.
    group: String,
    /// How far.
    name: String,
    /// Name of the scene.
    scene: String,
    /// Members of the scene by JSON pointer.
    #[serde(default)]
    set: Map<String, Value>,
    /// Parameters that the case is about.
    #[serde(default)]
    params: Map<String, Value>,
    /// Picture size.
    #[serde(default)]
    image: Option<ImageSize>,
    /// The scene must be refused.
    #[serde(default)]
    refused: bool,
    /// Left out of the quick profile.
    #[serde(default)]
    full_only: bool,
}

/// Reads a stability file. Volumes of its scenes are looked for below `folder`, the output folder.
pub fn load_stability(
    path: &Path,
    folder: &Path,
    catalogue: &dyn MethodCatalogue,
) -> Result<Stability> {
    from_document(&Document::read(path)?, folder, catalogue)
}

/// [`load_stability`] from text; `path` is for messages.
pub fn parse_stability(
    path: &Path,
    text: String,
    folder: &Path,
    catalogue: &dyn MethodCatalogue,
) -> Result<Stability> {
    from_document(&Document::parse(path, text)?, folder, catalogue)
}

fn from_document(
    document: &Document,
    folder: &Path,
    catalogue: &dyn MethodCatalogue,
) -> Result<Stability> {
    let file: StabilityFile = document.get("")?;
    if file.name.is_empty() || file.name.chars().count() > 200 {
        let remedy = "Give the sweep a short name.";
        return Err(document.error("/name", "the name must have 1 to 200 characters", remedy));
    }
    if file.extremes.is_empty() {
        return Err(document.error("/extremes", "the list is empty", "Name at least one case."));
    }
    check_image(document, "/image", file.image)?;
    for (name, volume) in &file.volumes {
        check_volume(document, name, volume)?;
    }
    let ids = catalogue.ids();
    let specs: Vec<_> = ids
        .into_iter()
        .filter_map(|id| catalogue.params(id))
        .flatten()
        .collect();
    let common = settings(document, "/params", &file.params, &specs)?;
    let reader = Reader {
        document,
        specs: &specs,
        catalogue,
        folder,
    };
    let extremes = (0..file.extremes.len())
        .map(|i| reader.extreme(&file, i, &common))
        .collect::<Result<_>>()?;
    Ok(Stability {
        name: file.name,
        volumes: file.volumes,
        extremes,
    })
}

fn check_image(document: &Document, place: &str, image: ImageSize) -> Result<()> {
    for (side, pixels) in [("width", image.width), ("height", image.height)] {
        if !(1..=MAX_SIDE).contains(&pixels) {
            let problem = format!("{side} is {pixels} pixels, allowed is 1…{MAX_SIDE}");
            let remedy = "Choose a size such as 12 × 8.";
            return Err(document.error(&format!("{place}/{side}"), problem, remedy));
        }
    }
    Ok(())
}

fn check_volume(document: &Document, name: &str, volume: &VolumeFile) -> Result<()> {
    let place = format!("/volumes{}", locate::step(name));
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-';
    if name.is_empty() || name.len() > 60 || !name.chars().all(plain) {
        let problem = format!("`{name}` cannot name a file");
        let remedy = "Use 1 to 60 letters, digits and hyphens.";
        return Err(document.error_at_key(&place, problem, remedy));
    }
    let cells = volume.cells.iter().map(|n| u64::from(*n));
    let count = cells.fold(1, u64::saturating_mul);
    if count == 0 || count > MAX_CELLS {
        let problem = format!("{count} cells, allowed are 1…{MAX_CELLS}");
        let remedy = "Choose fewer cells.";
        return Err(document.error(&format!("{place}/cells"), problem, remedy));
    }
    for (i, fill) in volume.fill.iter().enumerate() {
        let inside = (0..3).all(|k| fill.from[k] < fill.to[k] && fill.to[k] <= volume.cells[k]);
        if !inside || !fill.value.is_finite() || fill.value < 0.0 {
            let problem =
                "the box must hold cells of the volume, its value must be finite and not below 0";
            let remedy = "Correct `from`, `to` or `value`.";
            return Err(document.error(&format!("{place}/fill/{i}"), problem, remedy));
        }
    }
    Ok(())
}

/// Parameters checked against the methods that declare them.
fn settings(
    document: &Document,
    place: &str,
    members: &Map<String, Value>,
    specs: &[&'static ParamSpec],
) -> Result<Settings> {
    let mut out = Settings::new();
    for (name, value) in members {
        let place = format!("{place}{}", locate::step(name));
        let mut named = specs.iter().filter(|spec| spec.name == name).peekable();
        if named.peek().is_none() {
            let known = specs.iter().map(|spec| spec.name);
            let remedy = format!(
                "{}`occlab methods` lists them.",
                suggest::sentence(name, known)
            );
            let problem = format!("no method has a parameter `{name}`");
            return Err(document.error_at_key(&place, problem, remedy));
        }
        for spec in named {
            let value = spec.parse(value).map_err(|problem| {
                let remedy = "`occlab methods` lists what is allowed.";
                document.error(&place, problem, remedy)
            })?;
            out.insert(spec.name, value);
        }
    }
    Ok(out)
}

/// What all cases are read with: the file, the methods and the output folder.
struct Reader<'a> {
    document: &'a Document,
    specs: &'a [&'static ParamSpec],
    catalogue: &'a dyn MethodCatalogue,
    folder: &'a Path,
}

impl Reader<'_> {
    fn extreme(&self, file: &StabilityFile, index: usize, common: &Settings) -> Result<Extreme> {
        let Self {
            document,
            specs,
            folder,
            ..
        } = self;
        let place = format!("/extremes/{index}");
        let entry = &file.extremes[index];
        let Some(base) = file.scenes.get(&entry.scene) else {
            let names = file.scenes.keys().map(String::as_str);
            let remedy = format!(
                "{}Scenes stand under `scenes`.",
                suggest::sentence(&entry.scene, names)
            );
            let problem = format!("there is no scene `{}`", entry.scene);
            return Err(document.error(&format!("{place}/scene"), problem, remedy));
        };
        let mut value = base.clone();
        for (target, new) in &entry.set {
            matrix::set(&mut value, target, new).map_err(|problem| {
                let place = format!("{place}/set{}", locate::step(target));
                let remedy = "Only the last step of the path may be new.";
                document.error_at_key(&place, format!("cannot set `{target}`: {problem}"), remedy)
            })?;
        }
        let mut scene: Scene =
            deserialize(&value).map_err(|fault| document.fault(blamed(&place, entry, fault)))?;
        let scene = match (scene.validate(), entry.refused) {
            (Ok(()), false) => {
                scene.resolve_paths(folder);
                Ok(Box::new(scene))
            }
            (Err(problem), true) => Err(format!("{}: {}", problem.pointer, problem.message)),
            (Err(problem), false) => {
                return Err(document.fault(blamed(&place, entry, problem.into())));
            }
            (Ok(()), true) => {
                let problem = "the scene is valid, but the file says that it must be refused";
                let remedy = "Remove `refused`, or push the value further.";
                return Err(document.error(&format!("{place}/refused"), problem, remedy));
            }
        };
        let image = entry.image.unwrap_or(file.image);
        check_image(document, &format!("{place}/image"), image)?;
        let params = settings(document, &format!("{place}/params"), &entry.params, specs)?;
        self.check_effect(&place, common, &params)?;
        Ok(Extreme {
            group: entry.group.clone(),
            name: entry.name.clone(),
            scene,
            image,
            common: common.clone(),
            params,
            full_only: entry.full_only,
        })
    }
}

impl Reader<'_> {
    /// Refuses a case that is about parameters which no method has, or none at a setting where they apply.
    fn check_effect(&self, place: &str, common: &Settings, params: &Settings) -> Result<()> {
        let takes_part = |id: &&str| {
            let specs = self.catalogue.params(id).unwrap_or_default();
            let mut all = Params::defaults(specs.iter().copied());
            let given = common.iter().chain(params);
            for (name, value) in given.filter(|(name, _)| specs.iter().any(|s| s.name == **name)) {
                all.set(name, *value);
            }
            let applying = all.applying(specs.iter().copied());
            params.keys().all(|name| applying.get(name).is_some())
        };
        if params.is_empty() || self.catalogue.ids().iter().any(takes_part) {
            return Ok(());
        }
        let problem = "no method has all of these parameters at a setting where they apply";
        let remedy = "Leave one out or set what it depends on; `occlab methods` lists both.";
        let place = format!("{place}/params");
        Err(self.document.error(&place, problem, remedy))
    }
}

/// A fault of a scene at the value that the extreme sets there, or in the scene itself.
fn blamed(place: &str, entry: &FileExtreme, fault: Fault) -> Fault {
    let inside = |target: &&String| {
        let rest = fault.pointer.strip_prefix(target.as_str());
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
    };
    let pointer = match entry.set.keys().find(inside) {
        Some(target) => format!("{place}/set{}", locate::step(target)),
        None => format!("/scenes{}{}", locate::step(&entry.scene), fault.pointer),
    };
    Fault { pointer, ..fault }
}
