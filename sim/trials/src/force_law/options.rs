//! The options of version 3, each alone and all together, in the hard cases of the plain law.

use law::axial::{AxialOutput, AxialSpec, Breakaway, ForceLaw, LayerOptions, MaxwellBranch, ParamError};
use law::ledger::{LayerEnergy, Ledger};

use super::DT;
use crate::scenes::{AxialRun, Leg, OPTION_SETS, make_layer, needle_through, training_axial_spec, with_options};
use crate::{Measured, largest};

/// Returns the largest measurement in the training scene over every option alone and all together.
fn worst(measure: impl Fn(AxialSpec) -> Measured) -> Measured {
    OPTION_SETS.iter().try_fold(f64::NEG_INFINITY, |worst, options| {
        Ok(libm::fmaximum(worst, measure(with_options(training_axial_spec(), options))?))
    })
}

/// A wall that does not rupture, with branches of 0.1 s, 1 s and 30 s.
fn relaxing_wall() -> AxialSpec {
    let mut wall = make_layer("wall", [100.0, 300.0, 0.0, 50.0, 50.0, 0.0, 0.0]);
    let branch = |share, time_s| MaxwellBranch { share, time_s };
    wall.options = LayerOptions {
        branches: vec![branch(0.5, 0.1), branch(0.4, 1.0), branch(0.3, 30.0)],
        ..LayerOptions::default()
    };
    AxialSpec { law: ForceLaw::Version3, ..needle_through(vec![wall]) }
}

/// Returns the force of the wall after ramps of constant speed, each with a duration in s and a
/// speed in m/s, in closed form, in N.
fn wall_force_n(spec: &AxialSpec, ramps: &[[f64; 2]]) -> f64 {
    let layer = &spec.layers[0];
    let k = layer.stiffness_n_per_m;
    let dent_m: f64 = ramps.iter().map(|[seconds, speed]| seconds * speed).sum();
    let branch_n = |branch: &MaxwellBranch| {
        ramps.iter().fold(0.0, |q, [seconds, speed]| {
            let left = libm::exp(-seconds / branch.time_s);
            q * left + branch.share * k * branch.time_s * speed * (1.0 - left)
        })
    };
    k * dent_m + layer.options.branches.iter().map(branch_n).sum::<f64>()
}

/// In by 3 mm in a second, then held for ten minutes: largest deviation of the force from its
/// closed form, in N.
pub(super) fn relaxed_hold_force() -> Measured {
    let spec = relaxing_wall();
    let mut run = AxialRun::new(spec.clone())?;
    run.travel(&Leg { start_s: 0.0, duration_s: 1.0, dt_s: DT, from_m: 0.0, to_m: 0.003 }, |_, _, _| ());
    Ok(largest((1..=600_000_u32).map(|tick| {
        let held_s = f64::from(tick) * DT;
        let found_n = run.step(1.0 + held_s, 0.003).tip_n;
        (found_n - wall_force_n(&spec, &[[1.0, 0.003], [held_s, 0.0]])).abs()
    })))
}

/// The same hold with options after 11 mm: the largest rise of the force in a tick, in N.
pub(super) fn optioned_hold_rise() -> Measured {
    worst(hold_rise)
}

fn hold_rise(spec: AxialSpec) -> Measured {
    let mut run = AxialRun::new(spec)?;
    run.travel(&Leg { start_s: 0.0, duration_s: 1.1, dt_s: DT, from_m: 0.0, to_m: 0.011 }, |_, _, _| ());
    let mut before_n = run.step(1.1 + DT, 0.011).total_n();
    Ok(largest((2..=600_000_u32).map(|tick| {
        let now_n = run.step(1.1 + f64::from(tick) * DT, 0.011).total_n();
        now_n - std::mem::replace(&mut before_n, now_n)
    })))
}

/// In for 50 ms and back for 30 ms, within the second branch's time and beyond half of the first
/// one's: deviation from the closed form, in N.
pub(super) fn relaxed_reversal_force() -> Measured {
    let spec = relaxing_wall();
    let mut run = AxialRun::new(spec.clone())?;
    run.step(0.0, 0.0);
    Ok(largest((1..=80_u32).map(|tick| {
        let (inwards_s, back_s) = (f64::from(tick.min(50)) * DT, f64::from(tick.saturating_sub(50)) * DT);
        let found_n = run.step(f64::from(tick) * DT, 0.04 * inwards_s - 0.02 * back_s).tip_n;
        (found_n - wall_force_n(&spec, &[[inwards_s, 0.04], [back_s, -0.02]])).abs()
    })))
}

