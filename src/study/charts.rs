//! The study's charts: measured curves beside the published points, and what the cost models miss.

use super::Outcome;
use super::cost_model::Cost;
use super::interval::Interval;
use super::select::{self, Found, Records};
use crate::config::{ChartSpec, Pick, Published, Study};
use crate::error::Result;
use crate::report::charts::curves::{Curve, Curves, Look, Point, Spread, draw};
use crate::report::format::ms;

/// A chart of the page.
pub struct Figure {
    /// File name inside `charts/`.
    pub file: String,
    /// Published figure, or empty.
    pub figure: String,
    /// What it shows.
    pub title: String,
    /// Experiment that its cells are from; empty for all.
    pub experiment: String,
    /// Curves that could not be drawn, and why.
    pub missing: Vec<String>,
    /// The picture; empty where nothing could be drawn.
    pub svg: String,
}

/// Every chart of the study, then those of the cost models.
pub fn all(study: &Study, records: &Records<'_>, outcome: &Outcome) -> Result<Vec<Figure>> {
    let mut figures = Vec::new();
    for spec in &study.charts {
        figures.push(chart(spec, records, outcome)?);
    }
    for (file, title, own) in [
        (
            "cost-thesis.svg",
            "One price a sample: predicted ÷ measured",
            false,
        ),
        (
            "cost-own.svg",
            "Prices of each method's own: predicted ÷ measured",
            true,
        ),
    ] {
        figures.push(Figure {
            file: file.to_owned(),
            figure: "eqs. 3.1–3.5".to_owned(),
            title: title.to_owned(),
            experiment: String::new(),
            missing: Vec::new(),
            svg: residuals(title, own, outcome)?.unwrap_or_default(),
        });
    }
    Ok(figures)
}

fn chart(spec: &ChartSpec, records: &Records<'_>, outcome: &Outcome) -> Result<Figure> {
    let (mut curves, mut missing) = (Vec::new(), Vec::new());
    for (metric, look) in [
        (Some(&spec.metric), Look::Solid),
        (spec.also.as_ref(), Look::Dashed),
    ] {
        let Some(metric) = metric else { continue };
        for name in &spec.series {
            let pick = Pick {
                experiment: spec.experiment.clone(),
                series: name.clone(),
                at: spec.at.clone(),
            };
            let label = match &spec.also {
                None => records.label(name).to_owned(),
                Some(_) => format!("{} {}", records.label(name), metric_words(metric)),
            };
            match points(spec, records, &pick, metric) {
                Ok(points) => curves.push(Curve {
                    label,
                    method: records.method(name).to_owned(),
                    look,
                    points,
                }),
                Err(reason) => missing.push(format!("{label}: {reason}")),
            }
        }
    }
    curves.extend(spec.published.iter().map(|p| published(records, p)));
    let chart = Curves {
        title: format!("{} ({})", spec.title, spec.figure),
        of: unit_of(spec, records),
        x: (spec.along_title.clone(), spec.log_x),
        y: (spec.metric_title.clone(), spread(spec)),
        curves,
        levels: spec.relative_to.iter().map(|_| 1.0).collect(),
        source: format!("Measured on {}", outcome.adapter),
        note: spec.note.clone(),
    };
    Ok(Figure {
        file: format!("figure-{}.svg", spec.id),
        figure: spec.figure.clone(),
        title: spec.title.clone(),
        experiment: spec.experiment.clone(),
        missing,
        svg: draw(&chart)?.unwrap_or_default(),
    })
}

/// Points of the source in the chart's units.
fn published(records: &Records<'_>, published: &Published) -> Curve {
    let place = |(x, y): &(f64, f64)| {
        let y = y / published.unit;
        Point {
            x: x * published.x_scale,
            y,
            low: y,
            high: y,
        }
    };
    Curve {
        label: format!("{} published", records.label(&published.series)),
        method: records.method(&published.series).to_owned(),
        look: Look::Published,
        points: published.points.iter().map(place).collect(),
    }
}

fn spread(spec: &ChartSpec) -> Spread {
    match spec.log_y {
        true if spec.metric.ends_with("_bytes") => Spread::Bytes,
        true => Spread::Log,
        false => Spread::Linear,
    }
}

fn metric_words(metric: &str) -> &str {
    match metric {
        "generate_ms" => "map pass",
        "total_ms" => "total",
        "payload_bytes" => "stored",
        "map_bytes" => "allocated",
        other => other,
    }
}

/// What 1 stands for, in ms where the whole chart has one view.
fn unit_of(spec: &ChartSpec, records: &Records<'_>) -> String {
    let Some(name) = &spec.relative_to else {
        return format!("Experiment `{}`", spec.experiment);
    };
    let pick = Pick {
        experiment: spec.experiment.clone(),
        series: name.clone(),
        at: spec.at.clone(),
    };
    let label = records.label(name);
    match records
        .find(&pick)
        .and_then(|f| select::metric(&f, "total_ms"))
    {
        Ok(unit) => format!(
            "1 = {label} in the same picture: {}",
            ms(Some(unit.interval.value))
        ),
        Err(_) => format!("1 = {label} in the same picture"),
    }
}

