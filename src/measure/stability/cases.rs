//! Cases of a sweep: every setting of every method, and the generated volumes of the scenes.

use super::record::Setting;
use crate::config::{Extreme, VolumeFile};
use crate::error::{Error, Result};
use crate::frame::atomic::write_atomic;
use crate::occlusion::{MethodSetup, REGISTRY};
use crate::param::{ParamKind, ParamSpec, ParamValue};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

/// Parameters whose options give rows of their own.
const CHOICES: [&str; 3] = ["form", "storage", "lookup"];

/// Every setting of every registered method: form, storage and look-up, where it has them. Settings that a method refuses
/// are left out.
pub fn settings() -> Vec<Setting> {
    let mut out = Vec::new();
    for method in REGISTRY {
        let info = method.info();
        let options = |name: &str| {
            let declared = info.specs().find(|spec| spec.name == name);
            match declared.map(|spec| spec.kind) {
                Some(ParamKind::Choice { options, .. }) => options,
                _ => &["-"],
            }
        };
        let [forms, storages, lookups] = CHOICES.map(options);
        for form in forms {
            for storage in storages {
                let settings = lookups.iter().map(|lookup| Setting {
                    method: info.id.to_owned(),
                    form: (*form).to_owned(),
                    storage: (*storage).to_owned(),
                    lookup: (*lookup).to_owned(),
                });
                out.extend(settings.filter(combines));
            }
        }
    }
    out
}

/// Whether the method has a map, or none, at this setting: not every look-up reads every storage.
fn combines(setting: &Setting) -> bool {
    let setup = MethodSetup::defaults(&setting.method).and_then(|setup| chosen(setup, setting));
    setup.is_ok_and(|setup| setup.method.plan(&setup.params).is_ok())
}

/// The method with the choices of a row.
fn chosen(mut setup: MethodSetup, setting: &Setting) -> Result<MethodSetup> {
    let options = [&setting.form, &setting.storage, &setting.lookup];
    for (name, option) in CHOICES.iter().zip(options) {
        if option != "-" {
            setup = setup.with(name, option)?;
        }
    }
    Ok(setup)
}

/// The method of a row at an extreme; `None` where it lacks a parameter of the extreme, or one does not apply.
pub fn setup(
    setting: &Setting,
    extreme: &Extreme,
    truth_step_m: f64,
) -> Result<Option<MethodSetup>> {
    let mut setup = MethodSetup::defaults(&setting.method)?;
    let specs: Vec<&'static ParamSpec> = setup.method.info().specs().collect();
    let declares = |name: &str| specs.iter().any(|spec| spec.name == name);
    if !extreme.params.keys().all(|name| declares(name)) {
        return Ok(None);
    }
    for (name, value) in extreme.common.iter().chain(&extreme.params) {
        if declares(name) {
            setup.params.set(name, *value);
        }
    }
    if setup.method.info().is_truth() {
        setup.params.set("step_m", ParamValue::Float(truth_step_m));
    }
    let setup = chosen(setup, setting)?;
    let applying = setup.applying();
    let all_apply = extreme.params.keys().all(|n| applying.get(n).is_some());
    Ok(all_apply.then_some(setup))
}

/// Writes every volume to `inputs/NAME.npy` below `folder`, f32, C order, axes z, y (up), x.
pub fn write_volumes(folder: &Path, volumes: &BTreeMap<String, VolumeFile>) -> Result<()> {
    let inputs = folder.join("inputs");
    std::fs::create_dir_all(&inputs).map_err(Error::writing(&inputs))?;
    for (name, volume) in volumes {
        let path = inputs.join(format!("{name}.npy"));
        write_atomic(&path, |file| {
            write_volume(file, volume).map_err(Error::writing(&path))
        })?;
    }
    Ok(())
}

/// One volume as a NumPy file.
fn write_volume(file: impl Write, volume: &VolumeFile) -> std::io::Result<()> {
    let [nx, ny, nz] = volume.cells.map(|n| n as usize);
    let mut values = vec![0.0f32; nx * ny * nz];
    for fill in &volume.fill {
        let ([x0, y0, z0], [x1, y1, z1]) = (fill.from, fill.to);
        for z in z0..z1 {
            for y in y0..y1 {
                let row = (z as usize * ny + y as usize) * nx;
                values[row + x0 as usize..row + x1 as usize].fill(fill.value);
            }
        }
    }
    crate::density::volume::save(file, volume.cells, values)
}
