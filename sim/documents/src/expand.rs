//! Expands a scene that names an anatomy into one with layers, structures and a skin.
//!
//! The document stays the single source: a few numbers that describe a body. They are expanded when
//! the scene is read, and the result is stored and sent as text and meshes, as if an author had
//! written them. A recording therefore re-simulates independently of later changes to the body
//! model.

use std::ops::ControlFlow;
use std::panic::resume_unwind;
use std::thread;

use anatomy::{AnatomyPart, Body, BodyEntry, BodyQuality, LayerOnPath, Tissue};
use law::Skin;
use law::axial::MaxwellBranch;
use law::structures::{StructureKind, Surface};
use nalgebra::Vector3;
use phrase::{Phrase, phrase};
use serde::Deserialize;
use toml::{Table, Value};

use crate::describe::{LAYERS, one_of};
use crate::feel::TissueFeel;
use crate::mesh::write_stl;
use crate::planned::PlannedNeedle;
use crate::scene_body::SceneBody;
use crate::source::Files;
use crate::tip::NeedleScaling;
use crate::walk::Walked;

/// Structures farther from the planned needle than this are left out, in m.
const REACH_M: f64 = 25e-3;
/// Number of points along the needle at which the distance to a part is evaluated.
const STEPS: u32 = 64;
/// Mesh quality of structures.
const STRUCTURE_QUALITY: BodyQuality = BodyQuality::Medium;
/// Minimum thickness of a layer, in mm: in general, and of fat. A thinner layer is merged into the
/// one above it.
const THIN_MM: [f64; 2] = [0.5, 1.5];
/// Thickness of the dura, in mm. Our choice, within 0.3 to 0.6 mm.
const DURA_MM: f64 = 0.5;
/// Thickness of the lumbodorsal fascia, in mm, taken from the muscle below it. Our choice.
const FASCIA_MM: f64 = 0.8;
/// Way through the kidney to the calyx, and through the calyx, in mm. Our choice.
const PARENCHYMA_MM: f64 = 16.0;
const CALYX_MM: f64 = 8.0;
/// Wall of a vessel: stiffness in N/m and rupture force in N, as in lower-back-vessel.
const VESSEL_WALL: [f64; 2] = [600.0, 0.6];
/// Name of the skin's file.
const SKIN_FILE: &str = "skin.stl";
/// The words allowed in `parts`, and the kind of structure that each selects.
const PARTS: [(&str, StructureKind); 4] = [
    ("bones", StructureKind::Bone),
    ("dura", StructureKind::Nerve),
    ("vessels", StructureKind::Vessel),
    ("kidneys", StructureKind::Organ),
];

/// `[anatomy]` of a scene.
#[derive(Deserialize)]
pub(crate) struct SceneAnatomy {
    #[serde(flatten)]
    body: SceneBody,
    angle_deg: f64,
    azimuth_deg: f64,
    introducer_mm: f64,
    parts: Option<Vec<String>>,
}

/// A layer in the form in which it is written to the document.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MetLayer {
    name: String,
    tissue: &'static str,
    feel: &'static TissueFeel,
    thickness_mm: f64,
    /// Thresholds of tip and rim, in N.
    pub(crate) rupture_n: [f64; 2],
}

/// A body with the needle's entry.
pub(crate) struct EnteredBody {
    order: SceneBody,
    body: Body,
    entry: BodyEntry,
    direction: Vector3<f64>,
    parts: Vec<StructureKind>,
    /// Planned entry, angle and azimuth.
    pub(crate) planned: PlannedNeedle,
    /// The layers along the planned path.
    pub(crate) layers: Vec<MetLayer>,
    depth_m: f64,
}

