//! Explicit integration: symplectic Euler, v ← v + h M⁻¹(f − αMv), u ← u + h v.
//!
//! Displacements and velocities are accumulated in double precision. The pulls of the springs,
//! nearly all of the work, are computed in single precision: the error of a displacement u is then
//! 6e-8 u, less than a millionth of any relevant difference between nodes, and four springs are
//! computed at once.
//!
//! The energy error stays bounded for any number of steps below the stable one (Hairer, Lubich and
//! Wanner 2006, IX).

use wide::f32x4;

use super::LatticeError;
use super::kernel::{NodalField, pull_plane};
use super::lattice::Lattice;
use super::laws::{Damped, Elastic};
use super::motion::LatticeMotion;

/// Maximum number of sub-steps of one [`advance`]: some seconds of computing, not an endless loop.
pub const MAX_SUBSTEPS: u32 = 100_000;

/// Scratch of the explicit steps.
#[derive(Clone, Debug)]
pub struct ExplicitScratch {
    /// Displacement rounded for the springs, in m.
    displacement_m: NodalField<f32>,
    /// Velocity rounded for the dashpots, in m/s.
    velocity_m_per_s: NodalField<f32>,
    /// Nodal forces, in N; zero between steps.
    forces_n: NodalField<f32>,
}

impl ExplicitScratch {
    /// Scratch for this lattice.
    #[must_use]
    pub fn new(lattice: &Lattice) -> Self {
        let zeros = || NodalField::zeros(lattice.grid.places());
        Self { displacement_m: zeros(), velocity_m_per_s: zeros(), forces_n: zeros() }
    }

    /// Rounds a plane of a motion to single precision.
    fn round(&mut self, lattice: &Lattice, motion: &LatticeMotion, k: usize) {
        let plane = lattice.grid.place([0, 0, k])..lattice.grid.place([0, 0, k + 1]);
        let round = |rounded: &mut NodalField<f32>, exact: &NodalField| {
            for (rounded, exact) in rounded.axes.iter_mut().zip(&exact.axes) {
                let pairs = rounded[plane.clone()].iter_mut().zip(&exact[plane.clone()]);
                pairs.for_each(|(rounded, exact)| *rounded = *exact as f32);
            }
        };
        round(&mut self.displacement_m, &motion.displacement_m);
        if lattice.damping.stiffness_s > 0.0 {
            round(&mut self.velocity_m_per_s, &motion.velocity_m_per_s);
        }
    }
}

/// Makes one step. A step of 0 changes nothing.
///
/// # Errors
/// If the step is negative, NaN, or longer than the stable one; nothing has moved then.
pub fn step(
    lattice: &Lattice,
    motion: &mut LatticeMotion,
    scratch: &mut ExplicitScratch,
    step_s: f64,
) -> Result<(), LatticeError> {
    let stable_s = lattice.stable_step_s();
    if !(0.0..=stable_s).contains(&step_s) {
        return Err(LatticeError::Step { step_s, stable_s });
    }
    sub_step(lattice, motion, scratch, step_s);
    Ok(())
}

/// Advances by any time, in equal sub-steps as long as stability allows. Returns their number; 0
/// for no time.
///
/// # Errors
/// If the time is negative, NaN, or longer than [`MAX_SUBSTEPS`] stable steps; nothing has moved
/// then.
pub fn advance(
    lattice: &Lattice,
    motion: &mut LatticeMotion,
    scratch: &mut ExplicitScratch,
    time_s: f64,
) -> Result<u32, LatticeError> {
    let stable_s = lattice.stable_step_s();
    let longest_s = stable_s * f64::from(MAX_SUBSTEPS);
    if !(0.0..=longest_s).contains(&time_s) {
        return Err(LatticeError::Time { time_s, longest_s });
    }
    let substeps = (time_s / stable_s).ceil() as u32;
    for _ in 0..substeps {
        sub_step(lattice, motion, scratch, time_s / f64::from(substeps));
    }
    Ok(substeps)
}

fn sub_step(lattice: &Lattice, motion: &mut LatticeMotion, scratch: &mut ExplicitScratch, step_s: f64) {
    motion.load.add_single(motion.force_n, &mut scratch.forces_n);
    let stiffness_damping_s = lattice.damping.stiffness_s;
    scratch.round(lattice, motion, 0);
    // A plane's forces are complete once the springs stored in it have pulled, and no later plane
    // reads its old positions: all work on a plane is done while it is in the cache.
    for k in 0..lattice.links.len() {
        scratch.round(lattice, motion, k + 1);
        let ExplicitScratch { displacement_m, velocity_m_per_s, forces_n } = &mut *scratch;
        if stiffness_damping_s > 0.0 {
            let law = Damped { stiffness_damping_s };
            pull_plane::<f32x4, 2>(lattice, &law, [displacement_m, velocity_m_per_s], k, forces_n);
        } else {
            pull_plane::<f32x4, 1>(lattice, &Elastic, [displacement_m], k, forces_n);
        }
        move_plane(lattice, motion, k, forces_n, step_s);
    }
}

/// Moves the nodes of a plane by their forces, and clears these.
fn move_plane(lattice: &Lattice, motion: &mut LatticeMotion, k: usize, forces_n: &mut NodalField<f32>, step_s: f64) {
    let plane = lattice.grid.place([0, 0, k])..lattice.grid.place([0, 0, k + 1]);
    let kept = 1.0 - step_s * lattice.damping.mass_per_s;
    for axis in 0..3 {
        let velocities = &mut motion.velocity_m_per_s.axes[axis][plane.clone()];
        let moved = motion.displacement_m.axes[axis][plane.clone()].iter_mut().zip(velocities);
        let forces = &mut forces_n.axes[axis][plane.clone()];
        let known = lattice.inverse_masses.axes[axis][plane.clone()].iter().zip(forces);
        for ((inverse, force), (u, v)) in known.zip(moved) {
            *v = *v * kept + step_s * inverse * f64::from(*force);
            *u += step_s * *v;
            *force = 0.0;
        }
    }
}
