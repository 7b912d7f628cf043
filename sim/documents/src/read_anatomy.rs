//! Reads the geometry of a scene: the shapes of its structures, its skin, and their files.

use law::structures::Shape;
use nalgebra::Vector3;
use phrase::{Phrase, phrase};
use serde_json::Value;

use crate::mesh::{self, Axes, Coordinates, MeshFile};
use crate::model::SceneSkin;
use crate::source::{Files, Find};
use crate::walk::Walked;

/// The geometry of a scene.
pub(crate) struct Anatomy {
    /// Meshes, one entry for each structure.
    pub meshes: Vec<Option<Shape>>,
    /// The skin.
    pub skin: Option<SceneSkin>,
    /// Every file read.
    pub files: Files,
}

/// Loads meshes and collects the files read.
struct MeshShelf<'f> {
    find: Find<'f>,
    files: Files,
}

/// A mesh reference in a table.
struct Named {
    file: String,
    coordinates: Coordinates,
}

/// Checks the keys of structures and skin, and reads the meshes that they name.
pub(crate) fn read_anatomy(doc: &mut Walked, find: Find<'_>) -> Anatomy {
    let mut shelf = MeshShelf { find, files: Files::new() };
    let mut meshes = Vec::new();
    for (at, table) in doc.tables("structure").iter().enumerate() {
        let path = format!("structure[{at}]");
        check_shape_keys(doc, table, &path);
        let named = named(doc, table, &path).filter(|_| table["shape"] == "mesh");
        let read = named.map(|named| shelf.read(&named, |file| mesh::read_solid(file, named.coordinates)));
        meshes.push(read.and_then(|read| accept(doc, &path, mesh::allowed_solid(), read)));
    }
    let skin = read_skin(doc, &mut shelf);
    Anatomy { meshes, skin, files: shelf.files }
}

fn read_skin(doc: &mut Walked, shelf: &mut MeshShelf<'_>) -> Option<SceneSkin> {
    let table = doc.value["skin"].clone();
    let named = named(doc, &table, "skin")?;
    let position_m = Vector3::from_fn(|axis, _| table["position_mm"][axis].as_f64().unwrap_or_default() / 1e3);
    let read = shelf.read(&named, |file| mesh::read_skin_mesh(file, named.coordinates, &position_m));
    let (vertices_m, triangles) = accept(doc, "skin", mesh::allowed_skin(), read)?;
    Some(SceneSkin { vertices_m, triangles, file: named.file })
}

/// Returns the mesh that a table names; `None` if a key of its position was refused.
fn named(doc: &Walked, table: &Value, path: &str) -> Option<Named> {
    let is_refused = |key: &&str| table[*key].is_null() && doc.is_written(&format!("{path}.{key}"));
    if ["axes", "position_mm"].iter().any(is_refused) {
        return None;
    }
    let axes = Axes::named(table["axes"].as_str().unwrap_or_default());
    let in_mm = table["unit"].as_str()? == "mm";
    Some(Named { file: table["file"].as_str()?.to_owned(), coordinates: Coordinates { in_mm, axes } })
}

/// Returns the mesh, or adds an issue at the key `file`.
fn accept<T>(doc: &mut Walked, path: &str, allowed: Phrase, read: Result<T, Phrase>) -> Option<T> {
    read.map_err(|why| doc.refuse(&format!("{path}.file"), why, allowed)).ok()
}

impl MeshShelf<'_> {
    /// Finds a mesh, reads it and stores its bytes.
    fn read<T>(
        &mut self,
        Named { file, .. }: &Named,
        read: impl FnOnce(MeshFile<'_>) -> Result<T, Phrase>,
    ) -> Result<T, Phrase> {
        let named = |why: Phrase| phrase!("{file}: {why}", file = Phrase::quoted(file), why = why);
        let bytes = (self.find)(file).map_err(named)?;
        let shape = read(MeshFile { name: file, bytes: &bytes }).map_err(named)?;
        if !self.files.iter().any(|(name, _)| name == file) {
            self.files.push((file.clone(), bytes));
        }
        Ok(shape)
    }
}

/// Keys that each shape requires; the keys of other shapes are refused.
const SHAPE_KEYS: [(&str, &[&str]); 4] = [
    ("sphere", &["radius_mm"]),
    ("capsule", &["radius_mm", "half_axis_mm"]),
    ("box", &["half_extents_mm"]),
    ("mesh", &["file", "unit"]),
];

fn check_shape_keys(doc: &mut Walked, table: &Value, path: &str) {
    let Some(&(shape, needed)) = SHAPE_KEYS.iter().find(|(shape, _)| table["shape"] == **shape) else { return };
    let mut all: Vec<&str> = SHAPE_KEYS.iter().flat_map(|(_, keys)| keys.iter().copied()).collect();
    all.dedup();
    if shape != "mesh" {
        all.push("axes");
    }
    for key in all {
        let field = format!("{path}.{key}");
        match (needed.contains(&key), table[key].is_null()) {
            (true, true) if !doc.is_written(&field) => {
                doc.refuse(&field, phrase!("missing"), phrase!("required for a {shape}", shape = shape));
            }
            (false, false) => {
                let allowed = phrase!("a {shape} has {keys}", shape = shape, keys = needed.join(", "));
                doc.refuse(&field, phrase!("not a key of this shape"), allowed);
            }
            _ => {}
        }
    }
    let extents = table["half_extents_mm"].as_array();
    if shape == "box" && extents.is_some_and(|e| e.iter().any(|v| v.as_f64().is_none_or(|v| v <= 0.0))) {
        let found = phrase!("a half extent of 0 mm or less");
        doc.refuse(&format!("{path}.half_extents_mm"), found, phrase!("allowed: each above 0 mm"));
    }
}
