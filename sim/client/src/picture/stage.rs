//! The constant part of the pictures of an attempt.

use std::path::Path;

use documents::{Channel, Exercise, ExerciseBundle, Feedback, Patient, Scene};
use law::Skin;
use law::puncture::PunctureSpec;
use law::structures::{StructureKind, StructureSpec};
use nalgebra::{Point3, Vector3};
use recording::Recording;
use render::frame::{
    self, DrawnBend, DrawnLayer, DrawnMaterial, DrawnNeedle, DrawnStructure, FieldTable, Mesh, OnHub, Stage, Tip,
};
use tissue::Specimen;
use tissue::follow::Profiles;

use crate::exit::Failure;
use crate::sources;

/// Builds the stage of an exercise on a patient. `file` is named in errors.
///
/// # Errors
/// If no model of the tissue can be made.
pub fn build_stage(file: &Path, bundle: &ExerciseBundle, specimen: &Specimen) -> Result<Stage, Failure> {
    let ExerciseBundle { exercise, scene, .. } = bundle;
    let spec = specimen.spec();
    let profiles = specimen.profiles().map_err(|error| Failure::refused(file, error))?;
    Ok(Stage {
        layers: drawn_layers(scene, spec),
        needle: drawn_needle(scene, spec),
        skin: scene.skin.as_ref().map(|skin| drawn_mesh(&skin.vertices_m, &skin.triangles)),
        bend: drawn_bend(&scene.skin_shape),
        structures: spec.structures.iter().map(drawn_structure).collect(),
        field: profiles.map(field_table).unwrap_or_default(),
        ..planned_stage(exercise)
    })
}

/// Builds the stage of a recording's own patient.
///
/// # Errors
/// If the law or the tissue rejects the scene.
pub fn stage_of_recording(path: &Path, bundle: &ExerciseBundle, recording: &Recording) -> Result<Stage, Failure> {
    let patient = Patient { thickness_mm: recording.session.patient_thickness_mm.clone() };
    build_stage(path, bundle, &sources::prepare_specimen(path, bundle, &patient)?)
}

fn drawn_bend(skin: &Skin) -> DrawnBend {
    let line = skin.line().map_or([0.0; 2], |line| [line.x, line.y]);
    match *skin {
        Skin::Flat => DrawnBend::Flat,
        Skin::Sphere { radius_m } => DrawnBend::Sphere(radius_m as f32),
        Skin::Cylinder { radius_m, .. } => {
            DrawnBend::Cylinder { radius_m: radius_m as f32, line: line.map(|part| part as f32) }
        }
    }
}

/// Returns the part of a stage that a trainee may see during an attempt.
pub fn hide_what_is_withheld(stage: &Stage, feedback: Feedback) -> Stage {
    Stage { target_m: stage.target_m.filter(|_| feedback.gives(Channel::Target)), ..stage.clone() }
}

/// A stage with the exercise's plan and nothing else.
fn planned_stage(exercise: &Exercise) -> Stage {
    Stage {
        entry_m: picture_point(&exercise.entry_m()),
        axis: picture_vector(&exercise.axis()),
        target_m: Some(picture_point(&exercise.target_m())),
        ..Stage::default()
    }
}

fn drawn_layers(scene: &Scene, spec: &PunctureSpec) -> Vec<DrawnLayer> {
    let mut top_m = 0.0;
    let both = scene.layers.iter().zip(&spec.axial.layers);
    both.map(|(document, layer)| {
        let thickness_m = layer.thickness_m as f32;
        let drawn =
            DrawnLayer { name: layer.name.clone(), material: drawn_material(&document.texture), top_m, thickness_m };
        top_m += thickness_m;
        drawn
    })
    .collect()
}

/// Unknown textures are drawn as muscle, the most common tissue.
pub(super) fn drawn_material(texture: &str) -> DrawnMaterial {
    match texture {
        "skin" => DrawnMaterial::Skin,
        "fat" => DrawnMaterial::Fat,
        "fascia" | "ligament" | "tendon" => DrawnMaterial::Fascia,
        "bone" => DrawnMaterial::Bone,
        "fluid" | "blood" => DrawnMaterial::Fluid,
        _ => DrawnMaterial::Muscle,
    }
}

fn drawn_needle(scene: &Scene, spec: &PunctureSpec) -> DrawnNeedle {
    let tip = match scene.needle.tip.as_str() {
        "bevel" | "tuohy" => Tip::Bevel,
        "conical" | "pencil-point" => Tip::Conical,
        "blunt" => Tip::Blunt,
        _ => Tip::Diamond,
    };
    DrawnNeedle {
        length_m: spec.needle_length_m as f32,
        diameter_m: (scene.needle.diameter_mm * 1e-3) as f32,
        tip_to_rim_m: spec.axial.tip_to_rim_m as f32,
        tip,
        hub: if scene.needle.hub == "syringe" { OnHub::Syringe } else { OnHub::Stylet },
    }
}

fn drawn_structure(spec: &StructureSpec) -> DrawnStructure {
    let (corners, triangles) = spec.surface();
    let kind = match spec.kind {
        StructureKind::Target => frame::DrawnStructureKind::Target,
        StructureKind::Vessel => frame::DrawnStructureKind::Vessel,
        StructureKind::Nerve => frame::DrawnStructureKind::Nerve,
        StructureKind::Bone => frame::DrawnStructureKind::Bone,
        StructureKind::Organ => frame::DrawnStructureKind::Organ,
    };
    DrawnStructure { name: spec.name.clone(), kind, mesh: drawn_mesh(&corners, &triangles) }
}

pub(super) fn drawn_mesh(corners: &[Point3<f64>], triangles: &[[u32; 3]]) -> Mesh {
    Mesh { positions_m: corners.iter().map(picture_point).collect(), triangles: triangles.to_vec() }
}

fn field_table(profiles: Profiles) -> FieldTable {
    let single = |values: Vec<f64>| values.into_iter().map(|value| value as f32).collect();
    FieldTable {
        radii_m: single(profiles.radii_m),
        loads: profiles.loads,
        axial_m_per_n: single(profiles.axial_m_per_n),
    }
}

fn picture_point(point: &Point3<f64>) -> [f32; 3] {
    picture_vector(&point.coords)
}

fn picture_vector(vector: &Vector3<f64>) -> [f32; 3] {
    vector.map(|c| c as f32).into()
}

#[cfg(test)]
mod tests {
    //! Fails if the skin is drawn elsewhere than the needle meets it: the needle would seem to hang
    //! in the air.

    use super::*;

    #[test]
    fn a_skin_is_drawn_where_the_force_law_has_it() {
        let cylinder = |along_rad| Skin::Cylinder { radius_m: 0.08, along_rad };
        for skin in [Skin::Flat, Skin::Sphere { radius_m: 0.06 }, cylinder(0.4), Skin::cylinder_along_y(0.11)] {
            let drawn = drawn_bend(&skin);
            for [x_m, y_m] in [[0.0, 0.0], [0.02, -0.01], [-0.03, 0.025], [0.0, 0.04]] {
                let off_m = f64::from(drawn.height_m([x_m as f32, y_m as f32])) - skin.above(x_m, y_m).z;
                assert!(off_m.abs() < 1e-7, "{skin:?} at {x_m}, {y_m} m: {off_m} m off");
            }
        }
    }
}
