//! Sums over an element, one direction at a time: N⁴ products instead of the N⁶ of the direct sum
//! (Orszag 1980).

use super::basis::Table;

/// Three numbers at each of N³ positions, the first direction fastest.
pub(super) type Cube<const N: usize> = [[[[f64; 3]; N]; N]; N];

/// The same for each derivative by ξ, η and ζ.
pub(super) type Gradient<const N: usize> = [Cube<N>; 3];

pub(super) const fn zeros<const N: usize>() -> Cube<N> {
    [[[[0.0; 3]; N]; N]; N]
}

fn add(target: &mut [f64], factor: f64, source: &[f64]) {
    for (t, s) in target.iter_mut().zip(source) {
        *t += factor * s;
    }
}

fn along_first<const N: usize>(matrix: &[[f64; N]; N], from: &Cube<N>, to: &mut Cube<N>) {
    for (to, from) in to.as_flattened_mut().iter_mut().zip(from.as_flattened()) {
        for (to, row) in to.iter_mut().zip(matrix) {
            for (factor, from) in row.iter().zip(from) {
                add(to, *factor, from);
            }
        }
    }
}

fn along_second<const N: usize>(matrix: &[[f64; N]; N], from: &Cube<N>, to: &mut Cube<N>) {
    for (to, from) in to.iter_mut().zip(from) {
        for (to, row) in to.iter_mut().zip(matrix) {
            for (factor, from) in row.iter().zip(from) {
                add(to.as_flattened_mut(), *factor, from.as_flattened());
            }
        }
    }
}

fn along_third<const N: usize>(matrix: &[[f64; N]; N], from: &Cube<N>, to: &mut Cube<N>) {
    for (to, row) in to.iter_mut().zip(matrix) {
        for (factor, from) in row.iter().zip(from) {
            add(to.as_flattened_mut().as_flattened_mut(), *factor, from.as_flattened().as_flattened());
        }
    }
}

/// Derivatives at the quadrature points of a field given by its values at the nodes.
pub(super) fn to_points<const N: usize>(table: &Table<N>, nodes: &Cube<N>) -> Gradient<N> {
    let (mut value, mut slope) = (zeros(), zeros());
    along_first(&table.value, nodes, &mut value);
    along_first(&table.slope, nodes, &mut slope);
    let (mut value_value, mut slope_value, mut value_slope) = (zeros(), zeros(), zeros());
    along_second(&table.value, &value, &mut value_value);
    along_second(&table.slope, &value, &mut value_slope);
    along_second(&table.value, &slope, &mut slope_value);
    let mut gradient = [zeros(), zeros(), zeros()];
    along_third(&table.value, &slope_value, &mut gradient[0]);
    along_third(&table.value, &value_slope, &mut gradient[1]);
    along_third(&table.slope, &value_value, &mut gradient[2]);
    gradient
}

/// The transpose of [`to_points`].
pub(super) fn to_nodes<const N: usize>(table: &Table<N>, gradient: &Gradient<N>) -> Cube<N> {
    let (mut value_value, mut slope_value, mut value_slope) = (zeros(), zeros(), zeros());
    along_third(&table.value_to_nodes, &gradient[0], &mut slope_value);
    along_third(&table.value_to_nodes, &gradient[1], &mut value_slope);
    along_third(&table.slope_to_nodes, &gradient[2], &mut value_value);
    let (mut value, mut slope) = (zeros(), zeros());
    along_second(&table.value_to_nodes, &value_value, &mut value);
    along_second(&table.slope_to_nodes, &value_slope, &mut value);
    along_second(&table.value_to_nodes, &slope_value, &mut slope);
    let mut nodes = zeros();
    along_first(&table.value_to_nodes, &value, &mut nodes);
    along_first(&table.slope_to_nodes, &slope, &mut nodes);
    nodes
}
