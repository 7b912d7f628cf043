//! Extreme motions and long-lasting motions.

use law::axial::{AxialOutput, ParamError};

use super::{DT, inserted, lateness_m};
use crate::scenes::{AxialRun, Leg, in_hold_out_in, training_axial_spec};
use crate::{Measured, largest};

/// 1 m/s from above the skin to beyond the last rupture.
const STAB: Leg = Leg { start_s: 0.0, duration_s: 0.045, dt_s: DT, from_m: -0.002, to_m: 0.043 };

pub(super) fn stab_lateness() -> Measured {
    Ok(lateness_m(training_axial_spec(), &STAB)? * 1e3)
}

/// The bound, in N: the largest pair of thresholds, Σ b l · 1 m/s, Σ c l and the largest cutting
/// force, for l down to 43 mm: 1.5 + 1.9, 0.24 + 0.84 + 10.14, 0.08 + 0.126 + 1.352 and 0.3.
pub(super) fn stab_force() -> Measured {
    let mut forces_n = Vec::new();
    AxialRun::new(training_axial_spec())?.travel(&STAB, |_, _, output| forces_n.push(output.total_n()));
    Ok(largest(forces_n))
}

/// Positions to which a needle is moved in one tick, in m: below all layers, within them, and where
/// the tip has just opened the skin.
const TELEPORTS_M: [f64; 3] = [0.05, 0.0122, 0.0041];

/// Returns the largest value of `of` for a needle after its teleport to each target.
fn teleport(of: impl Fn(AxialRun, f64) -> f64) -> Measured {
    let mut found = Vec::with_capacity(TELEPORTS_M.len());
    for target_m in TELEPORTS_M {
        let mut run = AxialRun::new(training_axial_spec())?;
        run.step(0.0, -0.0001);
        run.step(DT, target_m);
        found.push(of(run, target_m));
    }
    Ok(largest(found))
}

pub(super) fn teleport_ledger() -> Measured {
    teleport(|run, _| run.state.ledger.closure_error_j().abs())
}

pub(super) fn teleport_energy() -> Measured {
    teleport(|run, _| run.state.ledger.layers.iter().map(|layer| -layer.rupture_j * 1e3).sum())
}

pub(super) fn teleport_afterwards() -> Measured {
    teleport(|mut run, target_m| {
        run.step(2.0 * DT, target_m);
        run.ruptures().len() as f64
    })
}

pub(super) fn teleport_force() -> Measured {
    teleport(|mut run, target_m| run.step(2.0 * DT, target_m).total_n().abs())
}

/// Releases a handle of 45 g at rest at a displacement. Returns its position after two seconds, in
/// m, and the largest total energy of handle and tissue, in J.
fn release(run: &mut AxialRun, x_m: f64) -> (f64, f64) {
    let start_s = x_m / 0.01;
    let (mut x_m, mut v, mut force_n) = (x_m, 0.0_f64, run.state.last_output().total_n());
    let energy_j = |tick: u32| {
        v -= force_n / 0.045 * DT;
        x_m += v * DT;
        force_n = run.step(start_s + f64::from(tick) * DT, x_m).total_n();
        run.state.ledger.elastic_j() + run.state.ledger.presliding_j + 0.5 * 0.045 * v * v
    };
    let most_j = largest((1..=2000).map(energy_j));
    (x_m, most_j)
}

/// Just before the tip opens the skin.
const TENTED_M: f64 = 0.0029;

pub(super) fn release_energy() -> Measured {
    let mut tented = inserted(training_axial_spec(), TENTED_M)?;
    let stored_j = tented.state.ledger.elastic_j();
    Ok(release(&mut tented, TENTED_M).1 / stored_j)
}

pub(super) fn release_depth() -> Measured {
    let (x_m, _) = release(&mut inserted(training_axial_spec(), TENTED_M)?, TENTED_M);
    Ok(libm::fmaximum(x_m, 0.0) * 1e3)
}

pub(super) fn release_inserted() -> Measured {
    let (x_m, _) = release(&mut inserted(training_axial_spec(), 0.03)?, 0.03);
    Ok((x_m - 0.03).abs() * 1e3)
}

/// Moves back by 0.2 mm from 30 mm and in again, and passes each tick with its distance back in m
/// to `see`. The friction's cap there is about 1.04 N, and the presliding zone is 1.04 mm wide from
/// end to end.
fn reverse(run: &mut AxialRun, mut see: impl FnMut(f64, &AxialOutput)) {
    for tick in 1..=400_u32 {
        let back_m = f64::from(tick.min(400 - tick)) * 1e-6;
        see(back_m, &run.step(3.0 + f64::from(tick) * DT, 0.03 - back_m));
    }
}

