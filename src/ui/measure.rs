//! The right panel: times, memory and error numbers of what is shown.

use super::app::{App, Slot};
use super::ink::ink;
use crate::batch::numbers::study_number;
use crate::cost::PassTimes;
use crate::metrics::{Comparison, Format, Origin, arranged, summarise};
use crate::report::format::{bytes, maybe, ms, number};
use eframe::egui;
use egui_plot::{Legend, Line, Plot, PlotPoints};

/// Draws the panel.
pub fn draw(app: &mut App, ui: &mut egui::Ui) {
    ui.label(&app.adapter)
        .on_hover_text("The adapter. All times are its own.");
    let sides: Vec<usize> = if app.mode.shows_b() {
        vec![0, 1]
    } else {
        vec![0]
    };
    times(app, ui, &sides);
    ui.separator();
    errors(app, ui, &sides);
    ui.separator();
    waiting(app, ui);
}

/// A table with a column for each side; `None` = not measured yet.
fn table(app: &App, ui: &mut egui::Ui, name: &str, sides: &[usize], rows: &[MetricRow]) {
    egui::Grid::new(name).striped(true).show(ui, |ui| {
        ui.label("");
        for side in sides {
            let id = app.state.methods[*side].method.info().id;
            ui.strong(format!("{} {id}", ["A", "B"][*side]));
        }
        ui.end_row();
        for (row, doc, values) in rows {
            ui.label(*row).on_hover_text(*doc);
            for value in values {
                ui.monospace(value.as_deref().unwrap_or("…"));
            }
            ui.end_row();
        }
    });
}

fn times(app: &mut App, ui: &mut egui::Ui, sides: &[usize]) {
    ui.strong("Time and memory");
    let costs: Vec<_> = sides
        .iter()
        .map(|i| app.shown.picture(Slot::Side(*i)).and_then(|p| p.drawn.cost))
        .collect();
    let time = |of: &dyn Fn(&PassTimes) -> Option<f64>| {
        costs.iter().map(|c| c.map(|(t, _)| ms(of(&t)))).collect()
    };
    let memory = |of: &dyn Fn(&crate::cost::Memory) -> u64| {
        costs
            .iter()
            .map(|c| c.map(|(_, m)| bytes(of(&m))))
            .collect()
    };
    let pass = "GPU timestamps of the last exact picture, which was alone in the queue: a device that rests between pictures \
        may run at a lower clock than in a batch. n/a where there is no map, or the adapter has no timestamps.";
    let rows = [
        ("generate", pass, time(&|t| t.generate)),
        ("march", pass, time(&|t| t.march)),
        ("total", pass, time(&PassTimes::total)),
        (
            "wall",
            "From submission to completion, with the waits of small tiles that keep the window alive.",
            time(&|t| Some(t.wall)),
        ),
        (
            "payload",
            "Values × bytes a value × texels.",
            memory(&|m| m.payload_bytes),
        ),
        (
            "map",
            "The map's textures as allocated.",
            memory(&|m| m.map_bytes),
        ),
    ];
    table(app, ui, "times", sides, &rows);
    let doc = "Renders A again and again when everything else is done, for the median.";
    ui.checkbox(&mut app.repeat, "Measure A again and again")
        .on_hover_text(doc);
    rolling(app, ui);
}

