//! Examines an exercise draft: parses it as publishing would, plans its tissue and tries its
//! rubric.

use documents::{DocumentError, ExerciseBundle, Issue, Patient};
use model::authoring::draft::Publishable;
use phrase::{Phrase, phrase};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use store::authoring::exercises::RevisionBytes;
use tissue::follow::{Field, FieldPlan};

/// A draft to examine.
#[derive(Debug, Serialize, Deserialize)]
pub struct DraftQuestion {
    /// The id that the document must have.
    pub id: String,
    /// The documents and meshes.
    pub bytes: RevisionBytes,
    /// File names of the attached images, which were validated when they were uploaded.
    pub pictures: Vec<String>,
    /// Language code of the verdict.
    pub language: String,
}

impl DraftQuestion {
    /// Returns the SHA-256 of everything that determines the verdict.
    #[must_use]
    pub fn sha256(&self) -> [u8; 32] {
        let Self { id, bytes: RevisionBytes { exercise, scene, meshes }, pictures, language } = self;
        let mut hash = Sha256::new();
        let meshes = meshes.iter().flat_map(|(name, bytes)| [name.as_bytes(), bytes]);
        let pictures = pictures.iter().map(String::as_bytes);
        for part in [id.as_bytes(), exercise, scene, language.as_bytes()].into_iter().chain(meshes).chain(pictures) {
            hash.update((part.len() as u64).to_le_bytes());
            hash.update(part);
        }
        hash.finalize().into()
    }
}

/// Returns the exercise of a draft if it can be published. May take long.
///
/// # Errors
/// Returns the problems of the draft.
pub fn publishable(question: &DraftQuestion) -> Result<Publishable, DocumentError> {
    let RevisionBytes { exercise, scene, meshes } = &question.bytes;
    let bundle = ExerciseBundle::from_parts(exercise, scene, meshes)?;
    same_id(&bundle.exercise.id, &question.id)?;
    let mut issues = bundle.place("document", &bundle.list_missing_pictures(&question.pictures))?;
    issues.extend(bundle.unsound()?);
    if !issues.is_empty() {
        return Err(DocumentError { issues });
    }
    let (plan, advice) = (plan(&bundle)?, advice(&bundle)?);
    Ok(Publishable { bundle, plan, advice })
}

/// Checks the document's id: with another id, the draft would be published over another document.
///
/// # Errors
/// Fails if the ids differ.
pub fn same_id(found: &str, id: &str) -> Result<(), DocumentError> {
    match found == id {
        true => Ok(()),
        false => {
            let allowed = phrase!("allowed: \"{id}\", the id of this draft", id = id);
            Err(issue("document", "id", Phrase::quoted(found), allowed).into())
        }
    }
}

/// Returns advice for the author, from the meaning of the metrics and from the scores that
/// degenerate attempts would get.
fn advice(bundle: &ExerciseBundle) -> Result<Vec<Issue>, DocumentError> {
    let allowed = || phrase!("allowed: an exercise that can be simulated");
    let remarks = assessment::appraise_rubric(bundle);
    let remarks = remarks.map_err(|error| issue("document", "scene", Phrase::data(error), allowed()))?;
    bundle.place("document", &remarks)
}

/// Plans the tissue of the nominal patient; returns `None` if the scene has no tissue model.
fn plan(bundle: &ExerciseBundle) -> Result<Option<FieldPlan>, DocumentError> {
    let tissue = bundle.scene.tissue_spec(&Patient::nominal(&bundle.scene), bundle.exercise.planned_needle());
    let allowed = || phrase!("allowed: a tissue for which a model can be built");
    let plan = tissue.map(|tissue| Field::new(&tissue).map(|field| field.plan().clone())).transpose();
    plan.map_err(|error| issue("attached scene", "tissue", error.in_words(), allowed()).into())
}

fn issue(file: &str, field: &str, found: Phrase, allowed: Phrase) -> Issue {
    let [file, field] = [file, field].map(str::to_owned);
    Issue { file, line: 1, column: 1, field, found, allowed }
}
