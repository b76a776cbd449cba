//! The matrix: every combination an experiment asks for, as views (scene, sun, image size) and cells (method settings).
//!
//! Order, slowest first: scenes as listed; members of `set` as listed; `sun_elevation_deg`; `view_steps`; `image`;
//! methods as listed; their parameters as listed; `reconstruct`. The index of a cell counts in that order from 0.

use super::document::Fault;
use super::experiment::{Experiment, STEPS_POINTER};
use super::locate::{self, MemberPart};
use super::methods::{self, MethodAxes};
use super::reconstructions::{self, Catalogue};
use super::scene_of;
use super::scenes::{SceneAxis, SceneEntry};
use crate::error::{Error, Result};
use crate::param::Params;
use crate::scene::{ImageSize, ReconstructionInfo, Scene};
use serde_json::{Map, Value};
use std::collections::HashSet;

/// Most cells of one experiment, duplicates included; checked before any is built.
pub const MAX_CELLS: usize = 100_000;

/// Everything an experiment asks for.
#[derive(Clone, Debug)]
pub struct Matrix {
    /// Views in matrix order, no two alike.
    pub views: Vec<MatrixView>,
    /// Notes for the user: duplicates that were dropped, parameters without effect.
    pub notes: Vec<String>,
}

/// One scene under one sun at one image size: all its cells share a truth.
#[derive(Clone, Debug)]
pub struct MatrixView {
    /// The scene, fully resolved.
    pub scene: Scene,
    /// Values that the experiment sets in the scene file (sun and view steps included), by JSON pointer.
    pub scene_set: Map<String, Value>,
    /// Image size.
    pub image: ImageSize,
    /// Cells in matrix order, no two alike.
    pub cells: Vec<CellSpec>,
}

/// One method at one setting.
#[derive(Clone, Debug, PartialEq)]
pub struct CellSpec {
    /// Position in the matrix, from 0.
    pub index: usize,
    /// Method id.
    pub method: String,
    /// Every parameter of the method that applies, defaults included.
    pub params: Params,
    /// Reconstruction of its pictures from the marched pixels.
    pub reconstruct: &'static ReconstructionInfo,
}

impl Matrix {
    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.views.iter().map(|view| view.cells.len()).sum()
    }
}

/// Multiplies the lists of `experiment`; checks every reconstruction, method, parameter and resulting scene.
pub fn expand(experiment: &Experiment, catalogue: &dyn Catalogue) -> Result<Matrix> {
    let reconstructions = reconstructions::check(experiment, catalogue)?;
    let methods = methods::check(experiment, catalogue)?;
    check_size(experiment, &methods, reconstructions.len())?;
    let mut matrix = Matrix {
        views: Vec::new(),
        notes: Vec::new(),
    };
    let settings = settings(&methods, &mut matrix.notes)?;
    let mut seen = HashSet::new();
    for entry in &experiment.scenes {
        for n in 0..count(&entry.axes) {
            let (scene, scene_set) = scene_at(experiment, entry, n)?;
            for image in &experiment.images {
                if !seen.insert(key(&(&scene, image))?) {
                    matrix.notes.push(format!(
                        "{} {} at {}×{} repeats an earlier view and is dropped",
                        scene.name,
                        set_text(&scene_set),
                        image.width,
                        image.height
                    ));
                    continue;
                }
                let each = reconstructions.len();
                let first = matrix.views.len() * settings.len() * each;
                let cells = (0..settings.len() * each)
                    .map(|i| {
                        let (method, params) = settings[i / each].clone();
                        CellSpec {
                            index: first + i,
                            method,
                            params,
                            reconstruct: reconstructions[i % each],
                        }
                    })
                    .collect();
                matrix.views.push(MatrixView {
                    scene: scene.clone(),
                    scene_set: scene_set.clone(),
                    image: *image,
                    cells,
                });
            }
        }
    }
    Ok(matrix)
}

fn count(axes: &[SceneAxis]) -> usize {
    axes.iter()
        .fold(1, |n, axis| n.saturating_mul(axis.values.len()))
}

