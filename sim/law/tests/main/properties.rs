//! Laws that hold for any scene and any motion: random layers (sound or not), random walks with leaps, pauses and
//! broken samples.
//!
//! They would fail if a dissipation could be negative, a boundary could heal or open out of turn, or some input gave a
//! force that is not a number.

use bench::scenes::{AxialRun, make_layer, paper_axial_spec};
use law::axial::{AxialParams, AxialSpec, Contactor, ForceLaw, Layer, ParamError, RateDependence};
use law::soundness::Unsound;
use proptest::prelude::*;

fn any_layer() -> impl Strategy<Value = Layer> {
    let thickness = prop_oneof![Just(0.0), 0.01..40.0_f64];
    let stiffness = (0.0..5.0_f64).prop_map(|exponent| libm::pow(10.0, exponent));
    (thickness, stiffness, 0.0..300.0_f64, 0.0..5.0_f64, 0.0..5.0_f64, 0.0..100.0_f64, 0.0..1.0_f64)
        .prop_map(|(d, k, b, tip, rim, c, f)| make_layer("any", [d, k, b, tip, rim, c, f]))
}

fn any_scene() -> impl Strategy<Value = AxialSpec> {
    let rate = prop::option::of((0.0..3.0_f64, 1e-3..0.1_f64))
        .prop_map(|rate| rate.map(|(p_infinity_n, v0_m_per_s)| RateDependence { p_infinity_n, v0_m_per_s }));
    let lag = prop_oneof![Just(0.0), 1e-4..5e-3_f64];
    let law = prop_oneof![
        Just((ForceLaw::Version1, 0.0)),
        Just((ForceLaw::Version2, 0.0)),
        (1e-4..0.05_f64).prop_map(|window_s| (ForceLaw::Version2, window_s)),
    ];
    (prop::collection::vec(any_layer(), 1..6), lag, rate, law).prop_map(
        |(layers, tip_to_rim_m, rate, (law, speed_window_s))| AxialSpec {
            law,
            layers,
            tip_to_rim_m,
            presliding_stiffness_n_per_m: 2000.0,
            speed_window_s,
            rate,
        },
    )
}

/// Increments of (t, x): mostly small, sometimes a leap, sometimes time that does not pass, sometimes not a number.
fn any_walk() -> impl Strategy<Value = Vec<(f64, f64)>> {
    let dt = prop_oneof![8 => Just(1e-3), 1 => Just(0.0), 1 => Just(-1.0), 1 => 1e-6..0.5_f64, 1 => Just(f64::NAN)];
    let dx = prop_oneof![8 => -1e-4..3e-4_f64, 1 => -0.05..0.08_f64, 1 => Just(0.0), 1 => Just(f64::INFINITY)];
    prop::collection::vec((dt, dx), 1..300)
}

