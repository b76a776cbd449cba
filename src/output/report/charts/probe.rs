//! Chart of transmittance T(d) of every method along one light column.

use super::super::format::number;
use super::super::style::Style;
use super::axis::AxisSpec;
use super::chart::{Chart, Data, GREY, Look, Plane, Point, PointSeries, SOLID};
use crate::probe::{MethodCurve, Probe};

/// Number of depths between two markers of a curve.
const MARKED: usize = 64;
/// Share of the plot's height that the largest extinction takes.
const PROFILE: f64 = 0.25;
/// T at the upper edge.
const UPPER: f64 = 1.05;

/// The chart; `of` names scene and column, `seen_m` is the depth of the pixel's point, m, if a pixel was asked for.
pub fn chart(probe: &Probe, of: &str, seen_m: Option<f64>) -> Chart {
    let tau = -probe.truth.last().copied().unwrap_or(1.0).ln();
    let mut series = vec![PointSeries {
        label: format!("truth, τ = {}", number(tau)),
        style: Style::of("truth"),
        look: Look::Bare(SOLID, 3),
        points: points(probe, &probe.truth),
    }];
    series.extend((0..probe.curves.len()).map(|i| curve(probe, i)));
    series.extend(probe.curves.iter().flat_map(|curve| marks(probe, curve)));
    series.push(profile(probe));
    let place = |depth_m: f64| {
        let words = format!("the pixel's point, {} m", number(depth_m));
        (depth_m, words)
    };
    let end_m = probe.depths_m.last().copied().unwrap_or(1.0);
    let plane = Plane {
        x: AxisSpec::up_to("depth inside the layer from its sun side, d (m)", end_m),
        y: AxisSpec::up_to("transmittance T(d)", UPPER),
        series,
        levels: Vec::new(),
        places: seen_m.map(place).into_iter().collect(),
    };
    Chart {
        title: "Light transmittance along one column".to_owned(),
        of: of.to_owned(),
        data: Data::Plane(plane),
        source: "Computed by the f64 oracle".to_owned(),
        note: "Parameters not named above are at their defaults; maps have their own texels, steps and storage."
            .to_owned(),
    }
}

fn points(probe: &Probe, values: &[f64]) -> Vec<Point> {
    let pairs = probe.depths_m.iter().zip(values);
    pairs.map(|(depth, t)| Point::at(*depth, *t)).collect()
}

/// A method's curve, its markers offset so that those of coinciding curves do not overlap.
fn curve(probe: &Probe, i: usize) -> PointSeries {
    let curve = &probe.curves[i];
    PointSeries {
        label: curve.method.to_owned(),
        style: Style::of(curve.method),
        look: Look::Sparse(MARKED * (i + 1) / (probe.curves.len() + 1), MARKED),
        points: points(probe, &curve.transmittance),
    }
}

/// Strip over depths where T rises or τ̂ exceeds the column's τ, and the point from which the largest optical depth is reached.
fn marks(probe: &Probe, curve: &MethodCurve) -> Vec<PointSeries> {
    let style = Style::of(curve.method);
    let pairs = probe.depths_m.windows(2).enumerate();
    let outside = pairs.filter(|(i, _)| curve.outside[i + 1]);
    let outside = outside.map(|(_, pair)| over([pair[0], pair[1]], 1.0));
    let clamped = curve.clamped_from.map(|from| Point {
        label: "τ_max".to_owned(),
        ..Point::at(probe.depths_m[from], curve.transmittance[from])
    });
    vec![
        PointSeries {
            label: format!("{}: T rises, or τ̂ exceeds the whole τ", curve.method),
            style,
            look: Look::Strip,
            points: outside.collect(),
        },
        PointSeries {
            label: format!("{}: largest optical depth reached", curve.method),
            style,
            look: Look::Hollow,
            points: clamped.into_iter().collect(),
        },
    ]
}

fn over(range: [f64; 2], y: f64) -> Point {
    Point {
        x_range: Some(range),
        ..Point::at(range[0], y)
    }
}

/// Extinction as columns from the foot of the plot.
fn profile(probe: &Probe) -> PointSeries {
    let densest = probe.extinction_per_m.iter().copied().fold(0.0, f64::max);
    let scale = if densest > 0.0 {
        PROFILE / densest
    } else {
        0.0
    };
    let pairs = probe.depths_m.windows(2).zip(&probe.extinction_per_m);
    PointSeries {
        label: format!("extinction, up to {} m⁻¹", number(densest)),
        style: GREY,
        look: Look::Columns,
        points: pairs
            .map(|(pair, sigma)| over([pair[0], pair[1]], scale * sigma))
            .collect(),
    }
}
