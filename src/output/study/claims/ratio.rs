//! Predicates on single numbers: range, ratio, order.

use super::super::interval::Interval;
use super::super::select::{self, Found, Records};
use super::{Finding, Verdict};
use crate::config::{Pick, Quantity};
use crate::report::format::number;

/// Published limits: lower, and upper where there is one.
pub type Limits = (f64, Option<f64>);

fn closed((least, most): Limits) -> (f64, f64) {
    (least, most.unwrap_or(f64::INFINITY))
}

fn wanted((least, most): Limits) -> String {
    match most {
        Some(most) => format!("wanted {} to {}", number(least), number(most)),
        None => format!("wanted at least {}", number(least)),
    }
}

/// Tests that a number lies between limits.
pub fn range(records: &Records<'_>, of: &Quantity, limits: Limits) -> Result<Finding, String> {
    let (value, cells) = records.quantity(of)?;
    let value = value.interval;
    let text = format!("{} = {value}; {}", words(records, of), wanted(limits));
    let verdict = Verdict::within(value.low, value.high, closed(limits));
    Ok(Finding::new(verdict, text, &cells))
}

/// Tests that a ratio of two numbers lies between limits.
pub fn ratio(
    records: &Records<'_>,
    of: &Quantity,
    to: &Quantity,
    limits: Limits,
) -> Result<Finding, String> {
    let ((a, mut cells), (b, more)) = (records.quantity(of)?, records.quantity(to)?);
    cells.extend(more);
    let value = a.over(&b)?.interval;
    let text = format!(
        "{} ÷ {} = {value}; {}",
        words(records, of),
        words(records, to),
        wanted(limits)
    );
    let verdict = Verdict::within(value.low, value.high, closed(limits));
    Ok(Finding::new(verdict, text, &cells))
}

fn words(records: &Records<'_>, quantity: &Quantity) -> String {
    let own = format!("{} of {}", quantity.metric, records.words(&quantity.of));
    match &quantity.minus {
        Some(minus) => format!("({own} − {})", records.words(minus)),
        None => own,
    }
}

/// Tests that every number of a group is below every number of the next group.
pub fn order(
    records: &Records<'_>,
    metric: &str,
    ascending: &[Vec<Pick>],
) -> Result<Finding, String> {
    let (mut verdicts, mut decided, mut cells) = (Vec::new(), Vec::new(), Vec::new());
    for group in ascending {
        for pick in group {
            let found = records.find(pick)?;
            let value = select::metric(&found, metric)?.interval;
            decided.push(format!("{} {value}", records.words(pick)));
            cells.push(found);
        }
    }
    for pair in ascending.windows(2) {
        for (small, large) in pair[0]
            .iter()
            .flat_map(|a| pair[1].iter().map(move |b| (a, b)))
        {
            let (a, b) = (records.find(small)?, records.find(large)?);
            verdicts.push(below(&a, &b, metric)?);
        }
    }
    let verdict = Verdict::all(verdicts.iter().copied());
    Ok(Finding::new(
        verdict,
        format!("{metric}: {}", decided.join(", ")),
        &cells,
    ))
}

/// Tests that a's number is below b's: by their ratio, or by their difference where b's may be 0.
fn below(a: &Found<'_>, b: &Found<'_>, metric: &str) -> Result<Verdict, String> {
    let (a, b) = (select::metric(a, metric)?, select::metric(b, metric)?);
    Ok(match a.over(&b) {
        Ok(ratio) => sign(ratio.interval.minus(Interval::exact(1.0))),
        Err(_) => sign(a.minus(&b)?.interval),
    })
}

fn sign(difference: Interval) -> Verdict {
    if difference.high < 0.0 {
        Verdict::Holds
    } else if difference.low > 0.0 || difference.low == difference.high {
        Verdict::Fails
    } else {
        Verdict::Undecidable
    }
}
