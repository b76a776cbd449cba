//! Each predicate on synthetic records that make it hold, fail and be undecidable.

use super::super::fixture::{FixtureReport, pick, quantity};
use super::*;
use crate::config::{Check, ClaimSpec, Quantity};
use Verdict::{Fails, Holds, Undecidable};
use serde_json::json;

fn steady(ms: f64) -> [f64; 5] {
    [0.99 * ms, ms, 1.01 * ms, ms, ms]
}

fn noisy(ms: f64) -> [f64; 5] {
    [0.6 * ms, ms, 1.5 * ms, ms, 1.1 * ms]
}

fn verdict(made: &FixtureReport, test: &Test) -> Verdict {
    let finding = find(&made.records(), test);
    assert!(!finding.numbers.is_empty());
    finding.verdict
}

fn ratio(between: (f64, Option<f64>)) -> Test {
    Test::Ratio {
        of: Box::new(quantity("total_ms", "a", 2)),
        to: Box::new(quantity("total_ms", "b", 1)),
        between,
    }
}

#[test]
fn a_ratio_holds_fails_or_stays_open_by_its_whole_range() {
    let mut made = FixtureReport::new(&["a", "b"]);
    made.cell("a", json!({"steps": 2}), &steady(20.0));
    made.cell("b", json!({"steps": 1}), &steady(10.0));
    assert_eq!(verdict(&made, &ratio((1.8, Some(2.2)))), Holds);
    assert_eq!(verdict(&made, &ratio((1.8, None))), Holds);
    assert_eq!(verdict(&made, &ratio((3.0, Some(4.0)))), Fails);
    assert_eq!(
        verdict(&made, &ratio((2.0, Some(4.0)))),
        Holds,
        "same rounds, same drift"
    );
    let mut made = FixtureReport::new(&["a", "b"]);
    made.cell("a", json!({"steps": 2}), &noisy(20.0));
    made.cell("b", json!({"steps": 1}), &steady(10.0));
    assert_eq!(verdict(&made, &ratio((1.8, Some(2.2)))), Undecidable);
}

#[test]
fn times_of_other_views_are_divided_at_their_worst() {
    let mut made = FixtureReport::new(&["a", "b"]);
    let drift = [10.0, 20.0, 30.0];
    made.cell("a", json!({"steps": 2}), &drift.map(|t| 2.0 * t));
    let other = made.cell("b", json!({"steps": 1}), &drift);
    assert_eq!(
        verdict(
            &FixtureReport {
                reports: vec![],
                ..FixtureReport::new(&["a"])
            },
            &ratio((0.0, None))
        ),
        Undecidable
    );
    if let Some(result) = &mut other.result {
        result.reference = "another".to_owned();
    }
    assert_eq!(verdict(&made, &ratio((1.9, Some(2.1)))), Undecidable);
    if let Some(result) = &mut made.reports[0].1.cells[0].result {
        result.reference = "another".to_owned();
    }
    assert_eq!(
        verdict(&made, &ratio((1.9, Some(2.1)))),
        Holds,
        "round by round"
    );
    timed_apart(&mut made);
    assert_eq!(
        verdict(&made, &ratio((1.9, Some(2.1)))),
        Undecidable,
        "one view, but not the same rounds"
    );
}

#[test]
fn failed_and_missing_cells_and_single_runs_are_not_decidable() {
    let mut made = FixtureReport::new(&["a", "b"]);
    made.cell("a", json!({"steps": 2}), &steady(20.0));
    let reason = |made: &FixtureReport| {
        let finding = find(&made.records(), &ratio((1.0, None)));
        assert_eq!(finding.verdict, Undecidable);
        finding.numbers
    };
    assert!(reason(&made).contains("0 cells fit b"), "{}", reason(&made));
    let cell = made.cell("b", json!({"steps": 1}), &steady(10.0));
    let numbers = cell.result.take();
    cell.failed = Some("adapter: too large".to_owned());
    assert!(reason(&made).contains("failed: adapter: too large"));
    made.reports[0].1.cells[1].result = numbers;
    made.reports[0].1.cells.pop();
    made.cell("b", json!({"steps": 1}), &[10.0]);
    assert!(
        reason(&made).contains("1 timed runs tell no spread"),
        "{}",
        reason(&made)
    );
}

