//! Contact with the skin: the entry point, the track, and the latched axis.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::axial::PLAIN_EDGE;
use crate::skin::{Incidence, Skin};

use super::state::{LastPose, PunctureEvent, PunctureInput, PunctureState};

/// Entries no farther apart than this, in m, share a track (physics section 2).
const TRACK_RADIUS_M: f64 = 0.002;
/// Maximum number of tracks; beyond it the nearest is reused, so that a step stays bounded.
pub(super) const MAX_TRACKS: usize = 64;

/// A puncture channel, with its open boundaries.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Track {
    /// First entry point, in m. Re-entries do not move it, or a track could creep over the skin.
    entry_m: Point3<f64>,
    tip_open: usize,
    rim_open: usize,
    /// Maximum material depth below the skin, perpendicular to it, in m: a re-entry may have
    /// another angle.
    deepest_m: f64,
    /// Cutting front below the skin, perpendicular to it, in m.
    #[serde(default)]
    front_m: Option<f64>,
}

/// The puncture in progress.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Latch {
    pub entry_m: Point3<f64>,
    pub axis: Vector3<f64>,
    #[serde(flatten)]
    pub incidence: Incidence,
    pub track: usize,
    /// δ⊥ at the last good sample, in m.
    pub offset_m: Vector3<f64>,
}

impl Latch {
    /// Axial displacement of a tip, and its offset from the latched line, both in m.
    pub fn resolve(&self, tip_m: &Point3<f64>) -> (f64, Vector3<f64>) {
        let from_entry = tip_m - self.entry_m;
        let x_m = from_entry.dot(&self.axis);
        (x_m, from_entry - self.axis * x_m)
    }
}

/// Latches the axis of a needle whose tip has just passed below the skin, and resumes or begins its
/// track.
pub(super) fn enter(skin: &Skin, state: &mut PunctureState, pose: &LastPose) -> PunctureEvent {
    let entry_m = entry_point(skin, state.last.as_ref(), pose);
    let incidence = skin.incidence(&entry_m, &pose.axis);
    let (track, reused) = choose_track(&mut state.tracks, entry_m);
    if let Some(known) = state.tracks.get(track) {
        state.axial.tip_open = known.tip_open;
        state.axial.rim_open = known.rim_open;
        state.axial.deepest_m = incidence.way_m(known.deepest_m);
        state.axial.front_m = known.front_m.map(|front_m| incidence.way_m(front_m));
    }
    state.axial.edge = edge_in_skin(&pose.edge);
    if !reused {
        state.open_walls.fill(false);
    }
    let mut latch = Latch { entry_m, axis: pose.axis, incidence, track, offset_m: Vector3::zeros() };
    latch.offset_m = latch.resolve(&pose.tip_m).1;
    state.latch = Some(latch);
    PunctureEvent::Contact { entry_m, track, reused }
}

/// Direction of an edge in the plane of the skin, of unit length; the default for an edge that
/// points straight in.
fn edge_in_skin(edge: &Vector3<f64>) -> [f64; 2] {
    let length = libm::hypot(edge.x, edge.y);
    if length > 1e-9 { [edge.x / length, edge.y / length] } else { PLAIN_EDGE }
}

/// Stores the state of the track that the needle has just left.
pub(super) fn leave(state: &mut PunctureState, latch: &Latch) {
    if let Some(track) = state.tracks.get_mut(latch.track) {
        track.tip_open = state.axial.tip_open;
        track.rim_open = state.axial.rim_open;
        track.deepest_m = latch.incidence.depth_m(state.axial.deepest_m);
        track.front_m = state.axial.front_m.map(|front_m| latch.incidence.depth_m(front_m));
    }
}

/// The intersection of the tip's path from the last sample with the skin; for a first sample
/// inside, that of its axis.
fn entry_point(skin: &Skin, last: Option<&LastPose>, pose: &LastPose) -> Point3<f64> {
    match last {
        Some(last) => skin.crossing(&last.tip_m, &pose.tip_m),
        None => skin.nearest(&(pose.tip_m - pose.axis * skin.displacement_m(&pose.tip_m, &pose.axis))),
    }
}

/// The track nearest to an entry if it is close enough or the maximum number is reached, otherwise
/// a new one.
fn choose_track(tracks: &mut Vec<Track>, entry_m: Point3<f64>) -> (usize, bool) {
    let nearest = tracks
        .iter()
        .enumerate()
        .map(|(index, track)| (index, (track.entry_m - entry_m).norm()))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    match nearest {
        Some((index, distance_m)) if distance_m <= TRACK_RADIUS_M || tracks.len() >= MAX_TRACKS => (index, true),
        _ => {
            tracks.push(Track { entry_m, tip_open: 0, rim_open: 0, deepest_m: 0.0, front_m: None });
            (tracks.len() - 1, false)
        }
    }
}

/// The needle's pose as the law uses it, or `None` if it is implausible.
pub(super) fn believe(state: &PunctureState, input: &PunctureInput) -> Option<LastPose> {
    /// Maximum plausible distance of the tip from the patient's origin, in m.
    const MAX_COORDINATE_M: f64 = 100.0;
    /// Allowed deviation of the square of the orientation's norm from 1.
    const UNIT_TOLERANCE: f64 = 1e-6;
    let pose = &input.patient_from_needle;
    let tip_m = Point3::from(pose.translation.vector);
    let axis = pose.rotation * Vector3::z();
    let believable = state.axial.is_later(input.t_s)
        && tip_m.iter().all(|coordinate| coordinate.abs() <= MAX_COORDINATE_M)
        && (pose.rotation.norm_squared() - 1.0).abs() <= UNIT_TOLERANCE;
    let edge = pose.rotation * Vector3::x();
    believable.then_some(LastPose { tip_m, axis, edge })
}
