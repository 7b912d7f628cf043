//! `/admin/outcomes`: the outcomes of a school; `/trainees/{id}/outcomes` and `/cohorts/{id}/outcomes`:
//! who has reached which level.

mod cohort;
mod trainee;

use acts::error::Error;
use acts::training::outcomes::{self as deeds, ImportedOutcomes, OutcomeSettings};
use axum::extract::{Query, State};
use axum::response::IntoResponse;
use model::CurrentPerson;
use model::ids::OutcomeId;
use pages::form::{FilledForm, SelectOption};
use pages::people::listed::{ListPart, ListQuery};
use pages::training::outcomes::{LevelsForm, OutcomeForm, OutcomePage, OutcomeRow, OutcomesPage, name_levels};
use pages::{NavPlace, Shell};
use routes_base::addresses::PathId;
use routes_base::auth::{Administrator, Csrf, CsrfFileForm, CsrfForm, Visit};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use routes_base::{AppState, Routes, get, post};
use store::training::{curricula, outcomes};

use super::rows::PeopleOnPage;

const PAGE: &str = "/admin/outcomes";
/// Maximum size of a catalogue, in bytes.
const MOST_FILE_BYTES: usize = 4 * 1024 * 1024;

/// Returns the routes of outcomes.
pub(super) fn outcome_routes() -> Routes {
    Routes::new()
        .route("/admin/outcomes", get(list_outcomes).merge(post(add_outcome)))
        .route("/admin/outcomes/file", post(import_catalogue))
        .route("/admin/outcomes/levels", post(set_levels))
        .route("/admin/outcomes/{id}", get(show_outcome).merge(post(change_outcome)))
        .route("/trainees/{id}/outcomes", get(trainee::show_trainee_outcomes))
        .route("/trainees/{id}/outcomes/{outcome}", post(trainee::entrust_level))
        .route("/cohorts/{id}/outcomes", get(cohort::show_cohort_outcomes))
}

async fn list_outcomes(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    Query(query): Query<PeopleOnPage>,
    csrf: Csrf,
) -> Result<OutcomesPage, PageError> {
    Ok(make_list(&state, Visit::new(&person, &csrf), query.into()).await?)
}

async fn make_list(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    query: ListQuery,
) -> Result<OutcomesPage, Error> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let taught = curricula::list_taught_curricula(reader, school).await?;
    let courses = outcomes::list_outcome_courses(reader, school).await?;
    let row = |outcome: outcomes::Outcome| {
        let of_outcome = courses.iter().filter(|course| course.outcome_id == outcome.id);
        let title =
            |id: &str| taught.iter().find(|course| course.curriculum_id == id).map(|course| course.title.clone());
        OutcomeRow {
            href: format!("{PAGE}/{}", outcome.id),
            courses: of_outcome.filter_map(|course| title(&course.curriculum_id)).collect(),
            is_retired: outcome.retired_at.is_some(),
            title: outcome.title,
            code: outcome.code,
        }
    };
    let found = outcomes::list_outcomes(reader, school).await?;
    let found: Vec<(String, outcomes::Outcome)> =
        found.into_iter().map(|one| (format!("{} {}", one.code, one.title), one)).collect();
    let (part, list) = ListPart::of(query, found, |(words, _)| words);
    let levels = name_levels(outcomes::list_levels(reader, school).await?);
    Ok(OutcomesPage {
        shell: Shell::new(person, csrf.token(), NavPlace::Administration),
        rows: part.into_iter().map(|(_, outcome)| row(outcome)).collect(),
        list,
        form: FilledForm::default(),
        levels: FilledForm::new(LevelsForm { levels: levels.join("\n") }),
        refused_file: None,
        imported: None,
    })
}

async fn add_outcome(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<OutcomeForm>,
) -> Result<FormAnswer<OutcomesPage>, PageError> {
    match split_refusal(deeds::add_outcome(&state, &person, form.text("")).await)? {
        Ok(id) => Ok(FormAnswer::lead_to(&format!("{PAGE}/{id}"))),
        Err(why) => {
            let page = make_list(&state, Visit::new(&person, &csrf), ListQuery::default()).await?;
            Ok(FormAnswer::Refused(OutcomesPage { form: FilledForm::refused(form, why), ..page }))
        }
    }
}