#[test]
fn a_range_takes_differences_and_exact_numbers() {
    let mut made = FixtureReport::new(&["a", "b"]);
    made.cell("a", json!({"steps": 1}), &steady(10.0));
    made.cell("a", json!({"steps": 2}), &steady(30.0));
    let range = |between| Test::Range {
        of: Box::new(Quantity {
            minus: Some(pick("a", json!({"steps": 1}))),
            ..quantity("total_ms", "a", 2)
        }),
        between,
    };
    assert_eq!(verdict(&made, &range((19.0, Some(21.0)))), Holds);
    assert_eq!(verdict(&made, &range((25.0, None))), Fails);
    assert_eq!(verdict(&made, &range((20.0, None))), Undecidable);
    let error = |least| Test::Range {
        of: Box::new(quantity("rel_rmse", "a", 1)),
        between: (least, None),
    };
    assert_eq!(verdict(&made, &error(0.0)), Holds);
    assert_eq!(verdict(&made, &error(1e9)), Fails);
    let unknown = Test::Range {
        of: Box::new(quantity("beauty", "a", 1)),
        between: (0.0, None),
    };
    assert_eq!(verdict(&made, &unknown), Undecidable);
}

#[test]
fn an_order_compares_each_group_with_the_next() {
    let mut made = FixtureReport::new(&["a", "b", "c", "d"]);
    for (method, rounds) in [
        ("a", steady(10.0)),
        ("b", steady(12.0)),
        ("c", steady(20.0)),
        ("d", noisy(12.0)),
    ] {
        made.cell(method, json!({}), &rounds);
    }
    let order = |groups: &[&[&str]]| Test::Order {
        metric: "total_ms".to_owned(),
        ascending: groups
            .iter()
            .map(|group| group.iter().map(|s| pick(s, json!({}))).collect())
            .collect(),
    };
    assert_eq!(verdict(&made, &order(&[&["a"], &["b"], &["c"]])), Holds);
    assert_eq!(verdict(&made, &order(&[&["b", "a"], &["c"]])), Holds);
    assert_eq!(verdict(&made, &order(&[&["c"], &["a"]])), Fails);
    assert_eq!(verdict(&made, &order(&[&["d"], &["b"]])), Undecidable);
    let equal = Test::Order {
        metric: "rel_rmse".to_owned(),
        ascending: vec![vec![pick("a", json!({}))], vec![pick("b", json!({}))]],
    };
    assert_eq!(verdict(&made, &equal), Fails, "equal is not smaller");
}

/// Puts each cell into a timing block of its own, so that no two cells share rounds.
fn timed_apart(made: &mut FixtureReport) {
    for (i, cell) in made.reports[0].1.cells.iter_mut().enumerate() {
        if let Some(result) = &mut cell.result {
            result.block = i;
        }
    }
}

fn sweep(rounds: impl Fn(f64) -> [f64; 5]) -> FixtureReport {
    let mut made = FixtureReport::new(&["a", "b"]);
    for steps in [1.0, 10.0, 20.0, 50.0] {
        made.cell("a", json!({"steps": steps}), &rounds(steps));
        made.cell("b", json!({"steps": steps}), &steady(30.0));
    }
    made
}

#[test]
fn a_straight_line_is_told_from_a_curve_and_from_noise() {
    let straight = |intercept| Test::Straight {
        metric: "total_ms".to_owned(),
        of: pick("a", json!({})),
        along: "steps".to_owned(),
        bend: 0.1,
        intercept,
    };
    let line = sweep(|x| steady(20.0 + 2.0 * x));
    assert_eq!(verdict(&line, &straight(None)), Holds);
    assert_eq!(verdict(&line, &straight(Some(0.05))), Fails);
    assert_eq!(
        verdict(&sweep(|x| steady(2.0 * x)), &straight(Some(0.05))),
        Holds
    );
    assert_eq!(verdict(&sweep(|x| steady(x * x)), &straight(None)), Fails);
    assert_eq!(
        verdict(&sweep(|x| steady(100.0 - x)), &straight(None)),
        Fails,
        "it falls"
    );
    let mut shaken = sweep(|x| noisy(20.0 + 2.0 * x));
    assert_eq!(
        verdict(&shaken, &straight(None)),
        Holds,
        "all cells share the drift of their rounds"
    );
    timed_apart(&mut shaken);
    assert_eq!(verdict(&shaken, &straight(None)), Undecidable);
    let mut flat = sweep(|x| noisy(20.0 - 0.01 * x));
    timed_apart(&mut flat);
    assert_eq!(
        verdict(&flat, &straight(None)),
        Undecidable,
        "it may grow or fall"
    );
}

