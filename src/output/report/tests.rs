use super::fixture::{ADAPTER, HOSTILE, paint, report};
use super::*;
use crate::metrics::Stats;
use std::collections::BTreeMap;
use std::fs::read_to_string;

/// A folder with the fixture's report.
fn written(dir: &Path) -> (Report, PathBuf) {
    let report = report();
    paint(dir, &report, 16);
    let page = write(dir, &report).expect("report");
    (report, page)
}

fn text(path: impl AsRef<Path>) -> String {
    read_to_string(path.as_ref()).expect("file")
}

/// Every file the report writes, by name.
fn outputs(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let read = |path: PathBuf| std::fs::read(path).expect("file");
    let mut out: BTreeMap<String, Vec<u8>> = ["index.html", "cells.csv", "report.json"]
        .iter()
        .map(|n| ((*n).to_owned(), read(dir.join(n))))
        .collect();
    for entry in std::fs::read_dir(dir.join("charts"))
        .expect("charts")
        .flatten()
    {
        out.insert(
            entry.file_name().to_string_lossy().into_owned(),
            read(entry.path()),
        );
    }
    out
}

#[test]
fn page_escapes_hostile_names_and_needs_no_network() {
    let dir = tempfile::tempdir().expect("folder");
    let (_, page) = written(dir.path());
    let html = text(page);
    assert!(
        !html.contains("<script>alert"),
        "a scene's name became markup"
    );
    assert!(
        !html.contains("<b>now</b>"),
        "a failure's reason became markup"
    );
    assert!(html.contains("&lt;script&gt;alert"));
    for scheme in [
        "src=\"http",
        "href=\"http",
        "url(",
        "@import",
        "href=\"//",
        "src=\"//",
    ] {
        assert!(
            !html.contains(scheme),
            "the page asks for something outside: {scheme}"
        );
    }
    assert!(html.contains("exceeds the limit of 1 GiB") && html.contains("1 cell failed"));
    assert!(
        html.matches("data:image/png;base64,").count() > 60,
        "pictures are embedded"
    );
}

#[test]
fn csv_has_one_row_a_cell_and_no_false_zeros() {
    let dir = tempfile::tempdir().expect("folder");
    let (report, _) = written(dir.path());
    let mut reader = ::csv::Reader::from_path(dir.path().join("cells.csv")).expect("csv");
    let headers = reader.headers().expect("headers").clone();
    let column = |name: &str| {
        headers
            .iter()
            .position(|h| h == name)
            .unwrap_or_else(|| panic!("no column {name}"))
    };
    let rows: Vec<::csv::StringRecord> = reader.records().map(|r| r.expect("row")).collect();
    assert_eq!(rows.len(), report.cells.len());
    assert_eq!(&rows[0][column("scene")], HOSTILE);
    assert_eq!(&rows[1][column("params.steps")], "10");
    assert_eq!(
        &rows[0][column("params.storage")],
        "",
        "srm has no such parameter"
    );
    assert_eq!(
        &rows[7][column("time_ms.total.median")],
        "",
        "no timestamps is empty, not 0"
    );
    assert!(rows[13][column("failed")].starts_with("adapter:"));
    assert_eq!(&rows[13][column("error.rel_rmse")], "");
    for name in [
        "memory.allocator_bytes",
        "error.flicker",
        "samples.light",
        "files.png",
        "image.width",
    ] {
        column(name);
    }
}

#[test]
fn charts_name_adapter_scene_and_sun_in_text_large_enough() {
    let dir = tempfile::tempdir().expect("folder");
    written(dir.path());
    let charts: Vec<_> = outputs(dir.path())
        .into_iter()
        .filter(|(n, _)| n.ends_with(".svg"))
        .map(|(n, svg)| (n, String::from_utf8(svg).expect("text")))
        .collect();
    // There are four cases, two with three errors each; the memory chart shows the whole report.
    for (stem, count) in [
        ("error-time-", 4),
        ("error-bytes-", 4),
        ("error-steps-", 4),
        ("time-", 4),
        ("three-errors-", 2),
        ("memory.svg", 1),
    ] {
        let named = charts.iter().filter(|(n, _)| n.starts_with(stem));
        assert_eq!(named.count(), count, "{stem}");
    }
    for (name, svg) in &charts {
        assert!(
            svg.contains(ADAPTER) && svg.contains("Cpu"),
            "{name} does not name its adapter"
        );
        assert!(
            svg.trim_end().ends_with("</svg>") && !svg.contains("<script"),
            "{name}"
        );
        assert!(
            name == "memory.svg"
                || svg.contains("cumulus")
                || svg.contains("Stratus deck, 2 km · sun"),
            "{name}"
        );
        for size in svg
            .split("font-size=\"")
            .skip(1)
            .filter_map(|s| s.split('"').next())
        {
            assert!(
                size.parse::<f64>().expect("size") >= 11.999,
                "{name} has text of {size} px"
            );
        }
    }
}

