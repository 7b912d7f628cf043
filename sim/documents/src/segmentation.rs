//! Labels of a segmentation: `labels.toml` of `stylet anatomy import`.

use law::structures::StructureKind;
use nalgebra::{Point3, Vector3};
use phrase::{Phrase, phrase};
use serde::Deserialize;

use crate::describe::{SEGMENTATION, measure};
use crate::error::DocumentError;
use crate::source::Source;
use crate::walk::Walked;

/// The labels of a segmentation, and the needle's entry.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct SegmentationLabels {
    /// Title of the resulting scene.
    pub title: String,
    /// The needle's entry.
    pub entry: SegmentationEntry,
    /// The labels.
    #[serde(rename = "label")]
    pub labels: Vec<SegmentationLabel>,
}

/// The needle's entry in the image's world coordinates.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct SegmentationEntry {
    point_mm: [f64; 3],
    up: Option<[f64; 3]>,
}

/// A label.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct SegmentationLabel {
    /// Voxel value.
    pub number: u16,
    /// Name of the structure or layer.
    pub name: String,
    /// The kind as the document gives it: a structure's kind, `skin` or `layer`.
    kind: String,
    tissue: Option<String>,
    /// Largest displacement of the mesh by smoothing, in voxels.
    pub smoothing_voxels: f64,
    /// Stiffness of its wall, in N/m, if it has one.
    pub wall_stiffness_n_per_m: Option<f64>,
    /// Rupture force of its wall, in N.
    pub wall_rupture_n: Option<f64>,
}

impl SegmentationEntry {
    /// Returns the entry point, in m.
    #[must_use]
    pub fn point_m(&self) -> Point3<f64> {
        Point3::from(self.point_mm.map(|mm| mm / 1e3))
    }

    /// Returns the direction out of the body, if the document gives one.
    #[must_use]
    pub fn up(&self) -> Option<Vector3<f64>> {
        self.up.map(Vector3::from)
    }
}

impl SegmentationLabel {
    /// Returns the kind of structure; `None` for a layer.
    #[must_use]
    pub fn structure(&self) -> Option<StructureKind> {
        serde_json::from_value(self.kind.as_str().into()).ok()
    }

    /// Returns the tissue of a layer; `None` for a structure.
    #[must_use]
    pub fn tissue(&self) -> Option<&str> {
        match self.kind.as_str() {
            "skin" => Some("skin"),
            "layer" => self.tissue.as_deref(),
            _ => None,
        }
    }

    /// Returns the kind as the document gives it.
    #[must_use]
    pub fn kind(&self) -> &str {
        &self.kind
    }
}

impl SegmentationLabels {
    /// Reads the labels from the bytes of a document; errors refer to it as `name`.
    ///
    /// # Errors
    /// Every issue found.
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self, DocumentError> {
        let mut doc = Walked::new(Source::new(name, bytes)?, &SEGMENTATION)?;
        doc.refuse_duplicates("label", "name");
        check_numbers(&mut doc);
        check_kinds(&mut doc);
        check_up(&mut doc);
        doc.finish()
    }
}

fn check_numbers(doc: &mut Walked) {
    let numbers: Vec<_> = doc.tables("label").iter().map(|label| label["number"].as_u64()).collect();
    for (at, number) in numbers.iter().enumerate() {
        let first = numbers[..at].iter().position(|earlier| earlier == number);
        if let (Some(first), Some(number)) = (first, number) {
            let allowed = phrase!("{first} already has it; each must be unique", first = format!("label[{first}]"));
            doc.refuse(&format!("label[{at}].number"), Phrase::data(number), allowed);
        }
    }
}

/// Checks that a layer has a tissue and no wall, that bone and targets have no wall, and that a
/// wall has both numbers.
fn check_kinds(doc: &mut Walked) {
    for (at, label) in doc.tables("label").iter().enumerate() {
        let kind = label["kind"].as_str().unwrap_or_default();
        let field = |key: &str| format!("label[{at}].{key}");
        if kind == "layer" && label["tissue"].is_null() && !doc.is_written(&field("tissue")) {
            doc.refuse(
                &field("tissue"),
                phrase!("missing"),
                phrase!("required for a layer: its mechanical properties follow from it"),
            );
        }
        if let (Some(tissue), true) = (label["tissue"].as_str(), kind != "layer") {
            let allowed = phrase!("allowed only with kind = \"layer\"");
            doc.refuse(&field("tissue"), Phrase::quoted(tissue), allowed);
        }
        let keys = ["wall_stiffness_n_per_m", "wall_rupture_n"];
        let [stiffness, rupture] = keys.map(|key| label[key].as_f64());
        let lacks = [(rupture, stiffness, keys[1]), (stiffness, rupture, keys[0])];
        for (_, _, key) in lacks.into_iter().filter(|(this, other, _)| this.is_none() && other.is_some()) {
            doc.refuse(
                &field(key),
                phrase!("missing"),
                phrase!("both are required for a wall: its stiffness and the force at which it gives way"),
            );
        }
        if let (Some(stiffness), false) = (stiffness, ["vessel", "nerve", "organ"].contains(&kind)) {
            let allowed = phrase!("allowed only for vessel, nerve and organ");
            doc.refuse(&field(keys[0]), Phrase::Data(measure(stiffness, "N/m")), allowed);
        }
    }
}

fn check_up(doc: &mut Walked) {
    let up: Vec<f64> = doc.value["entry"]["up"].as_array().into_iter().flatten().filter_map(|c| c.as_f64()).collect();
    if !up.is_empty() && up.iter().all(|c| c.abs() < 1e-6) {
        doc.refuse(
            "entry.up",
            phrase!("a direction of zero length"),
            phrase!("allowed: a direction, for example [0, -1, 0]"),
        );
    }
}
