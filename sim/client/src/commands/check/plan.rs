//! The plan of a scene's simulation: effective layers, ruptures in closed form, tissue model.

use documents::{ClassCounts, ExerciseBundle, Patient, PlannedNeedle, Remark, Scene, SceneLayer, spec_along_path};
use law::axial::{AxialSpec, Contactor, Layer, RuptureCriterion};
use law::closed_form;
use serde::Serialize;
use tissue::follow::FollowError;

use super::tissue::TissuePlan;

/// The plan of one scene, or of one exercise in its scene.
#[derive(Serialize)]
pub struct ScenePlan {
    /// Id of the exercise, if the plan is for one.
    pub exercise: Option<String>,
    /// Id of the scene.
    pub scene: String,
    /// Angle to the surface normal, in degrees.
    pub angle_deg: f64,
    /// Layers from the surface down.
    pub layers: Vec<LayerPlan>,
    /// Ruptures of a slow insertion into the nominal patient.
    pub ruptures: Vec<RupturePlan>,
    /// The needle for which they hold, if they depend on its speed or on the direction of its edge.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ruptures_hold_for: Vec<&'static str>,
    /// Numbers of the layers that are measured, derived from a measurement, or chosen.
    pub classes: ClassCounts,
    /// What the author should look at, though it is no finding.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// The deforming tissue.
    #[serde(flatten)]
    pub tissue: TissuePlan,
}

/// A layer with its effective values for the needle.
#[derive(Serialize)]
pub struct LayerPlan {
    /// Name.
    pub name: String,
    /// Thickness of the nominal patient, in mm.
    pub thickness_mm: f64,
    /// Spread between patients (±), in mm.
    pub thickness_spread_mm: f64,
    /// Boundary stiffness for this needle, in N/m.
    pub stiffness_n_per_m: f64,
    /// Friction for this needle and tissue, in N/m.
    pub friction_n_per_m: f64,
    /// Cutting force for this needle and tissue, in N.
    pub cutting_n: f64,
}

/// A rupture in closed form.
#[derive(Serialize)]
pub struct RupturePlan {
    /// `tip` or `rim`.
    pub contactor: Contactor,
    /// Index of the boundary, from 0.
    pub boundary: usize,
    /// Name of its layer.
    pub layer: String,
    /// Displacement of the tip along its path, in mm.
    pub x_mm: f64,
    /// Elastic force just before, in N.
    pub force_before_n: f64,
    /// Elastic force just after, in N.
    pub force_after_n: f64,
}

impl ScenePlan {
    /// The plan of a scene for a perpendicular needle.
    ///
    /// # Errors
    /// If no model of a coupled tissue can be made.
    pub fn of_scene(scene: &Scene) -> Result<Self, FollowError> {
        Self::new(None, scene, PlannedNeedle::default())
    }

    /// The plan of an exercise at its angle.
    ///
    /// # Errors
    /// Those of [`ScenePlan::of_scene`].
    pub fn of_exercise(bundle: &ExerciseBundle) -> Result<Self, FollowError> {
        Self::new(Some(bundle.exercise.id.clone()), &bundle.scene, bundle.exercise.planned_needle())
    }

    fn new(exercise: Option<String>, scene: &Scene, planned: PlannedNeedle) -> Result<Self, FollowError> {
        let spec = scene.coupled_spec(&Patient::nominal(scene), planned)?;
        let nominal = spec_along_path(spec, &planned.incidence(&scene.skin_shape));
        Ok(Self {
            exercise,
            ruptures_hold_for: needle_told(&nominal),
            scene: scene.id.clone(),
            angle_deg: planned.angle_deg,
            layers: scene
                .layers
                .iter()
                .zip(&nominal.layers)
                .map(|(written, met)| LayerPlan::new(written, met))
                .collect(),
            ruptures: ruptures(&nominal),
            classes: scene.count_classes(),
            warnings: list_warnings(scene),
            tissue: TissuePlan::new(scene, planned)?,
        })
    }
}

/// Lists measured numbers outside their range, and the losses of resistance before the last.
fn list_warnings(scene: &Scene) -> Vec<String> {
    let remarks = scene.list_departed_numbers().into_iter().chain(scene.remark_early_loss());
    remarks.map(|Remark { field, found, allowed }| format!("{field}: {found}; {allowed}")).collect()
}

impl LayerPlan {
    fn new(written: &SceneLayer, met: &Layer) -> Self {
        Self {
            name: written.name.clone(),
            thickness_mm: written.thickness_mm,
            thickness_spread_mm: written.thickness_spread_mm,
            stiffness_n_per_m: met.stiffness_n_per_m,
            friction_n_per_m: met.friction_n_per_m,
            cutting_n: met.cutting_n,
        }
    }
}

fn ruptures(spec: &AxialSpec) -> Vec<RupturePlan> {
    let named = |boundary: usize| spec.layers.get(boundary).map_or_else(String::new, |layer| layer.name.clone());
    closed_form::predict_ruptures(spec)
        .into_iter()
        .map(|rupture| RupturePlan {
            contactor: rupture.contactor,
            boundary: rupture.boundary,
            layer: named(rupture.boundary),
            x_mm: rupture.x_m * 1e3,
            force_before_n: rupture.force_before_n,
            force_after_n: rupture.force_after_n,
        })
        .collect()
}

/// Describes the needle of the closed form, if options of the law make needles differ.
fn needle_told(spec: &AxialSpec) -> Vec<&'static str> {
    let relaxing = |criterion| {
        let is_such = |layer: &Layer| layer.options.relaxes() && layer.options.gives_way_at == criterion;
        spec.layers.iter().any(is_such)
    };
    let slow = match [RuptureCriterion::Force, RuptureCriterion::Dent].map(relaxing) {
        [false, false] => None,
        [true, false] => Some("so slow that every boundary relaxes; a faster one opens it sooner"),
        [false, true] => Some("so slow that every boundary relaxes; a faster one opens it with more force"),
        [true, true] => Some("so slow that every boundary relaxes; a faster one opens it sooner or with more force"),
    };
    let plain = spec.has_sheets().then_some("its edge along the patient's x");
    slow.into_iter().chain(plain).collect()
}