#[test]
fn charts_without_data_are_not_drawn_and_old_ones_go() {
    let dir = tempfile::tempdir().expect("folder");
    let (mut report, _) = written(dir.path());
    report.cells.retain(|c| c.method == "none");
    for cell in &mut report.cells {
        let result = cell.result.as_mut().expect("result");
        result.time_ms = Default::default();
        result.decomposition = None;
    }
    let page = write(dir.path(), &report).expect("report");
    let names: Vec<String> = outputs(dir.path())
        .into_keys()
        .filter(|n| n.ends_with(".svg"))
        .collect();
    let named = |stem: &str| names.iter().filter(|n| n.starts_with(stem)).count();
    assert_eq!(named("error-bytes-"), 4, "{names:?}");
    for stem in [
        "error-time",
        "error-steps",
        "time",
        "three-errors",
        "memory",
    ] {
        assert_eq!(named(stem), 0, "{names:?}");
    }
    assert!(text(page).contains("No cell has a time."));
}

#[test]
fn a_missing_picture_is_a_notice_and_no_path_leads_outside() {
    let dir = tempfile::tempdir().expect("folder");
    let mut report = report();
    paint(dir.path(), &report, usize::MAX);
    std::fs::remove_file(dir.path().join("images/truth-0-0.png")).expect("removed");
    let escape = [
        "../secret.png",
        "/etc/secret.png",
        "javascript:alert(1).png",
        "..\\secret.png",
    ];
    for (cell, name) in report.cells.iter_mut().zip(escape) {
        cell.result
            .as_mut()
            .expect("result")
            .files
            .insert("png".into(), name.into());
    }
    std::fs::write(dir.path().join("broken.png"), "not a picture").expect("file");
    report.cells[18]
        .result
        .as_mut()
        .expect("result")
        .files
        .insert("png".into(), "broken.png".into());
    let html = text(write(dir.path(), &report).expect("report"));
    assert!(
        html.contains("Picture missing.")
            && html.contains("images/truth-0-0.png` is not in the report folder")
    );
    assert_eq!(
        html.matches("leads outside the report folder").count(),
        escape.len()
    );
    assert!(html.contains("is not a PNG that can be shown"));
    assert!(
        !html.contains("href=\"..")
            && !html.contains("href=\"/")
            && !html.contains("href=\"javascript")
    );
}

#[test]
fn rebuilding_from_the_records_changes_no_byte() {
    let dir = tempfile::tempdir().expect("folder");
    written(dir.path());
    let first = outputs(dir.path());
    let again = Report::read(&dir.path().join("report.json")).expect("records");
    write(dir.path(), &again).expect("report");
    assert!(first == outputs(dir.path()), "a rebuilt folder differs");
}

#[test]
fn numbers_json_cannot_hold_fail_their_cell_and_the_file_stays_readable() {
    let dir = tempfile::tempdir().expect("folder");
    let mut report = report();
    report.cells[0]
        .result
        .as_mut()
        .expect("result")
        .error
        .rel_rmse = f64::NAN;
    report.cells[1]
        .result
        .as_mut()
        .expect("result")
        .error
        .psnr_db = Some(f64::INFINITY);
    let total = Some(Stats {
        median: 1.0,
        p95: f64::INFINITY,
        ..Stats::default()
    });
    report.cells[2]
        .result
        .as_mut()
        .expect("result")
        .time_ms
        .total = total;
    write(dir.path(), &report).expect("report");
    let read = Report::read(&dir.path().join("report.json")).expect("readable");
    assert!(
        read.cells[0]
            .failed
            .as_ref()
            .expect("failed")
            .contains("error.rel_rmse")
    );
    assert_eq!(
        read.cells[1].result.as_ref().expect("kept").error.psnr_db,
        None
    );
    assert!(
        read.cells[2]
            .failed
            .as_ref()
            .expect("failed")
            .contains("time_ms.total.p95")
    );
}

