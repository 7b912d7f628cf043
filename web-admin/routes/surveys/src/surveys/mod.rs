//! `/surveys`: the surveys that a trainee is asked, and those of a school.

pub(crate) mod answering;
mod exports;
mod instruments;
mod make;
pub(super) mod results;

use acts::error::Error;
use acts::surveys::answering::SurveyOccasion;
use acts::surveys::{answering as answers, instrument_of};
use axum::extract::{Query, State};
use axum::response::{IntoResponse, Response};
use model::ids::{SessionId, SurveyId};
use model::surveys::Survey;
use model::{CurrentPerson, Moment, Role};
use pages::form::{FilledForm, read_ticked_box};
use pages::surveys::form::{ConsentPage, respond_in_language};
use pages::surveys::manage::{ManagePage, OwnSurveyRow, SurveyRow, SurveysPage};
use pages::{NavPlace, Shell};
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfForm, PageHead, Visitor};
use routes_base::error::PageError;
use routes_base::forms::FormAnswer;
use routes_base::surveys::{TermsOf, find_asker, preferred_languages, terms_of_survey};
use routes_base::{AppState, Routes, get, post};
use serde::Deserialize;
use store::recordings::sessions;
use store::surveys;
use store::surveys::Practised;

/// Returns the routes below `/surveys`, for signed-in people.
pub(super) fn survey_routes() -> Routes {
    Routes::new()
        .route("/surveys", get(list_surveys))
        .route("/surveys/new", get(make::show_new_survey).merge(post(make::make_survey)))
        .route("/surveys/instruments", get(instruments::list_instruments))
        .route(
            "/surveys/instruments/new",
            get(instruments::show_new_instrument).merge(post(instruments::add_instrument)),
        )
        .route("/surveys/instruments/{id}", get(instruments::show_instrument))
        .route(
            "/surveys/instruments/{id}/edit",
            get(instruments::show_editor).merge(post(instruments::change_instrument)),
        )
        .route("/surveys/instruments/{id}/{file}", get(instruments::serve_document))
        .route("/surveys/{id}", get(show_survey))
        .route("/surveys/{id}/answer", post(begin_answer))
        .route("/surveys/{id}/links", post(make::make_links))
        .route("/surveys/{id}/close", post(make::close_survey))
        .route("/surveys/{id}/tags", post(results::tag_comment))
        .route("/surveys/{id}/results", get(results::show_results))
        .route("/surveys/{id}/results/{file}", get(exports::serve_export))
}

/// Returns a survey of the visitor's school; not found for trainees.
async fn find_school_survey(state: &AppState, person: &CurrentPerson, id: SurveyId) -> Result<Survey, PageError> {
    if person.role == Role::Trainee {
        return Err(Error::NotFound.into());
    }
    Ok(surveys::find(state.db.reader(), person.school_id, id).await?.ok_or(Error::NotFound)?)
}

/// Whether a person may create links for a survey, close it and see it completely: it is their own,
/// or it belongs to a course and they are an administrator.
fn owns_survey(person: &CurrentPerson, survey: &Survey) -> bool {
    survey.owner_id.map_or(person.role == Role::Administrator, |owner| owner == person.id)
}

async fn list_surveys(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    csrf: Csrf,
) -> Result<SurveysPage, PageError> {
    let shell = Shell::new(&person, csrf.token(), NavPlace::Surveys);
    if person.role == Role::Trainee {
        return Ok(SurveysPage { shell, asked: list_asked_surveys(&state, &person).await?, surveys: None });
    }
    let now = state.clock.now();
    let row = |survey: Survey| SurveyRow {
        href: format!("/surveys/{}", survey.id),
        open: survey.is_open(now),
        title: survey.title,
        instrument: survey.instrument,
        generated: survey.generated,
        created_at: survey.created_at.to_utc(),
    };
    let all = surveys::all(state.db.reader(), person.school_id).await?;
    Ok(SurveysPage { shell, asked: Vec::new(), surveys: Some(all.into_iter().map(row).collect()) })
}

async fn list_asked_surveys(state: &AppState, person: &CurrentPerson) -> Result<Vec<OwnSurveyRow>, Error> {
    let reader = state.db.reader();
    let mut rows = Vec::new();
    for survey in surveys::of_person(reader, person.school_id, person.id, state.clock.now()).await? {
        rows.push(OwnSurveyRow {
            href: format!("/surveys/{}", survey.id),
            duration_min: instrument_of(state, &survey).await?.duration_min,
            answered: surveys::answered(reader, &survey, person.id, None).await?,
            closes_at: survey.closes_at.map(Moment::to_utc),
            title: survey.title,
        });
    }
    Ok(rows)
}

