//! The hard cases of physics section 8 that concern the force law, each with its bound.
//!
//! They would fail on a law that triggers on velocity, counts ticks, drifts, allows an order that a coarse tick
//! breaks, or believes a broken device.

use mechanics::axial::{AxialInput, AxialOutput, AxialSpec, step};
use mechanics::closed_form;

use crate::scenes::{Leg, Run, in_hold_out_in, layer, paper, training, trocar_through};

const DT: f64 = 1e-3;

fn insert(run: &mut Run, to_m: f64) -> AxialOutput {
    let leg = Leg { start_s: 0.0, duration_s: to_m / 0.01, dt_s: DT, from_m: 0.0, to_m };
    let mut last = AxialOutput::default();
    run.travel(&leg, |_, _, output| last = *output);
    last
}

#[test]
fn a_stab_at_one_metre_per_second_opens_everything_within_a_tick_and_stays_bounded() {
    let mut run = Run::new(training());
    let mut found = Vec::new();
    let mut peak_n: f64 = 0.0;
    let leg = Leg { start_s: 0.0, duration_s: 0.045, dt_s: DT, from_m: -0.002, to_m: 0.043 };
    run.travel(&leg, |run, _, output| {
        found.extend_from_slice(run.ruptures());
        peak_n = peak_n.max(output.total_n());
    });
    let predicted = closed_form::ruptures(&training());
    assert_eq!(found.len(), predicted.len());
    for (found, wanted) in found.iter().zip(&predicted) {
        assert!((0.0..=1e-3 + 1e-12).contains(&(found.x_m - wanted.x_m)), "late by one tick of 1 mm at most");
    }
    // Largest threshold pair + Σ b d · 1 m/s + Σ c d + f, all at once.
    let bound_n = 1.5 + 1.9 + (0.24 + 0.84 + 11.7) + (0.08 + 0.126 + 1.56) + 0.3;
    assert!(peak_n < bound_n, "{peak_n} N");
}

#[test]
fn a_teleport_of_fifty_millimetres_is_one_cascade_and_the_ledger_closes() {
    for target_m in [0.05, 0.0122, 0.0041] {
        let mut run = Run::new(training());
        run.step(0.0, -0.0001);
        run.step(DT, target_m);
        let (dissipated_j, events) = (run.state.ledger.dissipated_j(), run.events());
        assert!(events.starts_with("tip:0"), "{events}");
        let ledger = &run.state.ledger;
        assert!(ledger.closure_error_j().abs() < 1e-12 && dissipated_j > 0.0);
        let after = run.step(2.0 * DT, target_m);
        assert!(run.ruptures().is_empty(), "the cascade was complete");
        assert!(after.total_n() < 6.0 && after.viscous_n.abs() <= 0.0, "{after:?}");
    }
}

#[test]
fn nan_infinite_repeated_and_backward_samples_are_held_without_a_trace() {
    let mut run = Run::new(training());
    let good = insert(&mut run, 0.02);
    let (state, t_s) = (run.state.clone(), 2.0);
    let cases = [
        (t_s + DT, f64::NAN),
        (t_s + DT, f64::INFINITY),
        (t_s + DT, f64::NEG_INFINITY),
        (f64::NAN, 0.02),
        (f64::INFINITY, 0.02),
        (t_s, 0.03),
        (t_s - 0.5, 0.03),
    ];
    for (t_s, x_m) in cases {
        let held = run.step(t_s, x_m);
        assert_eq!(held, AxialOutput { held: true, ..good }, "t = {t_s}, x = {x_m}");
        assert_eq!(run.state, state);
        assert!(run.ruptures().is_empty());
    }
    for path_factor in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
        let input = AxialInput { t_s: t_s + DT, x_m: 0.02, path_factor };
        assert!(step(&run.params, &mut run.state, &mut run.scratch, &input).held);
    }
    assert!(!run.step(t_s + DT, 0.02).held);
}

#[test]
fn a_bad_first_sample_leaves_the_first_good_one_first() {
    let (mut bad, mut clean) = (Run::new(training()), Run::new(training()));
    assert_eq!(bad.step(f64::NAN, 0.0), AxialOutput { held: true, ..AxialOutput::default() });
    assert_eq!(bad.step(0.0, 0.01), clean.step(0.0, 0.01));
}

