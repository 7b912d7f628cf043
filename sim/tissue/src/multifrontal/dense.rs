//! Dense kernels of a front, four columns at a time so that a vector is read and written once for
//! four.

/// Columns eliminated together.
const BLOCK: usize = 4;

/// Columns with which a later column is updated while it is in the nearest cache.
const PANEL: usize = 12 * BLOCK;

/// Eliminates the first `own` columns of a symmetric matrix of `size` rows, column-major, lower
/// triangle: its columns become those of the Cholesky factor, and the rest becomes the Schur
/// complement. Returns the first column whose pivot is not above `lost` times its diagonal, with
/// the pivot.
pub(super) fn eliminate(matrix: &mut [f64], size: usize, own: usize, lost: f64) -> Option<(usize, f64)> {
    let least: Vec<f64> = (0..own).map(|column| lost * matrix[column * size + column]).collect();
    for first in (0..own).step_by(PANEL) {
        let end = own.min(first + PANEL);
        let (panel, rest) = matrix[first * size..].split_at_mut((end - first) * size);
        for at in (first..end).step_by(BLOCK) {
            let after = end.min(at + BLOCK);
            let (block, later) = panel[(at - first) * size..].split_at_mut((after - at) * size);
            if let Some(pivot) = eliminate_block(block, size, at, &least) {
                return Some(pivot);
            }
            bring_up_to_date(later, size, after, block);
        }
        bring_up_to_date(rest, size, end, panel);
    }
    None
}

/// Eliminates a block of columns, starting with `first`, within themselves.
fn eliminate_block(block: &mut [f64], size: usize, first: usize, least: &[f64]) -> Option<(usize, f64)> {
    for at in 0..block.len() / size {
        let column = first + at;
        let (before, this) = block.split_at_mut(at * size);
        let this = &mut this[column..size];
        for earlier in before.chunks_exact(size) {
            subtract_one(this, &earlier[column..], earlier[column]);
        }
        let pivot = this[0];
        if !(pivot > least[column] && pivot.is_finite()) {
            return Some((column, pivot));
        }
        let scale = 1.0 / pivot.sqrt();
        this.iter_mut().for_each(|value| *value *= scale);
    }
    None
}

/// Updates columns, starting with `first`, with a finished panel. Two at a time, for which the
/// panel is read once; entries above the second one's diagonal do not count.
fn bring_up_to_date(columns: &mut [f64], size: usize, first: usize, panel: &[f64]) {
    for (at, pair) in columns.chunks_mut(2 * size).enumerate() {
        let row = first + 2 * at;
        let (one, two) = pair.split_at_mut(size);
        for block in panel.chunks(BLOCK * size) {
            if two.is_empty() || block.len() < BLOCK * size {
                for (at, target) in [&mut *one, &mut *two].into_iter().filter(|target| !target.is_empty()).enumerate() {
                    block.chunks_exact(size).for_each(|c| subtract_one(&mut target[row..], &c[row..], c[row + at]));
                }
            } else {
                let four = std::array::from_fn(|c| &block[c * size + row..(c + 1) * size]);
                subtract_four_from_two([&mut one[row..], &mut two[row..]], four);
            }
        }
    }
}

fn subtract_one(target: &mut [f64], column: &[f64], factor: f64) {
    for (value, c) in target.iter_mut().zip(column) {
        *value -= factor * c;
    }
}

fn subtract_four(target: &mut [f64], [a, b, c, d]: [&[f64]; BLOCK], factors: [f64; BLOCK]) {
    let n = target.len();
    let (a, b, c, d) = (&a[..n], &b[..n], &c[..n], &d[..n]);
    for i in 0..n {
        target[i] -= (factors[0] * a[i] + factors[1] * b[i]) + (factors[2] * c[i] + factors[3] * d[i]);
    }
}

