//! Whether the planned way in is free of bone, and where a free one is.

use law::Incidence;
use law::structures::{Obstacles, StructureKind};
use phrase::{Phrase, phrase};

use crate::describe::one_of;
use crate::error::Remark;
use crate::load::ExerciseBundle;
use crate::model::Scene;
use crate::planned::PlannedNeedle;
use crate::structure_names::name_structure;

/// A target may lie on bone: what is met within so much of the end of the way does not block it, in m.
const END_M: f64 = 1e-3;
/// Other ways are tried up to this angle to the skin's normal, in degrees, in steps of the second and third: angle and azimuth.
const MOST_DEG: u32 = 45;
const STEP_DEG: usize = 1;
const TURN_DEG: usize = 15;

impl ExerciseBundle {
    /// The remark on a planned way that meets bone before the target; none where the way is free.
    #[must_use]
    pub(crate) fn remark_blocked_way(&self) -> Option<Remark> {
        let target_m = self.exercise.target_depth_mm * 1e-3;
        remark_blocked_way(&self.scene, &self.exercise.planned_needle(), target_m, "entry.angle_deg")
    }
}

impl Scene {
    /// The same for a way that a scene plans to a layer, or else through all of its layers to the last.
    /// A goal that is not among the layers gives a remark, too.
    #[must_use]
    pub(crate) fn remark_blocked_way(&self, planned: &PlannedNeedle, goal: Option<&str>) -> Option<Remark> {
        let names: Vec<&str> = self.layers.iter().map(|layer| layer.name.as_str()).collect();
        let above = match goal {
            Some(goal) => names.iter().position(|name| *name == goal),
            None => Some(names.len().saturating_sub(1)),
        };
        let Some(above) = above else {
            let found = Phrase::quoted(goal.unwrap_or_default());
            return Some(Remark { field: "anatomy.goal".to_owned(), found, allowed: one_of(&names) });
        };
        let depth_m: f64 = self.layers.iter().take(above).map(|layer| layer.thickness_mm * 1e-3).sum();
        let incidence: Incidence = planned.incidence(&self.skin_shape);
        remark_blocked_way(self, planned, incidence.way_m(depth_m), "anatomy.angle_deg")
    }
}

fn remark_blocked_way(scene: &Scene, planned: &PlannedNeedle, length_m: f64, field: &str) -> Option<Remark> {
    let specs: Vec<_> = scene.structures.iter().map(|structure| structure.spec.clone()).collect();
    // A structure that makes no sense is refused elsewhere.
    let bones = Obstacles::new(&specs, StructureKind::Bone).ok()?;
    let meets = |way: &PlannedNeedle| {
        let (entry_m, axis) = (way.entry_m(&scene.skin_shape), way.axis(&scene.skin_shape));
        bones.first_met(&entry_m, &axis, length_m - END_M)
    };
    let (name, met_m) = meets(planned)?;
    let found = phrase!(
        "the planned needle meets {bone} at {depth} mm",
        bone = name_structure(name),
        depth = Phrase::number(met_m * 1e3, 1)
    );
    let allowed = match find_nearest_free(planned, |way| meets(way).is_none(), scene) {
        Some(free) => phrase!(
            "allowed: a path free of bone, the nearest at {angle}° towards {azimuth}°; or another entry or patient",
            angle = Phrase::number(free.angle_deg, 0),
            azimuth = Phrase::number(free.azimuth_deg, 0)
        ),
        None => {
            phrase!("allowed: a path free of bone; none exists from this entry, so choose another entry or patient")
        }
    };
    Some(Remark { field: field.to_owned(), found, allowed })
}

/// The free way from the same entry that turns the needle least.
fn find_nearest_free(
    planned: &PlannedNeedle,
    is_free: impl Fn(&PlannedNeedle) -> bool,
    scene: &Scene,
) -> Option<PlannedNeedle> {
    let axis = planned.axis(&scene.skin_shape);
    let azimuths = (0..360).step_by(TURN_DEG).map(f64::from);
    let angles = (0..=MOST_DEG).step_by(STEP_DEG).map(f64::from);
    let ways = angles.flat_map(|angle_deg| {
        azimuths.clone().map(move |azimuth_deg| PlannedNeedle { angle_deg, azimuth_deg, ..*planned })
    });
    let mut ways: Vec<(f64, PlannedNeedle)> = ways.map(|way| (way.axis(&scene.skin_shape).dot(&axis), way)).collect();
    ways.sort_by(|one, other| other.0.total_cmp(&one.0));
    ways.into_iter().map(|(_, way)| way).find(is_free)
}
