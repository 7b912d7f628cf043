//! Reads a scene: checks its fields and meshes against each other, then deserialises the typed
//! document.

use law::Skin;
use law::axial::{ForceLaw, RateDependence};
use law::structures::{Shape, StructureKind, StructureSpec, Wall};
use nalgebra::{Point3, Vector3};
use phrase::{Phrase, phrase};
use serde::Deserialize;
use tissue::volumetric::Material;

use crate::describe::{SCENE, measure};
use crate::error::DocumentError;
use crate::expand::{SceneAnatomy, check_expandable};
use crate::model::{Needle, Scene, SceneLayer, SceneStructure, TissueOptions};
use crate::planned::PlannedNeedle;
use crate::provenance::check_provenance;
use crate::read_anatomy::{Anatomy, read_anatomy};
use crate::read_options::check_options;
use crate::scene_body::SceneBody;
use crate::source::{Files, Find, Source};
use crate::tip::{NeedleScaling, tip_factor};
use crate::walk::Walked;

/// A scene with the keys of its TOML document.
#[derive(Deserialize)]
struct RawScene {
    id: String,
    title: String,
    description: String,
    law: ForceLaw,
    scaling: NeedleScaling,
    anatomy: Option<SceneAnatomy>,
    body: Option<SceneBody>,
    #[serde(default)]
    layer: Vec<SceneLayer>,
    needle: Needle,
    rate: Option<RawRate>,
    skin: Option<RawSkin>,
    structure: Vec<RawStructure>,
    tissue: TissueOptions,
}

#[derive(Deserialize)]
struct RawRate {
    p_infinity_n: f64,
    v0_mm_per_s: f64,
}

#[derive(Deserialize)]
struct RawSkin {
    shape: String,
    #[serde(default)]
    radius_mm: f64,
    #[serde(default)]
    along_deg: f64,
}

#[derive(Deserialize)]
struct RawStructure {
    name: String,
    kind: StructureKind,
    shape: String,
    position_mm: [f64; 3],
    #[serde(default)]
    radius_mm: f64,
    #[serde(default)]
    half_axis_mm: [f64; 3],
    #[serde(default)]
    half_extents_mm: [f64; 3],
    file: Option<String>,
    wall_stiffness_n_per_m: Option<f64>,
    wall_rupture_n: Option<f64>,
    youngs_modulus_pa: Option<f64>,
    poisson_ratio: Option<f64>,
}

/// A scene with its files.
pub(crate) struct ReadScene {
    /// The scene.
    pub scene: Scene,
    /// The files of its meshes.
    pub files: Files,
    /// The expansion of the scene's anatomy, if it names one.
    pub expanded: Option<ExpandedScene>,
}

/// The expansion of an anatomy.
pub(crate) struct ExpandedScene {
    /// The document with layers, structures and skin.
    pub bytes: Vec<u8>,
    /// The planned needle.
    pub planned: PlannedNeedle,
}

/// Reads a scene and the meshes it names, or expands its anatomy.
///
/// # Errors
/// Every issue found.
pub(crate) fn read_scene(source: Source, find: Find<'_>) -> Result<ReadScene, DocumentError> {
    let mut doc = Walked::new(source.clone(), &SCENE)?;
    doc.refuse_duplicates("layer", "name");
    doc.refuse_duplicates("structure", "name");
    check_expandable(&mut doc);
    check_needle(&mut doc);
    check_speed_window(&mut doc);
    check_damping_time(&mut doc);
    check_options(&mut doc);
    check_scaling(&mut doc);
    check_provenance(&mut doc);
    check_walls(&mut doc);
    check_elastic(&mut doc);
    check_skin(&mut doc);
    check_tissue(&mut doc);
    let shapes = read_anatomy(&mut doc, find);
    // Create this issue before `finish` consumes the document; it is reported if the expansion
    // fails.
    let allowed = phrase!("allowed: another patient, entry or angle");
    let unsound = doc.issue("anatomy", phrase!("layers for which no thresholds are sound"), allowed);
    let raw: RawScene = doc.finish()?;
    match &raw.anatomy {
        Some(anatomy) => expand(&source, anatomy, &raw, find)?.ok_or_else(|| unsound.into()),
        None => Ok(ReadScene { files: shapes.files.clone(), scene: scene(raw, shapes, source.sha256), expanded: None }),
    }
}

