//! Evaluation of a lattice: displacement between nodes, and the spring forces under a given
//! displacement.

use super::grid::Grid;
use super::kernel::{NodalField, pull_all};
use super::lattice::Lattice;
use super::laws::{Elastic, Linear};

/// Spring energies and forces under a displacement given at every node, including held ones: for
/// verification.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// Energy of the springs in the computed part, in J.
    pub energy_j: f64,
    /// Energy of the linearised lattice, in J.
    pub linear_energy_j: f64,
    /// All nodes, from the skin down.
    pub nodes: Vec<NodeForce>,
}

/// Pull of the springs at a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeForce {
    /// Position of the node at rest in the patient's frame, in m.
    pub position_m: [f64; 3],
    /// Whether it moves: it is not on the rim, beyond it or on the base.
    pub moves: bool,
    /// Pull of its springs, in N.
    pub force_n: [f64; 3],
    /// Pull in the linearised lattice, in N.
    pub linear_force_n: [f64; 3],
}

impl Lattice {
    /// Spring energies and forces under a displacement, in m, as a function of the position in the
    /// patient's frame, in m.
    #[must_use]
    pub fn respond(&self, displacement_m: impl Fn([f64; 3]) -> [f64; 3]) -> Response {
        let zeros = || NodalField::zeros(self.grid.places());
        let (mut u, mut forces, mut resistance) = (zeros(), zeros(), zeros());
        for node in self.grid.nodes() {
            let wanted = displacement_m(self.grid.position_m(node));
            u.axes.iter_mut().zip(wanted).for_each(|(axis, wanted)| axis[self.grid.place(node)] = wanted);
        }
        pull_all(self, &Elastic, [&u], &mut forces);
        pull_all(self, &Linear, [&u], &mut resistance);
        let at = |field: &NodalField, place: usize| [0, 1, 2].map(|axis| field.axes[axis][place]);
        let node_force = |node: [usize; 3]| NodeForce {
            position_m: self.grid.position_m(node),
            moves: self.grid.moves(node),
            force_n: at(&forces, self.grid.place(node)),
            linear_force_n: at(&resistance, self.grid.place(node)).map(|resistance| -resistance),
        };
        Response {
            energy_j: self.spring_energy_j(&u),
            linear_energy_j: 0.5 * u.dot(&resistance),
            nodes: self.grid.nodes().map(node_force).collect(),
        }
    }
}

impl Grid {
    /// Trilinear between the nodes, zero outside the lattice. A quarter is mirrored.
    pub(super) fn interpolate(&self, field: &NodalField, [x_m, y_m, z_m]: [f64; 3]) -> [f64; 3] {
        let mirrored = self.centre() == 0;
        let across = |at_m: f64| if mirrored { at_m.abs() } else { at_m } / self.spacing_m + self.centre() as f64;
        let [x, y] = [across(x_m), across(y_m)];
        let last = (self.side - 1) as f64;
        let within = |at: f64| at >= 0.0 && at <= last;
        // Rounding may put the skin or an interface slightly outside.
        if !(within(x) && within(y) && -z_m > -1e-9 && -z_m < self.depth_m()) {
            return [0.0; 3];
        }
        let cell = |at: f64| at.min(last - 1.0).floor();
        let (k, down) = self.storey_at(-z_m);
        let (first, parts) = ([cell(x) as usize, cell(y) as usize, k], [x - cell(x), y - cell(y), down]);
        let mut sum = [0.0; 3];
        for bits in 0..8_usize {
            let corner = [bits & 1, bits >> 1 & 1, bits >> 2];
            let weights = [0, 1, 2].map(|axis| if corner[axis] == 1 { parts[axis] } else { 1.0 - parts[axis] });
            let place = self.place([0, 1, 2].map(|axis| first[axis] + corner[axis]));
            (0..3).for_each(|axis| sum[axis] += weights.iter().product::<f64>() * field.axes[axis][place]);
        }
        let signs = [x_m, y_m, 1.0].map(|at| if mirrored && at < 0.0 { -1.0 } else { 1.0 });
        [0, 1, 2].map(|axis| sum[axis] * signs[axis])
    }
}
