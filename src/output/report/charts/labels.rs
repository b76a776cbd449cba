//! Places labels beside points so that they cover neither one another nor the points.

use super::canvas::Px;

/// Left, top, right, bottom in px.
type Box4 = [i32; 4];

/// Occupied rectangles of a plot, for placing labels.
pub struct Placer {
    bounds: Box4,
    taken: Vec<Box4>,
    lines: Vec<Box4>,
}

/// Position of a label.
pub struct Placed {
    /// Left end of the text, centred in height.
    pub text: Px,
    /// Nearest point of the label: where a leader line ends.
    pub near: Px,
    /// True when the label is so far from its point that it needs the line.
    pub leader: bool,
}

const HALF_HEIGHT: i32 = 8;

impl Placer {
    /// An empty plot.
    pub fn new(bounds: Box4) -> Self {
        Self {
            bounds,
            taken: Vec::new(),
            lines: Vec::new(),
        }
    }

    /// Keeps the square of this half-width around a point free of labels.
    pub fn keep_free(&mut self, (x, y): Px, radius: i32) {
        self.taken
            .push([x - radius, y - radius, x + radius, y + radius]);
    }

    /// Keeps labels off a line of horizontal and vertical segments, as long as there is room elsewhere.
    pub fn avoid_line(&mut self, points: &[Px]) {
        for pair in points.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            self.lines.push([
                a.0.min(b.0) - 1,
                a.1.min(b.1) - 1,
                a.0.max(b.0) + 1,
                a.1.max(b.1) + 1,
            ]);
        }
    }

    /// The nearest free place for a label `width` wide around `point`, if there is one.
    pub fn place(&mut self, point: Px, width: i32) -> Option<Placed> {
        let place = self
            .search(point, width, true)
            .or_else(|| self.search(point, width, false));
        place.map(|(area, placed)| {
            self.taken.push(area);
            placed
        })
    }

    fn search(&self, (x, y): Px, width: i32, off_lines: bool) -> Option<(Box4, Placed)> {
        const ANGLES: [f64; 12] = [
            -20.0, 20.0, -50.0, 50.0, -90.0, 90.0, -130.0, 130.0, 160.0, -160.0, 0.0, 180.0,
        ];
        for distance in [13, 19, 27, 37, 49, 63, 79, 97, 117] {
            for angle in ANGLES {
                let (sin, cos) = f64::to_radians(angle).sin_cos();
                let near = (
                    x + (cos * f64::from(distance)) as i32,
                    y + (sin * f64::from(distance)) as i32,
                );
                let left = match cos {
                    c if c > 0.2 => near.0,
                    c if c < -0.2 => near.0 - width,
                    _ => near.0 - width / 2,
                };
                let lifted = if sin.abs() > 0.9 {
                    near.1 + sin.signum() as i32 * 4
                } else {
                    near.1
                };
                let area = [
                    left - 2,
                    lifted - HALF_HEIGHT,
                    left + width + 2,
                    lifted + HALF_HEIGHT,
                ];
                if self.free(area, off_lines) {
                    return Some((
                        area,
                        Placed {
                            text: (left, lifted),
                            near,
                            leader: distance > 19,
                        },
                    ));
                }
            }
        }
        None
    }

    fn free(&self, a: Box4, off_lines: bool) -> bool {
        let [left, top, right, bottom] = self.bounds;
        let inside = a[0] > left + 2 && a[1] > top + 2 && a[2] < right - 2 && a[3] < bottom - 2;
        let clear = |b: &Box4| a[2] < b[0] || b[2] < a[0] || a[3] < b[1] || b[3] < a[1];
        inside && self.taken.iter().all(clear) && (!off_lines || self.lines.iter().all(clear))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_do_not_overlap_and_stay_inside() {
        let mut placer = Placer::new([0, 0, 300, 200]);
        let points: Vec<Px> = (0..8).map(|i| (100 + 6 * i, 100 - 5 * i)).collect();
        points.iter().for_each(|p| placer.keep_free(*p, 6));
        let placed = points
            .iter()
            .filter(|p| placer.place(**p, 60).is_some())
            .count();
        assert!(placed >= 6, "only {placed} of 8 labels found a place");
        let labels = &placer.taken[points.len()..];
        for (i, a) in labels.iter().enumerate() {
            assert!(a[0] > 0 && a[2] < 300 && a[1] > 0 && a[3] < 200);
            assert!(
                labels[i + 1..]
                    .iter()
                    .all(|b| a[2] < b[0] || b[2] < a[0] || a[3] < b[1] || b[3] < a[1])
            );
        }
    }
}
