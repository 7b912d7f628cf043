//! What does not move in a replay: layers, needle, structures, events.

use attempt::{AttemptCurve, CurveMark, LayerSpan, MarkKind, patient_thicknesses_m};
use documents::ExerciseBundle;
use law::Skin;
use law::structures::{StructureKind, StructureSpec, Surface};
use recording::Recording;
use serde::Serialize;
use utoipa::ToSchema;

use super::coarse::coarsen_to;
use super::frames::Frames;

/// Most triangles of a structure that are sent; a finer mesh is made coarser.
const MOST_TRIANGLES: usize = 2000;
/// Most triangles of a patient's skin.
const MOST_OF_SKIN: usize = 6000;

/// What does not move. Lengths in mm in the patient frame, +z out of the body; along the needle where that is said.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = Stage)]
pub struct ReplayStage {
    /// Title of the exercise.
    pub title: String,
    /// Length of the attempt, in s.
    pub duration_s: f64,
    /// What each frame holds, in order.
    pub columns: Vec<String>,
    /// Layers from the surface down.
    pub layers: Vec<StageLayer>,
    /// Where the needle should enter.
    pub entry_mm: [f64; 3],
    /// Where its tip should stop.
    pub target_mm: [f64; 3],
    /// How far in that is, along the needle, in mm.
    pub target_depth_mm: f64,
    /// The needle.
    pub needle: StageNeedle,
    /// Structures inside the body.
    pub structures: Vec<StageStructure>,
    /// Where each puncture whose blood a frame holds is on the skin.
    pub entries_mm: Vec<[f64; 3]>,
    /// How skin and layers bend away from z = 0, which the skin touches at the origin; none where they are flat.
    pub bend: Option<StageBend>,
    /// The skin of the whole patient, where the scene brings one.
    pub skin: Option<StageMesh>,
    /// What happened, in order of time.
    pub events: Vec<Happening>,
}

/// A layer.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = Layer)]
pub struct StageLayer {
    /// Name.
    pub name: String,
    /// The texture, which chooses its colour.
    pub texture: String,
    /// Where it begins below the skin, in mm, straight down.
    pub top_mm: f64,
    /// Where it ends below the skin, in mm, straight down.
    pub bottom_mm: f64,
    /// Where it begins along the needle, in mm.
    pub along_top_mm: f64,
    /// Where it ends along the needle, in mm.
    pub along_bottom_mm: f64,
}

/// The needle.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = Needle)]
pub struct StageNeedle {
    /// Diameter, in mm.
    pub diameter_mm: f64,
    /// Length, in mm.
    pub length_mm: f64,
    /// From the tip of the stylet to the rim of the cannula, in mm; 0 where there is no rim.
    pub tip_to_rim_mm: f64,
    /// What is on the hub until it is open: stylet or syringe.
    pub hub: String,
}

/// A structure.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = Structure)]
pub struct StageStructure {
    /// Name.
    pub name: String,
    /// target, vessel, nerve, bone or organ.
    #[schema(value_type = String)]
    pub kind: StructureKind,
    /// Its surface.
    #[serde(flatten)]
    pub mesh: StageMesh,
}

/// A surface.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = Mesh)]
pub struct StageMesh {
    /// Corners, three numbers each, in mm.
    pub vertices_mm: Vec<f64>,
    /// Triangles, three corners each.
    pub triangles: Vec<u32>,
}

/// A sphere, or a cylinder, that skin and layers are concentric with.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = Bend)]
pub struct StageBend {
    /// Radius of the skin, in mm.
    pub radius_mm: f64,
    /// Direction of a cylinder's line in plan, of unit length; none for a sphere.
    pub line: Option<[f64; 2]>,
}

/// An event.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Happening {
    /// contact, tip_rupture, rim_rupture, structure_hit, skin_exit or confirm.
    #[schema(value_type = String)]
    pub kind: MarkKind,
    /// When, in s.
    pub t_s: f64,
    /// Where, in mm along the needle.
    pub advance_mm: f64,
    /// Axial force on the hand just before, in N.
    pub force_n: f64,
    /// The layer or structure concerned, or empty.
    pub name: String,
}