/// Expands an anatomy; returns `None` if its layers have no sound thresholds.
fn expand(
    source: &Source,
    anatomy: &SceneAnatomy,
    raw: &RawScene,
    find: Find<'_>,
) -> Result<Option<ReadScene>, DocumentError> {
    let place =
        |why| DocumentError::from(source.issue(0, "anatomy", why, phrase!("allowed: the parameters of a body")));
    let document: toml::Table = toml::from_str(source.text()).map_err(|why| place(Phrase::data(why)))?;
    let mut body = anatomy.enter(raw.needle.length_mm, raw.scaling).map_err(place)?;
    let file = format!("{} (its anatomy)", source.file);
    let write = |table: &toml::Table| toml::to_string(table).map_err(|why| place(Phrase::data(why)));
    let layered = Source::new(&file, write(&body.with_layers(&document))?.as_bytes())?;
    let mut layered = read_scene(layered, find)?.scene;
    if !layered.lower_to_sound(anatomy.angle_deg()).map_err(|why| place(why.in_words()))? {
        return Ok(None);
    }
    for (layer, sound) in body.layers.iter_mut().zip(&layered.layers) {
        layer.rupture_n = [sound.tip_rupture_n, sound.rim_rupture_n];
    }
    let (table, made) = body.expand(&document);
    let bytes = write(&table)?.into_bytes();
    let find_made = |name: &str| {
        let found = made.iter().find(|(file, _)| file == name);
        found.map_or_else(|| find(name), |(_, bytes)| Ok(bytes.clone()))
    };
    let read = read_scene(Source::new(&file, &bytes)?, &find_made)?;
    Ok(Some(ReadScene { expanded: Some(ExpandedScene { bytes, planned: body.planned }), ..read }))
}

fn scene(raw: RawScene, shapes: Anatomy, sha256: String) -> Scene {
    let structures = raw.structure.into_iter().zip(shapes.meshes).map(|(s, mesh)| structure(s, mesh)).collect();
    let rate = raw.rate.map(|r| RateDependence { p_infinity_n: r.p_infinity_n, v0_m_per_s: r.v0_mm_per_s / 1e3 });
    Scene {
        id: raw.id,
        title: raw.title,
        description: raw.description,
        law: raw.law,
        scaling: raw.scaling,
        layers: raw.layer,
        body: raw.body,
        needle: raw.needle,
        rate,
        structures,
        skin: shapes.skin,
        skin_shape: raw.skin.as_ref().map_or(Skin::Flat, skin_shape),
        tissue: raw.tissue,
        sha256,
    }
}

/// Default bore of a needle as a fraction of its diameter: an 18 gauge cannula of regular wall has
/// 0.838 mm in 1.270 mm (ISO 9626).
const BORE: f64 = 0.66;

/// A needle has no rim. A trocar has one, by default 2 mm behind the tip; a rim requires
/// thresholds.
fn check_needle(doc: &mut Walked) {
    let needle = &doc.value["needle"];
    let is_trocar = needle["kind"] == "trocar";
    let is_flexible = needle["flexible"] == true;
    let diameter_mm = needle["diameter_mm"].as_f64().unwrap_or_default();
    let bore_mm = needle["inner_diameter_mm"].as_f64().unwrap_or(BORE * diameter_mm);
    let tip_to_rim_mm = needle["tip_to_rim_mm"].as_f64().unwrap_or(if is_trocar { 2.0 } else { 0.0 });
    doc.value["needle"]["tip_to_rim_mm"] = tip_to_rim_mm.into();
    if !is_trocar && tip_to_rim_mm > 0.0 {
        let allowed = phrase!("allowed: 0 mm, because a needle has no rim; kind = \"trocar\" has one");
        doc.refuse("needle.tip_to_rim_mm", Phrase::Data(measure(tip_to_rim_mm, "mm")), allowed);
    }
    if is_trocar && doc.value["needle"]["hub"] == "syringe" {
        let allowed = phrase!(
            "allowed: \"stylet\", because a trocar's stylet fills its cannula; kind = \"needle\" may have a syringe"
        );
        doc.refuse("needle.hub", Phrase::data("syringe"), allowed);
    }
    doc.value["needle"]["inner_diameter_mm"] = bore_mm.into();
    if is_flexible && is_trocar {
        let allowed = phrase!("allowed: false, because a trocar is rigid; kind = \"needle\" may bend");
        doc.refuse("needle.flexible", Phrase::data("true"), allowed);
    }
    if bore_mm > 0.0 && bore_mm >= diameter_mm {
        let allowed = phrase!("allowed: less than {diameter} mm, the needle's diameter", diameter = diameter_mm);
        doc.refuse("needle.inner_diameter_mm", Phrase::Data(measure(bore_mm, "mm")), allowed);
    }
    let rimless: Vec<usize> = doc
        .tables("layer")
        .iter()
        .enumerate()
        .filter(|(_, l)| l["rim_rupture_n"].is_null())
        .map(|(at, _)| at)
        .collect();
    for at in rimless {
        let field = format!("layer[{at}].rim_rupture_n");
        if is_trocar && tip_to_rim_mm > 0.0 && !doc.is_written(&field) {
            let allowed = phrase!("needed for a trocar: the force in N at which its rim opens the boundary");
            doc.refuse(&field, phrase!("missing"), allowed);
        }
    }
}

