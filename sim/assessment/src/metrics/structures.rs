//! Structures hit, and how close the shaft came to each.

use ::attempt::is_inserted;
use documents::{SceneStructure, StructureKind};
use nalgebra::Point3;
use recording::EventKind;

use super::MetricSheet;
use crate::attempt::{Attempt, Outcome};
use crate::catalogue::Direction;
use crate::distance::{MeasuredStructure, Segment, resolution_m};

/// What is to be avoided, and then what is to be met.
const KINDS: [StructureKind; 5] =
    [StructureKind::Vessel, StructureKind::Nerve, StructureKind::Bone, StructureKind::Organ, StructureKind::Target];

pub(super) fn measure_structures(attempt: &Attempt, sheet: &mut MetricSheet) {
    sheet.put("structure_hits", count_structure_hits(attempt, |kind| kind != Some(StructureKind::Target)));
    for kind in KINDS {
        sheet.put_for("structure_hits", kind.word(), count_structure_hits(attempt, |hit| hit == Some(kind)));
    }
    for structure in &attempt.bundle.scene.structures {
        let outcome = attempt.touched().map(|_| clearance_mm(attempt, structure));
        sheet.put_for("structure_clearance_mm", &structure.spec.name, outcome);
        if structure.kind() == StructureKind::Target {
            sheet.turn(Direction::Lower);
        }
    }
}

/// A hit of a structure that the scene does not know has no kind, and counts against the trainee.
fn count_structure_hits(attempt: &Attempt, counts: impl Fn(Option<StructureKind>) -> bool) -> Outcome {
    attempt.touched()?;
    let kind = |index: Option<u32>| {
        let index = usize::try_from(index?).ok()?;
        attempt.bundle.scene.structures.get(index).map(SceneStructure::kind)
    };
    let hits = attempt.recording.events.iter().filter(|e| e.kind == EventKind::StructureHit);
    Ok(hits.filter(|e| counts(kind(e.structure))).count() as f64)
}

/// The least distance over all samples, from the entry to the tip, as hits are told in the simulation. A segment cannot come closer to anything by more than its ends have moved, so
/// most samples need no look at the structure at all.
fn clearance_mm(attempt: &Attempt, structure: &SceneStructure) -> f64 {
    let measured = MeasuredStructure::new(&structure.spec);
    let resolution_m = resolution_m(&structure.spec.shape);
    let mut least_m = f64::INFINITY;
    let mut looked: Option<(Segment, f64)> = None;
    for (sample, insertion) in attempt.ticks() {
        let to = Point3::from(sample.tip_m());
        let from = insertion.filter(|_| is_inserted(sample)).map_or(to, |insertion| insertion.entry_m);
        let segment = Segment { from, to };
        let at_least_m = looked.as_ref().map_or(0.0, |(seen, distance_m)| distance_m - seen.moved_m(&segment));
        if at_least_m < least_m - resolution_m || looked.is_none() {
            let distance_m = measured.distance_m(&segment);
            least_m = least_m.min(distance_m);
            looked = Some((segment, distance_m));
        }
    }
    least_m * 1e3
}
