//! A scene: layers, needle, structures, tissue options.

use law::Skin;
use law::axial::ForceLaw;
use law::structures::{StructureKind, StructureSpec};
use nalgebra::Point3;
use serde::Deserialize;
use tissue::volumetric::Material;

/// A layer as its author wrote it: at 2.0 mm diameter, diamond tip, lubrication 1, toughness 1.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct SceneLayer {
    /// Name, unique in the scene.
    pub name: String,
    /// Thickness, in mm; 0 for a fascia that only has thresholds.
    pub thickness_mm: f64,
    /// Spread of the thickness between patients (uniform, ±), in mm.
    pub thickness_spread_mm: f64,
    /// Boundary stiffness, in N/m.
    pub stiffness_n_per_m: f64,
    /// Damping per inserted length, in N·s/m².
    pub damping_n_s_per_m2: f64,
    /// Tip threshold, in N; 0 where it follows from a fracture energy.
    #[serde(default)]
    pub tip_rupture_n: f64,
    /// Rim threshold, in N; 0 where the needle has no rim and the scene states none.
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
    /// Young's modulus, in Pa, where the scene states it.
    pub youngs_modulus_pa: Option<f64>,
    /// Factor on P, c and f.
    pub toughness_factor: f64,
    /// Recoil time, in s, where the scene states it.
    pub recoil_time_s: Option<f64>,
    /// Texture for the picture: `skin`, `fat`, `muscle`, `fascia`, ….
    pub texture: String,
    /// Where the numbers come from.
    pub source: String,
    /// What version 3 of the law may add.
    #[serde(flatten)]
    pub options: SceneLayerOptions,
}

/// Options of a layer under version 3 of the law, at the reference needle like its other numbers.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct SceneLayerOptions {
    /// κ of a tent that stiffens, in N/m²; 0 for one that does not.
    #[serde(default)]
    pub stiffening_n_per_m2: f64,
    /// Branches that relax.
    #[serde(default)]
    pub relaxation: Vec<law::axial::MaxwellBranch>,
    /// What opens the boundary where it relaxes.
    #[serde(default)]
    pub gives_way_at: law::axial::RuptureCriterion,
    /// Friction before the shaft has broken away, in N/m, where it is another than after.
    pub static_friction_n_per_m: Option<f64>,
    /// Fracture energy that the tip's threshold follows from, in J/m².
    pub fracture_energy_j_per_m2: Option<f64>,
    /// Fibres of a sheet of connective tissue.
    pub fibres: Option<SceneFibres>,
}

/// Fibres of a sheet of connective tissue.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct SceneFibres {
    /// Their direction, in degrees from the patient's x towards y.
    pub angle_deg: f64,
    /// Stiffness under an edge along them, as a share of that across.
    pub along_stiffness: f64,
    /// Thresholds under an edge along them, likewise.
    pub along_threshold: f64,
    /// Pretension of the sheet, in N/m.
    pub pretension_n_per_m: f64,
    /// Radius at which the sheet is held, in mm.
    pub held_radius_mm: f64,
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
    /// Tip type: diamond, bevel, conical or blunt.
    pub tip: String,
    /// What is on the hub: stylet or syringe.
    pub hub: String,
    /// Tip-to-rim distance, in mm; 0 is a single contactor.
    #[serde(default)]
    pub tip_to_rim_mm: f64,
    /// Length of the shaft from tip to hub, in mm.
    pub length_mm: f64,
    /// Stiffness of the skin under the hub, in N/m; none where the hub meets nothing.
    pub hub_stiffness_n_per_m: Option<f64>,
    /// Factor on c: 0.5 lubricated, 1, 1.5 dry.
    pub lubrication: f64,
    /// A bending beam on the foundation.
    pub flexible: bool,
    /// Young's modulus of the shaft, in Pa. Only a shaft that bends has a use for it.
    pub youngs_modulus_pa: f64,
    /// Bore of the shaft, in mm; 0 is solid.
    pub inner_diameter_mm: f64,
    /// Presliding stiffness, in N/m.
    pub presliding_stiffness_n_per_m: f64,
    /// Window that speed is measured over, in ms; 0 is the last two samples.
    pub speed_window_ms: f64,
    /// Time of the damping's spring and dashpot, in ms; 0 is a dashpot alone.
    pub damping_time_ms: f64,
    /// Lateral foundation, in N/m².
    pub lateral_stiffness_n_per_m2: f64,
    /// Slid length after which friction is no longer static, in mm, where layers have a static one.
    pub breakaway_mm: Option<f64>,
    /// Rest after which it is static again, in s.
    pub friction_rest_s: f64,
}

/// A structure inside the body.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneStructure {
    /// Its shape and place, in SI and the patient frame.
    pub spec: StructureSpec,
    /// File name of its mesh, for a mesh.
    pub mesh_file: Option<String>,
    /// What it is made of, where the field knows it as something else than the layers around it.
    pub elastic: Option<Material>,
}

impl SceneStructure {
    /// What it is to the exercise.
    #[must_use]
    pub fn kind(&self) -> StructureKind {
        self.spec.kind
    }
}

/// A mesh of the skin. It is for the picture: to the force law the skin is [`Scene::skin_shape`].
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSkin {
    /// Vertices, patient frame, in m.
    pub vertices_m: Vec<Point3<f64>>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// File name of the mesh.
    pub file: String,
}

/// How the tissue deforms.
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
    /// What it is and where it comes from.
    pub description: String,
    /// Version of the force law.
    pub law: ForceLaw,
    /// Layers from the surface down.
    pub layers: Vec<SceneLayer>,
    /// The needle.
    pub needle: Needle,
    /// Rate dependence of the thresholds.
    pub rate: Option<law::axial::RateDependence>,
    /// Structures.
    pub structures: Vec<SceneStructure>,
    /// A mesh of the skin, where the scene brings one.
    pub skin: Option<SceneSkin>,
    /// The skin as the force law and the field have it.
    pub skin_shape: Skin,
    /// Tissue options.
    pub tissue: TissueOptions,
    /// Lower-case hexadecimal SHA-256 of the document's bytes.
    pub sha256: String,
}
