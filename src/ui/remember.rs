//! Keeps the window's state between runs: a file in the user's data folder, written some seconds after each change and
//! at the end. A file that cannot be used never prevents the window from opening.

use super::app::App;
use super::view::Mode;
use crate::config::Document;
use crate::error::{Error, Result};
use crate::frame::atomic::write_atomic;
use crate::live::{Live, State};
use eframe::egui::{self, ThemePreference};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// At most one write in this time.
const PAUSE: Duration = Duration::from_secs(3);

/// The file of the window's state: `OCCLAB_STATE`, else in the user's data folder; `None` where a user has no such
/// folder.
pub fn file() -> Option<PathBuf> {
    if let Some(file) = std::env::var_os("OCCLAB_STATE").filter(|file| !file.is_empty()) {
        return Some(file.into());
    }
    directories::ProjectDirs::from("", "", "occlab").map(|dirs| dirs.data_dir().join("window.json"))
}

/// Content of that file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Left {
    mode: Mode,
    theme: Theme,
    want_truth: bool,
    /// [`State::experiment`].
    experiment: Value,
}

/// [`ThemePreference`] in a file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Theme {
    Dark,
    Light,
    System,
}

impl From<ThemePreference> for Theme {
    fn from(theme: ThemePreference) -> Self {
        match theme {
            ThemePreference::Dark => Self::Dark,
            ThemePreference::Light => Self::Light,
            ThemePreference::System => Self::System,
        }
    }
}

impl From<Theme> for ThemePreference {
    fn from(theme: Theme) -> Self {
        match theme {
            Theme::Dark => Self::Dark,
            Theme::Light => Self::Light,
            Theme::System => Self::System,
        }
    }
}

/// State that can change between frames.
#[derive(Clone, PartialEq)]
struct Now {
    mode: Mode,
    theme: Theme,
    want_truth: bool,
    state: State,
}

/// State that was written last, and the write under way.
#[derive(Default)]
pub struct WindowMemory {
    file: Option<PathBuf>,
    /// Theme read from the file, until it is applied.
    recalled: Option<ThemePreference>,
    /// The theme in use.
    theme: ThemePreference,
    written: Option<(Now, Instant)>,
    writer: Option<JoinHandle<Result<()>>>,
    /// Whether the user was told that the file cannot be written.
    complained: bool,
}

impl App {
    /// The content of a window that goes on where the last one was left: `file` holds that place, see
    /// [`remembered_in`](super::remembered_in). A `state` that was asked for is shown instead of the remembered one.
    pub fn remembering(
        live: Live,
        adapter: String,
        state: Option<State>,
        file: Option<PathBuf>,
        start: Instant,
    ) -> Result<Self> {
        let recalled = file.as_deref().map_or(Ok(None), recall);
        let (left, problem) = match recalled {
            Ok(left) => (left, None),
            Err(error) => (None, Some(error)),
        };
        let (left, last) = left.unzip();
        let mut app = Self::new(live, adapter, state.or(last), start)?;
        if let Some(left) = left {
            app.mode = left.mode;
            app.want_truth = left.want_truth;
            app.memory.recalled = Some(left.theme.into());
        }
        if let (Some(error), Some(file)) = (problem, &file) {
            app.banners.say(set_aside(file, &error));
        }
        app.memory.file = file;
        Ok(app)
    }

    /// Writes what changed, at most every few seconds.
    pub(super) fn remember(&mut self, ctx: &egui::Context) {
        if let Some(theme) = self.memory.recalled.take() {
            ctx.set_theme(theme);
        }
        self.memory.theme = ctx.options(|o| o.theme_preference);
        self.finish_writing(false);
        let now = self.now();
        let rest = match &self.memory.written {
            Some((written, _)) if *written == now => return,
            Some((_, at)) => PAUSE.saturating_sub(at.elapsed()),
            None => Duration::ZERO,
        };
        if !rest.is_zero() {
            ctx.request_repaint_after(rest);
        } else if self.memory.writer.is_none() && now.state.scene.validate().is_ok() {
            self.write(now);
        }
    }

