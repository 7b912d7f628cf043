//! Large rotations and motion: loads that jump, and inverted blocks.

use tissue::FieldModel;
use tissue::volumetric::{Corotational, Effort, Patch, Problem3, TissueMotion, VolumetricError};

use super::{block, coarse, lower_back, problem};
use crate::{Measured, largest};

/// Iteration limit and tolerance of a step.
const EFFORT: Effort = Effort { iterations: 30, tolerance: 1e-4 };

/// The tissue over time, with statistics of its energy.
struct WatchedTissue {
    tissue: Corotational,
    /// Largest energy so far, in J.
    most_j: f64,
    /// Largest energy that a step has added beyond the load's work, relative to `most_j`.
    growth: f64,
}

impl WatchedTissue {
    /// Creates the lower back at rest, with a time step in s.
    fn new(step_s: f64) -> Result<Self, VolumetricError> {
        let problem = Problem3::flat(&problem(lower_back()));
        let patch = Patch::new(&problem, &coarse(&problem))?;
        let tissue = Corotational::new(patch, Some(step_s), EFFORT)?;
        Ok(Self { tissue, most_j: f64::MIN_POSITIVE, growth: f64::NEG_INFINITY })
    }

    /// Returns elastic and kinetic energy, in J.
    fn energy_j(&self) -> f64 {
        let energies = self.tissue.energies();
        energies.elastic_j + energies.kinetic_j
    }

    /// Returns the work of a load of 1 N since rest, in J/N.
    fn way_m(&self) -> f64 {
        self.tissue.patch().load().iter().zip(self.tissue.motion().u_m()).map(|(load, u)| load * u).sum()
    }

    fn step(&mut self, force_n: f64) {
        let (before_j, from_m) = (self.energy_j(), self.way_m());
        self.tissue.solve(force_n);
        let (after_j, to_m) = (self.energy_j(), self.way_m());
        self.most_j = largest([self.most_j, after_j, (force_n * to_m).abs()]);
        self.growth = largest([self.growth, (after_j - before_j - force_n * (to_m - from_m)) / self.most_j]);
    }
}

/// Skin of 331 N/m, contacted at 1 m/s and 1 kHz, which ruptures at 1 N; 0.2 s.
pub(super) fn stab_growth() -> Measured {
    let mut back = WatchedTissue::new(1e-3)?;
    for tick in 0..200 {
        let force_n = 0.331 * f64::from(tick);
        back.step(if force_n < 1.0 { force_n } else { 0.0 });
    }
    Ok(back.growth)
}

/// From zero to 5 N in one step, held for 0.1 s.
pub(super) fn teleport_growth() -> Measured {
    let mut back = WatchedTissue::new(1e-3)?;
    for _ in 0..100 {
        back.step(5.0);
    }
    Ok(back.growth)
}

/// 0 if 20 N at once are balanced, or refused together with a load that is: more would crush the
/// tissue under a needle of 1 mm.
pub(super) fn teleport_refused() -> Measured {
    let problem = Problem3::flat(&problem(lower_back()));
    let patch = Patch::new(&problem, &coarse(&problem))?;
    let mut tissue = Corotational::new(patch, None, EFFORT)?;
    tissue.solve(20.0);
    let moved_m = tissue.displacement_m(0.0, 0.0)[0];
    let told = match tissue.check() {
        Ok(()) => tissue.last().converged,
        Err(refused) => {
            // The load reported as balanced must be balanced: applying it changes nothing.
            tissue.solve(refused.held_n);
            refused.held_n > 0.0 && tissue.check().is_ok() && tissue.last().iterations == 0
        }
    };
    Ok(if told && moved_m < 0.0 { 0.0 } else { 1.0 })
}

/// 0.3 N for 0.1 s, then zero for 0.2 s.
fn released() -> Result<(WatchedTissue, f64), VolumetricError> {
    let mut back = WatchedTissue::new(1e-3)?;
    for _ in 0..100 {
        back.step(0.3);
    }
    let held_j = back.energy_j();
    for _ in 0..200 {
        back.step(0.0);
    }
    let left = back.energy_j() / held_j;
    Ok((back, left))
}

pub(super) fn release_growth() -> Measured {
    Ok(released()?.0.growth)
}

pub(super) fn release_left() -> Measured {
    Ok(released()?.1)
}

/// Ten minutes at 5 Hz under the same load, without the first ten seconds.
pub(super) fn hold_moving() -> Measured {
    let mut tissue = WatchedTissue::new(0.2)?.tissue;
    for _ in 0..50 {
        tissue.solve(0.3);
    }
    let rest_m = tissue.displacement_m(0.0, 0.0)[0];
    let mut change_m = 0.0;
    for _ in 50..600 * 5 {
        tissue.solve(0.3);
        change_m = largest([change_m, (tissue.displacement_m(0.0, 0.0)[0] - rest_m).abs()]);
    }
    Ok(change_m)
}

/// An inverted block, released: the remaining share of its energy, and the largest share that a
/// step added.
fn inverted() -> Result<[f64; 2], VolumetricError> {
    let body = block([0.02, 0.02, 0.02], true)?;
    let mut motion = TissueMotion::new(&body, Some(5e-3), EFFORT)?;
    motion.displace(&body.interpolate_m(|point| nalgebra::Vector3::new(0.3 * point.z, 0.0, -1.7 * point.z)));
    let nothing = vec![0.0; body.unknowns()];
    let energy_j = |motion: &TissueMotion| {
        let energies = motion.energies(&body);
        energies.elastic_j + energies.kinetic_j
    };
    let first_j = energy_j(&motion);
    let (mut now_j, mut growth) = (first_j, f64::NEG_INFINITY);
    for _ in 0..300 {
        motion.step(&body, &nothing);
        let next_j = energy_j(&motion);
        growth = largest([growth, (next_j - now_j) / first_j]);
        now_j = next_j;
    }
    Ok([now_j / first_j, growth])
}

pub(super) fn inverted_left() -> Measured {
    Ok(inverted()?[0])
}

pub(super) fn inverted_growth() -> Measured {
    Ok(inverted()?[1])
}

/// A load that grows at 1 kHz to 0.3 N in 0.5 s and is constant for 1 s, sampled at 15 Hz.
fn rated() -> Result<WatchedTissue, VolumetricError> {
    let mut back = WatchedTissue::new(1.0 / 15.0)?;
    let mut seen = 0;
    for tick in 0..1500_u32 {
        let latest_n = 0.3 * (f64::from(tick) / 500.0).min(1.0);
        if tick * 15 >= seen * 1000 {
            back.step(latest_n);
            seen += 1;
        }
    }
    Ok(back)
}

pub(super) fn rate_growth() -> Measured {
    Ok(rated()?.growth)
}

pub(super) fn rate_left() -> Measured {
    let moving = rated()?.tissue;
    let mut still = Corotational::new(moving.patch().clone(), None, Effort { iterations: 100, tolerance: 1e-6 })?;
    still.solve(0.3);
    let [u, wanted] = [&moving, &still].map(|tissue| tissue.displacement_m(0.0, 0.0)[0]);
    Ok((u / wanted - 1.0).abs())
}
