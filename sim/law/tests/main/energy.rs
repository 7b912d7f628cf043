//! The energy ledger (physics section 7): it closes, what is dissipated never comes back, and it agrees with ∫F dx of the
//! forces that the hand felt.
//!
//! It would fail if a rupture, a shrinking friction cap or a withdrawal lost or made energy, or if the ledger closed
//! only because it booked something else than the forces.

use law::Incidence;
use law::axial::{AxialOutput, AxialSpec};
use law::ledger::{LayerEnergy, Ledger};
use trials::scenes::{
    AxialRun, Leg, in_hold_out_in, make_layer, paper_axial_spec, training_axial_spec, trocar_through,
};

/// Training layers with a fascia of no thickness between fat and muscle.
fn with_fascia() -> AxialSpec {
    let mut layers = training_axial_spec().layers;
    layers.insert(2, make_layer("fascia", [0.0, 600.0, 0.0, 2.0, 2.6, 0.0, 0.0]));
    trocar_through(layers)
}

fn scenes() -> [(&'static str, AxialSpec, f64); 4] {
    [
        ("paper", paper_axial_spec(), 1.0),
        ("training", training_axial_spec(), 1.0),
        ("fascia", with_fascia(), 1.0),
        ("oblique", training_axial_spec(), 1.3),
    ]
}

/// In, hold, out, in, handing every tick to `see`.
fn perform(spec: AxialSpec, path_factor: f64, mut see: impl FnMut(&AxialRun, f64, &AxialOutput)) -> AxialRun {
    let mut run = AxialRun::new(spec).expect("a valid scene");
    run.incidence = Incidence::of_factor(path_factor);
    for leg in in_hold_out_in() {
        run.travel(&leg, &mut see);
    }
    run
}

fn parts(layer: &LayerEnergy) -> [f64; 4] {
    [layer.rupture_j, layer.viscous_j, layer.friction_j, layer.cutting_j]
}

#[test]
fn the_ledger_closes_at_every_tick_to_a_thousandth_of_the_input() {
    for (name, spec, factor) in scenes() {
        let run = perform(spec, factor, |run, x_m, _| {
            let ledger = &run.state.ledger;
            let error_j = ledger.closure_error_j().abs();
            assert!(error_j <= 1e-3 * ledger.input_j + 1e-15, "{name} at {x_m} m: {error_j} J");
        });
        assert!(run.state.ledger.input_j > 1e-3, "{name}: the hand did no work");
    }
}

#[test]
fn no_part_of_any_layers_dissipation_ever_decreases() {
    for (name, spec, factor) in scenes() {
        let mut before = Ledger::new(spec.layers.len());
        perform(spec, factor, |run, x_m, _| {
            for (was, is) in before.layers.iter().zip(&run.state.ledger.layers) {
                assert!(parts(was).iter().zip(parts(is)).all(|(was, is)| is >= *was), "{name} at {x_m} m: {is:?}");
            }
            before.clone_from(&run.state.ledger);
        });
    }
}

/// In to 45 mm and out again at 5 mm/s, at a tick rate in Hz.
fn in_and_out(tick_hz: f64) -> Ledger {
    let mut run = AxialRun::new(training_axial_spec()).expect("a valid scene");
    for (start_s, from_m, to_m) in [(0.0, -0.001, 0.045), (9.2, 0.045, -0.001)] {
        run.travel(&Leg { start_s, duration_s: 9.2, dt_s: 1.0 / tick_hz, from_m, to_m }, |_, _, _| ());
    }
    run.state.ledger
}

#[test]
fn friction_cutting_and_their_layers_do_not_depend_on_the_tick() {
    let fine = in_and_out(16_000.0);
    for tick_hz in [250.0, 1000.0] {
        let coarse = in_and_out(tick_hz);
        for (name, part) in [("friction", 2), ("cutting", 3)] {
            let sum = |ledger: &Ledger| ledger.layers.iter().map(|layer| parts(layer)[part]).sum::<f64>();
            let error = sum(&coarse) / sum(&fine) - 1.0;
            assert!(error.abs() < 1e-3, "{name} at {tick_hz} Hz is off by {:.3} %", error * 100.0);
        }
    }
}

#[test]
fn a_window_of_speed_may_give_back_and_the_ledger_says_how_much() {
    let spec = AxialSpec { speed_window_s: 0.0075, ..training_axial_spec() };
    let (mut viscous_j, mut lagged_j) = (0.0, 0.0);
    let mut run = AxialRun::new(spec).expect("a valid scene");
    let mut see = |run: &AxialRun, x_m: f64, _: &AxialOutput| {
        let ledger = &run.state.ledger;
        let now_j: f64 = ledger.layers.iter().map(|layer| layer.viscous_j).sum();
        let back_j: f64 = viscous_j - now_j;
        assert!(back_j <= ledger.lagged_j - lagged_j + 1e-15, "at {x_m} m: {back_j} J came back unsaid");
        (viscous_j, lagged_j) = (now_j, ledger.lagged_j);
    };
    // In at 50 mm/s and at once back.
    for (start_s, from_m, to_m) in [(0.0, -0.002, 0.038), (0.8, 0.038, -0.002)] {
        run.travel(&Leg { start_s, duration_s: 0.8, dt_s: 1e-3, from_m, to_m }, &mut see);
    }
    let ledger = &run.state.ledger;
    assert!(ledger.lagged_j > 0.0, "turning about within a window must be seen");
    assert!(ledger.lagged_j < 1e-3 * ledger.input_j, "{} J of {} J", ledger.lagged_j, ledger.input_j);
    assert!(ledger.closure_error_j().abs() < 1e-9 * ledger.input_j);
}

#[test]
fn input_minus_returned_energy_is_the_integral_of_hand_force() {
    for (name, spec, factor) in scenes() {
        let (mut work_j, mut x_before_m, mut force_before_n) = (0.0, -0.002, 0.0);
        let run = perform(spec, factor, |run, x_m, output| {
            // A rupture falls between two ticks: the force held up to it, so the trapezium would miss half of the drop.
            let force_n = output.total_n();
            let mean_n = if run.ruptures().is_empty() { 0.5 * (force_before_n + force_n) } else { force_before_n };
            work_j += mean_n * (x_m - x_before_m);
            (x_before_m, force_before_n) = (x_m, force_n);
        });
        let ledger = &run.state.ledger;
        let booked_j = ledger.input_j - ledger.returned_j;
        assert!((booked_j - work_j).abs() < 2e-3 * ledger.input_j, "{name}: {booked_j} J booked, {work_j} J felt");
    }
}

#[test]
fn slow_rupture_dissipates_the_energy_of_the_closed_form() {
    let predicted = law::closed_form::predict_ruptures(&paper_axial_spec());
    let mut found = Vec::new();
    let leg = Leg { start_s: 0.0, duration_s: 20.0, dt_s: 1e-3, from_m: 0.0, to_m: 0.02 };
    let mut run = AxialRun::new(paper_axial_spec()).expect("a valid scene");
    run.travel(&leg, |run, _, _| found.extend_from_slice(run.ruptures()));
    assert_eq!(found.len(), predicted.len());
    for (found, wanted) in found.iter().zip(&predicted) {
        let wanted_j = wanted.energy_before_j - wanted.energy_after_j;
        assert!((found.dissipated_j - wanted_j).abs() < 2e-3 * wanted_j, "{found:?} against {wanted_j} J");
    }
    let booked: f64 = run.state.ledger.layers.iter().map(|layer| layer.rupture_j).sum();
    assert!((booked - found.iter().map(|rupture| rupture.dissipated_j).sum::<f64>()).abs() < 1e-15);
}

#[test]
fn tenting_without_rupture_gives_all_its_work_back() {
    let mut run = AxialRun::new(paper_axial_spec()).expect("a valid scene");
    for (start_s, from_m, to_m) in [(0.0, -0.001, 0.003), (1.0, 0.003, -0.001)] {
        run.travel(&Leg { start_s, duration_s: 0.999, dt_s: 1e-3, from_m, to_m }, |_, _, _| ());
    }
    let ledger = &run.state.ledger;
    // ½ · 331 N/m · (3 mm)².
    assert!((ledger.input_j - 1.4895e-3).abs() < 1e-9, "{}", ledger.input_j);
    assert!((ledger.returned_j - ledger.input_j).abs() < 1e-15);
    assert!(ledger.dissipated_j() <= 0.0);
}

#[test]
fn a_withdrawn_needle_has_dissipated_in_every_layer_it_passed() {
    let mut run = AxialRun::new(training_axial_spec()).expect("a valid scene");
    for leg in &in_hold_out_in()[..3] {
        run.travel(leg, |_, _, _| ());
    }
    let ledger = &run.state.ledger;
    for (layer, energy) in run.params.spec().layers.iter().zip(&ledger.layers) {
        let [rupture_j, viscous_j, friction_j, cutting_j] = parts(energy);
        assert!(rupture_j > 0.0 && viscous_j > 0.0 && friction_j > 0.0, "{}: {energy:?}", layer.name);
        assert!(cutting_j > 0.0, "{}", layer.name);
    }
}
