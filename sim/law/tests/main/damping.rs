//! Damping by a spring and a dashpot, version 5 of the law: what it does when held, moved, pushed in and drawn out, and where its energy goes.
//!
//! It would fail on a force that follows speed, on a spring that keeps its force where damping shrinks or its strain where it grows, and on a
//! loss that depends on the tick.

use law::axial::{AxialSpec, ForceLaw};
use law::ledger::Ledger;
use trials::scenes::{AxialRun, Leg, make_layer, needle_through, training_axial_spec};

const TIME_S: f64 = 0.01;
const TICK_S: f64 = 1e-3;

/// One layer that opens at once and only damps: 40 mm with 250 N·s/m².
fn damping_only() -> AxialSpec {
    let layer = make_layer("gel", [40.0, 1.0, 250.0, 0.0, 0.0, 0.0, 0.0]);
    AxialSpec { law: ForceLaw::Version5, damping_time_s: TIME_S, ..needle_through(vec![layer]) }
}

/// A needle at rest 30 mm deep, where B = 7.5 N·s/m, and the time in s.
fn at_rest() -> (AxialRun, f64) {
    let mut run = AxialRun::new(damping_only()).expect("a valid scene");
    run.travel(&Leg { start_s: 0.0, duration_s: 1.0, dt_s: TICK_S, from_m: -0.001, to_m: 0.03 }, |_, _, _| ());
    run.travel(&Leg { start_s: 1.0, duration_s: 1.0, dt_s: TICK_S, from_m: 0.03, to_m: 0.03 }, |_, _, _| ());
    (run, 2.0)
}

fn lost_j(ledger: &Ledger) -> f64 {
    ledger.layers.iter().map(|layer| layer.viscous_j).sum()
}

fn close(found: f64, wanted: f64) {
    assert!((found / wanted - 1.0).abs() < 1e-9, "{found} is not {wanted}");
}

#[test]
fn held_force_decays_by_e_in_its_time_and_loses_stored_energy() {
    let (mut run, t_s) = at_rest();
    let pushed = run.step(t_s + TICK_S, 0.03 + 1e-4);
    let (stored_j, before_j) = (run.state.ledger.presliding_j, lost_j(&run.state.ledger));
    close(stored_j, pushed.viscous_n * pushed.viscous_n * TIME_S / (2.0 * 250.0 * 0.0301));
    let held = run.step(t_s + TICK_S + TIME_S, 0.03 + 1e-4);
    close(held.viscous_n, pushed.viscous_n * libm::exp(-1.0));
    let still_j = run.state.ledger.presliding_j;
    close(lost_j(&run.state.ledger) - before_j, stored_j - still_j);
}

/// Slow enough that damping grows by nothing within its time.
#[test]
fn at_a_steady_speed_it_is_the_dashpot() {
    let (mut run, t_s) = at_rest();
    let mut last = run.state.last_output();
    let leg = Leg { start_s: t_s, duration_s: 1.0, dt_s: TICK_S, from_m: 0.03, to_m: 0.0301 };
    run.travel(&leg, |_, _, output| last = *output);
    let wanted_n = 250.0 * 0.0301 * 1e-4;
    assert!((last.viscous_n / wanted_n - 1.0).abs() < 1e-3, "{} N is not {wanted_n} N", last.viscous_n);
}

#[test]
fn more_damping_keeps_the_force_and_less_keeps_the_strain() {
    let (mut run, t_s) = at_rest();
    let pushed_n = run.step(t_s + TICK_S, 0.032).viscous_n;
    let u = -libm::expm1(-0.1);
    let moved_n = |b: f64, way_m: f64| b / TIME_S * way_m * (u / 0.1);
    close(pushed_n, moved_n(250.0 * 0.032, 0.002));
    let mut deeper = run.state.clone();
    std::mem::swap(&mut run.state, &mut deeper);
    close(run.step(t_s + 2.0 * TICK_S, 0.034).viscous_n, pushed_n * (1.0 - u) + moved_n(250.0 * 0.034, 0.002));
    run.state = deeper;
    let drawn_n = run.step(t_s + 2.0 * TICK_S, 0.028).viscous_n;
    close(drawn_n, pushed_n * (28.0 / 32.0) * (1.0 - u) + moved_n(250.0 * 0.028, -0.004));
    run.step(t_s + 3.0 * TICK_S, -0.001);
    assert!(
        run.state.last_output().viscous_n == 0.0 && run.state.ledger.presliding_j == 0.0,
        "nothing is left outside"
    );
    assert!(run.state.ledger.closure_error_j().abs() < 1e-12 * run.state.ledger.input_j);
}

/// In to 45 mm and out again at 20 mm/s through the training layers.
fn in_and_out(tick_hz: f64) -> Ledger {
    let spec = AxialSpec { law: ForceLaw::Version5, damping_time_s: TIME_S, ..training_axial_spec() };
    let mut run = AxialRun::new(spec).expect("a valid scene");
    for (start_s, from_m, to_m) in [(0.0, -0.001, 0.045), (2.3, 0.045, -0.001)] {
        run.travel(&Leg { start_s, duration_s: 2.3, dt_s: 1.0 / tick_hz, from_m, to_m }, |_, _, _| ());
    }
    run.state.ledger
}

#[test]
fn the_loss_does_not_depend_on_the_tick() {
    let fine_j = lost_j(&in_and_out(16_000.0));
    for tick_hz in [250.0, 1000.0] {
        let error = lost_j(&in_and_out(tick_hz)) / fine_j - 1.0;
        assert!(error.abs() < 2e-3, "{:.3} % at {tick_hz} Hz", error * 100.0);
    }
}