#[test]
fn missing_samples_are_one_long_tick() {
    let (mut whole, mut gapped) = (Run::new(training()), Run::new(training()));
    for tick in 0..4000_u32 {
        let (t_s, x_m) = (f64::from(tick) * DT, f64::from(tick) * 5e-6);
        let wanted = whole.step(t_s, x_m);
        if !(2000..2100).contains(&tick) {
            let found = gapped.step(t_s, x_m);
            assert!((found.total_n() - wanted.total_n()).abs() < 1e-9, "tick {tick}: {found:?} against {wanted:?}");
        }
    }
}

#[test]
fn a_reversal_inside_the_presliding_zone_is_a_spring() {
    let mut run = Run::new(training());
    let start = insert(&mut run, 0.03);
    // The cap is 1.04 N or so, the zone 1.04 mm wide from end to end; back by 0.2 mm and in again stays within.
    let friction_j = |run: &Run| run.state.ledger.layers.iter().map(|layer| layer.friction_j).sum::<f64>();
    let before_j = friction_j(&run);
    for tick in 1..=400_u32 {
        let back_m = if tick <= 200 { f64::from(tick) * 1e-6 } else { f64::from(400 - tick) * 1e-6 };
        let output = run.step(3.0 + f64::from(tick) * DT, 0.03 - back_m);
        let wanted_n = start.friction_n - 2000.0 * back_m;
        assert!((output.friction_n - wanted_n).abs() < 1e-9, "tick {tick}: {} N", output.friction_n);
    }
    let lost_j = friction_j(&run) - before_j;
    // Backward differences lose ½ k_pre Δx² a tick: 1 nJ each here.
    assert!(lost_j < 400.0 * 1.01e-9, "{lost_j} J");
}

#[test]
fn ten_minutes_hold_neither_creeps_nor_buzzes() {
    let mut run = Run::new(training());
    insert(&mut run, 0.02);
    let settled = run.step(2.5, 0.02);
    let ledger = run.state.ledger.clone();
    for tick in 1..=600_000_u32 {
        assert_eq!(run.step(2.5 + f64::from(tick) * DT, 0.02), settled, "tick {tick}");
    }
    assert_eq!(run.state.ledger, ledger);
}

#[test]
fn duplicate_and_zero_thickness_layers_open_together() {
    let fascia = layer("fascia", [0.0, 400.0, 0.0, 0.8, 1.0, 0.0, 0.2]);
    let spec = trocar_through(vec![
        fascia.clone(),
        fascia.clone(),
        fascia,
        layer("fat", [9.0, 80.0, 0.0, 0.3, 0.4, 0.0, 0.0]),
    ]);
    let mut run = Run::new(spec);
    let mut events = Vec::new();
    run.travel(&Leg { start_s: 0.0, duration_s: 10.0, dt_s: DT, from_m: 0.0, to_m: 0.02 }, |run, _, output| {
        assert!(output.cutting_n <= 0.0, "a layer without thickness has nothing to cut");
        if !run.ruptures().is_empty() {
            events.push(run.events());
        }
    });
    // The fat's boundary lies at the same depth: 2 mm of tent are 0.16 N, not yet its threshold.
    assert_eq!(events, ["tip:0+tip:1+tip:2", "tip:3", "rim:0+rim:1+rim:2", "rim:3"]);
}

#[test]
fn layers_thinner_than_the_rims_distance_open_by_every_tip_before_the_first_rim() {
    let thin = |name, tip, rim| layer(name, [0.3, 1000.0, 0.0, tip, rim, 0.0, 0.0]);
    let spec = trocar_through(vec![thin("a", 0.2, 0.3), thin("b", 0.2, 0.3), thin("c", 0.2, 0.3)]);
    let mut run = Run::new(spec);
    let mut events = Vec::new();
    run.travel(&Leg { start_s: 0.0, duration_s: 5.0, dt_s: DT, from_m: 0.0, to_m: 0.005 }, |run, _, _| {
        if !run.ruptures().is_empty() {
            events.push(run.events());
        }
    });
    assert_eq!(events, ["tip:0", "tip:1", "tip:2", "rim:0", "rim:1", "rim:2"]);
}

