//! State of the window: scene, image size and two methods, as the JSON that a batch reads.

use crate::config::{Experiment, expand, load_experiment, load_scene, parse_experiment};
use crate::error::{Error, Result};
use crate::frame::atomic::write_atomic;
use crate::occlusion::MethodSetup;
use crate::reconstruct::Registry;
use crate::scene::{ImageSize, Scene};
use serde_json::{Value, json};
use std::io::Write;
use std::path::Path;

/// A scene, an image size and two methods to compare.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// A valid scene.
    pub scene: Scene,
    /// Size of exact pictures.
    pub image: ImageSize,
    /// The methods A and B.
    pub methods: [MethodSetup; 2],
}

impl State {
    /// The picture size of a state that names none.
    pub const IMAGE: ImageSize = ImageSize {
        width: 320,
        height: 180,
    };

    /// A scene with `srm` and `bsm` at their defaults.
    pub fn new(scene: Scene) -> Result<Self> {
        Ok(Self {
            scene,
            image: Self::IMAGE,
            methods: [MethodSetup::defaults("srm")?, MethodSetup::defaults("bsm")?],
        })
    }

    /// Reads a scene file, or the first scene, size and methods of an experiment file.
    pub fn load(path: &Path) -> Result<Self> {
        let is_experiment = crate::config::Document::read(path)?
            .value()
            .get("scenes")
            .is_some();
        if !is_experiment {
            return Self::new(load_scene(path)?);
        }
        Self::first_of(&load_experiment(path)?)
    }

    /// The state that [`State::experiment`] described; `place` is for messages.
    pub fn parse(place: &Path, text: String) -> Result<Self> {
        Self::first_of(&parse_experiment(place, text)?)
    }

    /// The first view of an experiment; a lone method is both A and B.
    fn first_of(experiment: &Experiment) -> Result<Self> {
        let matrix = expand(experiment, &Registry)?;
        let view = matrix.views.first().ok_or_else(|| {
            Error::input(
                experiment.document().name(),
                "the experiment has no view",
                "Give it a scene and a method.",
            )
        })?;
        let mut state = Self::new(view.scene.clone())?;
        state.image = view.image;
        let cells = [view.cells.first(), view.cells.get(1).or(view.cells.first())];
        for (method, cell) in state.methods.iter_mut().zip(cells) {
            if let Some(cell) = cell {
                *method = MethodSetup::of(&cell.method, &cell.params)?;
            }
        }
        Ok(state)
    }

    /// The state as an experiment of one view whose scene is part of the file.
    pub fn experiment(&self) -> Result<Value> {
        let mut scene = self.scene.clone();
        if let Some(path) = scene.input_file_mut() {
            *path = std::path::absolute(&*path).map_err(Error::reading(path))?;
        }
        let mut methods: Vec<Value> = Vec::new();
        for setup in &self.methods {
            let mut entry = json!({ "method": setup.method.info().id });
            for (name, value) in setup.applying().iter() {
                entry[name] = json!(value);
            }
            if !methods.contains(&entry) {
                methods.push(entry);
            }
        }
        Ok(json!({
            "name": scene.name,
            "image": self.image,
            "scenes": [{ "scene": scene }],
            "methods": methods,
        }))
    }

    /// Writes [`State::experiment`] to a file that `occlab batch` and [`State::load`] read.
    pub fn save(&self, path: &Path) -> Result<()> {
        write_json(path, &self.experiment()?)
    }

    /// Writes the scene alone, for `occlab render` and for experiments.
    pub fn save_scene(&self, path: &Path) -> Result<()> {
        write_json(path, &self.experiment()?["scenes"][0]["scene"])
    }
}

fn write_json(path: &Path, value: &Value) -> Result<()> {
    let text = serde_json::to_string_pretty(value).map_err(|e| Error::writing(path)(e.into()))?;
    write_atomic(path, |file| {
        file.write_all(text.as_bytes())
            .map_err(Error::writing(path))
    })
}
