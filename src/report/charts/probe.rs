//! T(d) of every method along one light column.

use super::super::format::number;
use super::super::style::Style;
use super::axis::Axis;
use super::canvas::{Canvas, GRID, Hang, INK, MUTED, Px, SMALL, ink_of, sheet};
use super::plot::{Key, MAP_DASH, Plot, foot, legend, title};
use crate::error::Result;
use crate::probe::{Curve, Probe};
use plotters::style::Color as _;

const HEIGHT: i32 = 560;
/// Depths between two markers of a curve.
const MARKED: usize = 64;
/// Share of the plot's height that the largest extinction takes.
const PROFILE: f64 = 0.25;
/// Height of the strip that shows where a series is outside, px.
const STRIP: i32 = 7;

/// The chart; `of` says which scene and column, `seen_m` is the depth of the pixel's point, if a pixel was asked for.
pub fn draw(probe: &Probe, of: &str, seen_m: Option<f64>) -> Result<String> {
    sheet(HEIGHT, |canvas| {
        let top = title(canvas, "Light transmittance along one column", of)?;
        let top = legend(canvas, top, &keys(probe, seen_m))?;
        let depth = "depth inside the layer from its sun side, d (m)";
        let x = Axis::from_zero(depth, probe.depths_m.iter().map(|d| d / 1.05));
        let y = Axis::from_zero("transmittance T(d)", [1.0].into_iter());
        let plot = Plot::new(top, HEIGHT, 74, x, y);
        plot.draw(canvas)?;
        profile(canvas, &plot, probe)?;
        if let Some(depth_m) = seen_m {
            let [_, top, _, bottom] = plot.bounds;
            let x = plot.px(depth_m);
            canvas.dashed(&[(x, top), (x, bottom)], MUTED, 1, MAP_DASH)?;
        }
        line(canvas, &plot, probe, "truth", &probe.truth, 3)?;
        for (i, curve) in probe.curves.iter().enumerate() {
            line(canvas, &plot, probe, curve.method, &curve.transmittance, 2)?;
            markers(canvas, &plot, probe, curve, i)?;
            marks(canvas, &plot, probe, curve)?;
        }
        let note = "Methods at their defaults, maps with their own texels, steps and storage.";
        foot(canvas, "Computed by the f64 oracle", HEIGHT, note)
    })
}

fn keys(probe: &Probe, seen_m: Option<f64>) -> Vec<(Key, String)> {
    let tau = -probe.truth.last().copied().unwrap_or(1.0).ln();
    let mut keys = vec![(
        Key::Line(Style::of("truth"), &[]),
        format!("truth, τ = {}", number(tau)),
    )];
    for curve in &probe.curves {
        let style = Style::of(curve.method);
        keys.push((Key::Line(style, &[]), curve.method.to_owned()));
    }
    for curve in &probe.curves {
        let style = Style::of(curve.method);
        if curve.outside.contains(&true) {
            let text = format!("{}: T rises, or τ̂ outside [0, τ]", curve.method);
            keys.push((Key::Swatch(ink_of(style), 0.5), text));
        }
        if curve.clamped_from.is_some() {
            let text = format!("{}: min(D_max, ·) sets in", curve.method);
            keys.push((Key::Hollow(style), text));
        }
    }
    let text = format!("extinction, up to {} m⁻¹", number(densest(probe)));
    keys.push((Key::Swatch(GRID, 1.0), text));
    if let Some(depth_m) = seen_m {
        let text = format!("the pixel's point, {} m", number(depth_m));
        keys.push((Key::MapFrontier, text));
    }
    keys
}

/// Extinction as columns from the foot of the plot.
fn profile(canvas: &Canvas<'_>, plot: &Plot, probe: &Probe) -> Result<()> {
    let most = densest(probe);
    if most <= 0.0 {
        return Ok(());
    }
    for (pair, sigma) in probe.depths_m.windows(2).zip(&probe.extinction_per_m) {
        let corners = [
            (plot.px(pair[0]), plot.py(PROFILE * sigma / most)),
            (plot.px(pair[1]), plot.py(0.0)),
        ];
        canvas.rect(corners, GRID)?;
    }
    Ok(())
}

fn densest(probe: &Probe) -> f64 {
    probe.extinction_per_m.iter().copied().fold(0.0, f64::max)
}

fn points(plot: &Plot, probe: &Probe, values: &[f64]) -> Vec<Px> {
    let pairs = probe.depths_m.iter().zip(values);
    pairs
        .filter(|(_, t)| t.is_finite())
        .map(|(d, t)| (plot.px(*d), plot.py(*t)))
        .collect()
}

fn line(
    canvas: &Canvas<'_>,
    plot: &Plot,
    probe: &Probe,
    method: &str,
    values: &[f64],
    width: u32,
) -> Result<()> {
    let color = ink_of(Style::of(method));
    canvas.line(&points(plot, probe, values), color, width)
}

/// Markers, shifted from curve to curve so that those of equal curves stay apart.
fn markers(canvas: &Canvas<'_>, plot: &Plot, probe: &Probe, curve: &Curve, i: usize) -> Result<()> {
    let shift = MARKED * (i + 1) / (probe.curves.len() + 1);
    let all = points(plot, probe, &curve.transmittance);
    let style = Style::of(curve.method);
    let some = all.iter().skip(shift).step_by(MARKED);
    some.copied()
        .try_for_each(|at| canvas.marker(at, 4.0, style, false))
}

/// The strip where a series is outside, under the top edge, and the point where a clamp sets in.
fn marks(canvas: &Canvas<'_>, plot: &Plot, probe: &Probe, curve: &Curve) -> Result<()> {
    let style = Style::of(curve.method);
    let top = plot.bounds[1];
    for (i, pair) in probe.depths_m.windows(2).enumerate() {
        if curve.outside[i + 1] {
            let corners = [(plot.px(pair[0]), top + 1), (plot.px(pair[1]), top + STRIP)];
            canvas.rect(corners, ink_of(style).mix(0.5))?;
        }
    }
    if let Some(from) = curve.clamped_from {
        let at = (
            plot.px(probe.depths_m[from]),
            plot.py(curve.transmittance[from]),
        );
        canvas.marker(at, 8.0, style, true)?;
        let label = (at.0, at.1 + 20);
        canvas.text(label, "D_max", SMALL, INK, Hang::Middle)?;
    }
    Ok(())
}
