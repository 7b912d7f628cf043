//! A scene: layers, needle, structures, tissue options.

use law::Skin;
use law::axial::ForceLaw;
use law::structures::{StructureKind, StructureSpec};
use nalgebra::Point3;
use serde::{Deserialize, Serialize};
use tissue::volumetric::Material;

use crate::scene_body::SceneBody;
use crate::tip::NeedleScaling;

/// Class of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NumberClass {
    /// Measured, with a published range.
    Measured,
    /// Derived from a measurement by a stated scaling.
    Derived,
    /// A choice: no measurement was found.
    Choice,
}

impl NumberClass {
    /// The words for the classes in a document.
    pub(crate) const WORDS: [&str; 3] = ["measured", "derived", "choice"];
}

/// Where one number of a layer comes from.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct NumberProvenance {
    /// Key of the number, for example `thickness_mm`.
    pub key: String,
    /// Its class.
    pub class: NumberClass,
    /// The publication, the scaling or the reason of the choice.
    #[serde(default)]
    pub source: String,
    /// Lower end of the published range, in the number's unit.
    pub low: Option<f64>,
    /// Upper end of the published range, in the number's unit.
    pub high: Option<f64>,
}

/// A number of a layer, by its key.
pub(crate) type LayerNumber = (&'static str, fn(&SceneLayer) -> f64);

/// A layer's numbers that have a class.
pub(crate) const NUMBERS: [LayerNumber; 10] = [
    ("thickness_mm", |layer| layer.thickness_mm),
    ("stiffness_n_per_m", |layer| layer.stiffness_n_per_m),
    ("stiffening_n_per_m2", |layer| layer.options.stiffening_n_per_m2),
    ("damping_n_s_per_m2", |layer| layer.damping_n_s_per_m2),
    ("tip_rupture_n", |layer| layer.tip_rupture_n),
    ("rim_rupture_n", |layer| layer.rim_rupture_n),
    ("friction_n_per_m", |layer| layer.friction_n_per_m),
    ("cutting_n", |layer| layer.cutting_n),
    ("density_kg_per_m3", |layer| layer.density_kg_per_m3),
    ("poisson_ratio", |layer| layer.poisson_ratio),
];

/// Their keys.
pub(crate) const NUMBER_KEYS: [&str; NUMBERS.len()] = {
    let mut keys = [""; NUMBERS.len()];
    let mut at = 0;
    while at < keys.len() {
        keys[at] = NUMBERS[at].0;
        at += 1;
    }
    keys
};

/// A layer as in the document: for 2.0 mm diameter, diamond tip, lubrication 1, toughness 1.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct SceneLayer {
    /// Name, unique in the scene.
    pub name: String,
    /// Thickness, in mm; 0 for a fascia, which only has thresholds.
    pub thickness_mm: f64,
    /// Spread of the thickness between patients (uniform, ±), in mm.
    pub thickness_spread_mm: f64,
    /// Boundary stiffness, in N/m.
    pub stiffness_n_per_m: f64,
    /// Damping per inserted length, in N·s/m².
    pub damping_n_s_per_m2: f64,
    /// Tip threshold, in N; 0 if it is derived from a fracture energy.
    #[serde(default)]
    pub tip_rupture_n: f64,
    /// Rim threshold, in N; 0 if the needle has no rim and the scene gives none.
    #[serde(default)]
    pub rim_rupture_n: f64,
    /// Friction, in N/m.
    pub friction_n_per_m: f64,
    /// Cutting force, in N.
    pub cutting_n: f64,
    /// Density, in kg/m³.
    pub density_kg_per_m3: f64,
    /// Poisson ratio.
    pub poisson_ratio: f64,
    /// Young's modulus, in Pa, if the scene gives one.
    pub youngs_modulus_pa: Option<f64>,
    /// Factor on P, c and f.
    pub toughness_factor: f64,
    /// Recoil time, in s, if the scene gives one.
    pub recoil_time_s: Option<f64>,
    /// Texture in the picture: `skin`, `fat`, `muscle`, `fascia`, ….
    pub texture: String,
    /// Source of the numbers.
    pub source: String,
    /// Class and source of single numbers.
    #[serde(default)]
    pub provenance: Vec<NumberProvenance>,
    /// Options from version 3 of the law on.
    #[serde(flatten)]
    pub options: SceneLayerOptions,
}

/// Options of a layer from version 3 of the law on, for the reference needle like its other
/// numbers.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct SceneLayerOptions {
    /// κ of a tent that stiffens, in N/m²; 0 for a linear tent.
    #[serde(default)]
    pub stiffening_n_per_m2: f64,
    /// Relaxing branches.
    #[serde(default)]
    pub relaxation: Vec<law::axial::MaxwellBranch>,
    /// Rupture criterion of a boundary that relaxes.
    #[serde(default)]
    pub gives_way_at: law::axial::RuptureCriterion,
    /// Friction before the shaft breaks away, in N/m, if it differs from kinetic friction.
    pub static_friction_n_per_m: Option<f64>,
    /// Fracture energy from which the tip's threshold is derived, in J/m².
    pub fracture_energy_j_per_m2: Option<f64>,
    /// Fibres of a sheet of connective tissue.
    pub fibres: Option<SceneFibres>,
}