/// Checks that the layers have a single source and that the parts exist.
pub(crate) fn check_expandable(doc: &mut Walked) {
    if !doc.is_written("anatomy") {
        if !doc.is_written("layer") {
            doc.refuse("layer", phrase!("missing"), LAYERS.kind.allowed());
        }
        return;
    }
    for field in ["layer", "skin", "body"] {
        if doc.is_written(field) {
            let allowed =
                phrase!("allowed: only one of the two, because the layers and the skin come from the anatomy");
            doc.refuse(field, phrase!("together with {field}", field = "anatomy"), allowed);
        }
    }
    if let Some(law) = doc.value["law"].as_i64().filter(|law| *law < 3) {
        let allowed = phrase!("allowed: 3, 4 or 5 with [anatomy], because its ligamentum flavum relaxes");
        doc.refuse("law", Phrase::data(law.to_string()), allowed);
    }
    let known = PARTS.map(|(word, _)| word);
    let parts = doc.value["anatomy"]["parts"].as_array().cloned().unwrap_or_default();
    for part in parts.iter().filter_map(|part| part.as_str()).filter(|part| !known.contains(part)) {
        doc.refuse("anatomy.parts", Phrase::quoted(part), one_of(&known));
    }
}

impl SceneAnatomy {
    /// Returns the planned angle to the skin's normal, in degrees.
    pub(crate) fn angle_deg(&self) -> f64 {
        self.angle_deg
    }

    /// Builds the body, enters it as planned and lists the layers that a needle of the given length
    /// in mm meets.
    ///
    /// # Errors
    /// If no body has these numbers.
    pub(crate) fn enter(&self, needle_mm: f64, scaling: NeedleScaling) -> Result<EnteredBody, Phrase> {
        let (body, entry) = self.body.enter()?;
        let planned =
            PlannedNeedle { angle_deg: self.angle_deg, azimuth_deg: self.azimuth_deg, ..PlannedNeedle::default() };
        let direction = planned.axis(&Skin::Flat);
        let met = body.list_layers_from(&entry, &direction, needle_mm / 1e3);
        let met = if scaling == NeedleScaling::Version1 { to_canal(&met) } else { met };
        let depth_m = met.last().map_or(0.0, |layer| layer.to_m);
        let cosine = libm::cos(self.angle_deg.to_radians());
        let mut layers = list_layers(&met, cosine, scaling);
        place_introducer(&mut layers, self.introducer_mm * cosine, scaling);
        name_apart(&mut layers);
        let exists = |word: &str| self.parts.as_ref().is_none_or(|parts| parts.iter().any(|part| part == word));
        let parts = PARTS.into_iter().filter(|(word, _)| exists(word)).map(|(_, kind)| kind).collect();
        Ok(EnteredBody { order: self.body.clone(), body, entry, direction, parts, planned, layers, depth_m })
    }
}

/// Keeps the layers up to the end of the canal; a path that misses the canal ends with the needle.
fn to_canal(met: &[LayerOnPath]) -> Vec<LayerOnPath> {
    let is_canal = |tissue| matches!(tissue, Tissue::Part(AnatomyPart::EpiduralSpace | AnatomyPart::DuralSac));
    let is_sac = |tissue| tissue == Tissue::Part(AnatomyPart::DuralSac);
    let mut kept: Vec<LayerOnPath> = Vec::new();
    let _ = met.iter().try_for_each(|layer| {
        let last = kept.last().map(|last| last.tissue);
        if last.is_some_and(is_canal) && !is_canal(layer.tissue) || last.is_some_and(is_sac) {
            return ControlFlow::Break(());
        }
        kept.push(*layer);
        ControlFlow::Continue(())
    });
    kept
}

