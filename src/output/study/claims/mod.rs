//! Tests published claims: predicates over records, with the numbers that decided.
//!
//! A time is an interval (see [`Interval`](crate::study::Interval)). A predicate holds or fails only where the whole
//! interval satisfies or violates it; otherwise, and where a cell is missing or failed, it is undecidable.

mod curve;
mod ratio;
#[cfg(test)]
mod tests;

use super::select::{Found, Records};
use crate::config::{ClaimSpec, Test};
use serde::Serialize;

/// Verdict on a claim, for the adapter that was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The claim holds.
    Holds,
    /// The claim does not hold.
    Fails,
    /// The records do not decide it: an interval contains a limit, or numbers are missing.
    Undecidable,
}

impl Verdict {
    /// Text of the verdict on the page.
    pub fn words(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "does not hold",
            Self::Undecidable => "not decidable here",
        }
    }

    /// Verdict of the interval `low`…`high` against limits: holds where it lies inside, fails where it lies outside.
    fn within(low: f64, high: f64, (least, most): (f64, f64)) -> Self {
        if low >= least && high <= most {
            Self::Holds
        } else if high < least || low > most {
            Self::Fails
        } else {
            Self::Undecidable
        }
    }

    /// Verdict of a conjunction of parts.
    fn all(parts: impl Iterator<Item = Self> + Clone) -> Self {
        if parts.clone().any(|part| part == Self::Fails) {
            Self::Fails
        } else if parts.clone().count() == 0 || parts.clone().any(|p| p == Self::Undecidable) {
            Self::Undecidable
        } else {
            Self::Holds
        }
    }
}

/// Reference to a cell of an experiment's report.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CellLink {
    /// Id of the experiment.
    pub experiment: String,
    /// Index of the cell in the report.
    pub index: usize,
}

impl From<&Found<'_>> for CellLink {
    fn from(found: &Found<'_>) -> Self {
        Self {
            experiment: found.experiment.to_owned(),
            index: found.cell.index,
        }
    }
}

/// Result of a predicate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Verdict of the predicate.
    pub verdict: Verdict,
    /// The numbers that decided and the wanted limits, in words.
    pub numbers: String,
    /// Cells that the numbers come from.
    pub cells: Vec<CellLink>,
}

impl Finding {
    fn new(verdict: Verdict, numbers: String, cells: &[Found<'_>]) -> Self {
        Self {
            verdict,
            numbers,
            cells: cells.iter().map(CellLink::from).collect(),
        }
    }

    fn undecidable(reason: String) -> Self {
        Self::new(Verdict::Undecidable, reason, &[])
    }
}

/// A part of a claim with its finding.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Part {
    /// The part in words.
    pub says: String,
    /// Finding of the part.
    #[serde(flatten)]
    pub finding: Finding,
}

/// A claim with its verdict.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Claim {
    /// Id, e.g. `M5`.
    pub id: String,
    /// Place in the publication.
    pub place: String,
    /// The claim in words.
    pub says: String,
    /// Verdict of the claim.
    pub verdict: Verdict,
    /// Reason for the verdict, one or two sentences.
    pub because: String,
    /// Parts that decided it.
    pub parts: Vec<Part>,
}

/// Tests a claim on records.
pub fn decide(records: &Records<'_>, spec: &ClaimSpec) -> Claim {
    let parts: Vec<Part> = spec
        .checks
        .iter()
        .map(|check| Part {
            says: check.says.clone(),
            finding: find(records, &check.test),
        })
        .collect();
    let verdict = Verdict::all(parts.iter().map(|part| part.finding.verdict));
    Claim {
        id: spec.id.clone(),
        place: spec.place.clone(),
        says: spec.says.clone(),
        verdict,
        because: because(verdict, &parts),
        parts,
    }
}

/// Finding of a test; an error, such as a missing cell, makes it undecidable.
pub fn find(records: &Records<'_>, test: &Test) -> Finding {
    let found = match test {
        Test::Range { of, between } => ratio::range(records, of, *between),
        Test::Ratio { of, to, between } => ratio::ratio(records, of, to, *between),
        Test::Order { metric, ascending } => ratio::order(records, metric, ascending),
        Test::Straight {
            metric,
            of,
            along,
            bend,
            intercept,
        } => curve::straight(records, metric, of, along, (*bend, *intercept)),
        Test::Crossover {
            metric,
            of,
            over,
            along,
            between,
        } => curve::crossover(records, metric, (of, over), along, *between),
        Test::Gain {
            metric,
            of,
            along,
            from,
            to,
            at_most,
        } => curve::gain(records, metric, (of, along), (*from, *to), *at_most),
        Test::Unmeasured { reason } => Err(reason.clone()),
    };
    found.unwrap_or_else(Finding::undecidable)
}

/// Reason for a verdict: the parts that decided it.
fn because(verdict: Verdict, parts: &[Part]) -> String {
    let of = |wanted: Verdict| -> Vec<&str> {
        let parts = parts.iter().filter(|part| part.finding.verdict == wanted);
        parts.map(|part| part.says.as_str()).collect()
    };
    match verdict {
        Verdict::Holds if parts.len() == 1 => "It holds as published.".to_owned(),
        Verdict::Holds => format!("All {} parts hold.", parts.len()),
        Verdict::Fails => {
            let failing = of(Verdict::Fails);
            let rest = parts.len() - failing.len();
            let mut text = format!("It fails in: {}.", named(&failing));
            if rest > 0 {
                let (held, open) = (of(Verdict::Holds).len(), of(Verdict::Undecidable).len());
                let held = count(held, "holds", "hold");
                let open = count(open, "is open", "are open");
                text += &format!(" Of the other parts {held} and {open}.");
            }
            text
        }
        Verdict::Undecidable if parts.is_empty() => "The study names nothing to test.".to_owned(),
        Verdict::Undecidable => format!("Open: {}.", named(&of(Verdict::Undecidable))),
    }
}

/// `n` with its verb: `one` for 0 and 1, else `many`.
fn count(n: usize, one: &str, many: &str) -> String {
    match n {
        0 => format!("none {one}"),
        1 => format!("1 {one}"),
        _ => format!("{n} {many}"),
    }
}

/// Largest number of parts that a sentence names.
const MOST_NAMED: usize = 3;

/// The first [`MOST_NAMED`] parts, and the number of the others.
fn named(parts: &[&str]) -> String {
    let shown = parts[..parts.len().min(MOST_NAMED)].join("; ");
    match parts.len().saturating_sub(MOST_NAMED) {
        0 => shown,
        more => format!("{shown}; and {more} more"),
    }
}