/// An indentation of 4 mm held for a minute and withdrawn in 10 ms: the smallest force on the way
/// out, in N, with a positive sign if it pulls.
pub(super) fn relaxed_pull() -> Measured {
    let mut run = AxialRun::new(relaxing_wall())?;
    let mut pulls_n = Vec::new();
    for (start_s, duration_s, from_m, to_m) in
        [(0.0, 1.0, 0.0, 0.004), (1.0, 60.0, 0.004, 0.004), (61.0, 0.01, 0.004, -0.001)]
    {
        run.travel(&Leg { start_s, duration_s, dt_s: DT, from_m, to_m }, |_, _, output| {
            pulls_n.push(-output.total_n())
        });
    }
    Ok(largest(pulls_n) + run.state.ledger.elastic_j())
}

/// A stab at 1 m/s with options. The bound, in N, is that of the training scene with 1.6 times its
/// friction.
pub(super) fn optioned_stab_force() -> Measured {
    worst(|spec| {
        let mut forces_n = Vec::new();
        let stab = Leg { start_s: 0.0, duration_s: 0.045, dt_s: DT, from_m: -0.002, to_m: 0.043 };
        AxialRun::new(spec)?.travel(&stab, |_, _, output| forces_n.push(output.total_n()));
        Ok(largest(forces_n))
    })
}

/// In by 12 mm at 20 mm/s and back by 0.2 mm in a tenth of a second, too little to break the shaft
/// away or restore it: difference between the ledger's input minus the returned energy and the work
/// of the force along the path, relative to the input. A tick advances at most 2 µm.
pub(super) fn optioned_reversal_work() -> Measured {
    worst(|spec| {
        let mut run = AxialRun::new(spec)?;
        let (mut work_j, mut before) = (0.0, None::<(f64, f64)>);
        for (start_s, duration_s, from_m, to_m) in
            [(0.0, 0.6, 0.0, 0.012), (0.6, 0.1, 0.012, 0.0118), (0.7, 0.1, 0.0118, 0.012)]
        {
            run.travel(&Leg { start_s, duration_s, dt_s: 1e-4, from_m, to_m }, |_, x_m, output| {
                let force_n = output.total_n();
                if let Some((was_m, was_n)) = before.replace((x_m, force_n)) {
                    work_j += 0.5 * (force_n + was_n) * (x_m - was_m);
                }
            });
        }
        let ledger = &run.state.ledger;
        Ok((ledger.input_j - ledger.returned_j - work_j).abs() / ledger.input_j)
    })
}

/// Number of ticks of a 20 s stroke.
const STROKE: u32 = 500;

/// Simulates eight hours of strokes of 20 s at 25 Hz with options; returns the forces of the second
/// and of the last stroke, in N.
fn hours(spec: AxialSpec) -> Result<(AxialRun, [Vec<f64>; 2]), ParamError> {
    let mut run = AxialRun::new(spec)?;
    let mut stroke = |number: u32| -> Vec<f64> {
        let force_n = |tick: u32| {
            let x_m = 0.015 - 0.016 * libm::cos(f64::from(tick) * core::f64::consts::TAU / f64::from(STROKE));
            run.step(f64::from(number * STROKE + tick) * 0.04, x_m).total_n()
        };
        (0..STROKE).map(force_n).collect()
    };
    stroke(0);
    let second_n = stroke(1);
    for number in 2..1439 {
        stroke(number);
    }
    let last_n = stroke(1439);
    Ok((run, [second_n, last_n]))
}

pub(super) fn optioned_hours_drift() -> Measured {
    worst(|spec| {
        let (_, [second_n, last_n]) = hours(spec)?;
        Ok(largest(second_n.iter().zip(&last_n).map(|(was, is)| (was - is).abs())))
    })
}

pub(super) fn optioned_hours_ledger() -> Measured {
    worst(|spec| {
        let ledger = hours(spec)?.0.state.ledger;
        Ok(ledger.closure_error_j().abs() / ledger.input_j)
    })
}

