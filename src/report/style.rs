//! One colour and one marker for a method, everywhere. Colours differ in lightness too (CIE L* from 0 to 79 in steps of
//! at least 8), so that charts survive a grey printer and colour-blind eyes; the marker's shape says it a third time.

/// Shape of a marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// Disc.
    Circle,
    /// Square.
    Square,
    /// Triangle, tip up.
    Up,
    /// Triangle, tip down.
    Down,
    /// Square on its corner.
    Diamond,
    /// Upright cross.
    Plus,
    /// Diagonal cross.
    Cross,
    /// Star with five points.
    Star,
    /// Hexagon.
    Hexagon,
}

/// How a method is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Style {
    /// Red, green, blue in sRGB.
    pub rgb: (u8, u8, u8),
    /// Shape of its points.
    pub marker: Marker,
}

const KNOWN: [(&str, Style); 7] = [
    (
        "truth",
        Style {
            rgb: (0x00, 0x00, 0x00),
            marker: Marker::Star,
        },
    ),
    (
        "srm",
        Style {
            rgb: (0x17, 0x3a, 0x8f),
            marker: Marker::Circle,
        },
    ),
    (
        "fom",
        Style {
            rgb: (0x8f, 0x2a, 0x7c),
            marker: Marker::Diamond,
        },
    ),
    (
        "bsm",
        Style {
            rgb: (0xc4, 0x50, 0x1b),
            marker: Marker::Up,
        },
    ),
    (
        "esm",
        Style {
            rgb: (0x1b, 0x9b, 0x80),
            marker: Marker::Square,
        },
    ),
    (
        "floor",
        Style {
            rgb: (0xdb, 0xa1, 0x1c),
            marker: Marker::Plus,
        },
    ),
    (
        "none",
        Style {
            rgb: (0x9c, 0xc8, 0xee),
            marker: Marker::Cross,
        },
    ),
];

/// Colours of methods that are not known by name, by growing lightness.
const OTHERS: [(u8, u8, u8); 8] = [
    (0x5c, 0x1a, 0x1a),
    (0x2c, 0x4a, 0x52),
    (0x3d, 0x5a, 0x2a),
    (0x6b, 0x5c, 0xa5),
    (0xb0, 0x44, 0x7a),
    (0x7f, 0x8f, 0x2b),
    (0xd9, 0x88, 0x80),
    (0x8f, 0xb3, 0xa3),
];

/// Shapes of methods that are not known by name; their number has no factor in common with the colours'.
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
    /// The style of a method id: fixed for the known ids, by a stable hash for others.
    pub fn of(method: &str) -> Self {
        if let Some((_, style)) = KNOWN.iter().find(|(id, _)| *id == method) {
            return *style;
        }
        let slot = fnv1a(method) as usize % (OTHERS.len() * SHAPES.len());
        Self {
            rgb: OTHERS[slot % OTHERS.len()],
            marker: SHAPES[slot % SHAPES.len()],
        }
    }

    /// `#rrggbb`.
    pub fn hex(&self) -> String {
        let (r, g, b) = self.rgb;
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}

/// 64-bit FNV-1a: small, and the same on every machine and in every version.
fn fnv1a(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |h, b| {
        (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)
    })
}

impl Marker {
    /// Corners around (0, 0) for a marker about `r` in radius; `None` for the disc.
    pub fn corners(self, r: f64) -> Option<Vec<(f64, f64)>> {
        let ring = |n: usize, start: f64, radius: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
            (0..n)
                .map(|i| {
                    let angle = (start + 360.0 * i as f64 / n as f64).to_radians();
                    (radius(i) * angle.cos(), radius(i) * angle.sin())
                })
                .collect()
        };
        Some(match self {
            Self::Circle => return None,
            Self::Square => ring(4, 45.0, &|_| 1.25 * r),
            Self::Diamond => ring(4, 0.0, &|_| 1.4 * r),
            Self::Up => ring(3, -90.0, &|_| 1.4 * r),
            Self::Down => ring(3, 90.0, &|_| 1.4 * r),
            Self::Hexagon => ring(6, 0.0, &|_| 1.15 * r),
            Self::Star => ring(10, -90.0, &|i| if i % 2 == 0 { 1.5 * r } else { 0.65 * r }),
            Self::Plus => cross(r, 0.0),
            Self::Cross => cross(r, 45.0),
        })
    }
}

/// A cross with arms 0.9 r wide, turned by `degrees`.
fn cross(r: f64, degrees: f64) -> Vec<(f64, f64)> {
    let (a, b) = (0.45 * r, 1.35 * r);
    let (sin, cos) = degrees.to_radians().sin_cos();
    [
        (-a, -b),
        (a, -b),
        (a, -a),
        (b, -a),
        (b, a),
        (a, a),
        (a, b),
        (-a, b),
        (-a, a),
        (-b, a),
        (-b, -a),
        (-a, -a),
    ]
    .iter()
    .map(|(x, y)| (x * cos - y * sin, x * sin + y * cos))
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

    #[test]
    fn known_methods_differ_in_lightness_and_shape() {
        for (i, (a, sa)) in KNOWN.iter().enumerate() {
            for (b, sb) in &KNOWN[i + 1..] {
                assert!(
                    (lightness(sa.rgb) - lightness(sb.rgb)).abs() >= 8.0,
                    "{a} and {b} print as the same grey"
                );
                assert_ne!(sa.marker, sb.marker, "{a} and {b} share a marker");
            }
        }
    }

    #[test]
    fn unknown_methods_keep_their_style() {
        assert_eq!(Style::of("my_method"), Style::of("my_method"));
        assert_ne!(Style::of("my_method"), Style::of("another"));
        assert!(
            KNOWN
                .iter()
                .all(|(_, s)| s.rgb != Style::of("my_method").rgb)
        );
    }
}