/// Checks that the scaling has the tip, and a body's introducer.
fn check_scaling(doc: &mut Walked) {
    // A number that the description refuses is absent, and the version then makes no difference.
    let scaling = if doc.value["scaling"] == 2 { NeedleScaling::Version2 } else { NeedleScaling::Version1 };
    let tip = doc.value["needle"]["tip"].as_str().unwrap_or_default().to_owned();
    if !tip.is_empty() && tip_factor(&tip, scaling).is_none() {
        let allowed = phrase!("allowed: diamond, bevel, conical, blunt; scaling = 2 has this tip");
        doc.refuse("needle.tip", Phrase::quoted(&tip), allowed);
    }
    let introducer_mm = doc.value["anatomy"]["introducer_mm"].as_f64().unwrap_or_default();
    if introducer_mm > 0.0 && scaling < NeedleScaling::Version2 {
        let allowed = phrase!("allowed: 0 mm; scaling = 2 has an introducer");
        doc.refuse("anatomy.introducer_mm", Phrase::Data(measure(introducer_mm, "mm")), allowed);
    }
}

/// Checks that a speed window is not used with version 1 of the law.
fn check_speed_window(doc: &mut Walked) {
    let window_ms = doc.value["needle"]["speed_window_ms"].as_f64().unwrap_or_default();
    if doc.value["law"] == 1 && window_ms > 0.0 {
        let allowed = phrase!("allowed: 0 ms with version 1 of the force law; law = 2 has a window");
        doc.refuse("needle.speed_window_ms", Phrase::Data(measure(window_ms, "ms")), allowed);
    }
}

/// Before version 5 of the law, damping is a dashpot alone.
fn check_damping_time(doc: &mut Walked) {
    let time_ms = doc.value["needle"]["damping_time_ms"].as_f64().unwrap_or_default();
    if let Some(law) = doc.value["law"].as_i64().filter(|law| *law < 5 && time_ms > 0.0) {
        let allowed = phrase!("allowed: 0 ms with version {law} of the force law; law = 5 has a spring", law = law);
        doc.refuse("needle.damping_time_ms", Phrase::Data(measure(time_ms, "ms")), allowed);
    }
}

/// A wall has a stiffness and a threshold; bone never ruptures, and a target is a place, not an
/// object.
fn check_walls(doc: &mut Walked) {
    for (at, structure) in doc.tables("structure").into_iter().enumerate() {
        let keys = ["wall_stiffness_n_per_m", "wall_rupture_n"];
        let [stiffness, rupture] = keys.map(|key| structure[key].as_f64());
        if let (Some(_), None) = (stiffness, rupture) {
            let allowed = phrase!("needed with wall_stiffness_n_per_m: the force in N at which the wall gives way");
            doc.refuse(&format!("structure[{at}].wall_rupture_n"), phrase!("missing"), allowed);
        }
        if let (None, Some(_)) = (stiffness, rupture) {
            let allowed = phrase!("needed with wall_rupture_n: the wall's stiffness in N/m");
            doc.refuse(&format!("structure[{at}].wall_stiffness_n_per_m"), phrase!("missing"), allowed);
        }
        if let (Some(stiffness), "bone" | "target") = (stiffness, structure["kind"].as_str().unwrap_or_default()) {
            let allowed =
                phrase!("allowed only for vessel, nerve and organ: bone never gives way, and a target is only a place");
            let field = format!("structure[{at}].wall_stiffness_n_per_m");
            doc.refuse(&field, Phrase::Data(measure(stiffness, "N/m")), allowed);
        }
    }
}

/// Checks that a structure with its own stiffness is round: the field supports no other inclusion.
fn check_elastic(doc: &mut Walked) {
    for (at, structure) in doc.tables("structure").into_iter().enumerate() {
        let [modulus, ratio] = ["youngs_modulus_pa", "poisson_ratio"].map(|key| structure[key].as_f64());
        if let (None, Some(_)) = (modulus, ratio) {
            let allowed = phrase!("needed with poisson_ratio: Young's modulus in Pa");
            doc.refuse(&format!("structure[{at}].youngs_modulus_pa"), phrase!("missing"), allowed);
        }
        let shape = structure["shape"].as_str().unwrap_or_default();
        if let Some(modulus) = modulus.filter(|_| ["box", "mesh"].contains(&shape)) {
            let allowed = phrase!("allowed only for a sphere or a capsule, not for a {shape}", shape = shape);
            doc.refuse(&format!("structure[{at}].youngs_modulus_pa"), Phrase::Data(measure(modulus, "Pa")), allowed);
        }
    }
}

/// Minimum radius of curvature of the skin, relative to the total thickness of the layers.
const LEAST_BEND: f64 = 1.25;

