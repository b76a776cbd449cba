//! Keys of a batch's records: a hash of everything that decides their numbers, so that a resumed run keeps a record
//! only where measuring again would give the same.
//!
//! Hashed are the scene, and the content (not the name) of the file that it reads; the image; the method and its
//! parameters; the reconstruction; and the sources of the program and its shaders. The adapter is not hashed: a folder
//! belongs to one.

use super::record::{InputFile, SceneRecord};
use crate::backend::Backend;
use crate::config::{CellSpec, Matrix, MatrixView};
use crate::density::volume::file_of;
use crate::error::{Error, Result};
use crate::scene::Scene;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs::Metadata;
use std::path::{Component, Path, PathBuf};
use std::time::SystemTime;

/// Computes the keys of one batch's records.
pub(super) struct Identity {
    sources: String,
    inputs: BTreeMap<PathBuf, Input>,
}

/// A file that scenes read, as it was when the batch began.
struct Input {
    hash: String,
    bytes: u64,
    modified: Option<SystemTime>,
}

impl Identity {
    /// Reads every file that the scenes of a matrix read.
    pub fn new(backend: &Backend, matrix: &Matrix) -> Result<Self> {
        let mut inputs = BTreeMap::new();
        for path in matrix.views.iter().filter_map(|v| v.scene.input_file()) {
            if !inputs.contains_key(path) {
                inputs.insert(path.to_owned(), Input::read(path)?);
            }
        }
        Ok(Self {
            sources: backend.sources(),
            inputs,
        })
    }

    /// Hash of the sources that decide the numbers.
    pub fn sources(&self) -> &str {
        &self.sources
    }

    /// Path and hash of every file that the scenes read.
    pub fn hashes(&self) -> BTreeMap<String, String> {
        let entry = |(path, input): (&PathBuf, &Input)| (text(path), input.hash.clone());
        self.inputs.iter().map(entry).collect()
    }

    /// Key of a view, and so of its truth.
    pub fn view(&self, view: &MatrixView) -> String {
        let scene = self.content(&view.scene);
        digest(&json!([self.sources, scene, view.image]))
    }

    /// Key of a cell.
    pub fn cell(&self, view: &MatrixView, spec: &CellSpec) -> String {
        let mut all = vec![
            json!(self.sources),
            self.content(&view.scene),
            json!(view.image),
            json!(spec.method),
            json!(spec.params),
        ];
        if !spec.reconstruct.is_full() {
            all.push(json!(spec.reconstruct));
        }
        digest(&Value::Array(all))
    }

    /// The scene as JSON, with the hash of its file in place of the file's name; for an archive also the name of the
    /// array.
    fn content(&self, scene: &Scene) -> Value {
        let mut scene = scene.clone();
        if let Some(path) = scene.input_file_mut() {
            let hash = self.inputs.get(path).map(|input| input.hash.as_str());
            *path = file_of(path).path_in(hash.unwrap_or_default());
        }
        json!(scene)
    }

    /// An error where the file of a scene has changed since the batch began: results would be recorded under the key of
    /// other content.
    pub fn check(&self, scene: &Scene) -> Result<()> {
        let Some((path, known)) = scene
            .input_file()
            .and_then(|path| Some((path, self.inputs.get(path)?)))
        else {
            return Ok(());
        };
        let changed = |problem: &str| {
            let remedy = "Run the same command again: it measures the file as it is then, and keeps what was measured before.";
            Err(Error::input(path.display().to_string(), problem, remedy))
        };
        match std::fs::metadata(file_of(path).file) {
            Ok(now) if known.looks_like(&now) => Ok(()),
            Ok(_) if Input::read(path).is_ok_and(|now| now.hash == known.hash) => Ok(()),
            Ok(_) => changed("the file changed while the batch was measuring it"),
            Err(_) => changed("the file vanished while the batch was measuring it"),
        }
    }

    /// A scene as a report in `folder` holds it, its file's path relative to the folder.
    pub fn scene(&self, scene: &Scene, folder: &Path) -> SceneRecord {
        let content = self.content(scene);
        let mut scene = scene.clone();
        if let Some(path) = scene.input_file_mut() {
            *path = text(&relative(folder, path)).into();
        }
        let scene = json!(scene);
        SceneRecord {
            id: digest(&json!([scene, content])),
            scene,
        }
    }

    /// The files that a report in `folder` names.
    pub fn files(&self, folder: &Path) -> Vec<InputFile> {
        let mut files: Vec<InputFile> = Vec::new();
        for (path, input) in &self.inputs {
            let path = text(&relative(folder, path));
            if files.iter().all(|file| file.path != path) {
                files.push(InputFile {
                    path,
                    bytes: input.bytes,
                    blake3: input.hash.clone(),
                });
            }
        }
        files
    }
}

impl Input {
    fn read(path: &Path) -> Result<Self> {
        // Read before the content, so that a change during the read is detected later.
        let metadata = std::fs::metadata(file_of(path).file).map_err(absent(path))?;
        let (hash, bytes) = hash_file(path)?;
        Ok(Self {
            hash,
            bytes,
            modified: metadata.modified().ok(),
        })
    }

    fn looks_like(&self, now: &Metadata) -> bool {
        self.modified.is_some() && now.len() == self.bytes && now.modified().ok() == self.modified
    }
}

