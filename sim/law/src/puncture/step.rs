//! One step of the puncture.

use nalgebra::Vector3;

use super::contact::{Latch, believe, enter, leave};
use super::params::PunctureParams;
use super::state::{LastPose, PunctureEvent, PunctureInput, PunctureOutput, PunctureScratch, PunctureState};
use crate::axial::{self, AxialInput, AxialOutput, PiercingStage};
use crate::beam::Bend;
use crate::hold::Hold;
use crate::skin::{Incidence, Skin};
use crate::stance::Intrusion;
use crate::structures::{Meeting, Shaft, Sighting, Structure, StructureKind};

/// How far the hub must be clear of the skin before it can meet it again, in m: a hand that trembles there meets it once.
const HUB_CLEAR_M: f64 = 0.0005;

/// One step. Never fails: a bad input is held, flagged and reported as an event.
pub fn step(
    params: &PunctureParams,
    state: &mut PunctureState,
    scratch: &mut PunctureScratch,
    input: &PunctureInput,
) -> PunctureOutput {
    scratch.events.clear();
    let Some(pose) = believe(state, input) else {
        scratch.events.push(PunctureEvent::Fault);
        let axial = AxialOutput { held: true, ..state.axial.last_output() };
        let side = SidewaysNeedle::new(state, params.bend(axial.depth_m));
        survey_structures(params, state, scratch, &side);
        return assemble_output(params, state, scratch, axial, &side);
    };
    let left = cross_skin(params.skin(), state, scratch, &pose);
    state.last = Some(pose);
    let axial = advance_axially(params, state, scratch, input.t_s, left.as_ref());
    let bend = params.bend(axial.depth_m);
    press_sideways(params, state, scratch, &bend);
    if let Some(latch) = left {
        leave(state, &latch);
        scratch.events.push(PunctureEvent::SkinExit);
    }
    let side = SidewaysNeedle::new(state, bend);
    survey_structures(params, state, scratch, &side);
    report_hits(state, scratch);
    report_hub(params, state, scratch);
    open_walls(params, state, scratch, &side);
    hold_on_bone(params, state, scratch, &side);
    assemble_output(params, state, scratch, axial, &side)
}

/// Writes the needle's loads on the tissue after the last step into `loads_n`, in N, like
/// [`axial::write_loads`]. Never allocates.
pub fn write_loads(params: &PunctureParams, state: &PunctureState, scratch: &PunctureScratch, loads_n: &mut [f64]) {
    axial::write_loads(&params.axial, &state.axial.standing(), &scratch.axial, loads_n);
}

/// Position of the needle in its current track; `None` in the air.
#[must_use]
pub fn measure_intrusion(params: &PunctureParams, state: &PunctureState) -> Option<Intrusion> {
    state.latch.as_ref().map(|_| Intrusion {
        tip_m: displacement_m(params, state),
        tip_to_rim_m: params.axial.spec().tip_to_rim_m,
        tip_open: state.axial.tip_open,
        rim_open: state.axial.rim_open,
    })
}

/// Incidence of a needle in the tissue; `None` in the air.
#[must_use]
pub fn held_incidence(state: &PunctureState) -> Option<Incidence> {
    state.latch.as_ref().map(|latch| latch.incidence)
}

/// Lateral state of the needle: a function of the state after the step, which is why a held sample
/// repeats it.
struct SidewaysNeedle {
    /// Lateral force on the hand, in N.
    force_n: Vector3<f64>,
    /// Offset of the tip from the hand's line, in m.
    bend_m: Vector3<f64>,
}

impl SidewaysNeedle {
    fn new(state: &PunctureState, bend: Bend) -> Self {
        let Some(Latch { offset_m, .. }) = state.latch else {
            return Self { force_n: Vector3::zeros(), bend_m: Vector3::zeros() };
        };
        Self { force_n: offset_m * -bend.stiffness_n_per_m, bend_m: offset_m * (bend.tip_share - 1.0) }
    }
}

/// Enters or leaves the body if the tip has crossed the skin. Returns the puncture that was just
/// left, if any.
fn cross_skin(skin: &Skin, state: &mut PunctureState, scratch: &mut PunctureScratch, pose: &LastPose) -> Option<Latch> {
    let height_m = skin.height_m(&pose.tip_m);
    if state.latch.is_some() && height_m > 0.0 {
        return state.latch.take();
    }
    if state.latch.is_none() && height_m < 0.0 {
        scratch.events.push(enter(skin, state, pose));
    }
    None
}

