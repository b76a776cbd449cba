//! `occlab render`.

use super::progress::bar;
use super::{Device, print_path};
use occlab::Error;
use occlab::config::load_scene;
use occlab::frame::{Exposure, tone_map, write_frame, write_png};
use occlab::occlusion::MethodSetup;
use occlab::scene::ImageSize;
use occlab::scene::{Density, Scene};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(clap::Args)]
pub struct Render {
    /// Scene file, or the name of one in configs/scenes.
    #[arg(long, short)]
    scene: PathBuf,
    /// Method id; `occlab methods` lists them.
    #[arg(long, short, default_value = "truth")]
    method: String,
    /// Parameters of the method.
    #[arg(long, value_name = "NAME=VALUE", num_args = 1..)]
    set: Vec<String>,
    /// Picture: .exr (linear, lossless) or .png (tone-mapped).
    #[arg(long, short)]
    out: PathBuf,
    /// Columns.
    #[arg(long, default_value_t = 640)]
    width: u32,
    /// Rows.
    #[arg(long, default_value_t = 360)]
    height: u32,
    /// Sun elevation in degrees, instead of the scene's.
    #[arg(long, value_name = "DEG")]
    sun_elevation: Option<f64>,
    /// Volume file (.npy), instead of the scene's.
    #[arg(long, value_name = "FILE")]
    volume: Option<PathBuf>,
    /// Seed of the noise, instead of the scene's.
    #[arg(long)]
    seed: Option<u32>,
    #[command(flatten)]
    device: Device,
}

impl Render {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let scene = self.scene()?;
        let setup = self.setup(&scene)?;
        let extension = self
            .out
            .extension()
            .and_then(|e| e.to_str())
            .unwrap_or_default()
            .to_owned();
        if !["exr", "png"].contains(&extension.as_str()) {
            return Err(Error::input(
                "--out",
                format!("`{}` is neither .exr nor .png", self.out.display()),
                "Name a file with one of these endings.",
            )
            .into());
        }
        if self.width == 0 || self.height == 0 {
            return Err(Error::input(
                "--width, --height",
                "a picture needs at least one pixel",
                "Give positive sizes.",
            )
            .into());
        }
        let backend = self.device.open()?;
        let progress = bar(1000, self.device.quiet);
        let image = ImageSize {
            width: self.width,
            height: self.height,
        };
        let (frame, times) = backend.render(&scene, image, &setup, &mut |share| {
            progress.set_position((share * 1000.0) as u64);
            ControlFlow::Continue(())
        })?;
        progress.finish_and_clear();
        match extension.as_str() {
            "exr" => write_frame(&self.out, &frame)?,
            _ => write_png(
                &self.out,
                frame.width,
                frame.height,
                &tone_map(&frame, Exposure::from_reference(&frame)),
            )?,
        }
        if !self.device.quiet {
            let ms = |t: Option<f64>| t.map_or("n/a".into(), |t| format!("{t:.1} ms"));
            let generate = times.generate.map_or(String::new(), |_| {
                format!("generate {}, ", ms(times.generate))
            });
            eprintln!(
                "{}: {generate}march {}, wall {:.1} ms",
                backend.environment().adapter,
                ms(times.march),
                times.wall
            );
        }
        print_path(&self.out)?;
        Ok(ExitCode::SUCCESS)
    }

    fn scene(&self) -> anyhow::Result<Scene> {
        let named = PathBuf::from("configs/scenes").join(self.scene.with_extension("json"));
        let path = if !self.scene.exists() && named.exists() {
            &named
        } else {
            &self.scene
        };
        let mut scene = load_scene(path)?;
        if let Some(elevation_deg) = self.sun_elevation {
            scene.sun.elevation_deg = elevation_deg;
        }
        match (&mut scene.density, &self.volume, self.seed) {
            (Density::Volume(volume), Some(path), _) => volume.path.clone_from(path),
            (_, Some(_), _) => {
                return Err(Error::input(
                    "--volume",
                    "the scene's density is not a volume",
                    "Use configs/scenes/volume.json.",
                )
                .into());
            }
            (Density::Procedural(p), _, Some(seed)) => p.seed = seed,
            (_, _, Some(_)) => {
                return Err(Error::input(
                    "--seed",
                    "the scene's density has no noise",
                    "Leave the option out.",
                )
                .into());
            }
            _ => {}
        }
        scene
            .validate()
            .map_err(|problem| problem.at(&path.display().to_string()))?;
        Ok(scene)
    }

    fn setup(&self, scene: &Scene) -> anyhow::Result<MethodSetup> {
        let mut setup = MethodSetup::defaults(&self.method)?;
        if self.method == "truth" {
            setup = setup.with("step_m", &scene.truth_step_m().to_string())?;
        }
        for pair in &self.set {
            let Some((name, value)) = pair.split_once('=') else {
                return Err(Error::input(
                    "--set",
                    format!("`{pair}` is not NAME=VALUE"),
                    "Write for example --set resolution=512.",
                )
                .into());
            };
            setup = setup.with(name, value)?;
        }
        Ok(setup)
    }
}
