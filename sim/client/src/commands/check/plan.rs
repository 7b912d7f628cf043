//! What simulating a scene comes to: layers as the needle meets them, ruptures in closed form, soundness, the model.

use mechanics::axial::{AxialSpec, Contactor};
use mechanics::{closed_form, soundness};
use scene::{ExerciseBundle, Patient, Scene, SceneLayer};
use serde::Serialize;

use crate::commands::contactor_name;

/// The plan of one scene, or of one exercise in its scene.
#[derive(Serialize)]
pub struct Plan {
    /// The exercise, for an exercise.
    pub exercise: Option<String>,
    /// The scene.
    pub scene: String,
    /// Angle to the surface normal, in degrees.
    pub angle_deg: f64,
    /// Layers from the surface down.
    pub layers: Vec<LayerPlan>,
    /// Ruptures of a slow insertion into the nominal patient.
    pub ruptures: Vec<RupturePlan>,
    /// Ruptures that would create force or energy, in any patient; in words.
    pub unsound: Vec<String>,
    /// Which tissue model is used.
    pub model: &'static str,
    /// Why.
    pub reason: &'static str,
}

/// A layer as the needle meets it.
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
    pub contactor: &'static str,
    /// Boundary, from 0.
    pub boundary: usize,
    /// Its layer.
    pub layer: String,
    /// Displacement of the tip along its path, in mm.
    pub x_mm: f64,
    /// Elastic force just before, in N.
    pub force_before_n: f64,
    /// Elastic force just after, in N.
    pub force_after_n: f64,
}

impl Plan {
    /// The plan of a scene met perpendicularly.
    pub fn of_scene(scene: &Scene) -> Self {
        Self::new(None, scene, 0.0)
    }

    /// The plan of an exercise at its angle.
    pub fn of_exercise(bundle: &ExerciseBundle) -> Self {
        Self::new(Some(bundle.exercise.id.clone()), &bundle.scene, bundle.exercise.angle_deg)
    }

    fn new(exercise: Option<String>, scene: &Scene, angle_deg: f64) -> Self {
        let nominal = spec(scene, &Patient::nominal(scene), angle_deg);
        Self {
            exercise,
            scene: scene.id.clone(),
            angle_deg,
            layers: scene.layers.iter().zip(&nominal.layers).map(LayerPlan::new).collect(),
            ruptures: ruptures(&nominal),
            unsound: unsound(scene, angle_deg),
            model: "none",
            reason: "the force law alone; this version has no model of the deforming tissue",
        }
    }
}

impl LayerPlan {
    fn new((written, met): (&SceneLayer, &mechanics::axial::Layer)) -> Self {
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

/// The axial law of a patient along an oblique path, whose thicknesses are d/cos θ.
fn spec(scene: &Scene, patient: &Patient, angle_deg: f64) -> AxialSpec {
    let mut spec = scene.puncture_spec(patient).axial;
    let path_factor = 1.0 / libm::cos(angle_deg.to_radians());
    for layer in &mut spec.layers {
        layer.thickness_m *= path_factor;
    }
    spec
}

fn ruptures(spec: &AxialSpec) -> Vec<RupturePlan> {
    let named = |boundary: usize| spec.layers.get(boundary).map_or_else(String::new, |layer| layer.name.clone());
    closed_form::ruptures(spec)
        .into_iter()
        .map(|rupture| RupturePlan {
            contactor: contactor_name(rupture.contactor),
            boundary: rupture.boundary,
            layer: named(rupture.boundary),
            x_mm: rupture.x_m * 1e3,
            force_before_n: rupture.force_before_n,
            force_after_n: rupture.force_after_n,
        })
        .collect()
}

/// Each unsound rupture once, in the first patient that has it: the nominal one, the thinnest, the thickest.
fn unsound(scene: &Scene, angle_deg: f64) -> Vec<String> {
    let mut known: Vec<(usize, Contactor)> = Vec::new();
    let mut found = Vec::new();
    for (who, side) in [("", 0.0), (" in the thinnest patient", -1.0), (" in the thickest patient", 1.0)] {
        for unsound in soundness::check(&spec(scene, &patient(scene, side), angle_deg)) {
            let rupture = (unsound.boundary, unsound.contactor);
            if !known.contains(&rupture) {
                known.push(rupture);
                found.push(format!("{unsound}{who}"));
            }
        }
    }
    found
}

/// The patient whose every layer is at one end of its spread: −1 the thinnest, 0 the nominal, +1 the thickest.
fn patient(scene: &Scene, side: f64) -> Patient {
    let thickness = |layer: &SceneLayer| (layer.thickness_mm + side * layer.thickness_spread_mm).max(0.0);
    Patient { thickness_mm: scene.layers.iter().map(thickness).collect() }
}