/// Returns the layers of a path; `cosine` is that of its angle to the skin's normal. Bone and
/// vessels are structures, not layers: the tissue in front of them continues.
fn list_layers(met: &[LayerOnPath], cosine: f64, scaling: NeedleScaling) -> Vec<MetLayer> {
    let mut layers: Vec<MetLayer> = Vec::new();
    for layer in met {
        let thickness_mm = (layer.to_m - layer.from_m) * 1e3 * cosine;
        let least_mm = if layer.tissue == Tissue::Fat { THIN_MM[1] } else { THIN_MM[0] };
        let tissue = name_tissue(layer.tissue).filter(|_| thickness_mm >= least_mm);
        let above = layers.last().map(|last| last.tissue);
        match (tissue, layers.last_mut()) {
            (None, Some(last)) => last.thickness_mm += thickness_mm,
            (Some(tissue), Some(last)) if last.tissue == tissue => last.thickness_mm += thickness_mm,
            (tissue, _) => {
                let parts = list_parts(tissue.unwrap_or("skin"), above, thickness_mm, scaling);
                layers.extend(parts.into_iter().map(|(tissue, part_mm)| MetLayer::new(tissue, part_mm, scaling)));
            }
        }
    }
    layers
}

/// Returns the parts of a tissue along a needle that comes from the tissue above: the dura around
/// the fluid and, from version 2 of the scaling, the fascia over muscle and the calyx in a kidney.
fn list_parts(
    tissue: &'static str,
    above: Option<&str>,
    thickness_mm: f64,
    scaling: NeedleScaling,
) -> Vec<(&'static str, f64)> {
    let has_all = scaling >= NeedleScaling::Version2;
    match (tissue, above) {
        ("cerebrospinal fluid", _) => vec![("dura", DURA_MM), (tissue, thickness_mm - DURA_MM)],
        (_, Some("cerebrospinal fluid")) if has_all => {
            let behind = if tissue == "epidural space" { "anterior epidural space" } else { tissue };
            vec![("dura", DURA_MM), (behind, thickness_mm - DURA_MM)]
        }
        ("muscle", Some("fat")) if has_all && thickness_mm > FASCIA_MM => {
            vec![("fascia", FASCIA_MM), (tissue, thickness_mm - FASCIA_MM)]
        }
        ("kidney", _) if has_all && thickness_mm > PARENCHYMA_MM + CALYX_MM => {
            let behind_mm = thickness_mm - PARENCHYMA_MM - CALYX_MM;
            vec![(tissue, PARENCHYMA_MM), ("calyx", CALYX_MM), (tissue, behind_mm)]
        }
        _ => vec![(tissue, thickness_mm)],
    }
}

/// Replaces what lies above the end of an introducer by the introducer.
fn place_introducer(layers: &mut Vec<MetLayer>, introducer_mm: f64, scaling: NeedleScaling) {
    if introducer_mm <= 0.0 {
        return;
    }
    let mut left_mm = introducer_mm;
    for layer in layers.iter_mut() {
        let within_mm = layer.thickness_mm.min(left_mm);
        layer.thickness_mm -= within_mm;
        left_mm -= within_mm;
    }
    layers.retain(|layer| layer.thickness_mm > 0.0);
    layers.insert(0, MetLayer::new("introducer", introducer_mm - left_mm, scaling));
}

/// Gives each layer a name of its own.
fn name_apart(layers: &mut [MetLayer]) {
    for at in 0..layers.len() {
        let own = layers[at].name.clone();
        let earlier = layers[..at].iter().filter(|layer| layer.tissue == layers[at].tissue).count();
        layers[at].name = match (own.as_str(), earlier) {
            (_, 0) => own,
            ("fat", 1) => "deep fat".to_owned(),
            _ => format!("{own} {}", earlier + 1),
        };
    }
}

/// Returns the tissue of a layer; `None` for tissues that are only structures.
fn name_tissue(tissue: Tissue) -> Option<&'static str> {
    let part = match tissue {
        Tissue::Skin => return Some("skin"),
        Tissue::Fat => return Some("fat"),
        Tissue::Part(part) => part,
    };
    match part {
        AnatomyPart::ErectorSpinae(_) | AnatomyPart::Quadratus(_) => Some("muscle"),
        AnatomyPart::Supraspinous => Some("supraspinous ligament"),
        AnatomyPart::Interspinous(_) => Some("interspinous ligament"),
        AnatomyPart::Flavum(_) => Some("ligamentum flavum"),
        AnatomyPart::EpiduralSpace => Some("epidural space"),
        AnatomyPart::DuralSac => Some("cerebrospinal fluid"),
        AnatomyPart::Kidney(_) => Some("kidney"),
        AnatomyPart::Disc(_) => Some("ligament"),
        _ => None,
    }
}

