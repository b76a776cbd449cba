//! The window: compares methods interactively. It shows what [`crate::live`] sends and renders nothing of the scene
//! itself; its only GPU objects are the textures that egui shows.
//!
//! ```text
//! State (scene, size, methods A and B) ─► Request ─► live ─► Update ─► Shown (textures, numbers) ─► panels
//! ```

mod app;
mod banner;
mod batch;
mod controls;
mod files;
mod help;
mod ink;
mod lower;
mod map;
mod map_grid;
mod measure;
mod menu;
mod outside;
mod probe;
mod remember;
mod shown;
mod view;

pub use app::App;
pub use files::Purpose;
pub use remember::file as remembered_in;
pub use view::Mode;

use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::live::{Live, State};
use eframe::egui;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// What the window is opened with.
pub struct WindowOptions {
    /// What to show first; `None` = where the last window was left, else the first scene by name.
    pub state: Option<State>,
    /// Folder of shaders to read instead of the compiled-in ones, and to watch.
    pub shaders: Option<PathBuf>,
    /// When the program was started.
    pub start: Instant,
}

/// Opens the window on `gpu`, which was made by [`Gpu::for_window`], and returns when it is closed.
pub fn open(gpu: Gpu, options: WindowOptions) -> Result<()> {
    // One device for window and renderer, except on llvmpipe: it writes the timestamps of passes that follow a frame of
    // the window only with the next frame, so that they measure nothing.
    let own = match gpu.is_software() {
        true => Some(Gpu::for_window(Some(&gpu.info.name))?),
        false => None,
    };
    let screen = own.as_ref().unwrap_or(&gpu);
    let wgpu_setup = eframe::egui_wgpu::WgpuSetupExisting {
        instance: screen.instance.clone(),
        adapter: screen.adapter.clone(),
        device: screen.device.clone(),
        queue: screen.queue.clone(),
    };
    let native = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("occlab")
            .with_inner_size([1280.0, 720.0]),
        wgpu_options: eframe::egui_wgpu::WgpuConfiguration {
            wgpu_setup: wgpu_setup.into(),
            ..Default::default()
        },
        ..Default::default()
    };
    let ending = Arc::new(Mutex::new(None));
    let told = ending.clone();
    let create = Box::new(move |cc: &eframe::CreationContext<'_>| {
        let ctx = cc.egui_ctx.clone();
        let adapter = gpu.info.name.clone();
        let live = Live::start(gpu, options.shaders, move || ctx.request_repaint());
        let app = App::remembering(live, adapter, options.state, remembered_in(), options.start)?
            .ending_in(told);
        Ok(Box::new(app) as Box<dyn eframe::App>)
    });
    eframe::run_native("occlab", native, create).map_err(|error| {
        Error::input(
            "view",
            format!("the window cannot be opened: {error}"),
            WITHOUT_A_WINDOW,
        )
    })?;
    let ended = ending.lock().unwrap_or_else(PoisonError::into_inner).take();
    match ended {
        None => Ok(()),
        Some(problem) => Err(Error::gpu(
            problem,
            "What was shown is kept: run the command again to go on.",
        )),
    }
}

/// Hint where no window can be opened.
pub const WITHOUT_A_WINDOW: &str = "Without a display use `occlab render --scene cumulus --method bsm --out bsm.png` or `occlab batch configs/quick.json`.";
