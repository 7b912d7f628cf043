//! Explicit integration: symplectic Euler, v ← v + h M⁻¹(f − αMv), u ← u + h v.
//!
//! Displacements and velocities are added up in double precision. The pulls of the springs, nearly all of the work, are
//! in single: a displacement u is then off by 6e-8 u, which is less than a millionth of any step between nodes that
//! matters, and four springs are computed at once.
//!
//! Its energy error stays bounded for any number of steps below the stable one (Hairer, Lubich and Wanner 2006, IX).

use super::LatticeError;
use super::kernel::{Field, pull_plane};
use super::lattice::Lattice;
use super::laws::{Damped, Elastic};
use super::motion::Motion;

/// Most sub-steps of one [`advance`]: some seconds of computing, not an endless loop.
pub const MAX_SUBSTEPS: u32 = 100_000;

/// Memory of the explicit steps.
#[derive(Clone, Debug)]
pub struct ExplicitScratch {
    /// Displacement rounded for the springs, in m.
    displacement_m: Field<f32>,
    /// Velocity rounded for the dashpots, in m/s.
    velocity_m_per_s: Field<f32>,
    /// Nodal forces, in N; zero between steps.
    forces_n: Field<f32>,
}

impl ExplicitScratch {
    /// Memory for this lattice.
    #[must_use]
    pub fn new(lattice: &Lattice) -> Self {
        let zeros = || Field::zeros(lattice.grid.places());
        Self { displacement_m: zeros(), velocity_m_per_s: zeros(), forces_n: zeros() }
    }

    fn round(&mut self, motion: &Motion) {
        let rounded = [&mut self.displacement_m, &mut self.velocity_m_per_s];
        for (rounded, exact) in rounded.into_iter().zip([&motion.displacement_m, &motion.velocity_m_per_s]) {
            for (rounded, exact) in rounded.axes.iter_mut().zip(&exact.axes) {
                rounded.iter_mut().zip(exact).for_each(|(rounded, exact)| *rounded = *exact as f32);
            }
        }
    }
}

/// One step. A step of 0 changes nothing.
///
/// # Errors
/// A step that is not a number, negative, or longer than the stable one; nothing has moved then.
pub fn step(
    lattice: &Lattice,
    motion: &mut Motion,
    scratch: &mut ExplicitScratch,
    step_s: f64,
) -> Result<(), LatticeError> {
    let stable_s = lattice.stable_step_s();
    if !(0.0..=stable_s).contains(&step_s) {
        return Err(LatticeError::Step { step_s, stable_s });
    }
    scratch.round(motion);
    sub_step(lattice, motion, scratch, step_s);
    Ok(())
}

/// Any time, in equal sub-steps as long as the stable one allows. Returns how many; 0 for no time.
///
/// # Errors
/// A time that is not a number, negative, or longer than [`MAX_SUBSTEPS`] stable steps; nothing has moved then.
pub fn advance(
    lattice: &Lattice,
    motion: &mut Motion,
    scratch: &mut ExplicitScratch,
    time_s: f64,
) -> Result<u32, LatticeError> {
    let stable_s = lattice.stable_step_s();
    let longest_s = stable_s * f64::from(MAX_SUBSTEPS);
    if !(0.0..=longest_s).contains(&time_s) {
        return Err(LatticeError::Time { time_s, longest_s });
    }
    let substeps = (time_s / stable_s).ceil() as u32;
    scratch.round(motion);
    for _ in 0..substeps {
        sub_step(lattice, motion, scratch, time_s / f64::from(substeps));
    }
    Ok(substeps)
}

/// A step of a motion that the scratch holds rounded.
fn sub_step(lattice: &Lattice, motion: &mut Motion, scratch: &mut ExplicitScratch, step_s: f64) {
    motion.load.add_single(motion.force_n, &mut scratch.forces_n);
    let stiffness_damping_s = lattice.damping.stiffness_s;
    // A plane's forces are complete once the springs kept in it have pulled, and no later plane asks where it was.
    for k in 0..lattice.links.len() {
        let forces = (k, &mut scratch.forces_n);
        if stiffness_damping_s > 0.0 {
            let fields = [&scratch.displacement_m, &scratch.velocity_m_per_s];
            pull_plane(lattice, &Damped { stiffness_damping_s }, fields, forces);
        } else {
            pull_plane(lattice, &Elastic, [&scratch.displacement_m], forces);
        }
        move_plane(lattice, motion, (k, scratch), step_s);
    }
}

/// Moves the nodes of a plane by their forces, and clears these.
fn move_plane(lattice: &Lattice, motion: &mut Motion, (k, scratch): (usize, &mut ExplicitScratch), step_s: f64) {
    let plane = lattice.grid.side * lattice.grid.side;
    let range = || k * plane..(k + 1) * plane;
    let kept = 1.0 - step_s * lattice.damping.mass_per_s;
    for axis in 0..3 {
        let velocities = &mut motion.velocity_m_per_s.axes[axis][range()];
        let known = lattice.inverse_masses.axes[axis][range()].iter().zip(&mut scratch.forces_n.axes[axis][range()]);
        let moved = motion.displacement_m.axes[axis][range()].iter_mut().zip(&mut *velocities);
        let rounded = &mut scratch.displacement_m.axes[axis][range()];
        for (((inverse, force), (u, v)), rounded) in known.zip(moved).zip(rounded) {
            *v = *v * kept + step_s * inverse * f64::from(*force);
            *u += step_s * *v;
            (*rounded, *force) = (*u as f32, 0.0);
        }
        if lattice.damping.stiffness_s > 0.0 {
            let rounded = &mut scratch.velocity_m_per_s.axes[axis][range()];
            rounded.iter_mut().zip(velocities).for_each(|(rounded, v)| *rounded = *v as f32);
        }
    }
}
