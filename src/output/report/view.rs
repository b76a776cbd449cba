//! View of the records for charts and page: groups of comparable cells, short names of settings.

use super::format::{memory_size, shorten};
use super::shown::RECONSTRUCT;
use crate::batch::record::{Cell, Clock, Measured, Reference, Report};
use crate::metrics::Stats;
use crate::scene::ReconstructionInfo;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// A cell that has numbers.
#[derive(Clone, Copy)]
pub struct Shot<'a> {
    /// The cell.
    pub cell: &'a Cell,
    /// Numbers of the cell.
    pub numbers: &'a Measured,
    /// Clock of the report.
    pub clock: Clock,
}

impl Shot<'_> {
    /// Time of one picture by the report's clock, ms.
    pub fn time(&self) -> Option<Stats> {
        self.clock
            .cost(&self.numbers.time_ms)
            .filter(|t| t.median > 0.0)
    }

    /// Median of [`Self::time`], ms.
    pub fn time_ms(&self) -> Option<f64> {
        self.time().map(|t| t.median)
    }

    /// Relative RMSE against the truth.
    pub fn rel_rmse(&self) -> f64 {
        self.numbers.error.rel_rmse
    }

    /// Bytes of the map's textures.
    pub fn map_bytes(&self) -> u64 {
        self.numbers.memory.map_bytes
    }

    /// Bytes of the history; 0 where frames use none.
    pub fn history_bytes(&self) -> u64 {
        let parts = self.numbers.reconstruction.as_ref();
        parts.map_or(0, |parts| parts.history_bytes)
    }

    /// Bytes of map and history.
    pub fn memory_bytes(&self) -> u64 {
        self.map_bytes().saturating_add(self.history_bytes())
    }

    /// Text of both sizes; the history is named where there is one.
    pub fn memory(&self) -> String {
        memory_size(self.map_bytes(), self.history_bytes())
    }
}

/// Cells that may be compared with one another: one scene, sun, image size and backend, so one truth.
pub struct CellGroup<'a> {
    /// Position in the report, from 1.
    pub number: usize,
    /// Scene and sun, and whatever else distinguishes it from the other cases.
    pub name: String,
    /// [`Self::name`] with a long scene name cut, so that the sun remains readable.
    pub short_name: String,
    /// Name for files and anchors: lower-case letters, digits and hyphens.
    pub slug: String,
    /// Cells of the view in matrix order, failed ones included.
    pub cells: Vec<&'a Cell>,
    /// The truth that its cells are compared with.
    pub reference: Option<&'a Reference>,
    /// Clock of the report.
    pub clock: Clock,
}

impl<'a> CellGroup<'a> {
    /// The cells that have numbers.
    pub fn shots(&self) -> Vec<Shot<'a>> {
        self.cells
            .iter()
            .filter_map(|cell| {
                Some(Shot {
                    cell,
                    numbers: cell.result.as_ref()?,
                    clock: self.clock,
                })
            })
            .collect()
    }

    /// Methods of the view in matrix order.
    pub fn methods(&self) -> Vec<&'a str> {
        distinct(self.cells.iter().map(|c| c.method.as_str()))
    }

    /// The cells of `method` that have numbers, the smallest error first.
    pub fn by_error(&self, method: &str) -> Vec<Shot<'a>> {
        let mut shots = self.shots();
        shots.retain(|s| s.cell.method == method);
        shots.sort_by(|a, b| a.rel_rmse().total_cmp(&b.rel_rmse()));
        shots
    }

    /// Difference at the ends of the false-colour scale, in units of the truth's mean radiance, where it is recorded.
    pub fn diff_scale(&self) -> Option<f64> {
        let scale = |s: &Shot<'_>| s.numbers.files.get("diff_scale")?.as_f64();
        self.shots().iter().find_map(scale)
    }
}

/// A report arranged for charts and page.
pub struct ReportView<'a> {
    /// The records.
    pub report: &'a Report,
    /// Comparable cells together, in matrix order.
    pub cases: Vec<CellGroup<'a>>,
    /// Names of varying parameters by method, see [`ReportView::varying`].
    varying: BTreeMap<&'a str, Vec<&'a str>>,
    reconstructions: Vec<&'static ReconstructionInfo>,
    frames: String,
}

