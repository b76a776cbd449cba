//! Charts of a study: measured curves beside the published points, and the cost models' predicted ÷ measured times.

use super::Outcome;
use super::cost_model::Cost;
use super::interval::Interval;
use super::select::{self, Found, Records};
use crate::config::{ChartSpec, CostChart, Pick, Prices, Published, Study};
use crate::error::Result;
use crate::report::charts::axis::{AxisSpec, Scale};
use crate::report::charts::chart::{Chart, DASHED, Data, Look, Plane, Point, PointSeries, SOLID};
use crate::report::format::ms;
use crate::report::style::Style;

/// Prefix of the charts' file names.
pub const FIGURE: &str = "figure-";
/// Prefix of the file names of the cost models' charts.
pub const COST: &str = "cost-";

/// A chart of the page.
pub struct Figure {
    /// True for charts of the cost models.
    pub of_costs: bool,
    /// File name inside `charts/`.
    pub file: String,
    /// Published figure, or empty.
    pub figure: String,
    /// Title of the chart.
    pub title: String,
    /// Experiment that the cells are from; empty for all.
    pub experiment: String,
    /// Curves that could not be drawn, and why.
    pub missing: Vec<String>,
    /// SVG text; empty where nothing could be drawn.
    pub svg: String,
}

/// Every chart of the study, then those of the cost models.
pub fn all(study: &Study, records: &Records<'_>, outcome: &Outcome) -> Result<Vec<Figure>> {
    let mut figures = Vec::new();
    for spec in &study.charts {
        figures.push(chart(spec, records, outcome)?);
    }
    for spec in &study.cost_model.charts {
        let chart = residuals(spec, outcome);
        figures.push(Figure {
            of_costs: true,
            file: format!("{COST}{}.svg", spec.id),
            figure: study.cost_model.figure.clone(),
            title: spec.title.clone(),
            experiment: String::new(),
            missing: Vec::new(),
            svg: svg(chart.as_ref())?,
        });
    }
    Ok(figures)
}

/// SVG text of a chart; empty where there is nothing to draw.
fn svg(chart: Option<&Chart>) -> Result<String> {
    let svg = chart.map(Chart::svg).transpose()?;
    Ok(svg.flatten().unwrap_or_default())
}

fn chart(spec: &ChartSpec, records: &Records<'_>, outcome: &Outcome) -> Result<Figure> {
    let (mut series, mut missing) = (Vec::new(), Vec::new());
    for (metric, dash) in [(Some(&spec.metric), SOLID), (spec.also.as_ref(), DASHED)] {
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
                Ok(points) => series.push(PointSeries {
                    label,
                    style: Style::of(records.method(name)),
                    look: Look::Line(dash),
                    points,
                }),
                Err(reason) => missing.push(format!("{label}: {reason}")),
            }
        }
    }
    series.extend(spec.published.iter().map(|p| published(records, p)));
    let [x, y] = axes(spec);
    let chart = Chart {
        title: format!("{} ({})", spec.title, spec.figure),
        of: unit_of(spec, records),
        data: Data::Plane(Plane {
            x,
            y,
            series,
            levels: spec.relative_to.iter().map(|_| 1.0).collect(),
            places: Vec::new(),
        }),
        source: format!("Measured on {}", outcome.adapter),
        note: spec.note.clone(),
    };
    Ok(Figure {
        of_costs: false,
        file: format!("{FIGURE}{}.svg", spec.id),
        figure: spec.figure.clone(),
        title: spec.title.clone(),
        experiment: spec.experiment.clone(),
        missing,
        svg: svg(Some(&chart))?,
    })
}

/// Points of the source in the chart's units.
fn published(records: &Records<'_>, published: &Published) -> PointSeries {
    let place = |(x, y): &(f64, f64)| Point::at(x * published.x_scale, y / published.unit);
    PointSeries {
        label: format!("{} published", records.label(&published.series)),
        style: Style::of(records.method(&published.series)),
        look: Look::Published,
        points: published.points.iter().map(place).collect(),
    }
}

fn axes(spec: &ChartSpec) -> [AxisSpec; 2] {
    let x = match spec.log_x {
        true => Scale::LogAtValues,
        false => Scale::Linear,
    };
    let y = match spec.log_y {
        true if spec.metric.ends_with("_bytes") => Scale::Bytes,
        true => Scale::Log,
        false => Scale::Linear,
    };
    [
        AxisSpec::new(&spec.along_title, x),
        AxisSpec::new(&spec.metric_title, y),
    ]
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

/// Text on the unit of a relative chart: the series whose total is 1, with its time where the whole chart has one view.
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
            y_range: (value.high > value.low).then_some([value.low, value.high]),
            ..Point::at(*x, value.value)
        })
    });
    cells.collect()
}

/// Ratio of a number of a cell to the total time of `series` in the same view.
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

/// Chart of predicted ÷ measured time of every cell over its measured time; `None` without a model.
fn residuals(spec: &CostChart, outcome: &Outcome) -> Option<Chart> {
    let model = outcome.cost_model.as_ref()?;
    let mut methods: Vec<&str> = model.cells.iter().map(|c| c.method.as_str()).collect();
    methods.sort_unstable();
    methods.dedup();
    let predicted = |cell: &Cost| match spec.prices {
        Prices::One => Some(cell.one_price_ms),
        Prices::Own => cell.own_ms,
    };
    let series = |method: &&str| {
        let own = model.cells.iter().filter(|cell| cell.method == *method);
        let point = |cell: &Cost| Some(Point::at(cell.total_ms, predicted(cell)? / cell.total_ms));
        PointSeries {
            label: (*method).to_owned(),
            style: Style::of(method),
            look: Look::Points,
            points: own.filter_map(point).collect(),
        }
    };
    Some(Chart {
        title: spec.title.clone(),
        of: "Every cell of the study; lines at ±20 %".to_owned(),
        data: Data::Plane(Plane {
            x: AxisSpec::new("measured total, ms (log)", Scale::Log),
            y: AxisSpec::new("predicted ÷ measured (log)", Scale::Log),
            series: methods.iter().map(series).collect(),
            levels: vec![0.8, 1.0, 1.2],
            places: Vec::new(),
        }),
        source: format!("Measured on {}", outcome.adapter),
        note: "Below 1 the model promises too little time.".to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::fixture::FixtureReport;
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
        let mut made = FixtureReport::new(&["a", "b"]);
        made.cell("b", json!({}), &[10.0, 20.0, 40.0]);
        made.cell("a", json!({"steps": 4}), &[30.0, 60.0, 120.0]);
        let records = made.records();
        let pick = super::super::fixture::pick("a", json!({}));
        let of = |metric: &str| {
            let drawn = points(&spec(|_| ()), &records, &pick, metric).unwrap();
            assert_eq!((drawn.len(), drawn[0].x), (1, 4.0));
            let [low, high] = drawn[0].y_range.unwrap_or([drawn[0].y; 2]);
            [low, drawn[0].y, high]
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
        let mut made = FixtureReport::new(&["a", "b"]);
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
