//! `occlab render`.

use super::progress::bar;
use super::scene::SceneOptions;
use super::{DeviceArgs, print_path};
use occlab::Error;
use occlab::frame::{Exposure, tone_map, write_frame, write_png};
use occlab::occlusion::{MethodSetup, is_truth};
use occlab::scene::Scene;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(clap::Args)]
pub struct RenderArgs {
    #[command(flatten)]
    scene: SceneOptions,
    /// Method id; `occlab methods` lists them.
    #[arg(long, short, default_value = "truth")]
    method: String,
    /// Parameters of the method.
    #[arg(long, value_name = "NAME=VALUE", num_args = 1..)]
    set: Vec<String>,
    /// Picture: .exr (linear, lossless) or .png (tone-mapped).
    #[arg(long, short)]
    out: PathBuf,
    #[command(flatten)]
    device: DeviceArgs,
}

impl RenderArgs {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let scene = self.scene.load()?;
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
        let image = self.scene.image()?;
        let backend = self.device.open()?;
        let progress = bar(1000, self.device.quiet);
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
                "{}: {generate}march {}, wall {:.1} ms (one picture, alone in the queue; `occlab batch` measures times)",
                backend.environment().adapter,
                ms(times.march),
                times.wall
            );
        }
        print_path(&self.out)?;
        Ok(ExitCode::SUCCESS)
    }

    fn setup(&self, scene: &Scene) -> anyhow::Result<MethodSetup> {
        let mut setup = match is_truth(&self.method) {
            true => MethodSetup::truth(scene)?,
            false => MethodSetup::defaults(&self.method)?,
        };
        for pair in &self.set {
            let (name, value) = name_and_value(pair)?;
            setup = setup.with(name, value)?;
        }
        let named = self.set.iter().filter_map(|pair| pair.split_once('='));
        for note in named.filter_map(|(name, _)| setup.idle_note(name)) {
            if !self.device.quiet {
                eprintln!("note: {note}");
            }
        }
        Ok(setup)
    }
}

/// Splits a value of `--set`.
pub fn name_and_value(pair: &str) -> occlab::Result<(&str, &str)> {
    pair.split_once('=').ok_or_else(|| {
        let problem = format!("`{pair}` is not NAME=VALUE");
        Error::input("--set", problem, "Write for example --set resolution=512.")
    })
}
