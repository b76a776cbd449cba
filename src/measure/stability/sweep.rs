//! Measures the cases of a sweep and writes a record of each: a killed sweep is resumed.

use super::cases::{settings, setup};
use super::columns::{ColumnProbe, measure as measure_columns, probes};
use super::pictures;
use super::record::{Columns, FormVerdict, SCHEMA, Setting, SweepCase, SweepPicture, SweepRow};
use crate::config::{Extreme, Stability};
use crate::environment::Environment;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::frame::atomic::write_atomic;

use crate::occlusion::rounding::Rounding;
use crate::occlusion::{MethodSetup, Role, playing};
use crate::oracle::{Options, Oracle};
use crate::provenance::cell_sources;
use crate::raymarch::Renderer;
use crate::scene::Scene;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A light ray of the truth takes at most about this many steps: llvmpipe ends loops after 65 535 iterations, and more
/// steps take too long.
const TRUTH_STEPS: f64 = 4000.0;
/// Steps of the longest light ray in a uniform medium, which needs no small ones.
const UNIFORM_STEPS: f64 = 64.0;

/// A method setting that takes part in a case.
struct Entrant {
    setting: Setting,
    setup: MethodSetup,
}

/// Step of the truth's light march, metres: the scene's own, longer where rays are very long, long in a uniform medium.
fn truth_step_m(scene: &Scene) -> f64 {
    let longest_m = scene.container.longest_path_m();
    match scene.density.field().is_uniform() {
        true => longest_m / UNIFORM_STEPS,
        false => scene.truth_step_m().max(longest_m / TRUTH_STEPS),
    }
}

/// Hash of everything that determines a case: 16 hexadecimal digits.
pub(super) fn case_id(
    stability: &Stability,
    extreme: &Extreme,
    renderer: Option<&Renderer>,
) -> String {
    let mut scene = extreme.scene.clone().ok();
    // The volume counts by its description, not by its folder.
    let mut volume = Value::Null;
    if let Some(path) = scene.as_mut().and_then(|scene| scene.input_file_mut()) {
        let name = path.file_stem().and_then(|stem| stem.to_str());
        let name = name.unwrap_or_default();
        volume = json!(stability.volumes.get(name).map(|v| format!("{v:?}")));
        *path = name.into();
    }
    // The commit is left out: commits of the same sources give the same results.
    let environment = renderer.map(|renderer| Environment {
        commit: String::new(),
        ..Environment::of_device(&renderer.gpu)
    });
    let key = json!([
        SCHEMA,
        cell_sources(),
        environment,
        [&extreme.group, &extreme.name],
        scene,
        volume,
        extreme.image,
        extreme.common,
        extreme.params,
    ]);
    blake3::hash(key.to_string().as_bytes()).to_hex()[..16].to_owned()
}

/// File of a case's record.
pub(super) fn record_path(folder: &Path, id: &str) -> PathBuf {
    folder.join("records").join(format!("{id}.json"))
}

/// A record of an earlier run; one that cannot be read is made again.
pub(super) fn recorded(folder: &Path, id: &str) -> Option<SweepCase> {
    let text = std::fs::read(record_path(folder, id)).ok()?;
    serde_json::from_slice(&text).ok()
}

/// Measures a case and writes its record atomically.
pub(super) fn run_case(
    stability: &Stability,
    extreme: &Extreme,
    renderer: Option<&Renderer>,
    folder: &Path,
) -> Result<SweepCase> {
    let case = measure(extreme, renderer, case_id(stability, extreme, renderer))?;
    let path = record_path(folder, &case.id);
    let text = serde_json::to_vec(&case).map_err(|e| Error::writing(&path)(e.into()))?;
    write_atomic(&path, |file| {
        file.write_all(&text).map_err(Error::writing(&path))
    })?;
    Ok(case)
}

