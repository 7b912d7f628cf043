//! One-dimensional polynomials: nodes and integration points of a hexahedron.

pub(super) use crate::quadrature::{gauss_rule, lobatto_rule};

/// Value and slope at x of the polynomial that is 1 at node `at` and 0 at the others.
pub(super) fn lagrange(nodes: &[f64], at: usize, x: f64) -> (f64, f64) {
    let (mut value, mut slope) = (1.0, 0.0);
    for (other, node) in nodes.iter().enumerate().filter(|&(other, _)| other != at) {
        let scale = 1.0 / (nodes[at] - nodes[other]);
        slope = slope * (x - node) * scale + value * scale;
        value *= (x - node) * scale;
    }
    (value, slope)
}

/// Values and slopes of an element's one-dimensional polynomials at its quadrature points,
/// `[point][node]`.
#[derive(Clone, Debug)]
pub(super) struct Table<const N: usize> {
    pub value: [[f64; N]; N],
    pub slope: [[f64; N]; N],
    /// The same, `[node][point]`.
    pub value_to_nodes: [[f64; N]; N],
    pub slope_to_nodes: [[f64; N]; N],
}

impl<const N: usize> Table<N> {
    pub fn new() -> Self {
        let nodes: Vec<f64> = lobatto_rule(N - 1).into_iter().map(|(x, _)| x).collect();
        let points = gauss_rule(N);
        let both = |point: usize, node: usize| lagrange(&nodes, node, points[point].0);
        let table = |f: &dyn Fn(usize, usize) -> f64| std::array::from_fn(|i| std::array::from_fn(|j| f(i, j)));
        Self {
            value: table(&|point, node| both(point, node).0),
            slope: table(&|point, node| both(point, node).1),
            value_to_nodes: table(&|node, point| both(point, node).0),
            slope_to_nodes: table(&|node, point| both(point, node).1),
        }
    }
}
