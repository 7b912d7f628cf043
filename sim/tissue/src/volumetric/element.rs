//! One hexahedron: its polynomials at the quadrature points, and its stiffness at rest.

use nalgebra::Vector3;

use super::basis;
use super::body::MaterialPoint;

/// Values and slopes of an element's polynomials at its quadrature points.
pub(super) struct BasisShape {
    /// Number of nodes, and of points.
    pub nodes: usize,
    /// Weight of each point.
    pub weights: Vec<f64>,
    /// For each point and node: value, and slope by ξ, η, ζ.
    table: Vec<(f64, Vector3<f64>)>,
}

impl BasisShape {
    pub fn new(order: usize) -> Self {
        let n = order + 1;
        let ends: Vec<f64> = basis::lobatto_rule(order).into_iter().map(|(x, _)| x).collect();
        let gauss = basis::gauss_rule(n);
        let line: Vec<(f64, f64)> = gauss
            .iter()
            .flat_map(|&(x, _)| (0..n).map(|node| basis::lagrange(&ends, node, x)).collect::<Vec<_>>())
            .collect();
        let split = |at: usize| [at % n, at / n % n, at / n / n];
        let nodes = n * n * n;
        let (mut weights, mut table) = (Vec::with_capacity(nodes), Vec::with_capacity(nodes * nodes));
        for point in (0..nodes).map(split) {
            weights.push(point.iter().map(|&at| gauss[at].1).product());
            for node in (0..nodes).map(split) {
                let [x, y, z]: [(f64, f64); 3] = std::array::from_fn(|axis| line[point[axis] * n + node[axis]]);
                let slope = Vector3::new(x.1 * y.0 * z.0, x.0 * y.1 * z.0, x.0 * y.0 * z.1);
                table.push((x.0 * y.0 * z.0, slope));
            }
        }
        Self { nodes, weights, table }
    }

    /// Value and slope of each node at a point.
    pub fn at(&self, point: usize) -> &[(f64, Vector3<f64>)] {
        &self.table[point * self.nodes..][..self.nodes]
    }
}

/// Points that are accumulated together, so that the matrices are read and written once for four.
const TOGETHER: usize = 4;

/// Fills an element's stiffness for small strains: Σ λ ∇a ∇bᵀ + μ ∇b ∇aᵀ + μ (∇a·∇b) I at the
/// points, for nodes a and b.
pub(super) fn stiffness(shape: &BasisShape, points: &[MaterialPoint], matrix: &mut [f64]) {
    let size = 3 * shape.nodes;
    // Within one material the products weighted by λ are a multiple of those weighted by μ.
    let ratio = points[0].lambda_j / points[0].mu_j;
    let one_material = points.iter().all(|point| (point.lambda_j - ratio * point.mu_j).abs() <= 1e-14 * point.lambda_j);
    let mut mu = vec![0.0; size * size];
    let mut gradients: [Vec<f64>; TOGETHER] = std::array::from_fn(|_| vec![0.0; size]);
    for first in (0..points.len()).step_by(TOGETHER) {
        let mut weights = [[0.0; TOGETHER]; 2];
        for (at, point) in points[first..].iter().take(TOGETHER).enumerate() {
            (weights[0][at], weights[1][at]) = (point.lambda_j, point.mu_j);
            let to_material = point.inverse.transpose();
            for (gradient, (_, slope)) in gradients[at].chunks_exact_mut(3).zip(shape.at(first + at)) {
                gradient.copy_from_slice((to_material * slope).as_slice());
            }
        }
        let gradients = gradients.each_ref().map(Vec::as_slice);
        add_products(gradients, weights[1], &mut mu);
        if !one_material {
            add_products(gradients, weights[0], matrix);
        }
    }
    if one_material {
        matrix.iter_mut().zip(&mu).for_each(|(lambda, mu)| *lambda = ratio * mu);
    }
    combine(shape.nodes, matrix, &mut mu);
}

/// Adds the weighted products of gradients at a few points, from each node's block on the diagonal
/// down; the three columns of a node at once.
fn add_products(gradients: [&[f64]; TOGETHER], weights: [f64; TOGETHER], matrix: &mut [f64]) {
    let size = gradients[0].len();
    for (node, columns) in matrix.chunks_exact_mut(3 * size).enumerate() {
        let first = 3 * node;
        let factors: [[f64; TOGETHER]; 3] =
            std::array::from_fn(|axis| std::array::from_fn(|point| weights[point] * gradients[point][first + axis]));
        let (x, rest) = columns.split_at_mut(size);
        let (y, z) = rest.split_at_mut(size);
        let columns = [&mut x[first..], &mut y[first..], &mut z[first..]];
        add_node(columns, &factors, gradients.map(|gradient| &gradient[first..]));
    }
}

/// Adds combinations of four vectors to three columns of the same length.
fn add_node([x, y, z]: [&mut [f64]; 3], factors: &[[f64; TOGETHER]; 3], [a, b, c, d]: [&[f64]; TOGETHER]) {
    let n = x.len();
    let (y, z, a, b, c, d) = (&mut y[..n], &mut z[..n], &a[..n], &b[..n], &c[..n], &d[..n]);
    for i in 0..n {
        let sum = |f: &[f64; TOGETHER]| (f[0] * a[i] + f[1] * b[i]) + (f[2] * c[i] + f[3] * d[i]);
        x[i] += sum(&factors[0]);
        y[i] += sum(&factors[1]);
        z[i] += sum(&factors[2]);
    }
}

/// Computes the stiffness from the products weighted by λ, in `matrix`, and by μ.
fn combine(nodes: usize, matrix: &mut [f64], mu: &mut [f64]) {
    let size = 3 * nodes;
    for (a, b) in (0..nodes).flat_map(|b| (b..nodes).map(move |a| (a, b))) {
        let trace: f64 = (0..3).map(|c| mu[(3 * b + c) * size + 3 * a + c]).sum();
        for (c, d) in (0..9).map(|at| (at / 3, at % 3)) {
            let diagonal = if c == d { trace } else { 0.0 };
            let value = matrix[(3 * b + d) * size + 3 * a + c] + mu[(3 * b + c) * size + 3 * a + d] + diagonal;
            mu[(3 * a + c) * size + 3 * b + d] = value;
        }
    }
    // The entries above the diagonal blocks of `mu` are now the stiffness; the other half is their
    // transpose.
    for (row, column) in (0..size).flat_map(|column| (0..size).map(move |row| (row, column))) {
        let above = if row / 3 >= column / 3 { row * size + column } else { column * size + row };
        matrix[column * size + row] = mu[above];
    }
}
