//! Text above a picture, and in place of one.

use super::Subject;
use crate::occlusion::{MethodSetup, REGISTRY};
use crate::param::ParamSpec;
use crate::ui::app::{App, Slot};
use eframe::egui::{self, Rect};

/// The slot of the method A.
pub const A: Slot = Slot::Side(0);

/// Short name of what a picture is of: `A srm`, `bsm`, `truth`.
pub fn name(app: &App, subject: Subject) -> String {
    match subject {
        Subject::Slot(Slot::Truth) => "truth".to_owned(),
        Subject::Slot(Slot::Side(side)) => match setup(app, side) {
            Some(setup) => format!("{} {}", letter(side), setup.method.info().id),
            None => letter(side).to_owned(),
        },
        Subject::Slot(Slot::Grid(i)) => REGISTRY
            .get(i)
            .map_or_else(String::new, |method| method.info().id.to_owned()),
        Subject::Difference => format!("{} minus truth", name(app, Subject::Slot(A))),
    }
}

/// Name of a side.
pub fn letter(side: usize) -> &'static str {
    if side == 0 { "A" } else { "B" }
}

fn setup(app: &App, side: usize) -> Option<&MethodSetup> {
    app.state.methods.get(side)
}

/// Draws the caption: state first, details last, cut off where there is no room.
pub fn draw(app: &mut App, ui: &mut egui::Ui, subject: Subject, strip: Rect) {
    line(app, ui, subject, strip, &full(app, subject));
}

/// The caption of a cell of the grid: error and time in place of parameters.
pub fn draw_short(app: &mut App, ui: &mut egui::Ui, subject: Subject, strip: Rect) {
    line(app, ui, subject, strip, &short(app, subject));
}

fn line(app: &mut App, ui: &mut egui::Ui, subject: Subject, strip: Rect, text: &str) {
    if !super::picture::has_room(strip) {
        return;
    }
    let builder = egui::UiBuilder::new()
        .id_salt(("caption", subject))
        .max_rect(strip)
        .layout(egui::Layout::left_to_right(egui::Align::Center));
    let mut child = ui.new_child(builder);
    child.shrink_clip_rect(strip);
    if matches!(subject, Subject::Slot(Slot::Truth) | Subject::Difference) {
        truth_button(app, &mut child);
    }
    child.add(egui::Label::new(text).truncate());
}

/// Stops the truth or lets it go on, while it is not whole.
fn truth_button(app: &mut App, ui: &mut egui::Ui) {
    let whole = app.shown.is_current(Slot::Truth)
        && app
            .shown
            .picture(Slot::Truth)
            .is_some_and(|p| p.drawn.is_exact());
    if app.want_truth && whole {
        return;
    }
    let (text, hint) = if app.want_truth {
        (
            "Stop",
            "Stop rendering the truth: methods alone are faster.",
        )
    } else {
        ("Continue", "Render the truth, too.")
    };
    if ui.small_button(text).on_hover_text(hint).clicked() {
        app.want_truth = !app.want_truth;
    }
}

fn full(app: &App, subject: Subject) -> String {
    let mut parts = vec![name(app, subject)];
    parts.extend(status(app, subject));
    match subject {
        Subject::Slot(Slot::Side(side)) => {
            if let Some(setup) = setup(app, side) {
                parts.push(parameters(setup));
            }
        }
        Subject::Difference => parts.extend(error(app, A)),
        Subject::Slot(_) => {}
    }
    parts.retain(|part| !part.is_empty());
    parts.join(" · ")
}

fn short(app: &App, subject: Subject) -> String {
    let mut parts = vec![name(app, subject)];
    parts.extend(status(app, subject));
    if let Subject::Slot(slot) = subject {
        parts.extend(error(app, slot));
        parts.extend(duration(app, slot));
    }
    parts.join(" · ")
}

