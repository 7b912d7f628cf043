//! The state of a lattice in time: displacements, velocities and the applied force.

use super::kernel::NodalField;
use super::lattice::Lattice;
use super::load::NodalLoad;

/// Maximum applied force, in N: far above any hand, low enough to avoid overflow.
pub const MAX_FORCE_N: f64 = 1e4;

/// The state of a lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct LatticeMotion {
    pub(super) displacement_m: NodalField,
    pub(super) velocity_m_per_s: NodalField,
    pub(super) load: NodalLoad,
    pub(super) force_n: f64,
}

impl LatticeMotion {
    /// A lattice at rest under no force.
    #[must_use]
    pub fn new(lattice: &Lattice, load: NodalLoad) -> Self {
        let zeros = NodalField::zeros(lattice.grid.places());
        Self { displacement_m: zeros.clone(), velocity_m_per_s: zeros, load, force_n: 0.0 }
    }

    /// Applies this force into the body from now on, in N. A force that is not finite is ignored:
    /// the last one stays. Clamped to ±[`MAX_FORCE_N`].
    pub fn push(&mut self, force_n: f64) {
        if force_n.is_finite() {
            self.force_n = force_n.clamp(-MAX_FORCE_N, MAX_FORCE_N);
        }
    }

    /// Sets the displacement of every movable node, in m, as a function of its position in the
    /// patient's frame, in m, with zero velocity.
    pub fn displace(&mut self, lattice: &Lattice, displacement_m: impl Fn([f64; 3]) -> [f64; 3]) {
        for node in lattice.grid.nodes() {
            let wanted = displacement_m(lattice.grid.position_m(node));
            for axis in (0..3).filter(|&axis| lattice.grid.is_free(node, axis)) {
                self.displacement_m.axes[axis][lattice.grid.place(node)] = wanted[axis];
            }
        }
        self.velocity_m_per_s.clear();
    }

    /// Displacement at a position in the patient's frame, in m: trilinear between the nodes, zero
    /// outside the lattice.
    #[must_use]
    pub fn displacement_m(&self, lattice: &Lattice, position_m: [f64; 3]) -> [f64; 3] {
        lattice.grid.interpolate(&self.displacement_m, position_m)
    }
}