#[test]
fn eight_hours_of_strokes_end_where_they_began() {
    let mut run = Run::new(training());
    // A stroke of 20 s at 100 Hz: in to 30 mm and out. The first opens and cuts; from the second on nothing new happens.
    let stroke = |run: &mut Run, number: u32| -> Vec<f64> {
        (0..2000_u32)
            .map(|tick| {
                let x_m = 0.015 - 0.016 * libm::cos(f64::from(tick) * core::f64::consts::TAU / 2000.0);
                run.step(f64::from(number * 2000 + tick) * 0.01, x_m).total_n()
            })
            .collect()
    };
    stroke(&mut run, 0);
    let second = stroke(&mut run, 1);
    for number in 2..1439 {
        stroke(&mut run, number);
    }
    let last = stroke(&mut run, 1439);
    let drift_n = second.iter().zip(&last).map(|(was, is)| (was - is).abs()).fold(0.0, f64::max);
    assert!(drift_n < 1e-8, "{drift_n} N after 8 h");
    let ledger = &run.state.ledger;
    assert!(ledger.closure_error_j().abs() < 1e-9 * ledger.input_j, "{} J", ledger.closure_error_j());
}

/// Every force of in–hold–out–in at a tick rate, at the common instants of 1 kHz. The legs are whole milliseconds.
fn at_rate(spec: AxialSpec, ticks_per_ms: u32) -> Vec<AxialOutput> {
    let mut run = Run::new(spec);
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
    outputs
}

#[test]
fn one_and_four_kilohertz_give_the_same_forces() {
    let (slow, fast) = (at_rate(training(), 1), at_rate(training(), 4));
    assert_eq!(slow.len(), fast.len());
    // Ticks of a rupture, of a reversal and of a boundary between layers differ, by up to one tick of travel.
    let differing = slow.iter().zip(&fast).filter(|(a, b)| (a.total_n() - b.total_n()).abs() > 1e-6).count();
    assert!(differing <= 16, "{differing} of {} instants differ", slow.len());
    let worst_n = slow.iter().zip(&fast).map(|(a, b)| (a.friction_n - b.friction_n).abs()).fold(0.0, f64::max);
    assert!(worst_n < 2000.0 * 0.01 * DT, "friction within one tick of travel: {worst_n} N");
}

/// A handle of 45 g let go at rest at a displacement: its path over two seconds, and how much energy it ever had.
fn release(run: &mut Run, start_s: f64, x_m: f64) -> (f64, f64) {
    let (mut x_m, mut v, mut force_n, mut most_j) = (x_m, 0.0_f64, run.state.last_output().total_n(), 0.0_f64);
    for tick in 1..=2000_u32 {
        v -= force_n / 0.045 * DT;
        x_m += v * DT;
        force_n = run.step(start_s + f64::from(tick) * DT, x_m).total_n();
        let stored_j = run.state.ledger.elastic_j() + run.state.ledger.presliding_j;
        most_j = most_j.max(stored_j + 0.5 * 0.045 * v * v);
    }
    (x_m, most_j)
}

#[test]
fn a_released_handle_takes_no_energy_from_the_tissue_but_what_was_stored() {
    let mut tented = Run::new(training());
    insert(&mut tented, 0.0029);
    let stored_j = tented.state.ledger.elastic_j();
    let (x_m, most_j) = release(&mut tented, 0.29, 0.0029);
    assert!(x_m < 0.0, "an intact skin throws it out");
    assert!(most_j < 1.06 * stored_j, "{most_j} J from {stored_j} J: the integrator's own error is ½ ω dt");

    let mut inserted = Run::new(training());
    insert(&mut inserted, 0.03);
    let (x_m, _) = release(&mut inserted, 3.0, 0.03);
    assert!((0.028..=0.03).contains(&x_m), "friction keeps an inserted needle: {x_m} m");
}

#[test]
fn thresholds_above_any_device_are_reached_as_stated() {
    let mut spec = paper();
    spec.layers.truncate(1);
    spec.layers[0].tip_rupture_n = 12.1;
    let mut run = Run::new(spec);
    let mut forces = Vec::new();
    run.travel(&Leg { start_s: 0.0, duration_s: 20.0, dt_s: DT, from_m: 0.0, to_m: 0.04 }, |run, _, _| {
        forces.extend(run.ruptures().iter().map(|rupture| rupture.force_n));
    });
    assert!((12.1..12.1 + 331.0 * 2.1e-6).contains(&forces[0]), "{forces:?}");
}
