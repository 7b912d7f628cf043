//! The fit to a curve with times: it finds the options that the curve was made with, within intervals that hold the truth, and says what the
//! curve does not show.
//!
//! Would fail on a law of its own beside the force law, an option that is fitted to nothing, a hold or a withdrawal that is passed over,
//! or an interval that does not hold the truth.

use law::axial::{AxialSpec, ForceLaw, LayerOptions};
use law::operator::Draw;
use law::soundness;
use tissue::calibrate::{
    CalibrateError, Fit, ParameterEstimate, Quantity, TimedCurve, TimedSample, fit_timed, timed_residual_rms_n,
};
use trials::scenes::{make_layer, needle_through};
use trials::timed_calibration::{
    DEEPEST_M, HOLD_S, SAMPLE_S, SPEED_M_PER_S, TimedNoise, along, changed, insertion, liver, sample_timed, sticky_at,
    try_timed_fit,
};

/// Curves whose intervals are held against the truth.
const CURVES: u64 = 12;

/// As the curves that are measured, but with a rest of another time in s.
fn measured(truth: &AxialSpec, hold_s: f64, noise: TimedNoise<'_>) -> Vec<TimedSample> {
    insertion(truth, DEEPEST_M, hold_s, noise).expect("a law")
}

fn fitted(samples: &[TimedSample], start: &AxialSpec) -> Fit {
    fit_timed(&TimedCurve::new(samples).expect("a curve"), start, &mut |_| ()).expect("a fit")
}

#[test]
fn a_clean_curve_gives_back_the_options_it_was_made_with() {
    let mut draw = Draw::new(3);
    let truth = liver(&mut draw);
    let samples = measured(&truth, HOLD_S, TimedNoise { draw: &mut draw, deviation_n: 0.0 });
    let fit = fitted(&samples, &changed(&truth, &mut draw));
    assert!(fit.rms_n < 2e-3, "{} N", fit.rms_n);
    let near = |found: f64, truth: f64| (found / truth - 1.0).abs() < 0.05;
    let (found, made) = (&fit.spec.layers[1].options, &truth.layers[1].options);
    assert!(near(found.branches[0].share, made.branches[0].share), "{found:?}, not {made:?}");
    assert!(near(found.branches[0].time_s, made.branches[0].time_s), "{found:?}, not {made:?}");
    assert!(near(found.stiffening_n_per_m2, made.stiffening_n_per_m2), "{found:?}, not {made:?}");
    assert!(near(fit.spec.layers[0].friction_n_per_m, truth.layers[0].friction_n_per_m), "{:?}", fit.spec.layers[0]);
    assert!(soundness::find_unsound_ruptures(&fit.spec).is_empty());
    let curve = TimedCurve::new(&samples).expect("a curve");
    assert!(timed_residual_rms_n(&fit.spec, &curve).expect("a law") < 5e-3, "the law as it stands is another");
}

#[test]
fn intervals_of_options_hold_the_truth() {
    let (mut held, mut missed, mut open, mut settled) = (0, 0, 0, 0);
    for seed in 0..CURVES {
        let trial = try_timed_fit(&sample_timed(9000 + seed).expect("a curve")).expect("a fit");
        if !trial.fit.converged {
            continue;
        }
        settled += 1;
        for judged in &trial.parameters {
            match judged.is_held() {
                Some(true) => held += 1,
                Some(false) => missed += 1,
                None => open += 1,
            }
        }
    }
    println!("{settled} settled: {held} held, {missed} missed, {open} not determined");
    assert!(settled * 10 >= CURVES * 8, "{settled} of {CURVES} settled");
    assert!(held * 10 >= (held + missed) * 9, "{held} held, {missed} missed");
    assert!(open <= held, "{open} not determined, {held} held");
}

/// A sheet above a deep soft layer, without relaxation: friction and cutting alone resist behind the sheet.
#[test]
fn second_insertion_in_a_track_separates_cutting_and_friction() {
    let layer = make_layer("liver", [60.0, 300.0, 0.0, 0.8, 0.0, 40.0, 0.2]);
    let truth = AxialSpec { law: ForceLaw::Version3, ..needle_through(vec![layer]) };
    let way_s = 12e-3 / SPEED_M_PER_S;
    // In, out, and in again; and in alone. The needle turns at a sample: between samples its way is taken to be straight.
    let again = |t_s: f64| SPEED_M_PER_S * (way_s - (t_s.rem_euclid(2.0 * way_s) - way_s).abs());
    let (mut draw, mut width) = (Draw::new(11), Vec::new());
    for length_s in [way_s, 3.0 * way_s] {
        let fit = fitted(
            &along(&truth, length_s, &again, TimedNoise { draw: &mut draw, deviation_n: 0.01 }).expect("a law"),
            &changed(&truth, &mut draw),
        );
        let cutting = fit.estimates.iter().find(|e| e.quantity == Quantity::Cutting).expect("it is fitted");
        assert!(cutting.interval.is_none_or(|interval| interval.holds(0.2)), "{cutting:?}, {:?}", fit.misfit);
        width.push(cutting.interval.map_or(f64::INFINITY, |interval| interval.high - interval.low));
    }
    assert!(width[1].is_finite() && width[1] < 0.7 * width[0], "{width:?} N wide, without and with a second insertion");
}

