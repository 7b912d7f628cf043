//! Structures hit, and the clearance of the shaft from each.

use ::attempt::{Insertion, is_inserted};
use documents::{SceneStructure, StructureKind};
use nalgebra::Point3;
use recording::{EventKind, Sample};

use super::{Id, MetricSheet};
use crate::attempt::{Attempt, Outcome};
use crate::catalogue::Direction;
use crate::distance::{MeasuredStructure, Segment, resolution_m};

/// Kinds to avoid, and last the kind to reach.
const KINDS: [StructureKind; 5] =
    [StructureKind::Vessel, StructureKind::Nerve, StructureKind::Bone, StructureKind::Organ, StructureKind::Target];

pub(super) fn measure_structures(attempt: &Attempt, sheet: &mut MetricSheet) {
    sheet.put("structure_hits", count_structure_hits(attempt, |kind| kind != Some(StructureKind::Target)));
    for kind in KINDS {
        sheet.put_for("structure_hits", kind.word(), count_structure_hits(attempt, |hit| hit == Some(kind)));
    }
    measure_contacts(attempt, sheet);
    for structure in &attempt.bundle.scene.structures {
        let outcome = attempt.touched().map(|_| clearance_mm(attempt, structure));
        sheet.put_for("structure_clearance_mm", &structure.spec.name, outcome);
        if structure.kind() == StructureKind::Target {
            sheet.turn(Direction::Lower);
        }
    }
}

/// Counts hits. A hit of a structure that the scene does not contain has no kind and counts against
/// the trainee.
fn count_structure_hits(attempt: &Attempt, counts: impl Fn(Option<StructureKind>) -> bool) -> Outcome {
    attempt.touched()?;
    let kind = |index: Option<u32>| {
        let index = usize::try_from(index?).ok()?;
        attempt.bundle.scene.structures.get(index).map(SceneStructure::kind)
    };
    let hits = attempt.recording.events.iter().filter(|e| e.kind == EventKind::StructureHit);
    Ok(hits.filter(|e| counts(kind(e.structure))).count() as f64)
}

/// Records the second version of hits: contacts, counted for each structure.
fn measure_contacts(attempt: &Attempt, sheet: &mut MetricSheet) {
    let structures = &attempt.bundle.scene.structures;
    let contacts: Vec<usize> = (0..structures.len()).map(|index| count_contacts(attempt, index)).collect();
    let of_kinds = |counts: &dyn Fn(StructureKind) -> bool| -> usize {
        structures.iter().zip(&contacts).filter(|(s, _)| counts(s.kind())).map(|(_, contacts)| contacts).sum()
    };
    // As in the first version, hits of unknown structures count.
    let unknown = hits(attempt).filter(|index| index.is_none_or(|index| index >= structures.len())).count();
    let all = of_kinds(&|kind| kind != StructureKind::Target) + unknown;
    sheet.put_anew("structure_hits", attempt.touched().map(|_| all as f64));
    for kind in KINDS {
        let of_kind = of_kinds(&|other| other == kind);
        sheet.enter(Id::second("structure_hits").by(kind.word()), attempt.touched().map(|_| of_kind as f64));
    }
}

/// Returns the index of the structure of each hit.
fn hits(attempt: &Attempt) -> impl Iterator<Item = Option<usize>> {
    let hits = attempt.recording.events.iter().filter(|e| e.kind == EventKind::StructureHit);
    hits.map(|e| usize::try_from(e.structure?).ok())
}

/// Counts the hits of a structure that the needle had left before.
fn count_contacts(attempt: &Attempt, index: usize) -> usize {
    let Some(structure) = attempt.bundle.scene.structures.get(index) else { return 0 };
    let of_structure = |e: &&recording::Event| {
        e.kind == EventKind::StructureHit && e.structure.and_then(|s| usize::try_from(s).ok()) == Some(index)
    };
    let hits_s: Vec<f64> = attempt.recording.events.iter().filter(of_structure).map(|e| e.t_s).collect();
    let [first_s, again_s @ ..] = hits_s.as_slice() else { return 0 };
    let mut again_s = again_s.iter().peekable();
    let mut contacts = 1;
    let mut clearing = Clearing::new(MeasuredStructure::new(&structure.spec));
    for (sample, insertion) in attempt.ticks().filter(|(sample, _)| sample.t_s > *first_s) {
        if again_s.peek().is_none() {
            break;
        }
        clearing.see(sample.t_s, needle_at(sample, insertion));
        while again_s.next_if(|hit_s| **hit_s <= sample.t_s).is_some() {
            contacts += usize::from(clearing.begin_anew());
        }
    }
    contacts
}

/// Distance at which a needle has left a structure, in m.
const CLEAR_M: f64 = 0.5e-3;
/// Time without contact after which it has left, too, in s.
const CLEAR_S: f64 = 0.3;

/// Detects whether a needle has left a structure since the last contact.
struct Clearing<'a> {
    measured: MeasuredStructure<'a>,
    /// The needle and its distance, in m, when the distance was last computed.
    looked: Option<(Segment, f64)>,
    clear_since_s: Option<f64>,
    has_left: bool,
}

impl<'a> Clearing<'a> {
    fn new(measured: MeasuredStructure<'a>) -> Self {
        Self { measured, looked: None, clear_since_s: None, has_left: false }
    }

    fn see(&mut self, t_s: f64, needle: Segment) {
        let distance_m = self.distance_m(needle);
        if distance_m <= 0.0 {
            self.clear_since_s = None;
            return;
        }
        let since_s = *self.clear_since_s.get_or_insert(t_s);
        self.has_left = self.has_left || distance_m >= CLEAR_M || t_s - since_s >= CLEAR_S;
    }

    /// Returns the distance or a lower bound: a needle that was far away cannot be near before it
    /// has moved that far.
    fn distance_m(&mut self, needle: Segment) -> f64 {
        if let Some((seen, distance_m)) = &self.looked {
            let at_least_m = distance_m - seen.moved_m(&needle);
            if at_least_m >= CLEAR_M {
                return at_least_m;
            }
        }
        let distance_m = self.measured.distance_m(&needle);
        self.looked = Some((needle, distance_m));
        distance_m
    }

    /// Registers a new contact; returns whether the needle had left the structure.
    fn begin_anew(&mut self) -> bool {
        self.clear_since_s = None;
        std::mem::take(&mut self.has_left)
    }
}

/// Returns the needle as the simulation uses it for hits: from the entry to the tip; outside the
/// body only the tip.
fn needle_at(sample: &Sample, insertion: Option<&Insertion>) -> Segment {
    let to = Point3::from(sample.tip_m());
    Segment { from: insertion.filter(|_| is_inserted(sample)).map_or(to, |insertion| insertion.entry_m), to }
}

/// Returns the smallest distance over all samples. A segment cannot come closer by more than its
/// ends have moved, so most samples need no distance query.
fn clearance_mm(attempt: &Attempt, structure: &SceneStructure) -> f64 {
    let measured = MeasuredStructure::new(&structure.spec);
    let resolution_m = resolution_m(&structure.spec.shape);
    let mut least_m = f64::INFINITY;
    let mut looked: Option<(Segment, f64)> = None;
    for (sample, insertion) in attempt.ticks() {
        let segment = needle_at(sample, insertion);
        let at_least_m = looked.as_ref().map_or(0.0, |(seen, distance_m)| distance_m - seen.moved_m(&segment));
        if at_least_m < least_m - resolution_m || looked.is_none() {
            let distance_m = measured.distance_m(&segment);
            least_m = least_m.min(distance_m);
            looked = Some((segment, distance_m));
        }
    }
    least_m * 1e3
}
