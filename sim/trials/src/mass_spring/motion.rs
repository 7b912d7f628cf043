//! Moving lattices under extreme loads.

use law::axial::ParamError;
use tissue::mass_spring::{Damping, LatticeError, MAX_FORCE_N};

use super::moved::{Advance, Moved, energy_over_work};
use crate::scenes::{AxialRun, training_axial_spec};
use crate::{Measured, largest};

pub(super) fn inverted_energy() -> Measured {
    let mut moved = Moved::undamped()?;
    moved.invert();
    let first_j = moved.energy_j();
    let mut energies_j = Vec::new();
    for _ in 0..200 {
        moved.explicitly(1e-3)?;
        energies_j.push(moved.energy_j() / first_j);
    }
    Ok(largest(energies_j))
}

pub(super) fn inverted_rest() -> Measured {
    let mut moved = Moved::undamped()?;
    moved.invert();
    let first_m = moved.skin_m();
    moved.rest()?;
    Ok((moved.skin_m() / first_m).abs())
}

pub(super) fn long_step_refused() -> Measured {
    let mut moved = Moved::undamped()?;
    moved.invert();
    let (before, stable_s) = (moved.motion.clone(), moved.lattice.stable_step_s());
    let refusal = moved.step(4.0 * stable_s);
    let named = refusal.is_err_and(|why| why.to_string().contains(&format!("stable step of {stable_s} s")));
    Ok(f64::from(u8::from(!named || moved.motion != before)))
}

/// Returns the tip's force on the tissue, in N, for a needle of the training scene at the given
/// depth in each millisecond.
fn tip_forces_n(depths_m: impl Iterator<Item = f64>) -> Result<Vec<f64>, ParamError> {
    let mut needle = AxialRun::new(training_axial_spec())?;
    Ok(depths_m.zip(0_u32..).map(|(x_m, tick)| needle.step(f64::from(tick) * 1e-3, x_m).tip_n).collect())
}

/// From above the skin to 43 mm at 1 m/s, and held.
pub(super) fn stab_energy() -> Measured {
    let mut moved = Moved::undamped()?;
    let depths_m = (-2..=100).map(|tick| f64::from(tick.min(43)) * 1e-3);
    energy_over_work(&mut moved, Moved::explicitly, 1e-3, tip_forces_n(depths_m)?)
}

/// From the skin into the skin's tent in one tick, then by 50 mm in another, and held.
fn teleport(advance: Advance) -> Measured {
    let mut moved = Moved::undamped()?;
    let depths_m = (0..40).map(|tick| if tick < 10 { 2.9e-3 } else { 0.0529 });
    energy_over_work(&mut moved, advance, 1e-3, tip_forces_n(depths_m)?)
}

pub(super) fn teleport_explicit() -> Measured {
    teleport(Moved::explicitly)
}

pub(super) fn teleport_implicit() -> Measured {
    teleport(Moved::implicitly)
}

pub(super) fn bad_samples() -> Measured {
    let mut moved = Moved::undamped()?;
    moved.motion.push(0.05);
    moved.rest()?;
    let before = moved.motion.clone();
    let mut changes = 0;
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        moved.motion.push(bad);
        changes += u32::from(moved.motion != before);
    }
    for bad_s in [f64::NAN, -1e-3, f64::NEG_INFINITY] {
        let refused = [moved.explicitly(bad_s), moved.implicitly(bad_s)];
        changes += u32::from(refused.iter().any(Result::is_ok) || moved.motion != before);
    }
    // A force above the limit is clamped to it.
    moved.motion.push(f64::MAX);
    let mut most = before;
    most.push(MAX_FORCE_N);
    Ok(f64::from(changes + u32::from(moved.motion != most)))
}

pub(super) fn no_time() -> Measured {
    let mut moved = Moved::undamped()?;
    moved.invert();
    moved.motion.push(0.05);
    let before = moved.motion.clone();
    let mut changes = 0;
    for advance in [Moved::explicitly as Advance, Moved::implicitly] {
        advance(&mut moved, 0.0)?;
        changes += u32::from(moved.motion != before);
    }
    Ok(f64::from(changes))
}