/// Checks that a skin has a mesh, a radius or both; a radius requires a shape and must enclose the
/// layers.
fn check_skin(doc: &mut Walked) {
    if !doc.is_written("skin") {
        return;
    }
    let skin = doc.value["skin"].clone();
    let shape = skin["shape"].as_str().unwrap_or_default().to_owned();
    let is_flat = shape == "flat";
    for (field, is_needed) in [("skin.file", is_flat), ("skin.unit", is_flat || doc.is_written("skin.file"))] {
        if is_needed && !doc.is_written(field) {
            doc.refuse(
                field,
                phrase!("missing"),
                phrase!("needed for a skin that is a mesh; shape and radius_mm bend a skin without a mesh"),
            );
        }
    }
    let thickest = |layer: &serde_json::Value| {
        ["thickness_mm", "thickness_spread_mm"].iter().filter_map(|key| layer[*key].as_f64()).sum::<f64>()
    };
    let least_mm = LEAST_BEND * doc.tables("layer").iter().map(thickest).sum::<f64>();
    match (is_flat, skin["radius_mm"].as_f64()) {
        (false, None) if !doc.is_written("skin.radius_mm") => {
            doc.refuse("skin.radius_mm", phrase!("missing"), phrase!("required for a {shape}", shape = shape.as_str()));
        }
        (true, Some(radius_mm)) => {
            let allowed = phrase!("allowed only for a curved skin: shape = \"sphere\" or \"cylinder\"");
            doc.refuse("skin.radius_mm", Phrase::Data(measure(radius_mm, "mm")), allowed);
        }
        (false, Some(radius_mm)) if radius_mm < least_mm => {
            let allowed = phrase!(
                "allowed: at least {least} mm, {times} times the thickness of the thickest patient's layers",
                least = Phrase::number(least_mm, 1),
                times = LEAST_BEND
            );
            doc.refuse("skin.radius_mm", Phrase::Data(measure(radius_mm, "mm")), allowed);
        }
        _ => {}
    }
    if let Some(along_deg) =
        skin["along_deg"].as_f64().filter(|_| shape != "cylinder" && doc.is_written("skin.along_deg"))
    {
        let allowed = phrase!("allowed only for a cylinder, whose direction it sets");
        doc.refuse("skin.along_deg", Phrase::Data(measure(along_deg, "°")), allowed);
    }
}

fn skin_shape(raw: &RawSkin) -> Skin {
    let radius_m = raw.radius_mm / 1e3;
    match raw.shape.as_str() {
        "sphere" => Skin::Sphere { radius_m },
        "cylinder" => Skin::Cylinder { radius_m, along_rad: raw.along_deg.to_radians() },
        _ => Skin::Flat,
    }
}

/// Density of inclusions, in kg/m³. The field of an attempt is static and does not depend on it.
const DENSITY_KG_PER_M3: f64 = 1050.0;
/// Default Poisson ratio of inclusions.
const POISSON_RATIO: f64 = 0.45;

/// Refuses coupling without a model: only a field can set the boundaries' stiffness.
fn check_tissue(doc: &mut Walked) {
    let tissue = &doc.value["tissue"];
    if tissue["coupling"] == "field" && tissue["model"] == "none" {
        let allowed = phrase!("allowed: \"none\", because model = \"none\" has no field; other models have one");
        doc.refuse("tissue.coupling", Phrase::quoted("field"), allowed);
    }
}

fn structure(raw: RawStructure, mesh: Option<Shape>) -> SceneStructure {
    let shape = match (mesh, raw.shape.as_str()) {
        (Some(mesh), _) => mesh,
        (None, "capsule") => Shape::Capsule { half_axis_m: metres(raw.half_axis_mm), radius_m: raw.radius_mm / 1e3 },
        (None, "box") => Shape::Box { half_extents_m: metres(raw.half_extents_mm) },
        (None, _) => Shape::Sphere { radius_m: raw.radius_mm / 1e3 },
    };
    let position_m = Point3::from(metres(raw.position_mm));
    let wall = raw.wall_stiffness_n_per_m.zip(raw.wall_rupture_n);
    let wall = wall.map(|(stiffness_n_per_m, rupture_n)| Wall { stiffness_n_per_m, rupture_n });
    let elastic = raw.youngs_modulus_pa.map(|youngs_modulus_pa| Material {
        youngs_modulus_pa,
        poisson_ratio: raw.poisson_ratio.unwrap_or(POISSON_RATIO),
        density_kg_per_m3: DENSITY_KG_PER_M3,
    });
    SceneStructure {
        spec: StructureSpec { name: raw.name, kind: raw.kind, shape, position_m, wall },
        mesh_file: raw.file,
        elastic,
    }
}

fn metres(mm: [f64; 3]) -> Vector3<f64> {
    Vector3::from(mm.map(|v| v / 1e3))
}
