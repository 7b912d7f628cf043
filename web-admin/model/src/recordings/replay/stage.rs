//! The constant part of a replay: layers, needle, structures, events.

use attempt::{AttemptCurve, CurveMark, LayerSpan, MarkKind, patient_thicknesses_m};
use documents::ExerciseBundle;
use law::Skin;
use law::structures::{StructureKind, StructureSpec, Surface};
use recording::Recording;
use serde::Serialize;
use utoipa::ToSchema;

use super::coarse::coarsen_to;
use super::frames::Frames;

/// Maximum number of triangles per structure; finer meshes are simplified.
const MOST_TRIANGLES: usize = 2000;
/// Maximum number of triangles of a patient's skin.
const MOST_OF_SKIN: usize = 6000;

/// The constant part of a replay. Lengths are in mm in the patient frame, with +z pointing out of
/// the body, or along the needle where stated.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = Stage)]
pub struct ReplayStage {
    /// Title of the exercise.
    pub title: String,
    /// Duration of the attempt, in s.
    pub duration_s: f64,
    /// Names of the columns of each frame, in order.
    pub columns: Vec<String>,
    /// Layers, from the surface downwards.
    pub layers: Vec<StageLayer>,
    /// Entry point of the needle, in mm.
    pub entry_mm: [f64; 3],
    /// Target point of the tip, in mm.
    pub target_mm: [f64; 3],
    /// Depth of the target along the needle, in mm.
    pub target_depth_mm: f64,
    /// The needle.
    pub needle: StageNeedle,
    /// Structures inside the body.
    pub structures: Vec<StageStructure>,
    /// Positions on the skin of the punctures whose blood the frames contain, in mm.
    pub entries_mm: Vec<[f64; 3]>,
    /// Curvature of skin and layers; the skin touches z = 0 at the origin. Null if they are flat.
    pub bend: Option<StageBend>,
    /// Skin of the whole patient, if the scene contains it.
    pub skin: Option<StageMesh>,
    /// Events, in order of time.
    pub events: Vec<Happening>,
}

/// A layer.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = Layer)]
pub struct StageLayer {
    /// Name.
    pub name: String,
    /// Texture, which determines the colour.
    pub texture: String,
    /// Vertical depth of its top below the skin, in mm.
    pub top_mm: f64,
    /// Vertical depth of its bottom below the skin, in mm.
    pub bottom_mm: f64,
    /// Start along the needle, in mm.
    pub along_top_mm: f64,
    /// End along the needle, in mm.
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
    /// Distance from the tip of the stylet to the rim of the cannula, in mm; 0 if there is no rim.
    pub tip_to_rim_mm: f64,
    /// Attachment that closes the hub: `stylet` or `syringe`.
    pub hub: String,
}

/// An anatomical structure.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = Structure)]
pub struct StageStructure {
    /// Name.
    pub name: String,
    /// `target`, `vessel`, `nerve`, `bone` or `organ`.
    #[schema(value_type = String)]
    pub kind: StructureKind,
    /// Surface.
    #[serde(flatten)]
    pub mesh: StageMesh,
}

/// A surface made of triangles.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = Mesh)]
pub struct StageMesh {
    /// Coordinates of the vertices in mm, three numbers each.
    pub vertices_mm: Vec<f64>,
    /// Vertex indices of the triangles, three each.
    pub triangles: Vec<u32>,
}

/// A sphere or cylinder with which skin and layers are concentric.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = Bend)]
pub struct StageBend {
    /// Radius of the skin, in mm.
    pub radius_mm: f64,
    /// Horizontal direction of a cylinder's axis, as a unit vector; null for a sphere.
    pub line: Option<[f64; 2]>,
}

/// An event.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Happening {
    /// `contact`, `tip_rupture`, `rim_rupture`, `structure_hit`, `skin_exit` or `confirm`.
    #[schema(value_type = String)]
    pub kind: MarkKind,
    /// Time, in s.
    pub t_s: f64,
    /// Advance along the needle, in mm.
    pub advance_mm: f64,
    /// Axial force on the hand just before the event, in N.
    pub force_n: f64,
    /// Layer or structure concerned, or empty.
    pub name: String,
}

impl ReplayStage {
    /// Makes the stage of a recording from its curve and frames.
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

/// Rounds to hundredths of a millimetre, far below the resolution of a picture.
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
    pub(in crate::recordings::replay) fn session() -> recording::Session {
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
