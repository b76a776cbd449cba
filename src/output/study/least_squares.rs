//! Non-negative least squares with a few unknowns.

/// x ≥ 0 that minimises |A x − b|², where `rows` are the rows of A, all of equal length. Solves the unconstrained
/// problem for every subset of columns and takes the best feasible solution; exact, since one subset is the support
/// of the optimum. Solves 2ⁿ − 1 systems for n columns.
pub fn non_negative(rows: &[Vec<f64>], b: &[f64]) -> Vec<f64> {
    let columns = rows.first().map_or(0, Vec::len);
    let mut best = (b.iter().map(|v| v * v).sum::<f64>(), vec![0.0; columns]);
    for set in 1..1_u32 << columns {
        let used: Vec<usize> = (0..columns).filter(|i| set >> i & 1 == 1).collect();
        let Some(values) = solve(rows, b, &used) else {
            continue;
        };
        if values.iter().any(|v| *v < 0.0) {
            continue;
        }
        let mut x = vec![0.0; columns];
        used.iter().zip(values).for_each(|(i, v)| x[*i] = v);
        let left = residual(rows, b, &x);
        if left < best.0 {
            best = (left, x);
        }
    }
    best.1
}

fn residual(rows: &[Vec<f64>], b: &[f64], x: &[f64]) -> f64 {
    let product = |row: &Vec<f64>| row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
    let squares = rows
        .iter()
        .zip(b)
        .map(|(row, b)| (product(row) - b).powi(2));
    squares.sum()
}

/// Solves the normal equations of the columns `used` by Gaussian elimination, columns scaled to length 1; `None` when
/// they are linearly dependent.
fn solve(rows: &[Vec<f64>], b: &[f64], used: &[usize]) -> Option<Vec<f64>> {
    let n = used.len();
    let dot = |i: usize, j: usize| rows.iter().map(|r| r[i] * r[j]).sum::<f64>();
    let lengths: Vec<f64> = used.iter().map(|i| dot(*i, *i).sqrt()).collect();
    if lengths.iter().any(|l| *l <= 0.0 || !l.is_finite()) {
        return None;
    }
    let mut m: Vec<Vec<f64>> = (0..n)
        .map(|i| {
            let mut row: Vec<f64> = (0..n)
                .map(|j| dot(used[i], used[j]) / (lengths[i] * lengths[j]))
                .collect();
            let right = rows.iter().zip(b).map(|(r, b)| r[used[i]] * b);
            row.push(right.sum::<f64>() / lengths[i]);
            row
        })
        .collect();
    for i in 0..n {
        let pivot = (i..n).max_by(|a, c| m[*a][i].abs().total_cmp(&m[*c][i].abs()))?;
        m.swap(i, pivot);
        if m[i][i].abs() < 1e-9 {
            return None;
        }
        let upper = m[i].clone();
        for row in &mut m[i + 1..] {
            let factor = row[i] / upper[i];
            row.iter_mut()
                .zip(&upper)
                .for_each(|(a, u)| *a -= factor * u);
        }
    }
    let mut x = vec![0.0; n];
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|j| m[i][j] * x[j]).sum();
        x[i] = (m[i][n] - known) / m[i][i];
    }
    Some(x.iter().zip(&lengths).map(|(x, l)| x / l).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_systems_are_solved_and_negative_parts_are_left_out() {
        let rows = vec![vec![1.0, 2.0], vec![3.0, 1.0], vec![1.0, 1.0]];
        let x = non_negative(&rows, &[5.0, 5.0, 3.0]);
        assert!((x[0] - 1.0).abs() < 1e-9 && (x[1] - 2.0).abs() < 1e-9);
        let x = non_negative(&rows, &[-2.0, 4.0, 0.0]);
        assert!(x[1] == 0.0 && x[0] > 0.0, "{x:?}");
        assert_eq!(non_negative(&rows, &[-1.0, -1.0, -1.0]), [0.0, 0.0]);
        assert!(non_negative(&[], &[]).is_empty());
    }

    #[test]
    fn dependent_columns_and_columns_of_zeros_do_no_harm() {
        let rows = vec![vec![1.0, 2.0, 0.0], vec![2.0, 4.0, 0.0]];
        let x = non_negative(&rows, &[2.0, 4.0]);
        assert!((x[0] + 2.0 * x[1] - 2.0).abs() < 1e-9 && x[2] == 0.0);
    }
}