fn check_size(experiment: &Experiment, methods: &[MethodAxes], each: usize) -> Result<()> {
    let scenes = experiment
        .scenes
        .iter()
        .fold(0_usize, |n, entry| n.saturating_add(count(&entry.axes)));
    let settings = methods
        .iter()
        .fold(0_usize, |n, method| n.saturating_add(method.count()))
        .saturating_mul(each);
    let cells = scenes
        .saturating_mul(experiment.images.len())
        .saturating_mul(settings);
    if cells <= MAX_CELLS {
        return Ok(());
    }
    let problem = format!(
        "{scenes} scenes × {} images × {settings} method settings exceed {MAX_CELLS} cells",
        experiment.images.len()
    );
    Err(experiment
        .document()
        .error("", problem, "Shorten the lists or split the experiment."))
}

/// All method settings of a view, without duplicates: settings that differ only in parameters that do not apply are
/// one.
fn settings(methods: &[MethodAxes], notes: &mut Vec<String>) -> Result<Vec<(String, Params)>> {
    let (mut seen, mut listed) = (HashSet::new(), HashSet::new());
    let mut all = Vec::new();
    for method in methods {
        notes.extend(method.notes());
        for n in 0..method.count() {
            let setting = method.setting(n);
            let params = method.applying(&setting);
            let repeated = !listed.insert(key(&(&method.id, &setting))?);
            if seen.insert(key(&(&method.id, &params))?) {
                all.push((method.id.clone(), params));
            } else if repeated {
                notes.push(format!(
                    "{} {} repeats an earlier setting and is dropped",
                    method.id,
                    params_text(&params)
                ));
            }
        }
    }
    Ok(all)
}

fn key(value: &impl serde::Serialize) -> Result<String> {
    serde_json::to_string(value).map_err(|e| Error::defect("matrix", e))
}

/// An axis and the value picked from it, with that value's place.
type Chosen<'a> = (&'a SceneAxis, &'a (String, Value));

/// Combination `n` of a scene's axes, deserialised and validated.
fn scene_at(
    experiment: &Experiment,
    entry: &SceneEntry,
    mut n: usize,
) -> Result<(Scene, Map<String, Value>)> {
    let mut chosen: Vec<Chosen<'_>> = Vec::with_capacity(entry.axes.len());
    for axis in entry.axes.iter().rev() {
        chosen.push((axis, &axis.values[n % axis.values.len()]));
        n /= axis.values.len();
    }
    chosen.reverse();
    let mut value = entry.document.value().clone();
    if let Some(members) = value.as_object_mut() {
        // Every member of `march` has a default, so that an absent one equals an empty one, whose members can be set.
        members
            .entry("march")
            .or_insert_with(|| Value::Object(Map::new()));
    }
    let mut scene_set = Map::new();
    for (axis, (_, new)) in &chosen {
        set(&mut value, &axis.target, new).map_err(|problem| {
            let remedy = "Only the last step of the path may be new; `occlab schema` prints the members of a scene.";
            experiment.document().error_at_key(
                &axis.place,
                format!("cannot set `{}` in {}: {problem}", axis.target, entry.document.name()),
                remedy,
            )
        })?;
        scene_set.insert(axis.target.clone(), new.clone());
    }
    let scene = scene_of(&value, entry.document.folder())
        .map_err(|fault| blame(experiment, entry, &chosen, fault))?;
    if let (Some(_), Some(axis)) = (
        scene.march.step_m,
        entry.axes.iter().find(|axis| axis.target == STEPS_POINTER),
    ) {
        let problem = format!(
            "{} fixes /march/step_m, so that the number of view steps has no effect",
            entry.document.name()
        );
        return Err(experiment.document().error_at_key(
            &axis.place,
            problem,
            "Remove one of the two, or set /march/step_m to null for this scene.",
        ));
    }
    Ok((scene, scene_set))
}

/// Writes `new` at `pointer`; the parent must exist, a member of an object may be created.
pub(super) fn set(root: &mut Value, pointer: &str, new: &Value) -> Result<(), String> {
    let (parent, last) = pointer.rsplit_once('/').ok_or("it is empty")?;
    let last = locate::steps(&format!("/{last}"))
        .next()
        .unwrap_or_default();
    match root.pointer_mut(parent) {
        Some(Value::Object(members)) => {
            members.insert(last, new.clone());
            Ok(())
        }
        Some(Value::Array(list)) => {
            let length = list.len();
            let slot = last.parse::<usize>().ok().and_then(|i| list.get_mut(i));
            slot.map(|slot| *slot = new.clone()).ok_or(format!(
                "the list has {length} elements, `{last}` is none of them"
            ))
        }
        Some(_) => Err(format!("`{parent}` is neither an object nor a list")),
        None => Err(format!("`{parent}` does not exist")),
    }
}