/// Held at rest by 0.05 N and released. Returns the energies in the following 0.2 s relative to the
/// stored energy, and the remaining relative displacement.
fn release(damping: Damping, advance: Advance) -> Result<(Vec<f64>, f64), LatticeError> {
    let mut moved = Moved::new(damping)?;
    moved.motion.push(0.05);
    moved.rest()?;
    let (stored_j, held_m) = (moved.energy_j(), moved.skin_m());
    moved.motion.push(0.0);
    let mut energies = Vec::new();
    for _ in 0..100 {
        advance(&mut moved, 2e-3)?;
        energies.push(moved.energy_j() / stored_j);
    }
    Ok((energies, (moved.skin_m() / held_m).abs()))
}

pub(super) fn release_explicit() -> Measured {
    Ok(largest(release(Damping::default(), Moved::explicitly)?.0))
}

pub(super) fn release_growth() -> Measured {
    let (energies, _) = release(Damping::default(), Moved::explicitly)?;
    let (early, late) = energies.split_at(energies.len() / 2);
    Ok(largest(late.iter().copied()) / largest(early.iter().copied()))
}

pub(super) fn release_implicit() -> Measured {
    Ok(largest(release(Damping::default(), Moved::implicitly)?.0))
}

pub(super) fn release_rest() -> Measured {
    Ok(release(Damping { mass_per_s: 200.0, stiffness_s: 0.0 }, Moved::explicitly)?.1)
}

/// Ten minutes in steps of a second, after ten seconds of settling.
pub(super) fn hold_creep() -> Measured {
    let mut moved = Moved::new(Damping { mass_per_s: 200.0, stiffness_s: 0.0 })?;
    moved.motion.push(0.05);
    for _ in 0..10 {
        moved.implicitly(1.0)?;
    }
    let settled_m = moved.skin_m();
    let mut changes = Vec::new();
    for _ in 0..600 {
        moved.implicitly(1.0)?;
        changes.push((moved.skin_m() / settled_m - 1.0).abs());
    }
    Ok(largest(changes))
}

/// A second of linearly increasing force, sampled 15 times a second: the latest of a thousand
/// samples.
fn slow_forces_n() -> impl Iterator<Item = f64> {
    (1..=15_u32).map(|step| 1e-4 * f64::from(step * 1000 / 15))
}

pub(super) fn slow_tissue_energy() -> Measured {
    let mut moved = Moved::undamped()?;
    energy_over_work(&mut moved, Moved::implicitly, 1.0 / 15.0, slow_forces_n())
}

pub(super) fn slow_tissue_rest() -> Measured {
    let mut moved = Moved::undamped()?;
    let held = std::iter::repeat_n(0.1, 10);
    energy_over_work(&mut moved, Moved::implicitly, 1.0 / 15.0, slow_forces_n().chain(held))?;
    let reached_m = moved.skin_m();
    moved.rest()?;
    Ok((reached_m / moved.skin_m() - 1.0).abs())
}

/// Returns the position of the skin every millisecond, in m, while the force grows for 50 ms with
/// `samples` samples per millisecond.
fn ramp_m(samples: u32) -> Result<Vec<f64>, LatticeError> {
    let mut moved = Moved::new(Damping { mass_per_s: 200.0, stiffness_s: 0.0 })?;
    let mut depths_m = Vec::new();
    for sample in 1..=50 * samples {
        moved.motion.push(0.001 * f64::from(sample) / f64::from(samples));
        moved.explicitly(1e-3 / f64::from(samples))?;
        if sample % samples == 0 {
            depths_m.push(moved.skin_m());
        }
    }
    Ok(depths_m)
}

pub(super) fn rates_displacement() -> Measured {
    let (coarse_m, fine_m) = (ramp_m(1)?, ramp_m(4)?);
    let most_m = largest(fine_m.iter().map(|depth_m| depth_m.abs()));
    Ok(largest(coarse_m.iter().zip(&fine_m).map(|(coarse_m, fine_m)| (coarse_m - fine_m).abs() / most_m)))
}