impl MetLayer {
    fn new(tissue: &'static str, thickness_mm: f64, scaling: NeedleScaling) -> Self {
        let feel = TissueFeel::of(tissue, scaling);
        Self { name: tissue.to_owned(), tissue, feel, thickness_mm, rupture_n: [feel.tip_n, feel.rim_n] }
    }

    fn table(&self) -> Table {
        let feel = self.feel;
        let lowered = if self.rupture_n[0] < feel.tip_n || self.rupture_n[1] < feel.rim_n {
            " Thresholds lowered until no rupture raises the force in these layers."
        } else {
            ""
        };
        let source = format!("Thickness: the anatomy, along the planned needle. {}{lowered}", feel.source);
        let numbers = [
            ("thickness_mm", libm::round(self.thickness_mm * 1e2) / 1e2),
            ("stiffness_n_per_m", feel.stiffness_n_per_m),
            ("damping_n_s_per_m2", feel.damping_n_s_per_m2),
            ("tip_rupture_n", self.rupture_n[0]),
            ("rim_rupture_n", self.rupture_n[1]),
            ("friction_n_per_m", feel.friction_n_per_m),
            ("cutting_n", feel.cutting_n),
            ("density_kg_per_m3", feel.density_kg_per_m3),
            ("poisson_ratio", 0.45),
        ];
        let texts = [("name", self.name.as_str()), ("texture", feel.texture), ("source", source.as_str())];
        let numbers = numbers.map(|(key, number)| (key.to_owned(), Value::Float(number)));
        let texts = texts.map(|(key, text)| (key.to_owned(), Value::from(text)));
        let mut table: Table = numbers.into_iter().chain(texts).collect();
        if feel.stiffening_n_per_m2 > 0.0 {
            table.insert("stiffening_n_per_m2".to_owned(), Value::Float(feel.stiffening_n_per_m2));
        }
        if !feel.derived.is_empty() {
            table.insert("provenance".to_owned(), Value::Array(list_provenance(feel)));
        }
        if let Some(MaxwellBranch { share, time_s }) = feel.branch {
            let branch =
                [("share", share), ("time_s", time_s)].map(|(key, number)| (key.to_owned(), Value::Float(number)));
            table.insert("relaxation".to_owned(), Value::Array(vec![Value::Table(branch.into_iter().collect())]));
            table.insert("gives_way_at".to_owned(), "dent".into());
        }
        table
    }
}

/// Returns the provenance of a layer's numbers that are no choices.
fn list_provenance(feel: &TissueFeel) -> Vec<Value> {
    let of_tissue = feel.derived.iter().map(|key| (*key, feel.source));
    let all =
        [("thickness_mm", "The body's published dimensions, along the planned needle.")].into_iter().chain(of_tissue);
    let rows = all.map(|(key, source)| [("key", key), ("class", "derived"), ("source", source)]);
    rows.map(|row| Value::Table(row.map(|(key, text)| (key.to_owned(), Value::from(text))).into_iter().collect()))
        .collect()
}

impl EnteredBody {
    /// Returns the document with layers in place of `[anatomy]`.
    pub(crate) fn with_layers(&self, document: &Table) -> Table {
        let mut expanded = document.clone();
        expanded.remove("anatomy");
        let layers = self.layers.iter().map(|layer| Value::Table(layer.table())).collect();
        expanded.insert("layer".to_owned(), Value::Array(layers));
        expanded
    }

