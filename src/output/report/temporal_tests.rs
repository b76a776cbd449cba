//! Tests of reports with cells that are reconstructed from several frames.

use super::fixture::{paint, report};
use super::*;
use crate::batch::record::{Ghosting, ReconstructionNumbers};
use crate::metrics::Stats;
use crate::reconstruct::find;
use crate::scene::CameraTrack;
use std::collections::BTreeMap;

const HISTORY_BYTES: u64 = 640 * 360 * 72;

/// Report with one cell of the fixture, and the same cell with temporal reconstruction.
fn pair() -> Report {
    let mut report = report();
    report.cells.truncate(1);
    let mut twin = report.cells[0].clone();
    twin.index = 1;
    twin.reconstruct = find("temporal_2x2").expect("registered").info();
    twin.id = "temporal".to_owned();
    let numbers = twin.result.as_mut().expect("numbers");
    let time = |median| Stats {
        median,
        ..Stats::default()
    };
    numbers.time_ms.march = Some(time(60.0));
    numbers.time_ms.reconstruct = Some(time(20.0));
    numbers.time_ms.total = Some(time(80.0));
    numbers.rounds_total_ms = [50.0, 40.0, 40.0].map(Some).into();
    let curve = |step_deg, step_m| Ghosting {
        step_deg,
        step_m,
        rel_rmse: vec![0.0, 0.125, 0.0625],
    };
    numbers.reconstruction = Some(ReconstructionNumbers {
        full_rel_rmse: 0.0,
        ghosting: BTreeMap::from([
            (CameraTrack::Pan, curve(Some(0.25), None)),
            (CameraTrack::Dolly, curve(None, Some(12.5))),
        ]),
        history_bytes: HISTORY_BYTES,
    });
    let full = report.cells[0].result.as_mut().expect("numbers");
    full.rounds_total_ms = [100.0, 200.0, 400.0].map(Some).into();
    report.cells.push(twin);
    report
}

/// The page, and the charts by name.
fn written(report: &Report) -> (String, BTreeMap<String, String>) {
    let dir = tempfile::tempdir().expect("folder");
    paint(dir.path(), report, 16);
    let page = write(dir.path(), report).expect("report");
    let read = |path: &Path| String::from_utf8_lossy(&std::fs::read(path).expect("file")).into();
    let charts = std::fs::read_dir(dir.path().join("charts")).expect("charts");
    let chart = |entry: std::fs::DirEntry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        (name, read(&entry.path()))
    };
    (read(&page), charts.flatten().map(chart).collect())
}

fn chart<'a>(charts: &'a BTreeMap<String, String>, start: &str) -> &'a str {
    let found = charts.iter().find(|(name, _)| name.starts_with(start));
    found.map(|(_, svg)| svg.as_str()).expect("chart")
}

#[test]
fn the_frame_is_divided_by_the_full_picture_inside_rounds() {
    // The ratios are 50, 20 and 10 %; the ratio of the medians would differ from their median.
    let (page, _) = written(&pair());
    let row = page.split("id=\"reconstruction\"").nth(1).expect("section");
    assert!(row.contains(">20.0 %<"), "{row}");
    let mut unequal = pair();
    let numbers = unequal.cells[1].result.as_mut().expect("numbers");
    numbers.rounds_total_ms.pop();
    let full_ms = numbers_of(&unequal, 0).time_ms.total.expect("time").median;
    let (page, _) = written(&unequal);
    let expected = format!(">{}<", format::percent(80.0 / full_ms));
    assert!(page.contains(&expected), "{expected}");
}

fn numbers_of(report: &Report, cell: usize) -> &crate::batch::record::Measured {
    report.cells[cell].result.as_ref().expect("numbers")
}

#[test]
fn times_and_memory_are_named_for_what_they_are() {
    let (page, charts) = written(&pair());
    let bars = chart(&charts, "time-");
    assert!(bars.contains("one frame (a quarter of the pixels marched)"));
    assert!(bars.contains("reconstruction") && bars.contains("at rest."));
    for words in [
        "Reconstruct <span class=\"unit\">ms",
        "History <span class=\"unit\">bytes",
        "no map + history 15.8 MiB",
        "Map + history",
    ] {
        assert!(page.contains(words), "{words}");
    }
    assert!(page.contains(&format!("data-bytes=\"{HISTORY_BYTES}\"")));
    assert!(chart(&charts, "error-bytes").contains("history"));
    assert!(chart(&charts, "ghosting-pan").contains("0.250° a frame"));
    assert!(chart(&charts, "ghosting-dolly").contains("12.5 m sideways a frame"));
    let (page, charts) = written(&report());
    assert!(!page.contains("Reconstruct <") && !page.contains("istory"));
    assert!(
        charts
            .values()
            .all(|svg| !svg.contains("history") && !svg.contains("marched)"))
    );
}

#[test]
fn a_report_of_temporal_cells_alone_says_so_in_every_setting() {
    let mut report = pair();
    report.cells.remove(0);
    let (page, charts) = written(&report);
    assert!(page.contains("reconstruct=temporal_2x2</span>"));
    assert!(chart(&charts, "time-").contains("srm temporal_2x2"));
}