/// Subtracts four columns, given from a row down, times their values in that row and in the next.
fn subtract_four_from_two([one, two]: [&mut [f64]; 2], [a, b, c, d]: [&[f64]; BLOCK]) {
    let n = one.len();
    let (two, a, b, c, d) = (&mut two[..n], &a[..n], &b[..n], &c[..n], &d[..n]);
    let [f, g] = [0, 1].map(|at| [a[at], b[at], c[at], d[at]]);
    for i in 0..n {
        one[i] -= (f[0] * a[i] + f[1] * b[i]) + (f[2] * c[i] + f[3] * d[i]);
        two[i] -= (g[0] * a[i] + g[1] * b[i]) + (g[2] * c[i] + g[3] * d[i]);
    }
}

/// Forward substitution on the columns of a front: the first `own` of `t` become the solution, the
/// rest is reduced.
pub(super) fn forward(mut columns: &[f64], own: usize, mut t: &mut [f64]) {
    let mut left = own;
    while left >= BLOCK {
        let (four, rest) = take_four(columns, t.len());
        let mut x = [0.0; BLOCK];
        for j in 0..BLOCK {
            x[j] = t[j] * four[j][0];
            for i in j + 1..BLOCK {
                t[i] -= four[j][i - j] * x[j];
            }
        }
        let (solved, below) = t.split_at_mut(BLOCK);
        solved.copy_from_slice(&x);
        subtract_four(below, std::array::from_fn(|j| &four[j][BLOCK - j..]), x);
        (columns, t, left) = (rest, below, left - BLOCK);
    }
    for _ in 0..left {
        let (column, rest) = columns.split_at(t.len());
        let (solved, below) = t.split_at_mut(1);
        solved[0] *= column[0];
        subtract_one(below, &column[1..], solved[0]);
        (columns, t) = (rest, below);
    }
}

/// The next four columns, of which the first has `size` numbers and each other one less, and the
/// rest.
fn take_four(columns: &[f64], size: usize) -> ([&[f64]; BLOCK], &[f64]) {
    let mut rest = columns;
    let four = std::array::from_fn(|j| {
        let (column, after) = rest.split_at(size - j);
        rest = after;
        column
    });
    (four, rest)
}

/// Backward substitution: the first `own` of `t` become the solution, the rest is known.
pub(super) fn backward(mut columns: &[f64], own: usize, t: &mut [f64]) {
    let single = own % BLOCK;
    for j in (own - single..own).rev() {
        let (rest, column) = columns.split_at(columns.len() - (t.len() - j));
        columns = rest;
        t[j] = (t[j] - dot(&column[1..], &t[j + 1..])) * column[0];
    }
    for first in (0..own - single).step_by(BLOCK).rev() {
        let size = t.len() - first;
        let (rest, four) = columns.split_at(columns.len() - (BLOCK * size - BLOCK * (BLOCK - 1) / 2));
        columns = rest;
        let (four, _) = take_four(four, size);
        let below = dot_four(std::array::from_fn(|j| &four[j][BLOCK - j..]), &t[first + BLOCK..]);
        for j in (0..BLOCK).rev() {
            let mut sum = below[j];
            for i in j + 1..BLOCK {
                sum += four[j][i - j] * t[first + i];
            }
            t[first + j] = (t[first + j] - sum) * four[j][0];
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Four dot products with the same vector, each in two interleaved sums, for two lanes.
fn dot_four(columns: [&[f64]; BLOCK], t: &[f64]) -> [f64; BLOCK] {
    let pairs = t.len() / 2 * 2;
    let [a, b, c, d] = columns.map(|column| &column[..t.len()]);
    let mut sums = [[0.0; 2]; BLOCK];
    for i in (0..pairs).step_by(2) {
        for lane in 0..2 {
            sums[0][lane] += a[i + lane] * t[i + lane];
            sums[1][lane] += b[i + lane] * t[i + lane];
            sums[2][lane] += c[i + lane] * t[i + lane];
            sums[3][lane] += d[i + lane] * t[i + lane];
        }
    }
    let mut sum = sums.map(|lanes| lanes[0] + lanes[1]);
    if let Some(&last) = t.get(pairs) {
        for (sum, column) in sum.iter_mut().zip([a, b, c, d]) {
            *sum += column[pairs] * last;
        }
    }
    sum
}