/// Walks a scene, checking each tick.
fn walk(spec: AxialSpec, steps: &[(f64, f64)]) -> Result<(), TestCaseError> {
    let (layers, windowed) = (spec.layers.clone(), spec.speed_window_s > 0.0);
    let mut run = AxialRun::new(spec).expect("a valid scene");
    let (mut t_s, mut x_m) = (0.0, -0.001);
    run.step(t_s, x_m);
    for &(dt, dx) in steps {
        let before = run.state.clone();
        let output = run.step(t_s + dt, x_m + dx);
        if output.held {
            prop_assert_eq!(&run.state, &before);
            continue;
        }
        (t_s, x_m) = (t_s + dt, x_m + dx);
        prop_assert!(output.total_n().is_finite() && output.depth_m >= 0.0);
        prop_assert!(output.tip_n >= 0.0 && output.rim_n >= 0.0 && output.cutting_n >= 0.0);
        prop_assert!(output.viscous_n * output.v_m_per_s >= 0.0, "viscosity must resist");
        let cap_n: f64 = layers.iter().map(|layer| layer.friction_n_per_m * layer.thickness_m).sum();
        prop_assert!(output.friction_n.abs() <= cap_n + 1e-12);

        prop_assert!(run.state.tip_open >= before.tip_open && run.state.rim_open >= before.rim_open, "healed");
        prop_assert!(run.state.rim_open <= run.state.tip_open, "the rim went before the tip");
        prop_assert!(dx >= 0.0 || run.ruptures().is_empty(), "ruptured while drawing back");
        for (was, is) in before.ledger.layers.iter().zip(&run.state.ledger.layers) {
            let gave_back_j = run.state.ledger.lagged_j - before.ledger.lagged_j;
            prop_assert!(gave_back_j <= 0.0 || windowed, "only a window of speed lags");
            let parts = [
                (was.rupture_j, is.rupture_j),
                (was.viscous_j, is.viscous_j + gave_back_j),
                (was.friction_j, is.friction_j),
                (was.cutting_j, is.cutting_j),
            ];
            prop_assert!(
                parts.iter().all(|(was, is)| is + 1e-12 * is.abs() >= *was),
                "dissipation came back: {was:?} to {is:?}"
            );
        }
        let ledger = &run.state.ledger;
        let error_j = ledger.closure_error_j().abs();
        prop_assert!(error_j <= 1e-9 * ledger.input_j + 1e-12, "the ledger misses {error_j} J");
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_laws_hold_for_any_scene_and_motion(spec in any_scene(), steps in any_walk()) {
        walk(spec, &steps)?;
    }

    #[test]
    fn the_largest_sound_threshold_is_sound(spec in any_scene()) {
        for issue in law::soundness::find_unsound_ruptures(&spec) {
            prop_assert!(issue.largest_sound_n < issue.threshold_n);
            prop_assert!(issue.force_rise_n > 0.0 || issue.energy_rise_mj > 0.0);
            if issue.largest_sound_n > 0.0 {
                let mut mended = spec.clone();
                let layer = &mut mended.layers[issue.boundary];
                match issue.contactor {
                    Contactor::Tip => layer.tip_rupture_n = issue.largest_sound_n,
                    Contactor::Rim => layer.rim_rupture_n = issue.largest_sound_n,
                }
                let left = law::soundness::find_unsound_ruptures(&mended);
                let same = |other: &Unsound| (other.boundary, other.contactor) == (issue.boundary, issue.contactor);
                prop_assert!(!left.iter().any(same), "{issue} and still {left:?}");
            }
        }
    }
}

#[test]
fn every_number_of_a_scene_is_checked_and_named() {
    type Set = fn(&mut AxialSpec, f64);
    let fields: [(&str, Set); 13] = [
        ("layers[1].thickness_m", |spec, value| spec.layers[1].thickness_m = value),
        ("layers[1].stiffness_n_per_m", |spec, value| spec.layers[1].stiffness_n_per_m = value),
        ("layers[1].damping_n_s_per_m2", |spec, value| spec.layers[1].damping_n_s_per_m2 = value),
        ("layers[1].tip_rupture_n", |spec, value| spec.layers[1].tip_rupture_n = value),
        ("layers[1].rim_rupture_n", |spec, value| spec.layers[1].rim_rupture_n = value),
        ("layers[1].friction_n_per_m", |spec, value| spec.layers[1].friction_n_per_m = value),
        ("layers[1].cutting_n", |spec, value| spec.layers[1].cutting_n = value),
        ("tip_to_rim_m", |spec, value| spec.tip_to_rim_m = value),
        ("presliding_stiffness_n_per_m", |spec, value| spec.presliding_stiffness_n_per_m = value),
        ("speed_window_s", |spec, value| spec.speed_window_s = value),
        ("rate.p_infinity_n", |spec, value| {
            spec.rate = Some(RateDependence { p_infinity_n: value, v0_m_per_s: 1.0 });
        }),
        ("rate.v0_m_per_s", |spec, value| {
            spec.rate = Some(RateDependence { p_infinity_n: 1.0, v0_m_per_s: value });
        }),
        ("layers", |spec, _| spec.layers.clear()),
    ];
    for (field, set) in fields {
        for value in [f64::NAN, f64::INFINITY, -1.0] {
            let mut spec = paper_axial_spec();
            set(&mut spec, value);
            let Err(ParamError { field: named, .. }) = AxialParams::new(spec) else {
                panic!("{field} = {value} was taken")
            };
            assert_eq!(named, field);
        }
    }
    assert!(AxialParams::new(paper_axial_spec()).is_ok());
}
