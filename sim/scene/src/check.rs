//! What `stylet check` asks beyond reading: whether the scenes are sound.

use std::path::{Path, PathBuf};

use mechanics::axial::Contactor;
use mechanics::soundness::{self, Unsound};

use crate::describe::SCENE;
use crate::error::{DocumentError, Issue};
use crate::load::{Document, beside, read, read_file};
use crate::model::Scene;
use crate::patient::Patient;
use crate::source::Source;
use crate::walk::Walked;

impl Scene {
    /// Every rupture that would create force or energy: in the nominal patient, then those only at the ends of the spread.
    ///
    /// An oblique path makes every layer thicker and so moves boundaries apart, which never makes a rupture take over more.
    #[must_use]
    pub fn soundness(&self) -> Vec<Unsound> {
        let [thinnest, thickest] = Patient::extremes(self);
        let mut found: Vec<Unsound> = Vec::new();
        for patient in [Patient::nominal(self), thinnest, thickest] {
            for unsound in soundness::check(&self.puncture_spec(&patient).axial) {
                if !found.iter().any(|f| (f.boundary, f.contactor) == (unsound.boundary, unsound.contactor)) {
                    found.push(unsound);
                }
            }
        }
        found
    }
}

/// Reads a document and all it names, and refuses unsound scenes.
///
/// # Errors
/// Every issue found.
pub fn check(path: &Path) -> Result<Document, DocumentError> {
    let document = read(path)?;
    let mut issues = Vec::new();
    for (path, scene) in scenes(path, &document) {
        issues.extend(unsound_issues(&path, scene)?);
    }
    if issues.is_empty() { Ok(document) } else { Err(DocumentError { issues }) }
}

/// Every scene of a document with its path, once.
fn scenes<'d>(path: &Path, document: &'d Document) -> Vec<(PathBuf, &'d Scene)> {
    let mut scenes = match document {
        Document::Scene(scene) => vec![(path.to_owned(), scene.as_ref())],
        Document::Exercise(bundle) => vec![(beside(path, &bundle.exercise.scene), &bundle.scene)],
        Document::Curriculum(curriculum, bundles) => curriculum
            .entries
            .iter()
            .zip(bundles)
            .map(|(entry, bundle)| (beside(&beside(path, &entry.file), &bundle.exercise.scene), &bundle.scene))
            .collect(),
    };
    scenes.sort_by(|a, b| a.0.cmp(&b.0));
    scenes.dedup_by(|a, b| a.0 == b.0);
    scenes
}

fn unsound_issues(path: &Path, scene: &Scene) -> Result<Vec<Issue>, DocumentError> {
    let unsound = scene.soundness();
    if unsound.is_empty() {
        return Ok(Vec::new());
    }
    // The scene keeps no places: they are found again, only when there is something to place.
    let doc = Walked::new(Source::new(&path.display().to_string(), &read_file(path)?)?, &SCENE)?;
    Ok(unsound.iter().map(|unsound| issue(&doc, scene, unsound)).collect())
}

fn issue(doc: &Walked, scene: &Scene, unsound: &Unsound) -> Issue {
    let Unsound { boundary, layer, threshold_n, force_rise_n, energy_rise_mj, largest_sound_n, .. } = unsound;
    let as_written = scene.layers.get(*boundary);
    let (key, contactor, written_n) = match unsound.contactor {
        Contactor::Tip => ("tip_rupture_n", "tip", as_written.map(|l| l.tip_rupture_n)),
        Contactor::Rim => ("rim_rupture_n", "rim", as_written.map(|l| l.rim_rupture_n)),
    };
    let written_n = written_n.unwrap_or(*threshold_n);
    // The document speaks of the reference needle and toughness; the rounding is downwards, so that the limit is sound.
    let limit_n = (largest_sound_n * written_n / threshold_n * 1e4).floor() / 1e4;
    let found = format!(
        "{written_n} N is unsound: when the {contactor} opens boundary {boundary} ({layer}), the force would rise by \
         {force_rise_n:.4} N and the elastic energy by {energy_rise_mj:.4} mJ"
    );
    let allowed = format!("allowed: at most {limit_n} N here, or a stiffer boundary, or a softer next layer");
    doc.issue(&format!("layer[{boundary}].{key}"), &found, &allowed)
}
