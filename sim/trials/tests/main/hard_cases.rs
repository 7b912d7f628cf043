//! The hard cases of physics section 8, each a named test, on every model that it concerns.
//!
//! They would fail when a model gives way in one, when a case is tried on fewer models than it concerns, or when a trial of the
//! report has no test.

use std::collections::BTreeSet;

use trials::{HardCaseTrial, all_trials};

/// What a trial measures keeps its bound.
#[track_caller]
fn holds(model: &str, name: &str) {
    let trial = all_trials()
        .into_iter()
        .find(|trial| (trial.model, trial.name) == (model, name))
        .expect("a trial of this name");
    let HardCaseTrial { case, measures, bound, unit, .. } = trial;
    let measured = (trial.measure)().unwrap_or_else(|why| panic!("{case}: cannot be set up: {why}"));
    assert!(trial.passes(measured), "{case}: {measures}: {measured} {unit}, the bound is {bound} {unit}");
}

/// One named test for each trial of each model, and the list of them.
macro_rules! hard_cases {
    ($($module:ident $model:literal: $($name:ident)+;)+) => {
        $(mod $module {
            $(#[test]
            fn $name() {
                super::holds($model, stringify!($name));
            })+
        })+

        /// Model and name of every trial that has a test.
        const TESTED: &[(&str, &str)] = &[$($(($model, stringify!($name))),+),+];
    };
}

hard_cases! {
    force_law "force law":
        stab_lateness stab_force
        teleport_ledger teleport_energy teleport_afterwards teleport_force
        bad_samples bad_first_sample missing_samples no_time
        release_energy release_depth release_inserted
        reversal_force reversal_loss
        hold_force hold_energy
        withdrawn_energy same_track_ruptures same_track_force beside_intact
        oblique_lateness
        coincident_lateness coincident_cutting thin_lateness
        cascade_lateness cascade_order threshold_excess
        hours_drift hours_ledger
        rates_instants rates_friction
        optioned_stab_force relaxed_hold_force optioned_hold_rise relaxed_reversal_force relaxed_pull static_tremor
        optioned_reversal_work
        toughness_order toughness_brittle toughness_tough tense_lateness
        optioned_hours_drift optioned_hours_ledger optioned_rates_energy optioned_rates_rupture
        optioned_rates_force;
    axisymmetric "axisymmetric":
        soft_within_error stiff_within_error contrast_estimate
        skin_error
        incompressible_error incompressible_locking
        film_error film_patch inverted_accepted
        stab_memory
        teleport_linearity
        bad_force_answers
        hold_changes
        sheets_change duplicate_change
        thin_error
        half_space_error half_space_rate boussinesq_error punch_error column_error patch_error mutual_error;
    mass_spring "mass-spring":
        contrast_error thin_skin_refused thin_skin_error
        incompressible_estimate incompressible_met
        sliver_refused inverted_energy inverted_rest
        long_step_refused
        stab_energy teleport_explicit teleport_implicit
        bad_samples no_time
        release_explicit release_growth release_implicit release_rest
        hold_creep
        coincident_answer
        slow_tissue_energy slow_tissue_rest rates_displacement;
    volumetric "volumetric":
        ratio_error thin_skin_error incompressible_error
        sliver_energy inverted_left inverted_growth
        stab_growth teleport_growth teleport_refused bad_forces
        release_growth release_left hold_still hold_moving
        oblique_error zero_thickness_change duplicate_change
        rate_growth rate_left;
}

#[test]
fn every_trial_has_a_test_of_its_own() {
    let trials: Vec<_> = all_trials().iter().map(|trial| (trial.model, trial.name)).collect();
    let (named, tested) = (BTreeSet::from_iter(trials.iter()), BTreeSet::from_iter(TESTED));
    assert_eq!(named.len(), trials.len(), "two trials have the same name");
    assert_eq!(named, tested);
}

/// Every hard case in the words of physics section 8, and the models that it concerns.
const CASES: [(&str, &[&str]); 31] = [
    ("1 m/s stab", &["force law", "axisymmetric", "mass-spring", "volumetric"]),
    ("50 mm teleport in one tick", &["force law", "axisymmetric", "mass-spring", "volumetric"]),
    (
        "NaN, infinite, repeated, missing and backwards-in-time samples",
        &["force law", "axisymmetric", "mass-spring", "volumetric"],
    ),
    ("dt = 0", &["force law", "mass-spring"]),
    ("a released handle", &["force law", "mass-spring", "volumetric"]),
    ("reversal inside the presliding zone", &["force law"]),
    ("ten minutes' hold", &["force law", "axisymmetric", "mass-spring", "volumetric"]),
    ("withdrawal, re-entry in the same track and 3 mm beside it", &["force law"]),
    ("60° oblique", &["force law", "volumetric"]),
    ("zero-thickness and duplicate layers", &["force law", "axisymmetric", "mass-spring", "volumetric"]),
    ("a layer thinner than L", &["force law", "axisymmetric"]),
    ("cascades", &["force law"]),
    ("thresholds above the device's force", &["force law"]),
    ("8 simulated hours without drift", &["force law"]),
    ("1 and 4 kHz giving the same forces", &["force law", "mass-spring"]),
    ("tissue at 15 Hz under a 1 kHz needle", &["mass-spring", "volumetric"]),
    ("stiffness ratios 1e2–1e5 between layers", &["axisymmetric", "mass-spring", "volumetric"]),
    ("0.8 mm skin on 39 mm muscle", &["axisymmetric", "mass-spring", "volumetric"]),
    ("ν = 0.499", &["axisymmetric", "mass-spring", "volumetric"]),
    ("slivers and inverted elements", &["axisymmetric", "mass-spring", "volumetric"]),
    ("half-space, Gaussian load", &["axisymmetric"]),
    ("Boussinesq", &["axisymmetric"]),
    ("flat punch", &["axisymmetric"]),
    ("layered column (confined)", &["axisymmetric"]),
    ("patch test", &["axisymmetric"]),
    ("two loads' work on each other (Betti)", &["axisymmetric"]),
    ("reversal within a branch's time", &["force law"]),
    ("every option at 250 Hz and 4 kHz", &["force law"]),
    ("thresholds from toughness, from brittle to tough", &["force law"]),
    ("a sheet under tension", &["force law"]),
    ("explicit step 4 × too large (refused with the stable step named, never NaN)", &["mass-spring"]),
];

#[test]
fn every_hard_case_is_tried_on_every_model_it_concerns() {
    let found: BTreeSet<_> = all_trials().iter().map(|trial| (trial.case, trial.model)).collect();
    let wanted = CASES.iter().flat_map(|(case, models)| models.iter().map(|model| (*case, *model))).collect();
    assert_eq!(found, wanted);
}

#[test]
fn what_is_not_a_number_and_what_is_above_the_bound_fails() {
    let trial = all_trials()[0];
    assert!(trial.passes(trial.bound) && trial.passes(f64::NEG_INFINITY));
    assert!(![f64::NAN, f64::INFINITY, trial.bound.next_up()].iter().any(|&measured| trial.passes(measured)));
}