impl<'a> ReportView<'a> {
    /// Arranges a report.
    pub fn new(report: &'a Report) -> Self {
        let mut varying: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for method in distinct(report.cells.iter().map(|c| c.method.as_str())) {
            let sets: Vec<_> = report
                .cells
                .iter()
                .filter(|c| c.method == method)
                .map(|c| &c.params)
                .collect();
            let mut keys = varying_keys(&sets);
            // A reconstruction is always part of the setting's name, even where all cells have the same.
            if sets.iter().any(|s| s.contains_key(RECONSTRUCT)) && !keys.contains(&RECONSTRUCT) {
                keys.push(RECONSTRUCT);
            }
            varying.insert(method, keys);
        }
        let kinds = report.cells.iter().map(|cell| cell.reconstruct);
        let reconstructions = distinct(kinds.filter(|info| !info.is_full()));
        let frames = |info: &&ReconstructionInfo| {
            let (id, share) = (info.id, info.share());
            format!(" {id}: one frame ({share} of the pixels marched), at rest.")
        };
        Self {
            report,
            cases: cases(report),
            varying,
            frames: reconstructions.iter().map(frames).collect(),
            reconstructions,
        }
    }

    /// Adapter name and device type, for the caption of every table and chart.
    pub fn adapter(&self) -> String {
        let e = &self.report.environment;
        if e.is_oracle() {
            return format!("{}, {}", e.adapter, e.driver);
        }
        format!("{} ({}, {})", e.adapter, e.device_type, e.backend)
    }

    /// `total` or `wall`: the clock that times of cells are taken from.
    pub fn clock(&self) -> Clock {
        self.report.clock()
    }

    /// Reconstructions of the cells other than `full`, in order of first appearance.
    pub fn reconstructions(&self) -> &[&'static ReconstructionInfo] {
        &self.reconstructions
    }

    /// True where pictures of any cell are reconstructed.
    pub fn reconstructed(&self) -> bool {
        !self.reconstructions.is_empty()
    }

    /// Noun for what [`Shot::time`] measures.
    pub fn timed(&self) -> &'static str {
        if self.reconstructed() {
            "one picture or frame"
        } else {
            "one picture"
        }
    }

    /// Sentence on how a frame is rendered, preceded by a blank; empty where no picture is reconstructed.
    pub fn frames(&self) -> &str {
        &self.frames
    }

    /// Noun for what [`Shot::memory_bytes`] counts.
    pub fn remembered(&self) -> &'static str {
        if self.reconstructed() {
            "Map + history"
        } else {
            "Map"
        }
    }

    /// Parameters of `method` that take more than one value in this report, and [`RECONSTRUCT`] wherever a cell has it.
    pub fn varying(&self, method: &str) -> &[&'a str] {
        self.varying.get(method).map_or(&[], Vec::as_slice)
    }

    /// Setting as names and values of the varying parameters: `steps=10 spacing=quadratic`; empty when nothing varies.
    pub fn setting(&self, cell: &Cell) -> String {
        let varying = self.varying(&cell.method).iter();
        pairs(varying.filter_map(|k| Some((*k, cell.params.get(*k)?))))
    }

    /// Method and setting, abbreviated for charts: `srm 10 steps quadratic`.
    pub fn short(&self, cell: &Cell) -> String {
        self.short_without(cell, &[])
    }

    /// [`Self::short`] without some of the parameters.
    pub fn short_without(&self, cell: &Cell, left_out: &[&str]) -> String {
        let mut words = vec![shorten(&cell.method, 24)];
        for key in self
            .varying(&cell.method)
            .iter()
            .filter(|k| !left_out.contains(k))
        {
            words.extend(cell.params.get(*key).map(|v| short_value(key, v)));
        }
        words.join(" ")
    }
}

fn short_value(key: &str, value: &Value) -> String {
    match (key, value) {
        ("steps", v) => format!("{} steps", plain(v)),
        ("resolution", v) => format!("{}²", plain(v)),
        (_, Value::String(text)) => shorten(text, 16),
        (_, v) => shorten(&format!("{key}={}", plain(v)), 20),
    }
}

/// A JSON value as plain text, strings without quotes.
pub fn plain(value: &Value) -> String {
    value
        .as_str()
        .map_or_else(|| value.to_string(), str::to_owned)
}

