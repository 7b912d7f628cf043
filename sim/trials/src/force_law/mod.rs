//! The force law in the hard cases that concern it.
//!
//! The trials detect a law that triggers on velocity, counts ticks, drifts, allows an order that a
//! coarse tick violates, or trusts a faulty device.

mod layers;
mod motion;
mod options;
mod samples;
mod sheets;

use law::axial::{AxialSpec, ParamError, Rupture};
use law::closed_form::{self, PredictedRupture};
use layers::{
    beside_intact, cascade_lateness, cascade_order, coincident_cutting, coincident_lateness, oblique_lateness,
    same_track_force, same_track_ruptures, thin_lateness, threshold_excess, withdrawn_energy,
};
use motion::{
    hold_energy, hold_force, hours_drift, hours_ledger, rates_friction, rates_instants, release_depth, release_energy,
    release_inserted, reversal_force, reversal_loss, stab_force, stab_lateness, teleport_afterwards, teleport_energy,
    teleport_force, teleport_ledger,
};
use options::{
    optioned_hold_rise, optioned_hours_drift, optioned_hours_ledger, optioned_rates_energy, optioned_rates_force,
    optioned_rates_rupture, optioned_reversal_work, optioned_stab_force, relaxed_hold_force, relaxed_pull,
    relaxed_reversal_force, static_tremor,
};
use samples::{bad_first_sample, bad_samples, missing_samples, no_time};
use sheets::{tense_lateness, toughness_brittle, toughness_order, toughness_tough};

use super::scenes::{AxialRun, Leg};
use super::{case, largest};

super::trials! { "force law":
    stab_lateness, case::STAB, "latest rupture after its closed form; bound: a tick", <= 1.0 "mm";
    stab_force, case::STAB, "largest force; bound: every part at its most at once", <= 16.48 "N";
    teleport_ledger, case::TELEPORT, "what the energy ledger misses", <= 1e-12 "J";
    teleport_energy, case::TELEPORT, "energy gained by the ruptures", <= 0.0 "mJ";
    teleport_afterwards, case::TELEPORT, "ruptures left over for the next tick", <= 0.0 "";
    teleport_force, case::TELEPORT, "force when the needle stands again", <= 6.0 "N";
    bad_samples, case::BAD_SAMPLES, "bad samples that changed anything", <= 0.0 "";
    bad_first_sample, case::BAD_SAMPLES, "change of the first good force by a bad sample before it", <= 0.0 "N";
    missing_samples, case::BAD_SAMPLES, "change of any later force by 0.1 s without samples", <= 1e-9 "N";
    no_time, case::NO_TIME, "samples without a passage of time that changed anything", <= 0.0 "";
    release_energy, case::RELEASED, "most energy over what was stored; bound: the integrator's ½ ω dt", <= 1.06 "";
    release_depth, case::RELEASED, "depth left 2 s after release by an intact skin", <= 0.0 "mm";
    release_inserted, case::RELEASED, "way of an inserted needle that friction must keep", <= 2.0 "mm";
    reversal_force, case::REVERSAL, "distance from a spring's force", <= 1e-9 "N";
    reversal_loss, case::REVERSAL, "energy lost; bound: ½ k_pre Δx² a tick", <= 4.04e-7 "J";
    hold_force, case::HOLD, "change of the force", <= 0.0 "N";
    hold_energy, case::HOLD, "change of stored and of dissipated energy", <= 0.0 "J";
    withdrawn_energy, case::RE_ENTRY, "energy stored after withdrawal", <= 0.0 "J";
    same_track_ruptures, case::RE_ENTRY, "ruptures in the same track", <= 0.0 "";
    same_track_force, case::RE_ENTRY, "largest elastic force in the same track", <= 0.0 "N";
    beside_intact, case::RE_ENTRY, "boundaries that were not intact 3 mm beside", <= 0.0 "";
    oblique_lateness, case::OBLIQUE, "latest rupture after that of doubled layers; bound: a tick", <= 20.0 "µm";
    coincident_lateness, case::COINCIDENT, "latest rupture after its closed form; bound: a tick", <= 2.001 "µm";
    coincident_cutting, case::COINCIDENT, "cutting force of layers without thickness", <= 0.0 "N";
    thin_lateness, case::THIN, "latest rupture after its closed form, tips before rims; bound: a tick", <= 1.001 "µm";
    cascade_lateness, case::CASCADE, "latest rupture after its closed form; bound: a tick", <= 2.001 "µm";
    cascade_order, case::CASCADE, "ruptures of one tick that are missing or out of turn", <= 0.0 "";
    threshold_excess, case::STRONG, "force above a threshold of 12.1 N; bound: a tick", <= 0.662 "mN";
    hours_drift, case::HOURS, "change of the force between the second and the last stroke", <= 1e-8 "N";
    hours_ledger, case::HOURS, "what the energy ledger misses, of the input", <= 1e-9 "";
    rates_instants, case::RATES, "instants that differ by over 1 µN: ruptures, reversals, new layers, the 15 in which cutting is taken up", <= 31.0 "";
    rates_friction, case::RATES, "largest difference of friction; bound: a tick of travel", <= 20.0 "mN";
    optioned_stab_force, case::STAB, "largest force under each option and all; bound: every part at its most at once", <= 17.42 "N";
    relaxed_hold_force, case::HOLD, "distance from the closed form of a wall that relaxes", <= 1e-9 "N";
    optioned_hold_rise, case::HOLD, "largest rise of the force in a tick under each option and all", <= 1e-12 "N";
    relaxed_reversal_force, case::BRANCH_REVERSAL, "distance from the closed form of a wall that relaxes", <= 1e-9 "N";
    relaxed_pull, case::BRANCH_REVERSAL, "pull on a needle that leaves a relaxed dent in 10 ms, and what is stored then", <= 0.0 "N";
    optioned_reversal_work, case::REVERSAL, "what the ledger's work misses of the force's along the way, of the input, under each option and all", <= 1e-3 "";
    static_tremor, case::REVERSAL, "energy lost to 20 s of tremor in static friction", <= 1e-6 "µJ";
    toughness_order, case::TOUGHNESS, "neighbouring radii, moduli and fracture energies that do not raise the threshold", <= 0.0 "";
    toughness_brittle, case::TOUGHNESS, "distance from πRJ where J is a millionth of μR, of it", <= 1e-6 "";
    toughness_tough, case::TOUGHNESS, "distance from πμR² (1 + ln(J/(μR))) where J is a hundred million times μR, of it", <= 1e-9 "";
    tense_lateness, case::TENSION, "latest rupture after its closed form, from slack to a drum; bound: a tick", <= 2.001 "µm";
    optioned_hours_drift, case::HOURS, "change of the force between the second and the last stroke under each option and all", <= 1e-8 "N";
    optioned_hours_ledger, case::HOURS, "what the energy ledger misses under each option and all, of the input", <= 1e-9 "";
    optioned_rates_energy, case::OPTION_RATES, "largest difference of work, viscous loss, friction and cutting", <= 0.01 "";
    optioned_rates_rupture, case::OPTION_RATES, "difference of what ruptures lose; bound: a tick of 40 µm", <= 0.03 "";
    optioned_rates_force, case::OPTION_RATES, "root mean square of the difference, of the force", <= 0.01 "";
}

