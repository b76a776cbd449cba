//! A batch that the window runs: its progress, its failures, its report.

use super::app::App;
use crate::batch::{Event, record::Cell, report_folder};
use crate::config::load_experiment;
use crate::error::Result;
use crate::live::Update;
use eframe::egui;
use std::path::{Path, PathBuf};

/// Where the command line writes reports, too.
pub const REPORTS: &str = "reports";

/// The batch of this window, if one was started.
#[derive(Default)]
pub struct BatchPanel {
    run: Option<RunningBatch>,
}

struct RunningBatch {
    name: String,
    folder: PathBuf,
    cells: usize,
    done: usize,
    stage: Option<(String, f32)>,
    notes: Vec<String>,
    failed: Vec<String>,
    cancelled: bool,
    outcome: Option<std::result::Result<PathBuf, String>>,
}

impl BatchPanel {
    /// Is a batch under way?
    pub fn is_running(&self) -> bool {
        self.run.as_ref().is_some_and(|run| run.outcome.is_none())
    }

    /// Closes the window of a batch that is over.
    pub fn close(&mut self) {
        self.run.take_if(|run| run.outcome.is_some());
    }
}

impl App {
    /// Runs an experiment file into a folder of its name below `reports`.
    pub fn start_batch(&mut self, config: &Path, reports: &Path) -> Result<()> {
        let name = load_experiment(config)?.name;
        if self.batch.is_running() {
            return Ok(());
        }
        let folder = report_folder(reports, &name);
        self.live.batch(config.to_owned(), folder.clone());
        self.batch.run = Some(RunningBatch {
            name,
            folder,
            cells: 0,
            done: 0,
            stage: None,
            notes: Vec::new(),
            failed: Vec::new(),
            cancelled: false,
            outcome: None,
        });
        Ok(())
    }
}

/// Takes what the worker says of the batch, and draws its window.
pub fn draw(app: &mut App, ctx: &egui::Context) {
    let news: Vec<Update> = app.shown.batch.drain(..).collect();
    let Some(run) = &mut app.batch.run else {
        return;
    };
    let mut over = false;
    for update in news {
        match update {
            Update::Batch(event) => run.take(event),
            Update::BatchDone(outcome) => {
                run.outcome = Some(outcome);
                over = true;
            }
            _ => {}
        }
    }
    let mut open = true;
    let mut cancel = false;
    egui::Window::new(format!("Batch {}", run.name))
        .id(egui::Id::unique("batch"))
        .collapsible(false)
        .default_width(420.0)
        .show(ctx, |ui| match &run.outcome {
            None => cancel = progress(run, ui),
            Some(outcome) => open = !result(run, outcome, ui),
        });
    if cancel {
        run.cancelled = true;
        app.live.cancel_batch();
    }
    if !open {
        app.batch.run = None;
    }
    if over {
        // The batch displaced the pictures that were under way.
        app.ask_again();
    }
}

impl RunningBatch {
    fn take(&mut self, event: Event) {
        match event {
            Event::Planned { cells, done } => (self.cells, self.done) = (cells, done),
            Event::Note(note) => self.notes.push(note),
            Event::Stage { what, share } => self.stage = Some((what, share as f32)),
            Event::Cell(cell) => {
                self.done += 1;
                self.failed.extend(failure(&cell));
            }
        }
    }
}

fn failure(cell: &Cell) -> Option<String> {
    let reason = cell.failed.as_ref()?;
    let params: Vec<String> = cell
        .params
        .iter()
        .map(|(k, v)| format!("{k}={}", v.as_str().map_or(v.to_string(), str::to_owned)))
        .collect();
    Some(format!(
        "{} {}° {} {}: {reason}",
        cell.scene,
        cell.sun_elevation_deg,
        cell.method,
        params.join(" ")
    ))
}

/// A batch under way; `true`: it is to end.
fn progress(run: &RunningBatch, ui: &mut egui::Ui) -> bool {
    ui.label("Pictures in the window wait until the batch is over.");
    // Drawn above content of changing height, so that the button does not move.
    let button = egui::Button::new(if run.cancelled { "Ending…" } else { "Cancel" });
    let cancel = ui
        .add_enabled(!run.cancelled, button)
        .on_hover_text("Finished cells are kept; run the same file again to go on")
        .clicked();
    let share = run.done as f32 / run.cells.max(1) as f32;
    let bar = egui::ProgressBar::new(share).text(format!("{} of {} cells", run.done, run.cells));
    ui.add(bar);
    if let Some((what, share)) = &run.stage {
        ui.label(what);
        ui.add(egui::ProgressBar::new(*share).show_percentage());
    }
    messages(run, ui);
    cancel
}

/// A batch that is over; `true`: its window is to be closed.
fn result(
    run: &RunningBatch,
    outcome: &std::result::Result<PathBuf, String>,
    ui: &mut egui::Ui,
) -> bool {
    match outcome {
        Ok(page) => {
            let (cells, failed) = (run.cells, run.failed.len());
            ui.label(format!("{cells} cells, {failed} of them failed now."));
            ui.label(page.display().to_string());
        }
        Err(_) if run.cancelled => {
            let (done, cells) = (run.done, run.cells);
            ui.label(format!("Cancelled after {done} of {cells} cells."));
            let folder = run.folder.display();
            ui.label(format!(
                "They are kept in {folder}: run the file again to go on."
            ));
        }
        Err(problem) => {
            ui.colored_label(ui.visuals().error_fg_color, problem);
        }
    }
    messages(run, ui);
    ui.horizontal(|ui| {
        if let Ok(page) = outcome
            && ui.button("Open report").clicked()
        {
            ui.ctx().open_url(egui::OpenUrl::new_tab(file_url(page)));
        }
        ui.button("Close").clicked()
    })
    .inner
}

fn messages(run: &RunningBatch, ui: &mut egui::Ui) {
    if run.failed.is_empty() && run.notes.is_empty() {
        return;
    }
    egui::ScrollArea::vertical()
        .max_height(160.0)
        .show(ui, |ui| {
            for failed in &run.failed {
                let text = format!("Failed: {failed}");
                ui.colored_label(ui.visuals().error_fg_color, text);
            }
            for note in &run.notes {
                ui.label(format!("Note: {note}"));
            }
        });
}

/// A file as a URL (RFC 8089, percent-encoded as RFC 3986 § 2 says).
fn file_url(path: &Path) -> String {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let text = path.to_string_lossy();
    let mut url = String::from("file://");
    if !text.starts_with('/') {
        url.push('/'); // a drive letter follows
    }
    for byte in text.bytes() {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' | b':' => {
                url.push(char::from(byte));
            }
            b'\\' if cfg!(windows) => url.push('/'),
            _ => url.push_str(&format!("%{byte:02X}")),
        }
    }
    url
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn urls_hold_no_character_that_means_something() {
        assert_eq!(
            file_url(Path::new("/a b/é#?%.html")),
            "file:///a%20b/%C3%A9%23%3F%25.html"
        );
    }
}
