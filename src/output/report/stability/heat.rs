//! Heat maps of method settings × extreme cases, one for the oracle and one for the device.

use super::super::format::{maybe, number};
use super::device;
use crate::stability::{Columns, FormVerdict, Setting, Sweep, SweepCase, SweepPicture, SweepRow};
use maud::{Markup, html};

/// Width of a column of the map, px; must equal that in the style sheet.
const CELL_PX: usize = 16;
/// Width of a letter of a group's name, px.
const LETTER_PX: usize = 7;

/// Content of a cell of a heat map.
struct HeatCell {
    class: &'static str,
    symbol: String,
    title: String,
}

/// Both maps with their legend.
pub fn section(sweep: &Sweep) -> Markup {
    let mut settings: Vec<&Setting> = Vec::new();
    for row in sweep.cases.iter().flat_map(|case| &case.rows) {
        if !settings.contains(&&row.setting) {
            settings.push(&row.setting);
        }
    }
    let order = |s: &&Setting| crate::stability::settings().iter().position(|o| o == *s);
    settings.sort_by_key(order);
    html! {
        section #oracle {
            h2 { "On the oracle" }
            p {
                "T along light columns, values rounded as the device would, the worse of denormals kept and flushed. Digits: weighted RMSE of T. Point at a cell for its numbers."
            }
            (legend())
            (map(sweep, &settings, &|row| oracle_cell(row.oracle())))
        }
        section #device {
            h2 { "On the device" }
            p { "Pictures on " (device(sweep)) ": stored bits of channels and texels, the range of V, and V against the oracle's truth (digits: the largest error of a pixel). Recorded, not asserted." }
            @if sweep.environment.is_some() {
                (map(sweep, &settings, &|row| row.device.as_ref().map_or_else(absent, device_cell)))
            }
        }
    }
}

fn legend() -> Markup {
    let entries = [
        ("is-e4", "4", "error ≤ 10⁻⁴"),
        ("is-e3", "3", "≤ 10⁻³"),
        ("is-e2", "2", "≤ 0.01"),
        ("is-e1", "1", "≤ 0.1"),
        ("is-e0", "0", "above 0.1: finite, but far off"),
        ("is-e4", "·", "finite; nothing scatters light here"),
        (
            "is-rings",
            "~",
            "rises as documented (FOM's overshoot, a march's few samples)",
        ),
        (
            "is-breaks",
            "✕",
            "breaks: not finite, outside [0, 1], or rising without documentation",
        ),
        ("is-refused", "R", "refused, with its reason below"),
        ("is-failed", "!", "the device did not deliver"),
        ("is-void", "", "the extreme does not concern the method"),
    ];
    html! {
        ul.keys { @for (class, symbol, text) in entries {
            li { span.key.(class) { (symbol) } " " (text) }
        } }
    }
}

fn map(sweep: &Sweep, settings: &[&Setting], cell: &dyn Fn(&SweepRow) -> HeatCell) -> Markup {
    let groups = sweep.cases.chunk_by(|a, b| a.group == b.group);
    html! {
        div.scroll tabindex="0" { table.heat {
            thead {
                tr {
                    th {}
                    @for group in groups.clone() {
                        @let name = &group[0].group;
                        @let narrow = group.len() * CELL_PX < name.chars().count() * LETTER_PX;
                        th.first scope="colgroup" colspan=(group.len()) { div.upright[narrow] { (name) } }
                    }
                }
                tr {
                    th.corner scope="col" { "method · form · storage · look-up" }
                    @for group in groups {
                        @for (i, case) in group.iter().enumerate() {
                            th.first[i == 0] scope="col" { div.upright { (case.name) } }
                        }
                    }
                }
            }
            tbody { @for (i, setting) in settings.iter().enumerate() {
                @let new = i == 0 || (&settings[i - 1].method, &settings[i - 1].form) != (&setting.method, &setting.form);
                tr.divided[new] {
                    th scope="row" { (label(setting)) }
                    @for (i, case) in sweep.cases.iter().enumerate() {
                        @let cell = shown(case, setting, cell);
                        @let first = i == 0 || sweep.cases[i - 1].group != case.group;
                        td.(cell.class).first[first] title=(cell.title) { (cell.symbol) }
                    }
                }
            } }
        } }
    }
}

/// Text of a setting: `esm published f16 blend`.
pub fn label(setting: &Setting) -> String {
    let words = [
        &setting.method,
        &setting.form,
        &setting.storage,
        &setting.lookup,
    ];
    let words: Vec<&str> = words.into_iter().map(String::as_str).collect();
    let kept: Vec<&str> = words.into_iter().filter(|word| *word != "-").collect();
    kept.join(" ")
}

fn shown(case: &SweepCase, setting: &Setting, cell: &dyn Fn(&SweepRow) -> HeatCell) -> HeatCell {
    if let Some(reason) = &case.refused {
        return HeatCell {
            class: "is-refused",
            symbol: "R".to_owned(),
            title: reason.clone(),
        };
    }
    let row = case.rows.iter().find(|row| row.setting == *setting);
    row.map_or_else(absent, cell)
}

fn absent() -> HeatCell {
    HeatCell {
        class: "is-void",
        symbol: String::new(),
        title: String::new(),
    }
}

fn oracle_cell(columns: &Columns) -> HeatCell {
    let numbers = format!(
        "largest error {}, weighted RMSE {}, {} rises up to {}",
        maybe(columns.max_error),
        maybe(columns.weighted_rmse),
        columns.rises,
        number(columns.largest_rise)
    );
    verdict_cell(
        columns.verdict,
        columns.reason.as_deref(),
        columns.weighted_rmse,
        &numbers,
    )
}

fn device_cell(picture: &SweepPicture) -> HeatCell {
    let range = picture.range.map_or("n/a".to_owned(), |[low, high]| {
        format!("{}…{}", number(low), number(high))
    });
    let numbers = format!(
        "largest error of V {}, V in {range}",
        maybe(picture.max_error)
    );
    verdict_cell(
        picture.verdict,
        picture.reason.as_deref(),
        picture.max_error,
        &numbers,
    )
}

fn verdict_cell(
    verdict: FormVerdict,
    reason: Option<&str>,
    error: Option<f64>,
    numbers: &str,
) -> HeatCell {
    let (class, symbol) = match verdict {
        FormVerdict::Ok => error_class(error),
        FormVerdict::Rings => ("is-rings", "~"),
        FormVerdict::Breaks => ("is-breaks", "✕"),
        FormVerdict::Refused => ("is-refused", "R"),
        FormVerdict::Failed => ("is-failed", "!"),
    };
    let title = match reason {
        Some(reason) => format!("{reason}; {numbers}"),
        None => numbers.to_owned(),
    };
    HeatCell {
        class,
        symbol: symbol.to_owned(),
        title,
    }
}

/// CSS class and symbol of the error's decade; `·` where there is no error, because nothing scatters light.
fn error_class(error: Option<f64>) -> (&'static str, &'static str) {
    match error {
        None => ("is-e4", "·"),
        Some(e) if e <= 1e-4 => ("is-e4", "4"),
        Some(e) if e <= 1e-3 => ("is-e3", "3"),
        Some(e) if e <= 1e-2 => ("is-e2", "2"),
        Some(e) if e <= 1e-1 => ("is-e1", "1"),
        Some(_) => ("is-e0", "0"),
    }
}
