//! What a draft of an exercise comes to: read as publishing would, its tissue planned, its rubric tried.

use documents::{DocumentError, ExerciseBundle, Issue, Patient};
use model::draft::Publishable;
use phrase::{Phrase, phrase};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use store::exercises::RevisionBytes;
use tissue::follow::{Field, FieldPlan};

/// A draft, and for whom its verdict is.
#[derive(Debug, Serialize, Deserialize)]
pub struct DraftQuestion {
    /// The id that it must have.
    pub id: String,
    /// What was written, and the meshes that it is with.
    pub bytes: RevisionBytes,
    /// Names of the pictures that it is with; each was read when it came.
    pub pictures: Vec<String>,
    /// Code of the language that the verdict is in.
    pub language: String,
}

impl DraftQuestion {
    /// SHA-256 of all that decides the answer.
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

/// The exercise of a draft, where it could be published. May take long.
///
/// # Errors
/// What is wrong with it.
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

/// A draft is of one document: under another id it would be published over something else.
///
/// # Errors
/// When it is another.
pub fn same_id(found: &str, id: &str) -> Result<(), DocumentError> {
    match found == id {
        true => Ok(()),
        false => {
            let allowed = phrase!("allowed: \"{id}\", whose draft this is", id = id);
            Err(issue("document", "id", Phrase::quoted(found), allowed).into())
        }
    }
}

/// What its author should change, by what its metrics mean and by what attempts worth nothing would earn.
fn advice(bundle: &ExerciseBundle) -> Result<Vec<Issue>, DocumentError> {
    let allowed = || phrase!("allowed: an exercise that can be simulated");
    let remarks = assessment::appraise_rubric(bundle);
    let remarks = remarks.map_err(|error| issue("document", "scene", Phrase::data(error), allowed()))?;
    bundle.place("document", &remarks)
}

/// The plan of the nominal patient's tissue; none where the scene names no model.
fn plan(bundle: &ExerciseBundle) -> Result<Option<FieldPlan>, DocumentError> {
    let tissue = bundle.scene.tissue_spec(&Patient::nominal(&bundle.scene), bundle.exercise.planned_needle());
    let allowed = || phrase!("allowed: a tissue that a model can be made of");
    let plan = tissue.map(|tissue| Field::new(&tissue).map(|field| field.plan().clone())).transpose();
    plan.map_err(|error| issue("attached scene", "tissue", error.in_words(), allowed()).into())
}

fn issue(file: &str, field: &str, found: Phrase, allowed: Phrase) -> Issue {
    let [file, field] = [file, field].map(str::to_owned);
    Issue { file, line: 1, column: 1, field, found, allowed }
}
