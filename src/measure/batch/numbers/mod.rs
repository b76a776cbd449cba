//! Table of every number of a cell's record: its name, how it is written, and where it is shown.
//!
//! Error numbers come from [`METRICS`](crate::metrics::METRICS), all others from the rows of `rows.rs`. Pages, the
//! window and studies read this table; `cells.csv` takes its columns from the type of the record, and a test compares
//! both.

mod rows;

use super::record::{Clock, Measured};
use crate::metrics::{ErrorNumbers, Format, Metric, Stats, arranged};
use std::sync::LazyLock;

/// Prefixes of the names of numbers that only cells with a reconstruction other than `full` have.
pub const OF_RECONSTRUCTIONS: [&str; 2] = ["time_ms.reconstruct.", "reconstruction."];

/// Where the page of a report shows a number. `cells.csv` and `report.json` have all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PagePlace {
    /// In the table of all cells.
    Cells,
    /// In the table of the three errors.
    Decomposition,
    /// In the section on reconstructions.
    Reconstruction,
    /// In the section on the clock.
    Clock,
    /// Not on the page.
    Nowhere,
}

/// A number that was measured once in each round.
#[derive(Clone, Copy, Debug)]
pub struct Repeats {
    /// Value in each round; empty where rounds are not recorded.
    pub rounds: fn(&Measured) -> &[Option<f64>],
    /// Statistics over the rounds, by the clock of the report.
    pub stats: fn(&Measured, Clock) -> Option<Stats>,
}

/// A number of a cell.
#[derive(Clone, Copy, Debug)]
pub struct CellNumber {
    /// Dotted name in the record, the column of `cells.csv`: `memory.map_bytes`.
    pub path: &'static str,
    /// Heading on a page.
    pub label: &'static str,
    /// Unit of the recorded value; empty for ratios and counts.
    pub unit: &'static str,
    /// How pages write it.
    pub format: Format,
    /// Where the page of a report shows it.
    pub shown: PagePlace,
    /// Definition.
    pub doc: &'static str,
    /// Name of the number in a study; `None` where studies cannot use it.
    pub study: Option<&'static str>,
    /// Values by round, where they are recorded.
    pub repeats: Option<Repeats>,
    /// Whether it is never positive; studies then compare its magnitude.
    negative: bool,
    get: Getter,
}

/// Function that reads the value.
#[derive(Clone, Copy, Debug)]
enum Getter {
    Cell(fn(&Measured) -> Option<f64>),
    Error(fn(&ErrorNumbers) -> Option<f64>),
}

impl CellNumber {
    fn of_error(metric: &Metric) -> Self {
        Self {
            path: metric.path,
            label: metric.label,
            unit: metric.unit,
            format: metric.format,
            shown: PagePlace::Cells,
            doc: metric.doc,
            study: Some(metric.key),
            repeats: None,
            negative: metric.range[1] <= 0.0,
            get: Getter::Error(metric.get),
        }
    }

    /// The value; `None` where it is absent.
    pub fn value(&self, measured: &Measured) -> Option<f64> {
        match self.get {
            Getter::Cell(get) => get(measured),
            Getter::Error(get) => get(&measured.error),
        }
    }

    /// The value as studies compare it: the magnitude of a number that is never positive.
    pub fn study_value(&self, measured: &Measured) -> Option<f64> {
        let value = self.value(measured)?;
        Some(if self.negative { -value } else { value })
    }

    /// Whether only cells with a reconstruction other than `full` have it.
    pub fn is_of_reconstruction(&self) -> bool {
        OF_RECONSTRUCTIONS
            .iter()
            .any(|start| self.path.starts_with(start))
    }
}

/// Every number of a cell's record, as lists show them.
pub fn numbers() -> &'static [CellNumber] {
    static NUMBERS: LazyLock<Vec<CellNumber>> = LazyLock::new(|| {
        let errors = arranged().into_iter().map(CellNumber::of_error);
        errors.chain(rows::ROWS.iter().copied()).collect()
    });
    &NUMBERS
}

/// The number that studies call `name`.
pub fn study_number(name: &str) -> Option<&'static CellNumber> {
    numbers().iter().find(|number| number.study == Some(name))
}

/// Names of all numbers that a study can ask for.
pub fn study_names() -> impl Iterator<Item = &'static str> {
    numbers().iter().filter_map(|number| number.study)
}