/// BLAKE3 of a file's content, 64 hexadecimal digits, and its length; `path` may name an array in the file.
pub(super) fn hash_file(path: &Path) -> Result<(String, u64)> {
    let path = &*file_of(path).file;
    let metadata = std::fs::metadata(path).map_err(absent(path))?;
    if !metadata.is_file() {
        let remedy = "Give the path of a file.";
        return Err(Error::input(
            path.display().to_string(),
            "it is not a file",
            remedy,
        ));
    }
    let file = std::fs::File::open(path).map_err(absent(path))?;
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(file).map_err(Error::reading(path))?;
    Ok((hasher.finalize().to_hex().to_string(), hasher.count()))
}

fn absent(path: &Path) -> impl FnOnce(std::io::Error) -> Error {
    let path = path.to_owned();
    move |source| Error::Io {
        path,
        action: "read",
        source,
        remedy: "A scene reads it: put it back, correct its path, or take the scene out of the experiment. Cells that were measured \
            with it are kept and found again.",
    }
}

fn digest(value: &Value) -> String {
    blake3::hash(value.to_string().as_bytes()).to_hex()[..16].to_owned()
}

/// `path` relative to `folder`; unchanged where there is no relative path.
fn relative(folder: &Path, path: &Path) -> PathBuf {
    let part = file_of(path);
    let (Ok(from), Ok(to)) = (folder.canonicalize(), part.file.canonicalize()) else {
        return path.to_owned();
    };
    let same = |(a, b): &(Component<'_>, Component<'_>)| a == b;
    let shared = from.components().zip(to.components()).take_while(same);
    let shared = shared.count();
    if shared == 0 {
        return part.path_in(to);
    }
    let up = from.components().skip(shared).map(|_| Component::ParentDir);
    part.path_in(up.chain(to.components().skip(shared)).collect::<PathBuf>())
}

/// A path as JSON holds it.
fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{expand, parse_experiment};
    use crate::reconstruct::Registry;

    #[test]
    fn a_path_is_relative_to_the_folder_of_the_report() {
        let root = tempfile::tempdir().expect("folder");
        let folder = root.path().join("reports/a");
        std::fs::create_dir_all(&folder).expect("folder");
        let file = root.path().join("cloud.npy");
        std::fs::write(&file, "x").expect("file");
        assert_eq!(relative(&folder, &file), Path::new("../../cloud.npy"));
        std::fs::copy(&file, folder.join("cloud.npy")).expect("file");
        let beside = folder.join("../a/cloud.npy");
        assert_eq!(relative(&folder, &beside), Path::new("cloud.npy"));
        std::fs::copy(&file, root.path().join("cloud.npz")).expect("file");
        let array = root.path().join("cloud.npz:density");
        assert_eq!(
            relative(&folder, &array),
            Path::new("../../cloud.npz:density")
        );
        let gone = Path::new("gone/cloud.npy");
        assert_eq!(relative(&folder, gone), gone);
    }

    #[test]
    fn a_name_depends_on_content_and_sources_and_not_on_where_a_file_lies() {
        let root = tempfile::tempdir().expect("folder");
        let experiment = |file: &str| {
            let scene = json!({
                "name": "cube",
                "container": {"box": {"min_m": [0, 0, 0], "max_m": [1000, 1000, 1000]}},
                "density": {"volume": {"path": file, "up_axis": 1}},
                "medium": {"extinction_per_m": 0.005},
                "sun": {"elevation_deg": 60, "azimuth_deg": 30, "irradiance": [1, 1, 1]},
                "camera": {"position_m": [500, 500, -2500], "target_m": [500, 500, 500], "fov_y_deg": 30}
            });
            let text = json!({
                "name": "e", "image": {"width": 4, "height": 4}, "scenes": [{"scene": scene}], "methods": ["srm"]
            });
            let place = root.path().join("e.json");
            let experiment = parse_experiment(&place, text.to_string()).expect("experiment");
            expand(&experiment, &Registry)
                .expect("matrix")
                .views
                .remove(0)
        };
        let names = |sources: &str, file: &str| {
            let view = experiment(file);
            let path = view.scene.input_file().expect("file").to_owned();
            let input = Input::read(&path).expect("read");
            let identity = Identity {
                sources: sources.to_owned(),
                inputs: BTreeMap::from([(path, input)]),
            };
            [identity.view(&view), identity.cell(&view, &view.cells[0])]
        };
        for (file, content) in [("a.npy", "x"), ("b.npy", "x"), ("c.npy", "y")] {
            std::fs::write(root.path().join(file), content).expect("file");
        }
        let first = names("s", "a.npy");
        assert_eq!(names("s", "b.npy"), first);
        std::fs::write(root.path().join("d.npz"), "x").expect("file");
        let array = names("s", "d.npz:density");
        for other in [names("s", "c.npy"), names("t", "a.npy"), array.clone()] {
            assert!(other[0] != first[0] && other[1] != first[1]);
        }
        assert_ne!(names("s", "d.npz:velocity")[0], array[0]);
    }

    #[test]
    fn a_hash_is_that_of_the_content_and_what_is_no_file_is_refused() {
        let root = tempfile::tempdir().expect("folder");
        let file = root.path().join("cloud.npy");
        std::fs::write(&file, "x").expect("file");
        let (hash, bytes) = hash_file(&file).expect("read");
        assert_eq!((hash, bytes), (blake3::hash(b"x").to_hex().to_string(), 1));
        let error = hash_file(root.path()).expect_err("a folder");
        assert!(error.to_string().contains("not a file"), "{error}");
        let error = hash_file(&root.path().join("gone.npy")).expect_err("absent");
        assert!(
            error.to_string().contains("gone.npy: cannot read"),
            "{error}"
        );
        if cfg!(target_os = "linux") {
            let error = hash_file(Path::new("/dev/zero")).expect_err("without an end");
            assert!(error.to_string().contains("not a file"), "{error}");
        }
    }
}