fn estimate_of(fit: &Fit, quantity: Quantity) -> &ParameterEstimate {
    fit.estimates.iter().find(|estimate| estimate.quantity == quantity).expect("it is fitted")
}

#[test]
fn a_needle_that_stops_shows_damping() {
    let mut draw = Draw::new(21);
    let mut truth = liver(&mut draw);
    truth.layers[0].damping_n_s_per_m2 = 8000.0;
    let mut start = changed(&truth, &mut draw);
    start.layers[0].damping_n_s_per_m2 = 3000.0;
    // The needle stops and turns at a sample: between samples its way is taken to be straight, and damping goes with its speed.
    let (deepest_m, hold_s) = (83.0 * SAMPLE_S * SPEED_M_PER_S, 133.0 * SAMPLE_S);
    let noise = TimedNoise { draw: &mut draw, deviation_n: 0.005 };
    let fit = fitted(&insertion(&truth, deepest_m, hold_s, noise).expect("a law"), &start);
    let damping = estimate_of(&fit, Quantity::Damping);
    let interval = damping.interval.unwrap_or_else(|| panic!("not determined: {damping:?}, {:?}", fit.misfit));
    assert!(interval.holds(8000.0), "{damping:?}");
    assert!(fit.spec.layers[1].damping_n_s_per_m2.abs() < f64::EPSILON, "a layer without damping is given none");
    assert!(fit.undetermined.iter().any(|line| line.starts_with("damping of liver:")), "{:?}", fit.undetermined);
}

/// The fit to a curve of a shaft that sticks, from a length that is half as long again.
fn fitted_sticky(slid_m: f64) -> Fit {
    let (truth, mut draw) = (sticky_at(slid_m, 70.0), Draw::new(31));
    let start = AxialSpec { breakaway: sticky_at(1.5 * slid_m, 70.0).breakaway, ..changed(&truth, &mut draw) };
    fitted(&measured(&truth, 2.0, TimedNoise { draw: &mut draw, deviation_n: 0.01 }), &start)
}

#[test]
fn the_length_at_which_static_friction_gives_way_is_found() {
    let fit = fitted_sticky(2e-3);
    let slid = estimate_of(&fit, Quantity::Breakaway);
    let interval = slid.interval.unwrap_or_else(|| panic!("not determined: {slid:?}, {:?}", fit.misfit));
    assert!(interval.holds(2e-3) && interval.high - interval.low < 1e-3, "{slid:?}");
    assert_eq!(fit.spec.breakaway.map(|breakaway| breakaway.slid_m), Some(slid.value), "the scene has another");
    let sticking = estimate_of(&fit, Quantity::StaticFriction);
    assert!(sticking.interval.is_some_and(|interval| interval.holds(70.0)), "{sticking:?}");
}

#[test]
fn a_shaft_that_never_breaks_away_does_not_tell_where_it_would() {
    let fit = fitted_sticky(40e-3);
    let slid = estimate_of(&fit, Quantity::Breakaway);
    assert_eq!(slid.interval, None, "{slid:?}");
    assert!(
        fit.undetermined.iter().any(|line| line.contains("breakaway length of the needle")),
        "{:?}",
        fit.undetermined
    );
}

#[test]
fn a_curve_without_a_hold_says_that_it_has_none() {
    let mut draw = Draw::new(5);
    let truth = liver(&mut draw);
    let fit = fitted(&measured(&truth, 0.0, TimedNoise { draw: &mut draw, deviation_n: 0.01 }), &truth);
    assert!(fit.undetermined.iter().any(|line| line.contains("no hold")), "{:?}", fit.undetermined);
}

#[test]
fn what_cannot_be_fitted_with_times_is_refused_with_the_reason() {
    let mut draw = Draw::new(7);
    let truth = liver(&mut draw);
    let samples = measured(&truth, 1.0, TimedNoise { draw: &mut draw, deviation_n: 0.0 });
    let curve = TimedCurve::new(&samples).expect("a curve");
    let refused = |start: &AxialSpec| fit_timed(&curve, start, &mut |_| ()).expect_err("no start");
    let mut old = truth.clone();
    old.law = ForceLaw::Version2;
    old.layers.iter_mut().for_each(|layer| layer.options = LayerOptions::default());
    assert_eq!(refused(&old), CalibrateError::TimedLaw);
    let trocar = AxialSpec { tip_to_rim_m: 2e-3, ..truth.clone() };
    assert_eq!(refused(&trocar), CalibrateError::TimedRim { tip_to_rim_mm: 2.0 });
    let mut still = samples;
    still[4].t_s = still[3].t_s;
    assert!(matches!(TimedCurve::new(&still), Err(CalibrateError::TimeStandsStill { row: 4, .. })));
}
