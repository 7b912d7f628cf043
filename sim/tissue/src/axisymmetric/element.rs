//! Stiffness of an element: products of matrices along r and along z.
//!
//! Every integrand is a function of r times one of z, so the cost of the matrix of an element with
//! (p + 1)² nodes is proportional to its entries, not to that times the number of quadrature
//! points.

use super::basis::{Nodal, basis};
use super::mesh::Span;
use crate::ElasticLayer;

/// One strip's integrals over r of products of its polynomials φ, row after row.
#[derive(Clone, Debug, Default)]
pub(super) struct RadialIntegrals {
    /// ∫ φᵢ′ φₖ′ r.
    pub slope: Vec<f64>,
    /// ∫ φᵢ φₖ r.
    pub mass: Vec<f64>,
    /// ∫ φᵢ φₖ / r.
    pub hoop: Vec<f64>,
    /// ∫ φᵢ′ φₖ r.
    pub mixed: Vec<f64>,
    /// ∫ φᵢ′ φₖ.
    pub lean: Vec<f64>,
    /// ∫ φᵢ φₖ.
    pub plain: Vec<f64>,
}

/// One strip's integrals over z of products of its polynomials ψ, row after row.
#[derive(Clone, Debug, Default)]
pub(super) struct AxialIntegrals {
    /// ∫ ψⱼ ψₗ.
    pub mass: Vec<f64>,
    /// ∫ ψⱼ′ ψₗ′.
    pub slope: Vec<f64>,
    /// ∫ ψⱼ ψₗ′.
    pub mixed: Vec<f64>,
}

/// Position, values, slopes in 1/m and weight in m of a strip's polynomials at the quadrature
/// points.
fn points(span: &Span) -> impl Iterator<Item = (f64, Nodal, Nodal, f64)> {
    let (middle_m, half_m) = (span.middle_m(), span.half_m());
    basis(span.order).rule().iter().map(move |&((x, weight), values, slopes)| {
        (middle_m + half_m * x, values, slopes.map(|slope| slope / half_m), weight * half_m)
    })
}

/// Adds f(i, k) to entry (i, k) of an n × n matrix.
fn add(matrix: &mut [f64], n: usize, f: impl Fn(usize, usize) -> f64) {
    for (at, value) in matrix.iter_mut().enumerate() {
        *value += f(at / n, at % n);
    }
}

impl RadialIntegrals {
    pub fn new(span: &Span) -> Self {
        let n = span.order + 1;
        let zeros = || vec![0.0; n * n];
        let [slope, mass, hoop, mixed, lean, plain] = std::array::from_fn(|_| zeros());
        let mut sums = Self { slope, mass, hoop, mixed, lean, plain };
        for (r, v, s, weight) in points(span) {
            let (w, wr) = (weight, weight * r);
            add(&mut sums.slope, n, |i, k| wr * s[i] * s[k]);
            add(&mut sums.mass, n, |i, k| wr * v[i] * v[k]);
            add(&mut sums.hoop, n, |i, k| w / r * v[i] * v[k]);
            add(&mut sums.mixed, n, |i, k| wr * s[i] * v[k]);
            add(&mut sums.lean, n, |i, k| w * s[i] * v[k]);
            add(&mut sums.plain, n, |i, k| w * v[i] * v[k]);
        }
        sums
    }
}

impl AxialIntegrals {
    pub fn new(span: &Span) -> Self {
        let n = span.order + 1;
        let zeros = || vec![0.0; n * n];
        let mut sums = Self { mass: zeros(), slope: zeros(), mixed: zeros() };
        for (_, v, s, w) in points(span) {
            add(&mut sums.mass, n, |j, l| w * v[j] * v[l]);
            add(&mut sums.slope, n, |j, l| w * s[j] * s[l]);
            add(&mut sums.mixed, n, |j, l| w * v[j] * s[l]);
        }
        sums
    }
}

/// Fills an element's stiffness per radian: rows and columns are its nodes, grouped by columns of
/// nodes, with (u_r, u_z) at each. From the virtual work of λ tr(ε) tr(δε) + 2μ ε:δε with ε =
/// (u_r,r, u_r/r, u_z,z, u_r,z + u_z,r).
pub(super) fn stiffness(layer: &ElasticLayer, r: &RadialIntegrals, z: &AxialIntegrals, matrix: &mut [f64]) {
    let (lambda, mu) = layer.lame_pa();
    let (n, m) = (r.mass.len().isqrt(), z.mass.len().isqrt());
    let size = 2 * n * m;
    for (i, k) in (0..n).flat_map(|i| (0..n).map(move |k| (i, k))) {
        let (at, back) = (i * n + k, k * n + i);
        let rr_mass = (lambda + 2.0 * mu) * (r.slope[at] + r.hoop[at]) + lambda * (r.lean[at] + r.lean[back]);
        let (rr_slope, zz_slope) = (mu * r.mass[at], (lambda + 2.0 * mu) * r.mass[at]);
        let (zz_mass, rz, rz_back) = (mu * r.slope[at], lambda * (r.mixed[at] + r.plain[at]), mu * r.mixed[back]);
        for j in 0..m {
            let row = 2 * (i * m + j);
            for l in 0..m {
                let column = 2 * (k * m + l);
                let (mass, slope) = (z.mass[j * m + l], z.slope[j * m + l]);
                let coupled = rz * z.mixed[j * m + l] + rz_back * z.mixed[l * m + j];
                matrix[column * size + row] = rr_mass * mass + rr_slope * slope;
                matrix[(column + 1) * size + row + 1] = zz_slope * slope + zz_mass * mass;
                matrix[(column + 1) * size + row] = coupled;
                matrix[row * size + column + 1] = coupled;
            }
        }
    }
}