impl ReplayStage {
    /// The stage of a recording, from its curve and its frames.
    #[must_use]
    pub fn of(recording: &Recording, bundle: &ExerciseBundle, curve: AttemptCurve, frames: &Frames) -> Self {
        let needle = &bundle.scene.needle;
        let (entry, target) = (bundle.exercise.entry_m(), bundle.exercise.target_m());
        Self {
            title: bundle.exercise.title.own().to_owned(),
            duration_s: curve.duration_s,
            columns: frames.columns(),
            layers: layers(recording, bundle, &curve.bands),
            entry_mm: [entry.x, entry.y, entry.z].map(to_mm),
            target_mm: [target.x, target.y, target.z].map(to_mm),
            target_depth_mm: curve.target_depth_mm,
            needle: StageNeedle {
                diameter_mm: needle.diameter_mm,
                length_mm: needle.length_mm,
                tip_to_rim_mm: needle.tip_to_rim_mm,
                hub: needle.hub.clone(),
            },
            entries_mm: frames.entries_m().iter().map(|entry_m| entry_m.map(to_mm)).collect(),
            structures: bundle.scene.structures.iter().map(|s| structure(&s.spec)).collect(),
            bend: bend(&bundle.scene.skin_shape),
            skin: bundle
                .scene
                .skin
                .as_ref()
                .map(|skin| stage_mesh(coarsen_to(&skin.vertices_m, &skin.triangles, MOST_OF_SKIN))),
            events: curve.marks.into_iter().map(happening).collect(),
        }
    }
}

fn bend(skin: &Skin) -> Option<StageBend> {
    let line = skin.line().map(|line| [line.x, line.y]);
    skin.radius_m().map(|radius_m| StageBend { radius_mm: to_mm(radius_m), line })
}

/// To the hundredth of a millimetre, far below what a picture shows.
fn to_mm(metres: f64) -> f64 {
    (metres * 1e5).round() / 1e2
}

fn layers(recording: &Recording, bundle: &ExerciseBundle, bands: &[LayerSpan]) -> Vec<StageLayer> {
    let mut top_mm = 0.0;
    let mut layers = Vec::with_capacity(bands.len());
    for (thickness_m, band) in patient_thicknesses_m(recording, bundle).into_iter().zip(bands) {
        let bottom_mm = top_mm + thickness_m * 1e3;
        layers.push(StageLayer {
            name: band.name.clone(),
            texture: band.texture.clone(),
            top_mm,
            bottom_mm,
            along_top_mm: band.top_mm,
            along_bottom_mm: band.bottom_mm,
        });
        top_mm = bottom_mm;
    }
    layers
}

fn structure(spec: &StructureSpec) -> StageStructure {
    let (corners, triangles) = spec.surface();
    let mesh = stage_mesh(coarsen_to(&corners, &triangles, MOST_TRIANGLES));
    StageStructure { name: spec.name.clone(), kind: spec.kind, mesh }
}

fn stage_mesh((vertices_m, triangles): Surface) -> StageMesh {
    let vertices_mm = vertices_m.iter().flat_map(|c| [c.x, c.y, c.z]).map(to_mm).collect();
    StageMesh { vertices_mm, triangles: triangles.into_iter().flatten().collect() }
}

fn happening(mark: CurveMark) -> Happening {
    let CurveMark { kind, t_s, advance_mm, axial_n, name } = mark;
    Happening { kind, t_s, advance_mm, force_n: axial_n, name }
}

#[cfg(test)]
pub(super) mod tests {
    pub(in crate::replay) fn session() -> recording::Session {
        recording::Session {
            session_id: uuid::Uuid::nil(),
            exercise_id: String::new(),
            exercise_sha256: String::new(),
            scene_sha256: String::new(),
            simulator_version: String::new(),
            git: String::new(),
            device: String::new(),
            device_max_force_n: 1.0,
            law: law::axial::ForceLaw::Version2,
            judging: law::Judging::default(),
            tick_hz: 1000.0,
            seed: 0,
            trainee: String::new(),
            started_at: time::OffsetDateTime::UNIX_EPOCH,
            patient_thickness_mm: vec![],
        }
    }
}