/// The error for a scene that cannot be used. It names the value that the experiment sets; the scene file when that is
/// invalid by itself; else the set value nearest to the fault, or the entry when values that are valid alone do not fit
/// together.
fn blame(
    experiment: &Experiment,
    entry: &SceneEntry,
    chosen: &[Chosen<'_>],
    fault: Fault,
) -> Error {
    let inside = |a: &str, b: &str| {
        a.strip_prefix(b)
            .is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
    };
    let mut guilty = chosen
        .iter()
        .rev()
        .find(|(axis, _)| inside(&fault.pointer, &axis.target));
    if guilty.is_none() {
        if let Err(own) = scene_of(entry.document.value(), entry.document.folder()) {
            return entry.document.fault(own);
        }
        guilty = chosen
            .iter()
            .rev()
            .find(|(axis, _)| !fault.pointer.is_empty() && inside(&axis.target, &fault.pointer));
    }
    let document = experiment.document();
    let problem = format!(
        "{} at {} of {}",
        fault.problem,
        fault.pointer,
        entry.document.name()
    );
    match guilty {
        None => document.error(&entry.place, problem, fault.remedy),
        Some((axis, _)) if fault.part == MemberPart::Key && axis.target == fault.pointer => {
            document.error_at_key(&axis.place, problem, fault.remedy)
        }
        Some((_, (place, _))) if fault.wants_list => document.error(
            place,
            problem,
            format!(
                "To vary a member that is a list, give a list of lists. {}",
                fault.remedy
            ),
        ),
        Some((_, (place, _))) => document.error(place, problem, fault.remedy),
    }
}

/// `name=value` of every parameter, separated by blanks.
fn params_text(params: &Params) -> String {
    params
        .iter()
        .map(|(name, value)| format!("{name}={value}"))
        .collect::<Vec<_>>()
        .join(" ")
}

/// The parameters, and the reconstruction where it does not march every pixel.
fn cell_text(cell: &CellSpec) -> String {
    let params = params_text(&cell.params);
    match cell.reconstruct {
        full if full.is_full() => params,
        other => format!("{params} reconstruct={}", other.id),
    }
}

fn set_text(set: &Map<String, Value>) -> String {
    set.iter()
        .map(|(pointer, value)| format!("{pointer}={value}"))
        .collect::<Vec<_>>()
        .join(" ")
}

/// Text of the dry run: one line a cell, then the count and the notes.
pub fn describe(matrix: &Matrix) -> String {
    let header = [
        "cell",
        "scene",
        "sun",
        "image",
        "method",
        "parameters",
        "set",
    ]
    .map(str::to_owned);
    let mut rows = vec![header];
    for view in &matrix.views {
        for cell in &view.cells {
            rows.push([
                cell.index.to_string(),
                view.scene.name.clone(),
                format!("{}°", view.scene.sun.elevation_deg),
                format!("{}×{}", view.image.width, view.image.height),
                cell.method.clone(),
                cell_text(cell),
                set_text(&view.scene_set),
            ]);
        }
    }
    let widths: Vec<usize> = (0..7)
        .map(|c| {
            rows.iter()
                .map(|row| row[c].chars().count())
                .max()
                .unwrap_or(0)
        })
        .collect();
    let line = |row: &[String; 7]| {
        let padded: Vec<String> = row
            .iter()
            .zip(&widths)
            .map(|(text, width)| format!("{text:<width$}"))
            .collect();
        padded.join("  ").trim_end().to_owned()
    };
    let mut lines: Vec<String> = rows.iter().map(line).collect();
    lines.push(format!(
        "{} cells in {} views",
        matrix.cell_count(),
        matrix.views.len()
    ));
    lines.extend(matrix.notes.iter().map(|note| format!("note: {note}")));
    lines.join("\n") + "\n"
}
