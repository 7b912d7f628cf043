//! Unusual layers, repeated entries, and oblique paths.

use law::axial::{AxialSpec, Contactor, ParamError, Rupture};
use law::closed_form;
use law::puncture::PunctureEvent;
use nalgebra::{Point3, Vector3};

use super::{DT, lateness_m, latest_m};
use crate::needle::{DrivenNeedle, NeedleTick};
use crate::scenes::{AxialRun, Leg, in_hold_out_in, make_layer, paper_axial_spec, training_axial_spec, trocar_through};
use crate::{Measured, largest};

/// Returns a leg from the skin to a depth in m, advancing `tick_m` per tick.
fn insertion(to_m: f64, tick_m: f64) -> Leg {
    Leg { start_s: 0.0, duration_s: to_m / tick_m * DT, dt_s: DT, from_m: 0.0, to_m }
}

/// Three identical fasciae at the skin, and fat at the same depth.
fn coincident() -> AxialSpec {
    let fascia = make_layer("fascia", [0.0, 400.0, 0.0, 0.8, 1.0, 0.0, 0.2]);
    let fat = make_layer("fat", [9.0, 80.0, 0.0, 0.3, 0.4, 0.0, 0.0]);
    trocar_through(vec![fascia.clone(), fascia.clone(), fascia, fat])
}

pub(super) fn coincident_lateness() -> Measured {
    Ok(lateness_m(coincident(), &insertion(0.02, 2e-6))? * 1e6)
}

pub(super) fn coincident_cutting() -> Measured {
    let mut cutting_n = Vec::new();
    AxialRun::new(coincident())?.travel(&insertion(0.02, 2e-6), |_, _, output| cutting_n.push(output.cutting_n));
    Ok(largest(cutting_n))
}

/// Three layers of 0.3 mm with a rim 2 mm behind the tip.
pub(super) fn thin_lateness() -> Measured {
    let thin = |name| make_layer(name, [0.3, 1000.0, 0.0, 0.2, 0.3, 0.0, 0.0]);
    Ok(lateness_m(trocar_through(vec![thin("a"), thin("b"), thin("c")]), &insertion(0.005, 1e-6))? * 1e6)
}

/// A skin so strong that everything below it has reached its own threshold when the skin ruptures.
pub(super) fn cascade_lateness() -> Measured {
    let spec = trocar_through(vec![
        make_layer("skin", [1.0, 400.0, 0.0, 2.0, 3.0, 0.0, 0.0]),
        make_layer("fascia", [0.0, 300.0, 0.0, 0.4, 0.5, 0.0, 0.0]),
        make_layer("fat", [0.5, 200.0, 0.0, 0.3, 0.4, 0.0, 0.0]),
    ]);
    Ok(lateness_m(spec, &insertion(0.06, 2e-6))? * 1e6)
}

/// All ruptures in one tick: every tip in boundary order, then every rim.
pub(super) fn cascade_order() -> Measured {
    let mut run = AxialRun::new(paper_axial_spec())?;
    run.step(0.0, -0.001);
    run.step(DT, 0.05);
    let wanted = [Contactor::Tip, Contactor::Rim].into_iter().flat_map(|contactor| (0..3).map(move |b| (contactor, b)));
    let found: Vec<_> = run.ruptures().iter().map(|rupture| (rupture.contactor, rupture.boundary)).collect();
    let in_turn = found.iter().copied().zip(wanted).filter(|(found, wanted)| found == wanted).count();
    Ok((found.len().max(6) - in_turn) as f64)
}

/// No device renders 12.1 N; the law reaches the threshold nevertheless. Scaling to the device is
/// done elsewhere.
pub(super) fn threshold_excess() -> Measured {
    let mut spec = paper_axial_spec();
    spec.layers.truncate(1);
    for layer in &mut spec.layers {
        layer.tip_rupture_n = 12.1;
    }
    let mut first_n = None;
    AxialRun::new(spec)?.travel(&insertion(0.04, 2e-6), |run, _, _| {
        first_n = first_n.or(run.ruptures().first().map(|rupture| rupture.force_n));
    });
    let excess_n = first_n.map_or(f64::INFINITY, |force_n| force_n - 12.1);
    Ok(if excess_n >= 0.0 { excess_n * 1e3 } else { f64::INFINITY })
}

/// Into the training scene and out again.
pub(super) fn withdrawn_energy() -> Measured {
    let mut run = AxialRun::new(training_axial_spec())?;
    for leg in &in_hold_out_in()[..3] {
        run.travel(leg, |_, _, _| ());
    }
    Ok(run.state.ledger.elastic_j() + run.state.ledger.presliding_j)
}

/// In to 30 mm and out, then in again at a distance in m from the first entry. Returns the ticks of
/// the second insertion.
fn enter_again(beside_m: f64) -> Result<Vec<NeedleTick>, ParamError> {
    let at = |x_m, z_m| Point3::new(x_m, 0.0, z_m);
    let down = -Vector3::z();
    let mut needle = DrivenNeedle::new(paper_axial_spec(), vec![])?;
    needle.travel(down, at(0.0, 0.003), at(0.0, -0.03));
    needle.travel(down, at(0.0, -0.03), at(0.0, 0.003));
    needle.travel(down, at(0.0, 0.003), at(beside_m, 0.003));
    Ok(needle.travel(down, at(beside_m, 0.003), at(beside_m, -0.03)))
}

fn ruptures(ticks: &[NeedleTick]) -> Vec<Rupture> {
    let rupture =
        |event: &PunctureEvent| if let PunctureEvent::Rupture(rupture) = event { Some(*rupture) } else { None };
    ticks.iter().flat_map(|tick| &tick.events).filter_map(rupture).collect()
}

/// Just under 2 mm, the distance within which a re-entry uses the same track.
const SAME_TRACK_M: f64 = 0.0019;

pub(super) fn same_track_ruptures() -> Measured {
    Ok(ruptures(&enter_again(SAME_TRACK_M)?).len() as f64)
}

pub(super) fn same_track_force() -> Measured {
    let elastic_n = |tick: NeedleTick| tick.output.axial.tip_n + tick.output.axial.rim_n;
    Ok(largest(enter_again(SAME_TRACK_M)?.into_iter().map(elastic_n)))
}

pub(super) fn beside_intact() -> Measured {
    let wanted = closed_form::predict_ruptures(&paper_axial_spec()).len();
    Ok(wanted.abs_diff(ruptures(&enter_again(0.003)?).len()) as f64)
}

/// At 60° every path length doubles.
pub(super) fn oblique_lateness() -> Measured {
    let angle = core::f64::consts::FRAC_PI_3;
    let axis = Vector3::new(libm::sin(angle), 0.0, -libm::cos(angle));
    let entry = Point3::new(0.01, 0.02, 0.0);
    let ticks = DrivenNeedle::new(paper_axial_spec(), vec![])?.travel(axis, entry - axis * 0.002, entry + axis * 0.05);
    let mut doubled = paper_axial_spec();
    for layer in &mut doubled.layers {
        layer.thickness_m *= 2.0;
    }
    Ok(latest_m(&ruptures(&ticks), &closed_form::predict_ruptures(&doubled)) * 1e6)
}