/// Steps the axial law on the needle's displacement.
///
/// The tick that leaves the body still runs on the track it leaves, with the tip above the skin, so
/// that all energy stored there is returned or lost and none is carried into the air.
fn advance_axially(
    params: &PunctureParams,
    state: &mut PunctureState,
    scratch: &mut PunctureScratch,
    t_s: f64,
    left: Option<&Latch>,
) -> AxialOutput {
    let incidence = state.latch.as_ref().or(left).map_or(Incidence::UPRIGHT, |latch| latch.incidence);
    let input = AxialInput { t_s, x_m: displacement_m(params, state), incidence };
    let output = axial::step(&params.axial, &mut state.axial, &mut scratch.axial, &input);
    scratch.events.extend(scratch.axial.ruptures.iter().copied().map(PunctureEvent::Rupture));
    output
}

/// Presses the needle against the sides of its track, and books the work.
fn press_sideways(params: &PunctureParams, state: &mut PunctureState, scratch: &PunctureScratch, bend: &Bend) {
    if let (Some(latch), Some(last)) = (&mut state.latch, &state.last) {
        let offset_m = latch.resolve(&last.tip_m).1;
        let work_j = bend.stiffness_n_per_m * offset_m.norm() * (offset_m - latch.offset_m).norm();
        latch.offset_m = offset_m;
        axial::book_lateral(&params.axial, &mut state.axial, &scratch.axial, work_j);
    }
}

/// x at the last good sample, in m; 0 before the first.
fn displacement_m(params: &PunctureParams, state: &PunctureState) -> f64 {
    match (&state.last, &state.latch) {
        (Some(pose), Some(latch)) => latch.resolve(&pose.tip_m).0,
        (Some(pose), None) => params.skin().displacement_m(&pose.tip_m, &pose.axis),
        (None, _) => 0.0,
    }
}

/// Finds the structures that the needle of the last good sample touches. A distant structure is not
/// searched again before the needle can have reached it: this changes no bit of the result.
fn survey_structures(
    params: &PunctureParams,
    state: &PunctureState,
    scratch: &mut PunctureScratch,
    side: &SidewaysNeedle,
) {
    let PunctureScratch { meetings, sightings, .. } = scratch;
    meetings.clear();
    let Some(shaft) = shaft(state, side) else { return };
    for (structure, sighting) in params.structures.iter().zip(sightings) {
        let least_m = sighting.map_or(f64::NEG_INFINITY, |seen: Sighting| seen.least_m(&shaft));
        if least_m > 0.0 {
            meetings.push(Meeting { distance_m: least_m, tip_inside: false });
            continue;
        }
        let meeting = structure.meet(&shaft);
        *sighting = Some(Sighting { shaft, distance_m: meeting.distance_m });
        meetings.push(meeting);
    }
}

/// The needle of the last good sample; `None` before it.
fn shaft(state: &PunctureState, side: &SidewaysNeedle) -> Option<Shaft> {
    let tip_m = state.last.as_ref()?.tip_m + side.bend_m;
    Some(Shaft { entry_m: state.latch.as_ref().map_or(tip_m, |latch| latch.entry_m), tip_m })
}

/// Smallest distance of the tip, or of the inserted shaft, to any structure that is not a target,
/// in m; infinite without such a structure. Not needed by a step, and costs a search of each
/// structure.
#[must_use]
pub fn measure_clearance_m(params: &PunctureParams, state: &PunctureState) -> f64 {
    let side = SidewaysNeedle::new(state, params.bend(state.axial.last_output().depth_m));
    let others = params.structures.iter().filter(|structure| structure.kind() != StructureKind::Target);
    let distances_m = shaft(state, &side).map(|shaft| others.map(move |other| other.meet(&shaft).distance_m));
    distances_m.into_iter().flatten().fold(f64::INFINITY, f64::min)
}

/// Reports each structure that the needle has entered since the last step.
fn report_hits(state: &mut PunctureState, scratch: &mut PunctureScratch) {
    for (structure, (meeting, touching)) in scratch.meetings.iter().zip(&mut state.touching).enumerate() {
        let touches = meeting.distance_m <= 0.0;
        if touches && !*touching {
            scratch.events.push(PunctureEvent::StructureHit { structure, by_tip: meeting.tip_inside });
        }
        *touching = touches;
    }
}

/// Reports a hub that has come to the skin, once until it has been clear of it by [`HUB_CLEAR_M`].
fn report_hub(params: &PunctureParams, state: &mut PunctureState, scratch: &mut PunctureScratch) {
    let depth_m = state.latch.as_ref().and_then(|_| params.hub_depth_m(displacement_m(params, state)));
    let Some(depth_m) = depth_m else {
        state.hub_touches = false;
        return;
    };
    if depth_m >= 0.0 && !state.hub_touches {
        scratch.events.push(PunctureEvent::HubContact);
        state.hub_touches = true;
    }
    state.hub_touches &= depth_m > -HUB_CLEAR_M;
}