    /// Writes what changed since the last time, and waits for it.
    pub fn remember_at_exit(&mut self) {
        self.finish_writing(true);
        let now = self.now();
        let known = matches!(&self.memory.written, Some((written, _)) if *written == now);
        if !known && now.state.scene.validate().is_ok() {
            self.write(now);
            self.finish_writing(true);
        }
    }

    fn now(&self) -> Now {
        Now {
            mode: self.mode,
            theme: self.memory.theme.into(),
            want_truth: self.want_truth,
            state: self.state.clone(),
        }
    }

    fn write(&mut self, now: Now) {
        if let Some(file) = self.memory.file.clone() {
            let written = now.clone();
            self.memory.writer = Some(std::thread::spawn(move || write(&file, &written)));
        }
        self.memory.written = Some((now, Instant::now()));
    }

    /// Takes the outcome of a write, if it is over or `wait`; a failure is reported once.
    fn finish_writing(&mut self, wait: bool) {
        let over = |writer: &mut JoinHandle<_>| wait || writer.is_finished();
        let Some(writer) = self.memory.writer.take_if(over) else {
            return;
        };
        // A panic of the writer was printed on stderr.
        if let Ok(Err(error)) = writer.join()
            && !std::mem::replace(&mut self.memory.complained, true)
        {
            self.banners
                .say(format!("What the window shows is not remembered: {error}"));
        }
    }
}

fn write(file: &Path, now: &Now) -> Result<()> {
    let left = Left {
        mode: now.mode,
        theme: now.theme,
        want_truth: now.want_truth,
        experiment: now.state.experiment()?,
    };
    let text = serde_json::to_string_pretty(&left).map_err(|e| Error::writing(file)(e.into()))?;
    if let Some(folder) = file.parent() {
        std::fs::create_dir_all(folder).map_err(Error::writing(folder))?;
    }
    write_atomic(file, |f| {
        f.write_all(text.as_bytes()).map_err(Error::writing(file))
    })
}

/// Content of a file; `None` when there is no file.
fn recall(file: &Path) -> Result<Option<(Left, State)>> {
    if !file.exists() {
        return Ok(None);
    }
    let value = Document::read(file)?.value().clone();
    let place = || file.display().to_string();
    let left: Left = serde_json::from_value(value)
        .map_err(|e| Error::input(place(), e.to_string(), "The first scene is shown instead."))?;
    let text = left.experiment.to_string();
    let state = State::parse(Path::new("remembered state"), text)?;
    if let Some(path) = state.scene.input_file() {
        let file = crate::density::volume::file_of(path).file;
        std::fs::metadata(&file).map_err(Error::reading(&file))?;
    }
    Ok(Some((left, state)))
}

/// Keeps an unusable file beside the new one; one line for the banner.
fn set_aside(file: &Path, error: &Error) -> String {
    let mut aside = file.as_os_str().to_owned();
    aside.push(".unusable");
    let kept = match std::fs::rename(file, &aside) {
        Ok(()) => format!("kept as {}", Path::new(&aside).display()),
        Err(_) => "ignored".to_owned(),
    };
    format!("Where the last window was left cannot be shown ({kept}): {error}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn themes_come_back() {
        for theme in [
            ThemePreference::Dark,
            ThemePreference::Light,
            ThemePreference::System,
        ] {
            let text = serde_json::to_string(&Theme::from(theme)).unwrap();
            let read: Theme = serde_json::from_str(&text).unwrap();
            assert_eq!(ThemePreference::from(read), theme);
        }
    }

    #[test]
    fn no_file_is_no_problem() {
        let folder = tempfile::tempdir().unwrap();
        assert!(recall(&folder.path().join("none")).unwrap().is_none());
    }
}