#[test]
fn a_report_without_cells_is_a_page_that_says_so() {
    let dir = tempfile::tempdir().expect("folder");
    let report = Report {
        cells: Vec::new(),
        references: Vec::new(),
        ..report()
    };
    let html = text(write(dir.path(), &report).expect("report"));
    assert!(
        html.contains("No cell has numbers to draw") && html.contains("The report has no truth")
    );
}

#[test]
fn hostile_methods_and_parameters_stay_text_everywhere() {
    let dir = tempfile::tempdir().expect("folder");
    let mut report = report();
    paint(dir.path(), &report, usize::MAX);
    for cell in report.cells.iter_mut().take(2) {
        cell.method = "\"><img src=x onerror=alert(3)>".into();
        cell.params.insert(
            "note".into(),
            format!("'\"><script>alert({})</script>", cell.index).into(),
        );
    }
    let html = text(write(dir.path(), &report).expect("report"));
    let svgs = outputs(dir.path())
        .into_iter()
        .filter(|(n, _)| n.ends_with(".svg"))
        .map(|(_, svg)| String::from_utf8(svg).expect("text"));
    for markup in svgs.chain([html]) {
        assert!(!markup.contains("<img src=x") && !markup.contains("<script>alert"));
    }
}

#[test]
fn the_sheet_shows_the_truth_and_the_middle_setting_of_each_method() {
    let dir = tempfile::tempdir().expect("folder");
    let (report, _) = written(dir.path());
    let view = view::ReportView::new(&report);
    let srm = contact::typical(&view.cases[0], "srm").expect("cell");
    assert_eq!(srm.rel_rmse(), 0.1595, "third of six by error");
    let sheets = contact::all(dir.path(), &view).expect("sheets");
    assert_eq!(sheets.len(), view.cases.len());
    let sheet = image::load_from_memory(&sheets[0].png)
        .expect("png")
        .into_rgb8();
    let size = sheet.dimensions();
    assert!(
        size.0 > 4 * 480 && size.1 > 4 * 270,
        "two rows of four: {size:?}"
    );
    let truth = image::open(dir.path().join("images/truth-0-0.png"))
        .expect("png")
        .into_rgb8();
    let shown = image::imageops::resize(&truth, 480, 270, image::imageops::FilterType::Triangle);
    let same = |x: u32, y: u32| {
        let mut pixels = shown.enumerate_pixels();
        pixels.all(|(u, v, p)| sheet.get_pixel(x + u, y + v) == p)
    };
    let found = (0..200).any(|y| (0..40).any(|x| same(x, y)));
    assert!(found, "the first tile is the truth, pixel for pixel");
    assert!(
        sheet.pixels().any(|p| p.0 == [103, 0, 31]),
        "the scale ends in its own colour"
    );
}

#[test]
fn the_first_table_answers_with_the_fastest_setting_within_the_error() {
    let dir = tempfile::tempdir().expect("folder");
    let mut report = report();
    report
        .cells
        .retain(|c| ["srm", "none"].contains(&c.method.as_str()));
    let html = text(write(dir.path(), &report).expect("report"));
    let row = |name: &str| {
        let start = html
            .find(&format!("<tr><th scope=\"row\">{name}"))
            .expect("row");
        let row = &html[start..];
        row[..row.find("</tr>").expect("end")].to_owned()
    };
    let first = row("cumulus");
    let answers: Vec<&str> = first.split("<td").skip(1).collect();
    assert!(answers[0].contains("none measured") && answers[0].contains("least: 0.0550"));
    assert!(answers[2].contains("steps=20 spacing=quadratic") && answers[2].contains("530 ms"));
    assert!(
        answers[4].contains("steps=6 spacing=quadratic"),
        "the fastest, not the best"
    );
    let all = row("every view");
    assert!(
        all.contains("least: 0.107"),
        "the worst of the views counts: {all}"
    );
}