/// A line of the plot: its name, and the time of a run.
type PlotSeries = (&'static str, fn(&PassTimes) -> Option<f64>);

/// Times of A over its last runs, and their medians.
fn rolling(app: &App, ui: &mut egui::Ui) {
    let runs = &app.shown.runs;
    let visuals = ui.visuals().clone();
    let series: [PlotSeries; 3] = [
        ("generate", |t| t.generate),
        ("march", |t| t.march),
        ("total", PassTimes::total),
    ];
    Plot::new("times of A")
        .height(110.0)
        .include_y(0.0)
        .show_axes([false, true])
        .y_axis_label("ms")
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .show_x(false)
        .legend(Legend::default())
        .show(ui, |plot| {
            for (i, (name, of)) in series.into_iter().enumerate() {
                let points: PlotPoints<'_> = runs
                    .iter()
                    .enumerate()
                    .filter_map(|(run, t)| Some([run as f64, of(t)?]))
                    .collect();
                // Colours that are told apart; these are passes, not methods.
                let line = Line::new(name, points).color(ink(["esm", "bsm", "srm"][i], &visuals));
                plot.line(line);
            }
        });
    let totals: Vec<f64> = runs.iter().filter_map(PassTimes::total).collect();
    if let Some(stats) = summarise(&totals) {
        let text = format!(
            "total of A: median {}, p95 {}, cv {} %, n {}",
            ms(Some(stats.median)),
            ms(Some(stats.p95)),
            number(stats.cv * 100.0),
            stats.n
        );
        ui.small(text);
    }
}

fn errors(app: &mut App, ui: &mut egui::Ui, sides: &[usize]) {
    let title = egui::RichText::new("Error against the truth").strong();
    ui.checkbox(&mut app.want_truth, title)
        .on_hover_text("Render the truth of every view, and compare exact pictures with it.");
    if !app.want_truth && !app.mode.needs_truth() {
        return;
    }
    let mut stale = false;
    let mut problem = None;
    let compared: Vec<Option<Comparison>> = sides
        .iter()
        .map(|i| {
            let (compared, current) = app.shown.compared(Slot::Side(*i))?;
            stale |= !current;
            match &compared.result {
                Ok((comparison, _)) => Some(*comparison),
                Err(why) => {
                    problem = Some(why.clone());
                    None
                }
            }
        })
        .collect();
    table(app, ui, "errors", sides, &error_rows(&compared));
    if let Some(problem) = problem {
        ui.colored_label(ui.visuals().error_fg_color, problem);
    }
    let state = match (compared.iter().all(Option::is_some), stale) {
        (false, _) => "waiting for the truth and an exact picture",
        (true, true) => "of the view before; the new one is under way",
        (true, false) => "as a batch cell has them",
    };
    ui.small(state);
}

/// A row of a table: name, definition and a value for each side.
type MetricRow = (&'static str, &'static str, Vec<Option<String>>);

/// The error numbers that one picture tells, by their names and values in a record.
fn error_rows(compared: &[Option<Comparison>]) -> Vec<MetricRow> {
    let values = |of: &dyn Fn(&Comparison) -> String| {
        let value = |c: &Option<Comparison>| c.as_ref().map(of);
        compared.iter().map(value).collect()
    };
    let told = arranged().into_iter().filter(|m| m.origin == Origin::Pair);
    let rows = told.map(|metric| {
        let text = |c: &Comparison| recorded(metric.format, (metric.get)(&c.error));
        (metric.key, metric.doc, values(&text))
    });
    let cloud = study_number("cloud_pixel_fraction").map(|number| {
        let text = |c: &Comparison| maybe(Some(c.cloud_pixel_fraction));
        (number.label, number.doc, values(&text))
    });
    rows.chain(cloud).collect()
}

/// A value as the record has it, without a unit: shares are fractions here.
fn recorded(format: Format, value: Option<f64>) -> String {
    match (format, value) {
        (Format::Integer, Some(value)) => value.to_string(),
        (_, value) => maybe(value),
    }
}

fn waiting(app: &App, ui: &mut egui::Ui) {
    let doc = "From a change to its first, perhaps coarse, picture on the screen.";
    if let Some(latency_ms) = app.shown.latency_ms {
        ui.small(format!("input to picture: {}", ms(Some(latency_ms))))
            .on_hover_text(doc);
    }
    if let Some(first) = app.shown.first {
        let waited_ms = first.duration_since(app.start()).as_secs_f64() * 1e3;
        ui.small(format!("start to first picture: {}", ms(Some(waited_ms))));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Frame;
    use crate::metrics::{METRICS, compare};

    #[test]
    fn every_number_that_a_picture_tells_has_its_row() {
        let frame = |level: f32| Frame {
            width: 16,
            height: 16,
            radiance: vec![[level, level, level, 0.5]; 256],
            sun: vec![[level; 4]; 256],
        };
        let comparison = compare(&frame(0.5), &frame(0.6)).unwrap();
        let rows = error_rows(&[Some(comparison), None]);
        let told = METRICS.iter().filter(|m| m.origin == Origin::Pair);
        for metric in told.clone() {
            let (_, doc, values) = rows.iter().find(|(name, ..)| *name == metric.key).unwrap();
            assert_eq!(*doc, metric.doc);
            assert!(values[0].as_ref().is_some_and(|text| text != "n/a"));
            assert_eq!(values[1], None);
        }
        let (last, ..) = rows[rows.len() - 1];
        assert_eq!((last, rows.len()), ("cloud pixels", told.count() + 1));
    }
}
