//! Types of a study file that say how its experiments' records are evaluated; no logic.
//!
//! An axis is named by what varies along it: a parameter of the method (`steps`), a scene member by JSON pointer
//! (`/sun/elevation_deg`), `width`, `height` or `pixels` of the picture, or the measured `cloud_pixel_fraction`.

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// A method and the axis values that pick its cells.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Series {
    /// Method id.
    pub method: String,
    /// Axis values that a cell must have.
    #[serde(default)]
    pub at: Map<String, Value>,
    /// Words for legends; default: the series' name.
    #[serde(default)]
    pub label: Option<String>,
}

/// Cells of an experiment: those of a series at further axis values.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pick {
    /// Id of the experiment.
    pub experiment: String,
    /// Name of the series.
    pub series: String,
    /// Axis values besides those of the series.
    #[serde(default)]
    pub at: Map<String, Value>,
}

/// A number of one cell, or the difference of two.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Quantity {
    /// Which number, e.g. `total_ms`.
    pub metric: String,
    /// The cell.
    pub of: Pick,
    /// The cell whose number is subtracted.
    #[serde(default)]
    pub minus: Option<Pick>,
}

/// What is tested. Limits are inclusive; a missing upper limit is no limit.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Test {
    /// A number lies between limits.
    Range {
        /// The number.
        of: Box<Quantity>,
        /// Lower and upper limit.
        between: (f64, Option<f64>),
    },
    /// The ratio of two numbers lies between limits; times of one view are divided round by round.
    Ratio {
        /// Dividend.
        of: Box<Quantity>,
        /// Divisor.
        to: Box<Quantity>,
        /// Lower and upper limit.
        between: (f64, Option<f64>),
    },
    /// Each number of a group is smaller than each of the next group.
    Order {
        /// Which number.
        metric: String,
        /// Groups from small to large.
        ascending: Vec<Vec<Pick>>,
    },
    /// The number grows along a straight line.
    Straight {
        /// Which number.
        metric: String,
        /// Cells of the line.
        of: Pick,
        /// The axis.
        along: String,
        /// Largest distance from the line over the range of the numbers.
        bend: f64,
        /// For proportionality: largest |intercept| over the largest number.
        #[serde(default)]
        intercept: Option<f64>,
    },
    /// One series is smaller before and larger after a place between limits.
    Crossover {
        /// Which number.
        metric: String,
        /// The series that overtakes.
        of: Pick,
        /// The series that is overtaken.
        over: Pick,
        /// The axis.
        along: String,
        /// Where the crossing is expected.
        between: (f64, f64),
    },
    /// What an error loses from one value of an axis to another is at most a share of it.
    Gain {
        /// Which error.
        metric: String,
        /// The series.
        of: Pick,
        /// The axis.
        along: String,
        /// From this value.
        from: f64,
        /// To this one.
        to: f64,
        /// (error(from) − error(to)) / error(from) at most.
        at_most: f64,
    },
    /// No record can decide it.
    Unmeasured {
        /// Why.
        reason: String,
    },
}

/// A part of a claim.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// The part in words, a clause.
    pub says: String,
    /// What decides it.
    pub test: Test,
}

/// A published claim: it holds when all of its parts do.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ClaimSpec {
    /// Id, e.g. `M5`.
    pub id: String,
    /// Where it is published.
    pub place: String,
    /// The claim in a sentence.
    pub says: String,
    /// What must hold together; a claim without parts is not decided.
    pub checks: Vec<Check>,
}

/// Published points of a series.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// The series they belong to.
    pub series: String,
    /// x as published, and y in the published unit.
    pub points: Vec<(f64, f64)>,
    /// Divides every y: the published value of what a chart is relative to.
    #[serde(default = "one")]
    pub unit: f64,
    /// Multiplies every x where the profile scales sizes.
    #[serde(default = "one")]
    pub x_scale: f64,
}

fn one() -> f64 {
    1.0
}

/// A chart: one curve a series.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChartSpec {
    /// Names the file.
    pub id: String,
    /// Published figure or table that it stands for.
    pub figure: String,
    /// Heading.
    pub title: String,
    /// Where the cells are.
    pub experiment: String,
    /// The horizontal axis.
    pub along: String,
    /// Title of the horizontal axis.
    pub along_title: String,
    /// Whether it is logarithmic.
    #[serde(default)]
    pub log_x: bool,
    /// Whether the vertical axis is.
    #[serde(default)]
    pub log_y: bool,
    /// Which number; several give one set of curves each.
    pub metric: String,
    /// A second number, drawn dashed.
    #[serde(default)]
    pub also: Option<String>,
    /// Title of the vertical axis.
    pub metric_title: String,
    /// Series whose total time in the same view is 1.
    #[serde(default)]
    pub relative_to: Option<String>,
    /// Series drawn.
    pub series: Vec<String>,
    /// Axis values besides those of the series.
    #[serde(default)]
    pub at: Map<String, Value>,
    /// Points of the source.
    #[serde(default)]
    pub published: Vec<Published>,
    /// A line on how to read it.
    pub note: String,
}

/// How the source models costs, and the charts that hold models against the measured times.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CostSpec {
    /// Where the source has its model.
    pub figure: String,
    /// What the source counts and takes times for, a sentence.
    pub says: String,
    /// Charts of predicted over measured times.
    #[serde(default)]
    pub charts: Vec<CostChart>,
}

/// A chart of predicted over measured times.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CostChart {
    /// Names the file.
    pub id: String,
    /// Heading.
    pub title: String,
    /// Which model predicts.
    pub prices: Prices,
}

/// A model of costs.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Prices {
    /// One price for every sample of every method.
    One,
    /// A price for each kind of sample, of each method's own.
    Own,
}

/// A table of the source, measured again.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TableSpec {
    /// Short name, for messages.
    pub id: String,
    /// Published table that it stands for.
    pub figure: String,
    /// Heading.
    pub title: String,
    /// Where the cells are.
    pub experiment: String,
    /// Numbers of a row.
    pub metrics: Vec<TableColumn>,
    /// Series whose total time in the same view is 1; absent: no ratios.
    #[serde(default)]
    pub relative_to: Option<String>,
    /// What 1 is in the source.
    #[serde(default)]
    pub unit: Option<f64>,
    /// One row a cell.
    pub rows: Vec<TableRow>,
    /// A line on how to read it.
    pub note: String,
}

/// A number of a table.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TableColumn {
    /// Which number.
    pub metric: String,
    /// Title of the column.
    pub title: String,
}

/// A cell of a table.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TableRow {
    /// Name of the series.
    pub series: String,
    /// Axis values besides those of the series.
    #[serde(default)]
    pub at: Map<String, Value>,
    /// The source's numbers by metric.
    #[serde(default)]
    pub published: BTreeMap<String, f64>,
}
