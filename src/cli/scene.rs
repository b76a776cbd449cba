//! The options that name a scene and change it.

use occlab::Error;
use occlab::config::load_scene;
use occlab::config::shipped::{FileKind, find};
use occlab::scene::{ImageSize, Problem, Scene};
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct SceneOptions {
    /// Scene file, or its name (`occlab --help` says where it is looked for).
    #[arg(long, short)]
    pub scene: PathBuf,
    /// Columns.
    #[arg(long, default_value_t = 640)]
    width: u32,
    /// Rows.
    #[arg(long, default_value_t = 360)]
    height: u32,
    /// Sun elevation in degrees, instead of the scene's.
    #[arg(long, value_name = "DEG")]
    sun_elevation: Option<f64>,
    /// Volume instead of the scene's: a .npy of three axes, or a .npz (FILE.npz:NAME where it has several arrays).
    #[arg(long, value_name = "FILE")]
    volume: Option<PathBuf>,
    /// Seed of the noise, instead of the scene's.
    #[arg(long)]
    seed: Option<u32>,
}

impl SceneOptions {
    /// Size of the picture.
    pub fn image(&self) -> occlab::Result<ImageSize> {
        if self.width == 0 || self.height == 0 {
            return Err(Error::input(
                "--width, --height",
                "a picture needs at least one pixel",
                "Give positive sizes.",
            ));
        }
        Ok(ImageSize {
            width: self.width,
            height: self.height,
        })
    }

    /// The scene, changed and valid.
    pub fn load(&self) -> occlab::Result<Scene> {
        let path = &find(FileKind::Scene, &self.scene)?;
        let mut scene = load_scene(path)?;
        if let Some(elevation_deg) = self.sun_elevation {
            scene.sun.elevation_deg = elevation_deg;
        }
        if let Some(path) = &self.volume {
            let own = scene.input_file_mut().ok_or_else(|| {
                let problem = "the scene's density is not a volume";
                Error::input("--volume", problem, "Use `--scene volume`.")
            })?;
            own.clone_from(path);
        }
        if let Some(seed) = self.seed {
            let own = scene.density.field_mut().seed_mut().ok_or_else(|| {
                let problem = "the scene's density has no noise";
                Error::input("--seed", problem, "Leave the option out.")
            })?;
            *own = seed;
        }
        scene
            .validate()
            .map_err(|problem| self.blame(problem, path))?;
        Ok(scene)
    }

    /// Attributes a problem to the option that gave the value, else to the file.
    fn blame(&self, problem: Problem, path: &Path) -> Error {
        let option = match problem.pointer.as_str() {
            "/sun/elevation_deg" if self.sun_elevation.is_some() => "--sun-elevation",
            // The file's own density was valid.
            place if place.starts_with("/density/") && self.volume.is_some() => "--volume",
            _ => return problem.at(&path.display().to_string()),
        };
        Error::input(
            option,
            problem.message,
            "Give another value, or leave the option out.",
        )
    }
}
