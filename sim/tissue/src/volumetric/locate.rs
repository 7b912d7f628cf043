//! Finds the element that contains a point of the tissue at rest, and evaluates its polynomials
//! there.

use nalgebra::{Matrix3, Point3, Vector3};

use super::basis;
use super::mesh::{HexMesh, ORDERS};

/// Maximum number of nodes along an element.
const MOST: usize = *ORDERS.end() + 1;

/// Newton iterations for the position in an element.
const STEPS: usize = 10;

/// Tolerance by which a point may lie outside an element, as a fraction of a half side: curved
/// sides are polynomials, not circles.
const OUTSIDE: f64 = 0.03;

/// Finds elements by their bounding boxes.
#[derive(Clone, Debug)]
pub(super) struct Locator {
    /// Nodes along a line, −1 to 1.
    line: Vec<f64>,
    boxes_m: Vec<(Point3<f64>, Point3<f64>)>,
}

/// A position in an element.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub element: usize,
    /// ξ, η, ζ.
    pub at: Vector3<f64>,
}

impl Locator {
    pub fn new(mesh: &HexMesh) -> Self {
        let boxes_m = mesh.iter().map(|nodes| {
            let nodes = nodes.iter().map(|&node| mesh.nodes_m[node as usize]);
            let (low, high) = nodes
                .fold((Point3::from([f64::MAX; 3]), Point3::from([f64::MIN; 3])), |(low, high), node| {
                    (low.inf(&node), high.sup(&node))
                });
            let margin = (high - low) * OUTSIDE;
            (low - margin, high + margin)
        });
        let boxes_m = boxes_m.collect();
        Self { line: basis::lobatto_rule(mesh.order).into_iter().map(|(x, _)| x).collect(), boxes_m }
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.boxes_m[..])
    }

    /// The position of a point; `None` outside the mesh.
    pub fn find(&self, mesh: &HexMesh, point: &Point3<f64>) -> Option<Place> {
        let mut best: Option<(f64, Place)> = None;
        for (element, _) in self.boxes_m.iter().enumerate().filter(|(_, (low, high))| point >= low && point <= high) {
            let Some(at) = self.within(mesh, element, point) else { continue };
            let outside = (at.amax() - 1.0).max(0.0);
            if outside <= OUTSIDE && best.is_none_or(|(least, _)| outside < least) {
                best = Some((outside, Place { element, at }));
            }
            if outside <= 1e-9 {
                break;
            }
        }
        best.map(|(_, place)| place)
    }

    fn within(&self, mesh: &HexMesh, element: usize, point: &Point3<f64>) -> Option<Vector3<f64>> {
        let nodes = &mesh.elements[element * mesh.nodes_each()..][..mesh.nodes_each()];
        let mut at = Vector3::zeros();
        for _ in 0..STEPS {
            let (mut place, mut jacobian) = (Vector3::zeros(), Matrix3::zeros());
            self.each(&at, |node, value, slope| {
                let rest = mesh.nodes_m[nodes[node] as usize].coords;
                place += rest * value;
                jacobian += rest * slope.transpose();
            });
            let change = jacobian.try_inverse()? * (point.coords - place);
            // Far outside, the polynomials fold back, so no step may be longer than the element.
            at += change / change.amax().max(1.0);
            if change.amax() < 1e-12 {
                break;
            }
        }
        Some(at)
    }

    /// Visits the nodes with the values and slopes of their polynomials at a position.
    pub fn each(&self, at: &Vector3<f64>, mut visit: impl FnMut(usize, f64, Vector3<f64>)) {
        let n = self.line.len();
        let mut along = [[(0.0, 0.0); MOST]; 3];
        for (along, &x) in along.iter_mut().zip(at) {
            for (node, along) in along[..n].iter_mut().enumerate() {
                *along = basis::lagrange(&self.line, node, x);
            }
        }
        let [x, y, z] = along;
        for node in 0..n * n * n {
            let (x, y, z) = (x[node % n], y[node / n % n], z[node / n / n]);
            let slope = Vector3::new(x.1 * y.0 * z.0, x.0 * y.1 * z.0, x.0 * y.0 * z.1);
            visit(node, x.0 * y.0 * z.0, slope);
        }
    }
}
