//! Previews a draft: its evaluation as shown on pages.

use acts::sandbox_jobs::{DraftQuestion, publishable};
use model::authoring::draft::DraftVerdict;
use pages::authoring::draft::{verdict_of_exercise, verdict_of_refused};
use words::Language;

/// Evaluates a draft, with text in its language. Blocks, and may take long.
#[must_use]
pub fn examine_draft(question: &DraftQuestion) -> DraftVerdict {
    let language = Language::named(&question.language).unwrap_or(Language::ENGLISH);
    words::within(language, || match publishable(question) {
        Ok(exercise) => verdict_of_exercise(&exercise),
        Err(refused) => verdict_of_refused(&refused.issues),
    })
}