fn points(
    spec: &ChartSpec,
    records: &Records<'_>,
    pick: &Pick,
    metric: &str,
) -> Result<Vec<Point>, String> {
    let cells = records.along(pick, &spec.along)?;
    let cells = cells.iter().map(|(x, found)| {
        let value = match &spec.relative_to {
            None => select::metric(found, metric)?.interval,
            Some(name) => relative(records, found, name, metric)?,
        };
        Ok(Point {
            x: *x,
            y: value.value,
            low: value.low,
            high: value.high,
        })
    });
    cells.collect()
}

/// A time over the total time of another series in the same view.
pub(super) fn relative(
    records: &Records<'_>,
    found: &Found<'_>,
    series: &str,
    metric: &str,
) -> Result<Interval, String> {
    let mut units = records.series.get(series).into_iter().flat_map(|series| {
        found.report.cells.iter().filter(move |cell| {
            let same = |r: &crate::batch::record::Measured| r.reference == found.numbers.reference;
            cell.method == series.method
                && select::matches(cell, &series.at)
                && cell.result.as_ref().is_some_and(same)
        })
    });
    let missing = || {
        format!(
            "{} was not measured in the same picture",
            records.label(series)
        )
    };
    let cell = units.next().ok_or_else(missing)?;
    let unit = Found {
        cell,
        numbers: cell.result.as_ref().ok_or_else(missing)?,
        ..*found
    };
    let unit = select::metric(&unit, "total_ms")?;
    Ok(select::metric(found, metric)?.over(&unit)?.interval)
}

/// Predicted over measured time of every cell.
fn residuals(title: &str, own: bool, outcome: &Outcome) -> Result<Option<String>> {
    let Some(model) = &outcome.cost_model else {
        return Ok(None);
    };
    let mut methods: Vec<&str> = model.cells.iter().map(|c| c.method.as_str()).collect();
    methods.sort_unstable();
    methods.dedup();
    let curve = |method: &&str| {
        let predicted = |c: &Cost| if own { c.own_ms } else { Some(c.thesis_ms) };
        let mut points: Vec<Point> = model
            .cells
            .iter()
            .filter(|c| c.method == *method)
            .filter_map(|c| {
                let y = predicted(c)? / c.total_ms;
                let (low, high) = (y, y);
                let x = c.total_ms;
                Some(Point { x, y, low, high })
            })
            .collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        Curve {
            label: (*method).to_owned(),
            method: (*method).to_owned(),
            look: Look::Points,
            points,
        }
    };
    draw(&Curves {
        title: title.to_owned(),
        of: "Every cell of the study; lines at ±20 %".to_owned(),
        x: ("measured total, ms (log)".to_owned(), true),
        y: ("predicted ÷ measured (log)".to_owned(), Spread::Log),
        curves: methods.iter().map(curve).collect(),
        levels: vec![0.8, 1.0, 1.2],
        source: format!("Measured on {}", outcome.adapter),
        note: "Below 1 the model promises too little time.".to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::fixture::Made;
    use super::*;
    use serde_json::{Value, json};

    fn spec(edit: impl FnOnce(&mut Value)) -> ChartSpec {
        let mut value = json!({
            "id": "c", "figure": "Figure 1", "title": "T", "experiment": "e", "along": "steps", "along_title": "steps",
            "metric": "total_ms", "metric_title": "time", "relative_to": "b", "series": ["a"], "note": ""
        });
        edit(&mut value);
        serde_json::from_value(value).unwrap()
    }

    #[test]
    fn points_are_ratios_to_the_same_round_and_published_ones_to_their_own_unit() {
        let mut made = Made::new(&["a", "b"]);
        made.cell("b", json!({}), &[10.0, 20.0, 40.0]);
        made.cell("a", json!({"steps": 4}), &[30.0, 60.0, 120.0]);
        let records = made.records();
        let pick = super::super::fixture::pick("a", json!({}));
        let of = |metric: &str| {
            let drawn = points(&spec(|_| ()), &records, &pick, metric).unwrap();
            assert_eq!((drawn.len(), drawn[0].x), (1, 4.0));
            [drawn[0].low, drawn[0].y, drawn[0].high]
        };
        assert_eq!(of("total_ms"), [3.0; 3]);
        assert_eq!(of("generate_ms"), [1.5; 3], "over the total of the other");
        let spec = spec(|s| {
            let curve =
                json!({"series": "a", "points": [[256, 4.2]], "unit": 2.1, "x_scale": 0.125});
            s["published"] = json!([curve]);
        });
        let curve = published(&records, &spec.published[0]);
        assert_eq!((curve.points[0].x, curve.points[0].y), (32.0, 2.0));
    }

    #[test]
    fn a_series_without_its_unit_is_missing_and_says_why() {
        let mut made = Made::new(&["a", "b"]);
        made.cell("a", json!({"steps": 4}), &[30.0, 60.0, 120.0]);
        let records = made.records();
        let pick = super::super::fixture::pick("a", json!({}));
        let Err(reason) = points(&spec(|_| ()), &records, &pick, "total_ms") else {
            panic!("no unit, no ratio");
        };
        assert!(
            reason.contains("b was not measured in the same picture"),
            "{reason}"
        );
    }
}