/// In to 40 mm, held, out and in again with options at a rate in Hz; returns the run, and the force
/// every 4 ms.
fn at_rate(spec: AxialSpec, tick_hz: u32) -> Result<(AxialRun, Vec<AxialOutput>), ParamError> {
    let mut run = AxialRun::new(spec)?;
    let mut outputs = Vec::new();
    for (start_s, duration_s, from_m, to_m) in
        [(0.0, 4.2, -0.002, 0.04), (4.2, 2.0, 0.04, 0.04), (6.2, 4.2, 0.04, -0.002), (10.4, 4.4, -0.002, 0.042)]
    {
        let mut tick = 0;
        let leg = Leg { start_s, duration_s, dt_s: 1.0 / f64::from(tick_hz), from_m, to_m };
        run.travel(&leg, |_, _, output| {
            if tick % (tick_hz / 250) == 0 {
                outputs.push(*output);
            }
            tick += 1;
        });
    }
    Ok((run, outputs))
}

/// Returns the largest relative difference of `of` of the ledger between 250 Hz and 4 kHz.
fn apart<const N: usize>(of: fn(&Ledger) -> [f64; N]) -> Measured {
    worst(|spec| {
        let (slow, fast) = (of(&at_rate(spec.clone(), 250)?.0.state.ledger), of(&at_rate(spec, 4000)?.0.state.ledger));
        Ok(largest(slow.iter().zip(fast).map(|(slow, fast)| (slow / fast - 1.0).abs())))
    })
}

fn sum_j(ledger: &Ledger, of: fn(&LayerEnergy) -> f64) -> f64 {
    ledger.layers.iter().map(of).sum()
}

pub(super) fn optioned_rates_energy() -> Measured {
    apart(|ledger| {
        let parts: [fn(&LayerEnergy) -> f64; 3] = [|e| e.viscous_j, |e| e.friction_j, |e| e.cutting_j];
        let [viscous_j, friction_j, cutting_j] = parts.map(|of| sum_j(ledger, of));
        [ledger.input_j, viscous_j, friction_j, cutting_j]
    })
}

/// A rupture is detected up to a tick late, 40 µm at 250 Hz and 10 mm/s, when the indentation of a
/// few mm stores correspondingly more energy.
pub(super) fn optioned_rates_rupture() -> Measured {
    apart(|ledger| [sum_j(ledger, |e| e.rupture_j)])
}

/// The force at 250 Hz compared with that at 4 kHz: root mean square of the difference, relative to
/// that of the force.
pub(super) fn optioned_rates_force() -> Measured {
    worst(|spec| {
        let (slow, fast) = (at_rate(spec.clone(), 250)?.1, at_rate(spec, 4000)?.1);
        let pairs = || slow.iter().zip(&fast).map(|(slow, fast)| (slow.total_n(), fast.total_n()));
        let apart: f64 = pairs().map(|(slow, fast)| (slow - fast) * (slow - fast)).sum();
        let whole: f64 = pairs().map(|(_, fast)| fast * fast).sum();
        Ok((apart / whole).sqrt())
    })
}

/// Tremor of 0.1 mm around 20 mm with a needle held by static friction: the dissipated energy, in
/// µJ. The spring stays below its cap.
pub(super) fn static_tremor() -> Measured {
    let mut muscle = make_layer("muscle", [100.0, 300.0, 0.0, 0.0, 0.0, 50.0, 0.0]);
    muscle.options.static_friction_n_per_m = Some(80.0);
    let spec = AxialSpec {
        law: ForceLaw::Version3,
        breakaway: Some(Breakaway { slid_m: 0.5e-3, rest_s: 1.0 }),
        ..needle_through(vec![muscle])
    };
    let mut run = AxialRun::new(spec)?;
    run.travel(&Leg { start_s: 0.0, duration_s: 2.0, dt_s: DT, from_m: -0.001, to_m: 0.02 }, |_, _, _| ());
    let lost_j = |run: &AxialRun| run.state.ledger.dissipated_j();
    let mut rested = None;
    for tick in 1..=20_000_u32 {
        let t_s = f64::from(tick) * DT;
        let x_m = 0.02 - 0.5e-4 * (1.0 - libm::cos(t_s * 10.0 * core::f64::consts::TAU));
        run.step(2.0 + t_s, x_m);
        rested = rested.or(Some(lost_j(&run)));
    }
    Ok((lost_j(&run) - rested.unwrap_or_default()) * 1e6)
}
