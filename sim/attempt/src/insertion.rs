//! The needle's contacts with the skin, and the axes that the law latches there.

use law::{Incidence, Skin};
use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};
use recording::sample::flags;
use recording::{Event, EventKind, Recording, Sample};

/// A contact of the needle with the skin, which latches its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Insertion {
    /// Time of the contact, in s.
    pub from_s: f64,
    /// Entry point, in m, patient frame.
    pub entry_m: Point3<f64>,
    /// Latched axis from hub to tip, unit length.
    pub axis: Vector3<f64>,
    /// Index of the puncture track.
    pub track: u32,
}

impl Insertion {
    /// Returns the needle's incidence on the layers under a skin, as in the law.
    #[must_use]
    pub fn incidence(&self, skin: &Skin) -> Incidence {
        skin.incidence(&self.entry_m, &self.axis)
    }
}

/// Returns the needle's +z in the patient frame, unit length; straight down if the recorded
/// orientation is zero or not finite.
#[must_use]
pub fn needle_axis(sample: &Sample) -> Vector3<f64> {
    let [x, y, z, w] = sample.orientation;
    let axis = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)) * Vector3::z();
    if axis.iter().all(|c| c.is_finite()) { axis } else { -Vector3::z() }
}

/// Whether the tip is in the body.
#[must_use]
pub fn is_inserted(sample: &Sample) -> bool {
    sample.depth_m > 0.0 || sample.flags & flags::INSIDE != 0
}

/// Returns one insertion for each contact with the skin, in order of time; without contacts, one
/// from the first sample in the body. `samples` must be in order of time, with finite times.
pub fn find_insertions<'a>(events: &[Event], samples: impl Iterator<Item = &'a Sample> + Clone) -> Vec<Insertion> {
    let mut contacts: Vec<&Event> = events.iter().filter(|event| is_contact(event)).collect();
    contacts.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    let (mut rest, mut last, mut insertions) = (samples.clone().peekable(), None, Vec::with_capacity(contacts.len()));
    for contact in contacts {
        while let Some(before) = rest.next_if(|sample| sample.t_s < contact.t_s) {
            last = Some(before);
        }
        // The tick of the contact itself latches the axis.
        let Some(latched) = rest.peek().copied().or(last) else { break };
        let (entry_m, track) = (Point3::from(contact.position_m), contact.track.unwrap_or(0));
        insertions.push(Insertion { from_s: contact.t_s, entry_m, axis: needle_axis(latched), track });
    }
    if insertions.is_empty() {
        insertions.extend(samples.clone().find(|sample| is_inserted(sample)).map(begin_inside));
    }
    insertions
}

fn is_contact(event: &Event) -> bool {
    event.kind == EventKind::Contact && event.t_s.is_finite() && event.position_m.iter().all(|m| m.is_finite())
}

/// An insertion whose contact was not recorded.
fn begin_inside(sample: &Sample) -> Insertion {
    let axis = needle_axis(sample);
    let entry_m = Point3::from(sample.position_m) - axis * sample.x_m;
    Insertion { from_s: sample.t_s, entry_m, axis, track: 0 }
}

/// Returns the insertion that went furthest along its axis, and its advance in m; `None` if the
/// needle never met the skin.
#[must_use]
pub fn deepest_insertion(recording: &Recording) -> Option<(Insertion, f64)> {
    let samples = || recording.samples.iter().filter(|sample| sample.t_s.is_finite());
    let insertions = find_insertions(&recording.events, samples());
    let deepest = samples().filter(|sample| sample.x_m.is_finite()).max_by(|a, b| a.x_m.total_cmp(&b.x_m))?;
    let under_way = insertions.iter().rfind(|insertion| insertion.from_s <= deepest.t_s).or(insertions.first());
    under_way.map(|insertion| (*insertion, deepest.x_m.max(0.0)))
}

#[cfg(test)]
mod tests {
    //! Fails if an insertion has the axis of another moment than its contact's, or if a broken
    //! orientation is used.

    use super::*;

    fn sample(t_s: f64, lean_rad: f64) -> Sample {
        // Half a turn about x points the needle down; a turn about y before it tilts it.
        let (sin, cos) = (libm::sin(lean_rad / 2.0), libm::cos(lean_rad / 2.0));
        Sample { t_s, orientation: [cos, 0.0, sin, 0.0], x_m: t_s, depth_m: 0.001, ..Sample::default() }
    }

    fn contact(t_s: f64, track: u32) -> Event {
        Event {
            t_s,
            kind: EventKind::Contact,
            boundary: None,
            x_m: 0.0,
            position_m: [0.0; 3],
            force_n: 0.0,
            dissipated_j: 0.0,
            track: Some(track),
            structure: None,
            text: String::new(),
        }
    }

    #[test]
    fn each_insertion_has_the_axis_of_the_tick_of_its_contact() {
        let samples = [sample(0.0, 0.1), sample(1.0, 0.2), sample(2.0, 0.3), sample(3.0, 0.4)];
        let found = find_insertions(&[contact(2.5, 1), contact(1.0, 0)], samples.iter());
        let told: Vec<_> = found.iter().map(|i| (i.track, libm::acos(-i.axis.z))).collect();
        assert_eq!(told.iter().map(|t| t.0).collect::<Vec<_>>(), [0, 1]);
        assert!((told[0].1 - 0.2).abs() < 1e-12 && (told[1].1 - 0.4).abs() < 1e-12, "{told:?}");
    }

    #[test]
    fn insertion_without_contact_begins_at_the_first_sample_inside() {
        let mut samples = [sample(0.0, 0.0), sample(1.0, 0.2)];
        samples[0].depth_m = 0.0;
        let found = find_insertions(&[], samples.iter());
        assert_eq!(found.iter().map(|i| i.from_s).collect::<Vec<_>>(), [1.0]);
        assert!(find_insertions(&[], samples[..1].iter()).is_empty());
    }

    #[test]
    fn a_broken_orientation_points_straight_down() {
        let broken = Sample { orientation: [f64::NAN; 4], ..Sample::default() };
        assert_eq!(needle_axis(&broken), -Vector3::z());
        assert_eq!(needle_axis(&sample(0.0, 0.0)), -Vector3::z());
    }
}