/// Opens the walls that the tip presses on with what they hold.
fn open_walls(params: &PunctureParams, state: &mut PunctureState, scratch: &PunctureScratch, side: &SidewaysNeedle) {
    let Some(pose) = &state.last else { return };
    let tip_m = pose.tip_m + side.bend_m;
    for ((structure, meeting), open) in params.structures.iter().zip(&scratch.meetings).zip(&mut state.open_walls) {
        *open = *open || meeting.tip_inside && structure.opens_wall(&tip_m);
    }
}

/// Updates the contact of the tip with every bone that it pushes on.
fn hold_on_bone(params: &PunctureParams, state: &mut PunctureState, scratch: &PunctureScratch, side: &SidewaysNeedle) {
    let Some(pose) = state.last.as_ref().filter(|_| params.bone_holds()) else { return };
    let tip_m = pose.tip_m + side.bend_m;
    for ((structure, meeting), hold) in params.structures.iter().zip(&scratch.meetings).zip(&mut state.holds) {
        // A bone without contact takes hold of a tip that is inside: the survey has already
        // determined this, and a second search would cost as much.
        if structure.kind() == StructureKind::Bone && (hold.is_some() || meeting.tip_inside) {
            *hold = Hold::follow(hold.as_ref(), structure, &tip_m);
        }
    }
}

/// The output as a function of the state after the step, which is why a held sample repeats it.
fn assemble_output(
    params: &PunctureParams,
    state: &PunctureState,
    scratch: &PunctureScratch,
    axial: AxialOutput,
    side: &SidewaysNeedle,
) -> PunctureOutput {
    let (stage, boundary) = piercing_stage(params, state);
    let (structures_n, bone_n) = structure_forces(params, state, scratch, side);
    let axis = state.latch.as_ref().map_or_else(Vector3::zeros, |latch| latch.axis);
    let x_m = displacement_m(params, state);
    let hub_n = state.latch.as_ref().and_then(|_| params.hub_depth_m(x_m)).map_or(0.0, |m| params.hub_force_n(m));
    PunctureOutput {
        x_m,
        axial,
        lateral_n: side.force_n,
        bend_m: side.bend_m,
        structures_n,
        bone_n: bone_n.norm(),
        hub_n,
        hand_n: axial.total_n() + hub_n - axis.dot(&structures_n),
        force_n: axis * -(axial.total_n() + hub_n) + side.force_n + structures_n,
        stage,
        boundary,
        inside: state.latch.is_some(),
    }
}

/// Force of all structures on the tip, and that of bone alone, in N.
fn structure_forces(
    params: &PunctureParams,
    state: &PunctureState,
    scratch: &PunctureScratch,
    side: &SidewaysNeedle,
) -> (Vector3<f64>, Vector3<f64>) {
    let (mut all_n, mut bone_n) = (Vector3::zeros(), Vector3::zeros());
    let Some(pose) = &state.last else { return (all_n, bone_n) };
    let tip_m = pose.tip_m + side.bend_m;
    let met = params.structures.iter().zip(&state.open_walls).zip(&scratch.meetings);
    let held = |structure: &Structure| params.bone_holds() && structure.kind() == StructureKind::Bone;
    for hold in state.holds.iter().flatten() {
        bone_n += hold.force_n();
    }
    all_n += bone_n;
    for ((structure, &open), _) in met.filter(|((structure, _), meeting)| meeting.tip_inside && !held(structure)) {
        let force_n = structure.tip_force_n(&tip_m, open);
        all_n += force_n;
        if structure.kind() == StructureKind::Bone {
            bone_n += force_n;
        }
    }
    (all_n, bone_n)
}

/// Stage of the first boundary that is not fully open, or of the last if all are. Untouched in the
/// air.
fn piercing_stage(params: &PunctureParams, state: &PunctureState) -> (PiercingStage, usize) {
    let spec = params.axial.spec();
    let (tip_open, rim_open) = (state.axial.tip_open, state.axial.rim_open);
    let forces = state.axial.last_output();
    if state.latch.is_none() {
        return (PiercingStage::Untouched, 0);
    }
    let boundary = if spec.tip_to_rim_m > 0.0 { rim_open } else { tip_open };
    if boundary >= spec.layers.len() {
        return (PiercingStage::RimThrough, spec.layers.len() - 1);
    }
    let stage = match (tip_open > boundary, forces.tip_n > 0.0, forces.rim_n > 0.0) {
        (false, false, _) => PiercingStage::Untouched,
        (false, true, _) => PiercingStage::TipTents,
        (true, _, false) => PiercingStage::TipThrough,
        (true, _, true) => PiercingStage::RimTents,
    };
    (stage, boundary)
}
