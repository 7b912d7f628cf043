//! `/trainees/{id}/transcript`: a record of a trainee's work, as a page and as PDF.

use acts::error::Error;
use axum::extract::State;
use axum::response::Response;
use model::PersonKey;
use model::ids::PersonId;
use pages::training::outcomes::{level_words, name_levels};
use pages::training::transcript::{TranscriptCourse, TranscriptOutcome, TranscriptPage};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, Visit, Visitor};
use routes_base::error::PageError;
use routes_base::export::attach_file;
use store::operations::schools;
use store::people;
use store::training::{outcomes, practice, reports};

use super::progress::certificate::logo_of_school;
use super::standing;

/// Shows the transcript.
pub(super) async fn show_transcript(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<PersonId>,
    csrf: Csrf,
) -> Result<TranscriptPage, PageError> {
    Ok(make_transcript(&state, Visit::new(&person, &csrf), id).await?)
}

/// Returns the transcript as PDF, in the language of the visitor.
pub(super) async fn export_transcript(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<PersonId>,
    csrf: Csrf,
) -> Result<Response, PageError> {
    let page = make_transcript(&state, Visit::new(&person, &csrf), id).await?;
    let logo = logo_of_school(&state, person.school_id).await?;
    let signatory = schools::find_school_settings(state.db.reader(), person.school_id).await?.signatory();
    let pdf = page.paper(logo, signatory.as_ref()).to_pdf().map_err(anyhow::Error::from)?;
    Ok(attach_file("application/pdf", "transcript.pdf", pdf))
}

async fn make_transcript(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    id: PersonId,
) -> Result<TranscriptPage, Error> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let trainee = reports::trainee(reader, person, id).await?.ok_or(Error::NotFound)?;
    let courses = standing::taught_courses(state, school).await?;
    let attempts = practice::list_trainee_practice(reader, school, id).await?;
    let progress = standing::progress_in_courses(&courses, &attempts);
    let line = |(at, progress): &(usize, _)| {
        let taught = &courses[*at];
        TranscriptCourse::new(&taught.title, &taught.course, &taught.sha256, progress)
    };
    let own = trainee.id == person.id;
    Ok(TranscriptPage {
        shell: Shell::new(person, csrf.token(), if own { NavPlace::Home } else { NavPlace::Cohorts }),
        trainee: (trainee.name, if own { "/".to_owned() } else { format!("/trainees/{id}") }),
        pdf_href: format!("/trainees/{id}/transcript.pdf"),
        school: schools::find_school_name(reader, school).await?,
        registrar_id: people::find_registrar_id(reader, school, id).await?,
        courses: progress.iter().map(line).collect(),
        outcomes: list_entrusted_outcomes(state, PersonKey { school_id: school, person_id: id }).await?,
        made_at: state.clock.now().to_utc(),
    })
}

/// Returns the outcomes of which a person has a level in force, by code.
async fn list_entrusted_outcomes(state: &AppState, whom: PersonKey) -> Result<Vec<TranscriptOutcome>, Error> {
    let reader = state.db.reader();
    let decisions = outcomes::list_entrustments(reader, whom).await?;
    if decisions.is_empty() {
        return Ok(Vec::new());
    }
    let levels = name_levels(outcomes::list_levels(reader, whom.school_id).await?);
    let entrusted = |outcome: outcomes::Outcome| {
        let last = decisions.iter().rfind(|decision| decision.outcome_id == outcome.id)?;
        Some(TranscriptOutcome {
            title: format!("{} {}", outcome.code, outcome.title),
            level: level_words(&levels, last.level?),
            by: last.decided_by.clone(),
            at: last.decided_at.to_utc(),
        })
    };
    Ok(outcomes::list_outcomes(reader, whom.school_id).await?.into_iter().filter_map(entrusted).collect())
}