#[test]
fn a_crossover_is_an_interval_of_the_sweep() {
    let crossover = |between| Test::Crossover {
        metric: "total_ms".to_owned(),
        of: pick("a", json!({})),
        over: pick("b", json!({})),
        along: "steps".to_owned(),
        between,
    };
    // The time exceeds 30 ms between 10 and 20 steps.
    let crossing = sweep(|x| steady(2.0 * x));
    assert_eq!(verdict(&crossing, &crossover((9.0, 21.0))), Holds);
    assert_eq!(verdict(&crossing, &crossover((25.0, 60.0))), Fails);
    assert_eq!(
        verdict(&crossing, &crossover((14.0, 16.0))),
        Undecidable,
        "too coarse"
    );
    let never = sweep(|x| steady(0.1 * x));
    assert_eq!(verdict(&never, &crossover((5.0, 30.0))), Fails);
    assert_eq!(
        verdict(&never, &crossover((40.0, 60.0))),
        Undecidable,
        "the sweep ends"
    );
    assert_eq!(
        verdict(&sweep(|x| steady(100.0 / x)), &crossover((0.0, 60.0))),
        Fails
    );
    assert_eq!(
        verdict(&sweep(|_| noisy(30.0)), &crossover((0.0, 60.0))),
        Undecidable
    );
    let mut gap = sweep(|x| steady(2.0 * x));
    gap.reports[0].1.cells.pop();
    assert_eq!(verdict(&gap, &crossover((9.0, 21.0))), Undecidable);
}

#[test]
fn a_gain_of_error_is_a_share_of_it() {
    let mut made = sweep(steady);
    for (cell, error) in made.reports[0]
        .1
        .cells
        .iter_mut()
        .step_by(2)
        .zip([0.4, 0.2, 0.19, 0.19])
    {
        if let Some(result) = &mut cell.result {
            result.error.rel_rmse = error;
        }
    }
    let gain = |from, to| Test::Gain {
        metric: "rel_rmse".to_owned(),
        of: pick("a", json!({})),
        along: "steps".to_owned(),
        from,
        to,
        at_most: 0.1,
    };
    assert_eq!(verdict(&made, &gain(10.0, 50.0)), Holds);
    assert_eq!(verdict(&made, &gain(1.0, 10.0)), Fails);
    assert_eq!(verdict(&made, &gain(10.0, 40.0)), Undecidable);
}

#[test]
fn a_claim_takes_all_of_its_parts_and_says_which_decided() {
    let mut made = FixtureReport::new(&["a", "b"]);
    made.cell("a", json!({"steps": 2}), &steady(20.0));
    made.cell("b", json!({"steps": 1}), &steady(10.0));
    let unmeasured = || Test::Unmeasured {
        reason: "no number".to_owned(),
    };
    let claim = |tests: Vec<Test>| {
        let check = |test| Check {
            says: "a part".to_owned(),
            test,
        };
        let spec = ClaimSpec {
            id: "X1".to_owned(),
            place: "Figure 1".to_owned(),
            says: "It is so.".to_owned(),
            checks: tests.into_iter().map(check).collect(),
        };
        decide(&made.records(), &spec)
    };
    let (holds, fails) = (ratio((1.8, Some(2.2))), ratio((3.0, None)));
    assert_eq!(claim(vec![holds.clone(), holds.clone()]).verdict, Holds);
    let failed = claim(vec![holds.clone(), fails, unmeasured()]);
    assert_eq!(failed.verdict, Fails);
    assert!(
        failed.because.contains("1 holds and 1 is open"),
        "{}",
        failed.because
    );
    assert_eq!(claim(vec![holds, unmeasured()]).verdict, Undecidable);
    assert_eq!(claim(Vec::new()).verdict, Undecidable);
    assert_eq!(failed.parts[0].finding.cells.len(), 2);
}
