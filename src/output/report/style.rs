//! Colour and marker of each method in all charts, as it declares them. Where two colours have a similar lightness (CIE
//! L* less than 8 apart), the markers differ, so that charts are readable in greyscale and by colour-blind readers.

pub use crate::occlusion::Marker;

use crate::occlusion;

/// Colour and marker of a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Style {
    /// Red, green, blue in sRGB.
    pub rgb: (u8, u8, u8),
    /// Shape of its points.
    pub marker: Marker,
}

/// A style from `0xrrggbb` and a shape.
const fn style(rgb: u32, marker: Marker) -> Style {
    let [_, r, g, b] = rgb.to_be_bytes();
    Style {
        rgb: (r, g, b),
        marker,
    }
}

/// Colours of methods that are not registered, by growing lightness.
const OTHERS: [u32; 8] = [
    0x5c1a1a, 0x2c4a52, 0x3d5a2a, 0x6b5ca5, 0xb0447a, 0x7f8f2b, 0xd98880, 0x8fb3a3,
];

/// Shapes of methods that are not registered; their number is coprime to that of the colours, so that all pairs occur.
const SHAPES: [Marker; 9] = [
    Marker::Hexagon,
    Marker::Down,
    Marker::Star,
    Marker::Square,
    Marker::Diamond,
    Marker::Circle,
    Marker::Up,
    Marker::Cross,
    Marker::Plus,
];

impl Style {
    /// Style of a method id: declared by a registered method, chosen by a stable hash for others, which a report of
    /// another program may contain.
    pub fn of(method: &str) -> Self {
        if let Ok(known) = occlusion::find(method) {
            let info = known.info();
            return style(info.colour, info.marker);
        }
        let slot = fnv1a(method) as usize % (OTHERS.len() * SHAPES.len());
        style(OTHERS[slot % OTHERS.len()], SHAPES[slot % SHAPES.len()])
    }

    /// CSS colour `#rrggbb`.
    pub fn hex(&self) -> String {
        let (r, g, b) = self.rgb;
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}

/// 64-bit FNV-1a hash, the same on every machine and in every version.
fn fnv1a(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |h, b| {
        (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)
    })
}

impl Style {
    /// Corners of the marker around (0, 0), with a radius of about `r`; `None` for the disc.
    pub fn corners(&self, r: f64) -> Option<Vec<(f64, f64)>> {
        Some(match self.marker {
            Marker::Circle => return None,
            Marker::Square => ring(4, 45.0, [1.25 * r; 2]),
            Marker::Diamond => ring(4, 0.0, [1.4 * r; 2]),
            Marker::Up => ring(3, -90.0, [1.4 * r; 2]),
            Marker::Down => ring(3, 90.0, [1.4 * r; 2]),
            Marker::Hexagon => ring(6, 0.0, [1.15 * r; 2]),
            Marker::Star => ring(10, -90.0, [1.5 * r, 0.65 * r]),
            Marker::Plus => cross(r, 0.0),
            Marker::Cross => cross(r, 45.0),
        })
    }
}

/// The point at `degrees` and `radius` around (0, 0).
fn polar(degrees: f64, radius: f64) -> (f64, f64) {
    let (sin, cos) = degrees.to_radians().sin_cos();
    (radius * cos, radius * sin)
}

/// `n` corners from `start` degrees on, the two radii in turn.
fn ring(n: usize, start: f64, radii: [f64; 2]) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| polar(start + 360.0 * i as f64 / n as f64, radii[i % 2]))
        .collect()
}

/// A cross with arms 0.9 r wide, turned by `degrees`: each quarter has the two corners of an arm's end and the notch
/// after it.
fn cross(r: f64, degrees: f64) -> Vec<(f64, f64)> {
    let (half, reach) = (0.45 * r, 1.35 * r);
    let (tip, end) = (half.atan2(reach).to_degrees(), half.hypot(reach));
    [0.0, 90.0, 180.0, 270.0]
        .iter()
        .map(|quarter| quarter + degrees)
        .flat_map(|at| {
            [
                polar(at - tip, end),
                polar(at + tip, end),
                polar(at + 45.0, half * std::f64::consts::SQRT_2),
            ]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE L* of an sRGB colour.
    fn lightness((r, g, b): (u8, u8, u8)) -> f64 {
        let linear = |c: u8| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 {
                c / 12.92
            } else {
                ((c + 0.055) / 1.055).powf(2.4)
            }
        };
        let y = 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
        if y > 0.008_856 {
            116.0 * y.cbrt() - 16.0
        } else {
            903.3 * y
        }
    }

    fn known() -> impl Iterator<Item = (&'static str, Style)> {
        let methods = occlusion::REGISTRY.iter().map(|m| m.info());
        methods.map(|info| (info.id, Style::of(info.id)))
    }

    /// Largest difference of two colours in a channel.
    fn apart(a: Style, b: Style) -> u8 {
        let channels = |s: Style| [s.rgb.0, s.rgb.1, s.rgb.2];
        let pairs = channels(a).into_iter().zip(channels(b));
        pairs.map(|(a, b)| a.abs_diff(b)).max().unwrap()
    }

    #[test]
    fn known_methods_differ_in_lightness_and_shape() {
        let all: Vec<_> = known().collect();
        for (i, (a, sa)) in all.iter().enumerate() {
            for (b, sb) in &all[i + 1..] {
                let steps = (lightness(sa.rgb) - lightness(sb.rgb)).abs();
                assert!(
                    steps >= 8.0 || sa.marker != sb.marker,
                    "{a} and {b} print as the same grey and share a marker"
                );
                assert!(apart(*sa, *sb) >= 32, "{a} and {b} have the same colour");
            }
        }
    }

    #[test]
    fn unknown_methods_keep_their_style() {
        assert_eq!(Style::of("my_method"), Style::of("my_method"));
        assert_ne!(Style::of("my_method"), Style::of("another"));
        assert!(known().all(|(_, s)| s.rgb != Style::of("my_method").rgb));
    }
}