pub(super) fn reversal_force() -> Measured {
    let mut run = inserted(training_axial_spec(), 0.03)?;
    let start_n = run.state.last_output().friction_n;
    let mut errors_n = Vec::with_capacity(400);
    reverse(&mut run, |back_m, output| errors_n.push((output.friction_n - (start_n - 2000.0 * back_m)).abs()));
    Ok(largest(errors_n))
}

pub(super) fn reversal_loss() -> Measured {
    let mut run = inserted(training_axial_spec(), 0.03)?;
    let friction_j = |run: &AxialRun| run.state.ledger.layers.iter().map(|layer| layer.friction_j).sum::<f64>();
    let before_j = friction_j(&run);
    reverse(&mut run, |_, _| ());
    Ok(friction_j(&run) - before_j)
}

/// Holds for ten minutes at 20 mm after an insertion and half a second of rest; returns the largest
/// change of `of`.
fn hold(of: impl Fn(&AxialRun) -> f64) -> Measured {
    let mut run = inserted(training_axial_spec(), 0.02)?;
    run.step(2.5, 0.02);
    let settled = of(&run);
    Ok(largest((1..=600_000_u32).map(|tick| {
        run.step(2.5 + f64::from(tick) * DT, 0.02);
        (of(&run) - settled).abs()
    })))
}

pub(super) fn hold_force() -> Measured {
    hold(|run| run.state.last_output().total_n())
}

pub(super) fn hold_energy() -> Measured {
    let stored_j = hold(|run| run.state.ledger.elastic_j() + run.state.ledger.presliding_j)?;
    let dissipated_j = hold(|run| run.state.ledger.dissipated_j())?;
    Ok(largest([stored_j, dissipated_j]))
}

/// Simulates eight hours of strokes of 20 s at 100 Hz, in to 30 mm and out; returns the forces of
/// the second and of the last stroke, in N. The first opens and cuts; from the second on the state
/// is periodic.
fn hours() -> Result<(AxialRun, [Vec<f64>; 2]), ParamError> {
    let mut run = AxialRun::new(training_axial_spec())?;
    let mut stroke = |number: u32| -> Vec<f64> {
        let force_n = |tick: u32| {
            let x_m = 0.015 - 0.016 * libm::cos(f64::from(tick) * core::f64::consts::TAU / 2000.0);
            run.step(f64::from(number * 2000 + tick) * 0.01, x_m).total_n()
        };
        (0..2000).map(force_n).collect()
    };
    stroke(0);
    let second_n = stroke(1);
    for number in 2..1439 {
        stroke(number);
    }
    let last_n = stroke(1439);
    Ok((run, [second_n, last_n]))
}

pub(super) fn hours_drift() -> Measured {
    let (_, [second_n, last_n]) = hours()?;
    Ok(largest(second_n.iter().zip(&last_n).map(|(was, is)| (was - is).abs())))
}

pub(super) fn hours_ledger() -> Measured {
    let ledger = hours()?.0.state.ledger;
    Ok(ledger.closure_error_j().abs() / ledger.input_j)
}

/// Returns every force of in–hold–out–in at a tick rate, at the instants of 1 kHz. The legs are
/// whole milliseconds.
fn at_rate(ticks_per_ms: u32) -> Result<Vec<AxialOutput>, ParamError> {
    let mut run = AxialRun::new(training_axial_spec())?;
    let mut outputs = Vec::new();
    for leg in in_hold_out_in() {
        let leg = Leg { dt_s: DT / f64::from(ticks_per_ms), ..leg };
        let mut tick = 0;
        run.travel(&leg, |_, _, output| {
            if tick % ticks_per_ms == 0 {
                outputs.push(*output);
            }
            tick += 1;
        });
    }
    Ok(outputs)
}

pub(super) fn rates_instants() -> Measured {
    let (slow, fast) = (at_rate(1)?, at_rate(4)?);
    let same = |(slow, fast): &(&AxialOutput, &AxialOutput)| (slow.total_n() - fast.total_n()).abs() <= 1e-6;
    let alike = slow.iter().zip(&fast).filter(same).count();
    Ok((slow.len().max(fast.len()) - alike) as f64)
}

pub(super) fn rates_friction() -> Measured {
    let apart_mn = |(slow, fast): (AxialOutput, AxialOutput)| (slow.friction_n - fast.friction_n).abs() * 1e3;
    Ok(largest(at_rate(1)?.into_iter().zip(at_rate(4)?).map(apart_mn)))
}