/// Fibres of a sheet of connective tissue.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct SceneFibres {
    /// Direction, in degrees from the patient's x towards y.
    pub angle_deg: f64,
    /// Stiffness under an edge along the fibres, relative to an edge across them.
    pub along_stiffness: f64,
    /// Thresholds under an edge along the fibres, relative to an edge across them.
    pub along_threshold: f64,
    /// Pretension of the sheet, in N/m.
    pub pretension_n_per_m: f64,
    /// Radius at which the sheet is fixed, in mm.
    pub held_radius_mm: f64,
}

/// Family of a needle. A published force was measured with one family and judges no other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NeedleFamily {
    /// Access needle of a percutaneous renal procedure, 18G, two parts.
    RenalAccess,
    /// Tuohy needle for the epidural space, 16G to 18G.
    Tuohy,
    /// Spinal needle, 20G to 27G.
    Spinal,
    /// Veress needle.
    Veress,
    /// Laparoscopic trocar, 3 to 12 mm.
    Trocar,
    /// Needle into an isolated organ.
    Organ,
}

impl NeedleFamily {
    /// The words for the families in a document, in the order of the variants.
    pub(crate) const WORDS: [&str; 6] = ["renal-access", "tuohy", "spinal", "veress", "trocar", "organ"];

    /// Returns the family's word in a document.
    #[must_use]
    pub const fn word(self) -> &'static str {
        Self::WORDS[self as usize]
    }
}

/// The needle.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Needle {
    /// `trocar` or `needle`.
    pub kind: String,
    /// Diameter, in mm.
    pub diameter_mm: f64,
    /// Exponent p of P, f ∝ D^p.
    pub diameter_exponent: f64,
    /// Family, which decides with which published figures its forces may be compared.
    pub family: Option<NeedleFamily>,
    /// Tip type: diamond, bevel, conical, blunt, pencil-point, tuohy or cutting-dilating.
    pub tip: String,
    /// Hub attachment: stylet or syringe.
    pub hub: String,
    /// Tip-to-rim distance, in mm; 0 for a single contactor.
    #[serde(default)]
    pub tip_to_rim_mm: f64,
    /// Length of the shaft from tip to hub, in mm.
    pub length_mm: f64,
    /// Stiffness of the skin under the hub, in N/m; none where the hub meets nothing.
    pub hub_stiffness_n_per_m: Option<f64>,
    /// Factor on c: 0.5 lubricated, 1, 1.5 dry.
    pub lubrication: f64,
    /// Whether the shaft bends as a beam on the foundation.
    pub flexible: bool,
    /// Young's modulus of the shaft, in Pa. Used only if the shaft is flexible.
    pub youngs_modulus_pa: f64,
    /// Bore of the shaft, in mm; 0 for a solid shaft.
    pub inner_diameter_mm: f64,
    /// Presliding stiffness, in N/m.
    pub presliding_stiffness_n_per_m: f64,
    /// Window over which the speed is measured, in ms; 0 uses the last two samples.
    pub speed_window_ms: f64,
    /// Relaxation time of the damping's spring and dashpot, in ms; 0 for a dashpot alone.
    pub damping_time_ms: f64,
    /// Stiffness of the lateral foundation, in N/m².
    pub lateral_stiffness_n_per_m2: f64,
    /// Sliding distance after which friction becomes kinetic, in mm, if layers have static
    /// friction.
    pub breakaway_mm: Option<f64>,
    /// Time at rest after which friction becomes static again, in s.
    pub friction_rest_s: f64,
}

/// A structure inside the body.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneStructure {
    /// Shape and position, in SI and the patient frame.
    pub spec: StructureSpec,
    /// File name of the mesh, if the shape is a mesh.
    pub mesh_file: Option<String>,
    /// Material, if the field treats it as different from the surrounding layers.
    pub elastic: Option<Material>,
}

impl SceneStructure {
    /// Returns the kind of structure.
    #[must_use]
    pub fn kind(&self) -> StructureKind {
        self.spec.kind
    }
}

/// A mesh of the skin. Used by the picture only: the force law uses [`Scene::skin_shape`].
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSkin {
    /// Vertices, patient frame, in m.
    pub vertices_m: Vec<Point3<f64>>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// File name of the mesh.
    pub file: String,
}

/// Options of the tissue's deformation.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct TissueOptions {
    /// auto, axisymmetric, mass-spring, volumetric or none.
    pub model: String,
    /// Tolerated relative error of the field.
    pub tolerance: f64,
    /// `none` or `field`.
    pub coupling: String,
}

/// A checked scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Identifier.
    pub id: String,
    /// Title shown to people.
    pub title: String,
    /// Description and source.
    pub description: String,
    /// Version of the force law.
    pub law: ForceLaw,
    /// Version of the needle's scaling.
    pub scaling: NeedleScaling,
    /// Layers from the surface down.
    pub layers: Vec<SceneLayer>,
    /// The body from which the layers and structures were made, if the scene comes from one.
    pub body: Option<SceneBody>,
    /// The needle.
    pub needle: Needle,
    /// Rate dependence of the thresholds.
    pub rate: Option<law::axial::RateDependence>,
    /// Structures.
    pub structures: Vec<SceneStructure>,
    /// A mesh of the skin, if the scene has one.
    pub skin: Option<SceneSkin>,
    /// The skin as used by the force law and the field.
    pub skin_shape: Skin,
    /// Tissue options.
    pub tissue: TissueOptions,
    /// Lower-case hexadecimal SHA-256 of the document's bytes.
    pub sha256: String,
}
