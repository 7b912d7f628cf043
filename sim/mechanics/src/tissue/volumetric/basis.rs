//! One-dimensional polynomials: where a hexahedron has its nodes, and where it is integrated.

use std::f64::consts::PI;

/// Legendre's polynomial of a degree at x, with its slope, by Bonnet's recursion.
fn legendre(degree: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (1.0, x);
    for n in 1..degree {
        let n = n as f64;
        (before, value) = (value, ((2.0 * n + 1.0) * x * value - n * before) / (n + 1.0));
    }
    (value, degree as f64 * (before - x * value) / (1.0 - x * x))
}

/// Points and weights of Gauss and Legendre's quadrature on −1 to 1, ascending.
pub(super) fn gauss(count: usize) -> Vec<(f64, f64)> {
    let mut points = Vec::with_capacity(count);
    for at in (0..count).rev() {
        let mut x = libm::cos(PI * (at as f64 + 0.75) / (count as f64 + 0.5));
        for _ in 0..8 {
            let (value, slope) = legendre(count, x);
            x -= value / slope;
        }
        let (_, slope) = legendre(count, x);
        points.push((x, 2.0 / ((1.0 - x * x) * slope * slope)));
    }
    points
}

/// Points and weights of Gauss and Lobatto's quadrature on −1 to 1, ascending: the nodes of an element of this order.
pub(super) fn lobatto(order: usize) -> Vec<(f64, f64)> {
    let p = order as f64;
    let end = 2.0 / (p * (p + 1.0));
    let mut points = vec![(-1.0, end)];
    for at in (1..order).rev() {
        let mut x = libm::cos(PI * at as f64 / p);
        for _ in 0..8 {
            let (value, slope) = legendre(order, x);
            // Legendre's equation gives the second derivative, of which the interior nodes are no roots.
            x -= slope * (1.0 - x * x) / (2.0 * x * slope - p * (p + 1.0) * value);
        }
        let (value, _) = legendre(order, x);
        points.push((x, end / (value * value)));
    }
    points.push((1.0, end));
    points
}

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

/// Values and slopes of an element's one-dimensional polynomials at its quadrature points, `[point][node]`.
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
        let nodes: Vec<f64> = lobatto(N - 1).into_iter().map(|(x, _)| x).collect();
        let points = gauss(N);
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