/// `steps 10, spacing quadratic`: what differs from the defaults first.
fn parameters(setup: &MethodSetup) -> String {
    let value = |spec: &&'static ParamSpec| setup.params.get(spec.name);
    let changed =
        |spec: &&'static ParamSpec| value(spec).is_some_and(|v| v != spec.default_value());
    let specs = setup.method.info().specs();
    let specs: Vec<_> = specs.filter(|s| s.applies_at(&setup.params)).collect();
    let (first, last): (Vec<_>, Vec<_>) = specs.into_iter().partition(changed);
    let parts = first.into_iter().chain(last);
    let parts = parts.filter_map(|spec: &'static ParamSpec| {
        let unit = if spec.unit == "m" { " m" } else { "" };
        Some(format!("{} {}{unit}", spec.name, value(&spec)?))
    });
    parts.collect::<Vec<_>>().join(", ")
}

/// Why a picture is not the exact one; `None` if it is.
fn status(app: &App, subject: Subject) -> Option<String> {
    let slot = match subject {
        Subject::Slot(slot) => slot,
        Subject::Difference => return difference_status(app),
    };
    let picture = app.shown.picture(slot)?;
    let percent = (picture.drawn.share * 100.0).floor();
    let off = slot == Slot::Truth && !app.want_truth;
    if !app.shown.is_current(slot) {
        let text = if off {
            "off, of a view before"
        } else {
            "being replaced"
        };
        return Some(text.to_owned());
    }
    if picture.drawn.factor > 1 {
        Some(format!("coarse 1:{}", picture.drawn.factor))
    } else if picture.drawn.share < 1.0 && slot == Slot::Truth {
        Some(format!("{percent} %"))
    } else if picture.drawn.share < 1.0 {
        Some(format!("refining {percent} %"))
    } else {
        None
    }
}

fn difference_status(app: &App) -> Option<String> {
    match app.shown.compared(A) {
        Some((_, true)) => None,
        Some((_, false)) => Some(format!("of the picture before; {}", truth_progress(app))),
        None => Some(truth_progress(app)),
    }
}

/// Progress of the truth: `truth 43 %`.
fn truth_progress(app: &App) -> String {
    let picture = app.shown.picture(Slot::Truth);
    let current = picture.filter(|_| app.shown.is_current(Slot::Truth));
    match current {
        _ if !app.want_truth => "truth off".to_owned(),
        Some(p) if p.drawn.is_exact() => "truth ready".to_owned(),
        Some(p) if p.drawn.factor == 1 => {
            format!("truth {} %", (p.drawn.share * 100.0).floor())
        }
        _ => "truth 0 %".to_owned(),
    }
}

fn error(app: &App, slot: Slot) -> Option<String> {
    let (compared, current) = app.shown.compared(slot)?;
    let (comparison, _) = compared.result.as_ref().ok()?;
    current.then(|| format!("rel. RMSE {:.4}", comparison.error.rel_rmse))
}

fn duration(app: &App, slot: Slot) -> Option<String> {
    let (times, _) = app.shown.picture(slot)?.drawn.cost?;
    Some(match times.march {
        Some(march_ms) => format!("march {march_ms:.1} ms"),
        None => format!("{:.1} ms", times.wall),
    })
}

/// Why there is no picture.
pub fn missing(app: &App, subject: Subject) -> String {
    let of_truth = matches!(subject, Subject::Slot(Slot::Truth) | Subject::Difference);
    let compared = app
        .shown
        .compared(A)
        .filter(|_| subject == Subject::Difference);
    if let Some((compared, _)) = compared
        && let Err(problem) = &compared.result
    {
        return format!("There is no difference: {problem}");
    }
    if of_truth && !app.want_truth {
        "The truth is off.".to_owned()
    } else if app.shown.done {
        "It could not be rendered.".to_owned()
    } else if subject == Subject::Difference {
        format!("Waiting for A and the truth: {}", truth_progress(app))
    } else {
        "Waiting for the first picture".to_owned()
    }
}
