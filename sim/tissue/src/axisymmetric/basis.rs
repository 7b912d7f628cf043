//! Lagrange polynomials on [−1, 1], with the tables that every mesh needs.

use std::sync::LazyLock;

use crate::quadrature::{gauss_rule, lobatto_rule};

/// Highest order of an element.
pub const MAX_ORDER: usize = 10;

/// One number per node of an element along one direction.
pub(super) type Nodal = [f64; MAX_ORDER + 1];

/// Number of points of the fine rule: it integrates a Gaussian over seven of its radii to full
/// precision.
const FINE: usize = 32;

/// A point of a quadrature rule on [−1, 1], with its weight.
pub(super) type Point = (f64, f64);

/// Tables of each order. Constant, hence computed once.
static TABLES: LazyLock<Tables> = LazyLock::new(|| Tables {
    bases: (0..=MAX_ORDER).map(|order| Basis::new(order.max(1))).collect(),
    fine: gauss_rule(FINE),
});

struct Tables {
    bases: Vec<Basis>,
    fine: Vec<Point>,
}

/// The polynomials of an order, 1 to [`MAX_ORDER`].
pub(super) fn basis(order: usize) -> &'static Basis {
    &TABLES.bases[order]
}

/// A rule for integrands that are not polynomials.
pub(super) fn fine_rule() -> &'static [Point] {
    &TABLES.fine
}

/// Lagrange polynomials of one order on the Gauss–Lobatto nodes.
#[derive(Clone, Debug)]
pub(super) struct Basis {
    order: usize,
    nodes: Nodal,
    /// 1/∏(xᵢ − xₖ) over k ≠ i.
    weights: Nodal,
    /// Points that integrate products of two polynomials with r exactly, and with 1/r closely;
    /// values and slopes there.
    rule: Vec<(Point, Nodal, Nodal)>,
}

impl Basis {
    pub fn new(order: usize) -> Self {
        let mut nodes = [0.0; MAX_ORDER + 1];
        for (node, (x, _)) in nodes.iter_mut().zip(lobatto_rule(order)) {
            *node = x;
        }
        let mut weights = [0.0; MAX_ORDER + 1];
        for i in 0..=order {
            weights[i] = 1.0 / (0..=order).filter(|&k| k != i).map(|k| nodes[i] - nodes[k]).product::<f64>();
        }
        let mut basis = Self { order, nodes, weights, rule: Vec::new() };
        let points = gauss_rule(order + 2).into_iter();
        basis.rule = points.map(|point| (point, basis.values(point.0), basis.slopes(point.0))).collect();
        basis
    }

    /// Points of a rule for the stiffness, with the polynomials' values and slopes there.
    pub fn rule(&self) -> &[(Point, Nodal, Nodal)] {
        &self.rule
    }

    /// The polynomials at x. Computed without division, so x may be a node.
    pub fn values(&self, x: f64) -> Nodal {
        let mut values = self.weights;
        let (mut below, mut above) = (1.0, 1.0);
        for i in 0..=self.order {
            values[i] *= below;
            values[self.order - i] *= above;
            below *= x - self.nodes[i];
            above *= x - self.nodes[self.order - i];
        }
        values
    }

    /// The slopes of the polynomials at x.
    fn slopes(&self, x: f64) -> Nodal {
        let mut slopes = [0.0; MAX_ORDER + 1];
        for (i, slope) in slopes[..=self.order].iter_mut().enumerate() {
            let others = |m: usize| (0..=self.order).filter(move |&k| k != i && k != m).map(|k| x - self.nodes[k]);
            let sum: f64 = (0..=self.order).filter(|&m| m != i).map(|m| others(m).product::<f64>()).sum();
            *slope = sum * self.weights[i];
        }
        slopes
    }
}