/// Parameters as `key=value key=value`.
pub fn pairs<'a>(params: impl Iterator<Item = (&'a str, &'a Value)>) -> String {
    let words: Vec<String> = params.map(|(k, v)| format!("{k}={}", plain(v))).collect();
    words.join(" ")
}

/// Every parameter of a cell as `key=value key=value`.
pub fn all_params(cell: &Cell) -> String {
    pairs(cell.params.iter().map(|(k, v)| (k.as_str(), v)))
}

/// The distinct items, in order of first appearance.
pub fn distinct<T: PartialEq>(items: impl Iterator<Item = T>) -> Vec<T> {
    let mut out = Vec::new();
    for item in items {
        if !out.contains(&item) {
            out.push(item);
        }
    }
    out
}

/// Keys whose value differs between `sets`; `steps` and `resolution` come first.
fn varying_keys<'a>(sets: &[&'a Map<String, Value>]) -> Vec<&'a str> {
    let mut keys = distinct(sets.iter().flat_map(|s| s.keys().map(String::as_str)));
    keys.retain(|k| sets.iter().any(|s| s.get(*k) != sets[0].get(*k)));
    keys.sort_by_key(|k| match *k {
        "steps" => 0,
        "resolution" => 1,
        _ => 2,
    });
    keys
}

fn cases(report: &Report) -> Vec<CellGroup<'_>> {
    let mut groups: Vec<Vec<&Cell>> = Vec::new();
    for cell in &report.cells {
        match groups.iter_mut().find(|g| comparable(g[0], cell)) {
            Some(group) => group.push(cell),
            None => groups.push(vec![cell]),
        }
    }
    let clock = report.clock();
    let firsts: Vec<&Cell> = groups.iter().map(|g| g[0]).collect();
    groups
        .into_iter()
        .enumerate()
        .map(|(i, cells)| CellGroup {
            number: i + 1,
            name: case_name(cells[0], &cells[0].scene, &firsts),
            short_name: case_name(cells[0], &shorten(&cells[0].scene, 64), &firsts),
            slug: format!(
                "{}-{}-sun{}",
                i + 1,
                slug(&cells[0].scene),
                slug(&cells[0].sun_elevation_deg.to_string())
            ),
            reference: reference(report, &cells),
            clock,
            cells,
        })
        .collect()
}

fn comparable(a: &Cell, b: &Cell) -> bool {
    a.scene == b.scene
        && a.sun_elevation_deg == b.sun_elevation_deg
        && a.image == b.image
        && a.backend == b.backend
        && a.scene_set == b.scene_set
}

/// Scene and sun, then whatever else differs between the cases of the report.
fn case_name(cell: &Cell, scene: &str, firsts: &[&Cell]) -> String {
    let mut name = format!("{scene} · sun {}°", cell.sun_elevation_deg);
    if firsts.iter().any(|c| c.image != cell.image) {
        name += &format!(" · {}×{}", cell.image.width, cell.image.height);
    }
    if firsts.iter().any(|c| c.backend != cell.backend) {
        name += &format!(" · {}", cell.backend);
    }
    for key in varying_keys(&firsts.iter().map(|c| &c.scene_set).collect::<Vec<_>>()) {
        if key == "/sun/elevation_deg" {
            continue; // the sun has words of its own
        }
        name += &cell
            .scene_set
            .get(key)
            .map(|v| format!(" · {key}={}", plain(v)))
            .unwrap_or_default();
    }
    name
}

/// Truth named by the cells; where all failed, the one of the same scene, sun and image size.
fn reference<'a>(report: &'a Report, cells: &[&Cell]) -> Option<&'a Reference> {
    let id = cells
        .iter()
        .find_map(|c| c.result.as_ref())
        .map(|r| r.reference.as_str());
    let same = |r: &&Reference| {
        let c = cells[0];
        r.scene == c.scene && r.sun_elevation_deg == c.sun_elevation_deg && r.image == c.image
    };
    match id {
        Some(id) => report.references.iter().find(|r| r.id == id),
        None => report.references.iter().find(same),
    }
}

/// Lower-case letters, digits and single hyphens, at most 40.
fn slug(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars().take(40) {
        if c.is_ascii_alphanumeric() {
            out.push(c.to_ascii_lowercase());
        } else if !out.is_empty() && !out.ends_with('-') {
            out.push('-');
        }
    }
    out.trim_end_matches('-').to_owned()
}
