//! `occlab view`.

use occlab::Error;
use occlab::config::shipped::{FileKind, find};
use occlab::gpu::Gpu;
use occlab::live::State;
use occlab::ui::{WITHOUT_A_WINDOW, WindowOptions, open};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

#[derive(clap::Args, Default)]
pub struct ViewArgs {
    /// Scene or experiment file, or the name of a scene; default: where the last window was left (a file in the user's
    /// data folder, or OCCLAB_STATE).
    scene: Option<PathBuf>,
    /// Part of the adapter's name; default: the fastest kind.
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Read shaders from this folder instead of the compiled-in ones, and again whenever they change (a debug build
    /// watches its own source folder).
    #[arg(long, value_name = "DIR")]
    shaders: Option<PathBuf>,
}

impl ViewArgs {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let start = Instant::now();
        check_display()?;
        let state = match &self.scene {
            Some(scene) => Some(State::load(&find(FileKind::Scene, scene)?)?),
            None => None,
        };
        let watched = cfg!(debug_assertions)
            .then(|| PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders")));
        let options = WindowOptions {
            state,
            shaders: self.shaders.or(watched),
            start,
        };
        open(Gpu::for_window(self.adapter.as_deref())?, options)?;
        Ok(ExitCode::SUCCESS)
    }
}

/// X11 and Wayland name their display in the environment; other systems always have one.
fn check_display() -> occlab::Result<()> {
    let named = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let needed = cfg!(all(unix, not(target_os = "macos")));
    if needed
        && !["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"]
            .into_iter()
            .any(named)
    {
        return Err(Error::input(
            "view",
            "there is no display (neither DISPLAY nor WAYLAND_DISPLAY is set)",
            WITHOUT_A_WINDOW,
        ));
    }
    Ok(())
}