/// Duration of a tick, in s.
const DT: f64 = 1e-3;
/// Allowed difference between the closed form's running sums and the law's, in m.
const ROUND_OFF_M: f64 = 1e-12;

/// Returns the largest delay of a rupture of a straight insertion relative to its closed form, in
/// m; infinite if one is early, missing or out of order.
///
/// # Errors
/// If the law refuses the scene.
pub fn lateness_m(spec: AxialSpec, leg: &Leg) -> Result<f64, ParamError> {
    let predicted = closed_form::predict_ruptures(&spec);
    let mut found = Vec::with_capacity(predicted.len());
    AxialRun::new(spec)?.travel(leg, |run, _, _| found.extend_from_slice(run.ruptures()));
    Ok(latest_m(&found, &predicted))
}

fn latest_m(found: &[Rupture], predicted: &[PredictedRupture]) -> f64 {
    if found.len() != predicted.len() {
        return f64::INFINITY;
    }
    largest(found.iter().zip(predicted).map(|(found, wanted)| {
        let in_turn = (found.contactor, found.boundary) == (wanted.contactor, wanted.boundary);
        let late_m = found.x_m - wanted.x_m;
        if in_turn && late_m >= -ROUND_OFF_M { late_m } else { f64::INFINITY }
    }))
}

/// Inserts a needle at 10 mm/s and 1 kHz from the skin to a depth in m.
fn inserted(spec: AxialSpec, to_m: f64) -> Result<AxialRun, ParamError> {
    let mut run = AxialRun::new(spec)?;
    run.travel(&Leg { start_s: 0.0, duration_s: to_m / 0.01, dt_s: DT, from_m: 0.0, to_m }, |_, _, _| ());
    Ok(run)
}
