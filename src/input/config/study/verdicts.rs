//! Types of a study file for what its readers take away: defects of the source, and questions of the guide; no logic.

use super::spec::Quantity;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Map, Value};

/// What shows a defect.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Evidence {
    /// A published number against a measured one.
    Number {
        /// The number as published, in `unit`s.
        published: f64,
        /// The unit's name.
        unit: String,
        /// Units in one of the measured number, e.g. bytes in a MiB.
        per: f64,
        /// The measured number.
        measured: Box<Quantity>,
    },
    /// A number of two cells: as printed and as meant.
    Cells {
        /// As printed.
        printed: Box<Quantity>,
        /// As meant.
        meant: Box<Quantity>,
    },
    /// rel_rmse of two truths from a third: the view march itself is at fault, which cells share with their truth.
    Truths {
        /// Id of the experiment.
        experiment: String,
        /// Scene members of the truth as printed.
        printed: Map<String, Value>,
        /// As meant.
        meant: Map<String, Value>,
        /// The truth that both are compared with.
        limit: Map<String, Value>,
    },
    /// Two published numbers that contradict each other.
    Text {
        /// The number in one place.
        one: f64,
        /// The number in the other.
        other: f64,
        /// Unit of both numbers.
        unit: String,
    },
}

/// A defect of the source.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Erratum {
    /// Where it stands.
    pub place: String,
    /// What is printed.
    pub printed: String,
    /// What is meant.
    pub meant: String,
    /// The number that shows it.
    pub evidence: Evidence,
}

/// A question of the guide.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Question {
    /// Which series has the smallest number at each value of an axis?
    Along {
        /// Heading.
        title: String,
        /// What the number is, in words with its unit.
        words: String,
        /// Which number.
        metric: String,
        /// Where the cells are.
        experiment: String,
        /// The axis.
        along: String,
        /// What the axis is, in words.
        along_words: String,
        /// Series that compete.
        series: Vec<String>,
        /// Axis values besides those of the series.
        #[serde(default)]
        at: Map<String, Value>,
    },
    /// Which series has the smallest number of all, of those that fit a budget?
    Within {
        /// Heading.
        title: String,
        /// What the number is, in words with its unit.
        words: String,
        /// Which number, its size counts.
        metric: String,
        /// Where the cells are.
        experiment: String,
        /// Series that compete.
        series: Vec<String>,
        /// Axis values besides those of the series.
        #[serde(default)]
        at: Map<String, Value>,
        /// What is limited, in words.
        #[serde(default)]
        budget_words: String,
        /// Number that is limited, e.g. `map_bytes`.
        #[serde(default)]
        budget: Option<String>,
        /// Limits of that number, one sentence each; none: one sentence without a limit.
        #[serde(default)]
        limits: Vec<f64>,
    },
}