async fn import_catalogue(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfFileForm { file, .. }: CsrfFileForm<MOST_FILE_BYTES>,
) -> Result<FormAnswer<OutcomesPage>, PageError> {
    let imported = match file.is_cut {
        true => Err(tr!("the file is too large; at most {most} bytes are allowed", most = MOST_FILE_BYTES)),
        false => split_refusal(deeds::import_catalogue(&state, &person, &file.bytes).await)?,
    };
    let page = make_list(&state, Visit::new(&person, &csrf), ListQuery::default()).await?;
    Ok(match imported {
        Ok(counts) => {
            let page = OutcomesPage { imported: Some(imported_words(counts)), ..page };
            FormAnswer::Answered(page.into_response())
        }
        Err(why) => FormAnswer::Refused(OutcomesPage { refused_file: Some(why), ..page }),
    })
}

fn imported_words(ImportedOutcomes { added, changed, unchanged }: ImportedOutcomes) -> String {
    tr!(
        "Outcomes added: {added}; changed: {changed}; unchanged: {unchanged}.",
        added = added,
        changed = changed,
        unchanged = unchanged
    )
}

async fn set_levels(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<LevelsForm>,
) -> Result<FormAnswer<OutcomesPage>, PageError> {
    match split_refusal(deeds::set_levels(&state, &person, &form.levels).await)? {
        Ok(()) => Ok(FormAnswer::lead_to(PAGE)),
        Err(why) => {
            let page = make_list(&state, Visit::new(&person, &csrf), ListQuery::default()).await?;
            Ok(FormAnswer::Refused(OutcomesPage { levels: FilledForm::refused(form, why), ..page }))
        }
    }
}

async fn show_outcome(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    PathId(id): PathId<OutcomeId>,
    csrf: Csrf,
) -> Result<OutcomePage, PageError> {
    Ok(make_outcome_page(&state, Visit::new(&person, &csrf), id, None).await?)
}

/// Returns the page of an outcome, with a refused form if there is one.
async fn make_outcome_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    id: OutcomeId,
    refused: Option<FilledForm<OutcomeForm>>,
) -> Result<OutcomePage, Error> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let outcome = find_outcome(state, person, id).await?;
    let courses = outcomes::list_outcome_courses(reader, school).await?.into_iter();
    let stored = OutcomeForm {
        code: outcome.code.clone(),
        title: outcome.title.clone(),
        description: outcome.description,
        courses: courses.filter(|course| course.outcome_id == id).map(|course| course.curriculum_id).collect(),
        retired: outcome.retired_at.is_some(),
    };
    let form = refused.unwrap_or_else(|| FilledForm::new(stored));
    let option = |course: curricula::TaughtCurriculum| SelectOption {
        chosen: form.typed.courses.contains(&course.curriculum_id),
        value: course.curriculum_id,
        label: course.title,
    };
    let courses = curricula::list_taught_curricula(reader, school).await?.into_iter().map(option).collect();
    Ok(OutcomePage {
        shell: Shell::new(person, csrf.token(), NavPlace::Administration),
        href: format!("{PAGE}/{id}"),
        heading: format!("{} {}", outcome.code, outcome.title),
        source: outcome.source,
        form,
        courses,
    })
}

async fn find_outcome(state: &AppState, person: &CurrentPerson, id: OutcomeId) -> Result<outcomes::Outcome, Error> {
    outcomes::find_outcome(state.db.reader(), person.school_id, id).await?.ok_or(Error::NotFound)
}

async fn change_outcome(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    PathId(id): PathId<OutcomeId>,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<OutcomeForm>,
) -> Result<FormAnswer<OutcomePage>, PageError> {
    let source = find_outcome(&state, &person, id).await?.source;
    let settings =
        OutcomeSettings { text: form.text(&source), courses: form.courses.clone(), is_retired: form.retired };
    match split_refusal(deeds::change_outcome(&state, &person, id, settings).await)? {
        Ok(()) => Ok(FormAnswer::lead_to(&format!("{PAGE}/{id}"))),
        Err(why) => {
            let form = FilledForm::refused(form, why);
            let page = make_outcome_page(&state, Visit::new(&person, &csrf), id, Some(form)).await?;
            Ok(FormAnswer::Refused(page))
        }
    }
}