#[derive(Deserialize)]
struct SurveyQuery {
    session: Option<SessionId>,
    lang: Option<String>,
    mailed: Option<usize>,
    before: Option<usize>,
}

async fn show_survey(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<SurveyId>,
    head: PageHead,
    Query(query): Query<SurveyQuery>,
) -> Result<Response, PageError> {
    if person.role != Role::Trainee && query.session.is_none() {
        let survey = find_school_survey(&state, &person, id).await?;
        let page = make::make_manage_page(&state, &person, &head.csrf, survey, FilledForm::default()).await?;
        return Ok(ManagePage { mailed: query.mailed.zip(query.before), ..page }.into_response());
    }
    let survey = find_asked_survey(&state, &person, id, query.session).await?;
    let begun = surveys::draft_of(state.db.reader(), survey.school_id, id, person.id, query.session).await?;
    if begun.is_none() && surveys::answered(state.db.reader(), &survey, person.id, query.session).await? {
        return Err(Error::Gone(tr!(
            "you have already answered this survey; only the address of its last page leads to your answers"
        ))
        .into());
    }
    let wanted = query.lang.unwrap_or_else(|| preferred_languages(&head.headers));
    let page = make_consent_page(&state, &survey, query.session, &head.csrf, &wanted).await?;
    let page = ConsentPage { begun: begun.is_some(), ..page };
    Ok(respond_in_language(&page.terms.language.clone(), page))
}

/// Builds the page with the information before the first question.
async fn make_consent_page(
    state: &AppState,
    survey: &Survey,
    session: Option<SessionId>,
    csrf: &Csrf,
    wanted: &str,
) -> Result<ConsentPage, Error> {
    let instrument = instrument_of(state, survey).await?;
    let asker = &find_asker(state, survey).await?;
    let of = TermsOf { survey, instrument: &instrument, after_attempt: session.is_some(), asker };
    let session = session.map(|id| id.to_string());
    let attempt = session.as_ref().map_or_else(String::new, |id| format!("&session={id}"));
    let href = |code: &String| (code.clone(), format!("/surveys/{}?lang={code}{attempt}", survey.id));
    let mut hidden = vec![("csrf", csrf.token().to_owned())];
    hidden.extend(session.map(|id| ("session", id)));
    Ok(ConsentPage {
        terms: terms_of_survey(&of, wanted),
        action: format!("/surveys/{}/answer", survey.id),
        hidden,
        languages: instrument.languages.iter().map(href).collect(),
        refused: false,
        begun: false,
    })
}

/// Returns a survey that a person is asked: once, or after an attempt of their own.
async fn find_asked_survey(
    state: &AppState,
    person: &CurrentPerson,
    id: SurveyId,
    session: Option<SessionId>,
) -> Result<Survey, Error> {
    let (reader, now) = (state.db.reader(), state.clock.now());
    let asked = match session {
        None => surveys::of_person(reader, person.school_id, person.id, now).await?,
        Some(session) => {
            let session = sessions::find_session(reader, person.school_id, session).await?;
            let own = session.filter(|session| session.trainee_id == person.id).ok_or(Error::NotFound)?;
            surveys::after_attempt(reader, Practised::by(&own), now).await?
        }
    };
    asked.into_iter().find(|survey| survey.id == id).ok_or(Error::NotFound)
}

#[derive(Deserialize)]
struct ConsentAnswerForm {
    session: Option<SessionId>,
    #[serde(default)]
    lang: String,
    #[serde(default, deserialize_with = "read_ticked_box")]
    consent: bool,
}

async fn begin_answer(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<SurveyId>,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<ConsentAnswerForm>,
) -> Result<FormAnswer<Response>, PageError> {
    let survey = find_asked_survey(&state, &person, id, form.session).await?;
    if !form.consent {
        let page = make_consent_page(&state, &survey, form.session, &csrf, &form.lang).await?;
        let page = ConsentPage { refused: true, ..page };
        return Ok(FormAnswer::Refused(respond_in_language(&page.terms.language.clone(), page)));
    }
    let instrument = instrument_of(&state, &survey).await?;
    let language = instrument.language_for(&form.lang);
    let token =
        answers::begin(&state, &person, SurveyOccasion { survey: &survey, session: form.session, language }).await?;
    Ok(FormAnswer::lead_to(&format!("/survey/{token}")))
}