fn measure(extreme: &Extreme, renderer: Option<&Renderer>, id: String) -> Result<SweepCase> {
    let start = Instant::now();
    let mut case = SweepCase {
        id,
        group: extreme.group.clone(),
        name: extreme.name.clone(),
        refused: None,
        wall_s: 0.0,
        depths: Vec::new(),
        truth: Vec::new(),
        rows: Vec::new(),
    };
    match &extreme.scene {
        Err(reason) => case.refused = Some(reason.clone()),
        Ok(scene) => {
            let oracle = Oracle::new(scene, extreme.image)?;
            let entrants = entrants(extreme, scene)?;
            let aspect = f64::from(extreme.image.width) / f64::from(extreme.image.height);
            let probes = probes(&oracle, scene, aspect);
            if let Some(first) = probes.first() {
                let longest = first.depths_m.last().copied().unwrap_or(1.0);
                case.depths = first.depths_m.iter().map(|d| d / longest).collect();
                case.truth.clone_from(&first.truth);
            }
            case.rows = entrants
                .par_iter()
                .map(|entrant| row(&oracle, &probes, entrant))
                .collect::<Result<_>>()?;
            if let Some(renderer) = renderer {
                let pictures = device_pictures(renderer, extreme, scene, &oracle, &entrants)?;
                for (row, picture) in case.rows.iter_mut().zip(pictures) {
                    row.device = Some(picture);
                }
            }
        }
    }
    case.wall_s = start.elapsed().as_secs_f64();
    Ok(case)
}

fn entrants(extreme: &Extreme, scene: &Scene) -> Result<Vec<Entrant>> {
    let step_m = truth_step_m(scene);
    let mut out = Vec::new();
    for setting in settings() {
        if let Some(setup) = setup(&setting, extreme, step_m)? {
            out.push(Entrant { setting, setup });
        }
    }
    Ok(out)
}

/// The oracle's part of a row.
fn row(oracle: &Oracle, probes: &[ColumnProbe], entrant: &Entrant) -> Result<SweepRow> {
    let with = |flush| {
        let mut rounding = Rounding::device(&entrant.setting.storage, flush);
        if let Some(format) = entrant.setup.stored_format()? {
            rounding.storage = format;
        }
        match measure_columns(oracle, probes, &entrant.setup, rounding) {
            Err(error) if error.concerns_one_cell() => Ok((refused(&error), Vec::new())),
            other => other,
        }
    };
    let (kept, _) = with(false)?;
    let (flushed, curve) = with(true)?;
    let finite = |t: f64| t.is_finite().then_some(t as f32);
    Ok(SweepRow {
        setting: entrant.setting.clone(),
        kept,
        flushed,
        device: None,
        curve: curve.into_iter().map(finite).collect(),
    })
}

fn refused(error: &Error) -> Columns {
    Columns {
        verdict: FormVerdict::Refused,
        reason: Some(error.to_string()),
        nonfinite: 0,
        nonfinite_stored: 0,
        range: None,
        rises: 0,
        largest_rise: 0.0,
        max_error: None,
        weighted_rmse: None,
    }
}

fn device_pictures(
    renderer: &Renderer,
    extreme: &Extreme,
    scene: &Scene,
    oracle: &Oracle,
    entrants: &[Entrant],
) -> Result<Vec<SweepPicture>> {
    let view = match renderer.view(scene, extreme.image) {
        Ok(view) => view,
        Err(error) if error.concerns_one_cell() => {
            return Ok(entrants.iter().map(|_| pictures::failed(&error)).collect());
        }
        Err(error) => return Err(error),
    };
    let truth = reference(oracle, scene)?;
    entrants
        .iter()
        .map(|entrant| pictures::measure(renderer, &view, &entrant.setup, &truth))
        .collect()
}

/// The oracle's picture of the truth.
fn reference(oracle: &Oracle, scene: &Scene) -> Result<Frame> {
    let truth = MethodSetup::new(playing(Role::Truth)?);
    let setup = truth.with("step_m", &truth_step_m(scene).to_string())?;
    oracle.render(&setup, Options::default())
}
