//! Matrix-free conjugate gradients with a diagonal preconditioner (Hestenes and Stiefel 1952).

use super::kernel::{NodalField, dot};
use super::lattice::Lattice;

/// Stopping criteria.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RelaxationLimit {
    pub(super) iterations: usize,
    /// Residual divided by the right-hand side, both in the norm of the preconditioner.
    pub(super) relative: f64,
    /// That norm of the right-hand side.
    pub(super) scale: f64,
}

/// Scratch of the iteration.
#[derive(Clone, Debug)]
pub(super) struct Relaxation {
    /// Right-hand side minus A x. Set before [`Relaxation::solve`].
    pub(super) residual: NodalField,
    direction: NodalField,
    product: NodalField,
}

impl Relaxation {
    pub(super) fn new(lattice: &Lattice) -> Self {
        let zeros = || NodalField::zeros(lattice.grid.places());
        Self { residual: zeros(), direction: zeros(), product: zeros() }
    }

    /// Memory, in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.residual.bytes() + self.direction.bytes() + self.product.bytes()
    }

    /// Improves `x` until the residual is below its limit. `apply` adds A p to its second argument.
    /// Entries whose `inverse_diagonal` is 0 stay fixed, whatever the residual. Returns the number
    /// of iterations.
    pub(super) fn solve(
        &mut self,
        mut apply: impl FnMut(&NodalField, &mut NodalField),
        inverse_diagonal: &NodalField,
        x: &mut NodalField,
        limit: RelaxationLimit,
    ) -> usize {
        self.direction.clear();
        let mut before = 1.0;
        for iteration in 0..limit.iterations {
            let now = norm_squared(&self.residual, inverse_diagonal);
            if now.is_nan() || now <= limit.relative * limit.relative * limit.scale * limit.scale {
                return iteration;
            }
            self.turn(inverse_diagonal, now / before);
            before = now;
            self.product.clear();
            apply(&self.direction, &mut self.product);
            let curvature = self.direction.dot(&self.product);
            if curvature.is_nan() || curvature <= 0.0 {
                return iteration;
            }
            x.add_scaled(now / curvature, &self.direction);
            self.residual.add_scaled(-now / curvature, &self.product);
        }
        limit.iterations
    }

    /// direction ← D⁻¹ residual + factor · direction
    fn turn(&mut self, inverse_diagonal: &NodalField, factor: f64) {
        for axis in 0..3 {
            let known = self.residual.axes[axis].iter().zip(&inverse_diagonal.axes[axis]);
            for (direction, (residual, inverse)) in self.direction.axes[axis].iter_mut().zip(known) {
                *direction = residual * inverse + factor * *direction;
            }
        }
    }
}

/// rᵀ D⁻¹ r.
pub(super) fn norm_squared(residual: &NodalField, inverse_diagonal: &NodalField) -> f64 {
    let axes = residual.axes.iter().zip(&inverse_diagonal.axes);
    axes.map(|(residual, inverse)| dot_thrice(residual, inverse)).sum()
}

/// Σ r² d, with several partial sums.
fn dot_thrice(residual: &[f64], inverse: &[f64]) -> f64 {
    const WIDTH: usize = 8;
    let mut weighted = [0.0; WIDTH];
    let (r, d) = (residual.as_chunks::<WIDTH>(), inverse.as_chunks::<WIDTH>());
    let whole: f64 = r.0.iter().zip(d.0).fold(0.0, |sum, (r, d)| {
        for lane in 0..WIDTH {
            weighted[lane] = r[lane] * d[lane];
        }
        sum + dot(&weighted, r)
    });
    whole + r.1.iter().zip(d.1).map(|(r, d)| r * r * d).sum::<f64>()
}