    /// Returns the document with layers, structures and skin in place of `[anatomy]`, and the files
    /// of their meshes. The document's own structures follow those of the body.
    pub(crate) fn expand(&self, document: &Table) -> (Table, Files) {
        let mut expanded = self.with_layers(document);
        expanded.insert("body".to_owned(), Value::Table(self.order.table()));
        let mut files = Files::new();
        let mut structures = Vec::new();
        let parts = AnatomyPart::list().into_iter().filter_map(|part| Some((part, part.kind()?)));
        let near: Vec<_> =
            parts.filter(|(part, kind)| self.parts.contains(kind) && self.may_be_within_reach(*part)).collect();
        let mut wanted: Vec<_> = near.iter().map(|(part, _)| (*part, STRUCTURE_QUALITY)).collect();
        wanted.push((AnatomyPart::Skin, BodyQuality::Low));
        let mut meshes = self.mesh_each(&wanted);
        let skin = meshes.pop().unwrap_or_default();
        for ((part, kind), mesh) in near.into_iter().zip(meshes).filter(|(_, mesh)| self.is_within_reach(mesh)) {
            files.push((format!("{}.stl", part.name()), write_stl(&mesh)));
            structures.push(Value::Table(structure_table(part, kind)));
        }
        if let Some(Value::Array(own)) = expanded.remove("structure") {
            structures.extend(own);
        }
        expanded.insert("structure".to_owned(), Value::Array(structures));
        files.push((SKIN_FILE.to_owned(), write_stl(&skin)));
        let skin = [("file", SKIN_FILE), ("unit", "mm")].map(|(key, text)| (key.to_owned(), Value::from(text)));
        expanded.insert("skin".to_owned(), Value::Table(skin.into_iter().collect()));
        (expanded, files)
    }

    /// Meshes the parts, each on its own thread.
    fn mesh_each(&self, wanted: &[(AnatomyPart, BodyQuality)]) -> Vec<Surface> {
        thread::scope(|scope| {
            let mesh = |&(part, quality): &(AnatomyPart, BodyQuality)| {
                scope.spawn(move || self.body.mesh_from(&self.entry, part, quality))
            };
            let making: Vec<_> = wanted.iter().map(mesh).collect();
            let made = making.into_iter().map(|making| making.join().unwrap_or_else(|panic| resume_unwind(panic)));
            made.map(|mesh| (mesh.vertices_m, mesh.triangles)).collect()
        })
    }

    /// Returns whether a vertex of a part's mesh may be near enough to the planned needle. Uses the
    /// part's shape, so that no mesh has to be built.
    fn may_be_within_reach(&self, part: AnatomyPart) -> bool {
        let step_m = self.depth_m / f64::from(STEPS);
        let places_m = (0..=STEPS).map(|step| self.direction * (f64::from(step) * step_m));
        let body_m = |own_m: Vector3<f64>| self.entry.origin_m + self.entry.to_body(&own_m);
        let least_m = |own_m| self.body.least_distance_m(part, STRUCTURE_QUALITY, &body_m(own_m));
        places_m.map(least_m).any(|least_m| least_m <= REACH_M + step_m)
    }

    /// Returns whether a vertex of a mesh is near enough to the planned needle.
    fn is_within_reach(&self, (vertices_m, _): &Surface) -> bool {
        vertices_m.iter().any(|vertex| {
            let along_m = vertex.coords.dot(&self.direction).clamp(0.0, self.depth_m);
            (vertex.coords - self.direction * along_m).norm() <= REACH_M
        })
    }
}

fn structure_table(part: AnatomyPart, kind: StructureKind) -> Table {
    let name = part.name();
    let texts = [("name", name.replace('-', " ")), ("kind", kind.word().to_owned()), ("file", format!("{name}.stl"))];
    let mut table: Table = texts.map(|(key, text)| (key.to_owned(), Value::from(text))).into_iter().collect();
    table.insert("shape".to_owned(), "mesh".into());
    table.insert("unit".to_owned(), "mm".into());
    table.insert("position_mm".to_owned(), Value::Array(vec![Value::Float(0.0); 3]));
    if kind == StructureKind::Vessel {
        table.insert("wall_stiffness_n_per_m".to_owned(), VESSEL_WALL[0].into());
        table.insert("wall_rupture_n".to_owned(), VESSEL_WALL[1].into());
    }
    table
}
