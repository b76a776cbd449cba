//! The Pareto frontier of cost against error.

/// Indices of the Pareto-optimal points (smaller is better in both coordinates), by growing first coordinate. Of equal
/// points the first is kept; points that are not finite are ignored.
pub fn frontier(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len())
        .filter(|&i| points[i].0.is_finite() && points[i].1.is_finite())
        .collect();
    order.sort_by(|&a, &b| {
        points[a]
            .0
            .total_cmp(&points[b].0)
            .then(points[a].1.total_cmp(&points[b].1))
            .then(a.cmp(&b))
    });
    let mut best = f64::INFINITY;
    order.retain(|&i| {
        let better = points[i].1 < best;
        best = best.min(points[i].1);
        better
    });
    order
}

#[cfg(test)]
mod tests {
    use super::frontier;

    #[test]
    fn keeps_what_nothing_beats() {
        let points = [
            (4.0, 1.0),
            (1.0, 4.0),
            (2.0, 2.0),
            (3.0, 3.0),
            (2.5, 2.0),
            (5.0, 0.5),
        ];
        assert_eq!(frontier(&points), [1, 2, 0, 5]);
    }

    #[test]
    fn equal_cost_keeps_the_smaller_error_and_equal_points_the_first() {
        assert_eq!(frontier(&[(1.0, 3.0), (1.0, 2.0), (1.0, 2.0)]), [1]);
    }

    #[test]
    fn non_finite_points_take_no_part() {
        assert_eq!(
            frontier(&[(f64::NAN, 0.0), (1.0, f64::INFINITY), (2.0, 1.0)]),
            [2]
        );
        assert!(frontier(&[]).is_empty());
    }
}
