//! Surveys after an attempt, and their answers.

use std::collections::BTreeMap;

use acts::error::Error;
use acts::surveys as asking;
use acts::surveys::AnsweredSheet;
use axum::Json;
use axum::extract::{Path, State};
use model::Role;
use model::ids::{PersonId, SchoolId, SessionId, SurveyId};
use model::surveys::{Identity, ResponseState, Survey};
use routes_base::AppState;
use routes_base::error::{ApiError, ProblemDocument};
use routes_base::surveys::{TermsOf, find_asker, open_attempts, terms_of_survey};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use store::recordings::sessions;
use store::recordings::sessions::Session;
use store::surveys::Practised;
use store::{people, surveys};
use utoipa::ToSchema;

use crate::caller::Caller;
use crate::{ApiId, ApiJson};

/// The surveys to be answered after an attempt.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct SurveysAfter {
    /// Empty if there is no survey, or all of them are answered.
    surveys: Vec<SurveyAfter>,
}

/// A survey to be answered after an attempt.
#[derive(Debug, Serialize, ToSchema)]
struct SurveyAfter {
    #[serde(flatten)]
    questions: Questions,
    /// Path of this service where the signed-in trainee answers the survey.
    path: String,
}

/// A survey with everything that is needed to ask it.
#[derive(Debug, Serialize, ToSchema)]
struct Questions {
    #[schema(value_type = Uuid)]
    survey_id: SurveyId,
    title: String,
    /// Estimated duration, in min.
    duration_min: f64,
    /// `anonymous`, `pseudonymous` or `named`: whether answers can be traced to the person who gave
    /// them.
    #[schema(value_type = String)]
    identity: Identity,
    /// Codes of the languages in which it can be answered, its own first.
    languages: Vec<String>,
    /// The terms by language, as paragraphs, which must be shown before the person agrees to
    /// answer.
    terms: BTreeMap<String, Vec<String>>,
    /// The instrument's document: questions, scales, conditions.
    instrument_toml: String,
}

/// A survey that a station may have to ask.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct StationSurvey {
    #[serde(flatten)]
    questions: Questions,
    /// Exercises after which it is asked; empty for all exercises.
    exercises: Vec<String>,
    /// Whether it belongs to a study: it is then asked at the station regardless of its duration.
    study: bool,
    /// Number of the attempt at those exercises from which it is asked, counted from this sign-in:
    /// a study may ask after the last attempt.
    from_attempt: u32,
}

/// Whether a person is a guest: a study participant without an account.
async fn is_guest(state: &AppState, person: PersonId) -> Result<bool, Error> {
    Ok(people::find_person(state.db.reader(), person).await?.is_some_and(|found| found.role == Role::Guest))
}

async fn questions_of_survey(state: &AppState, survey: Survey, guest: bool) -> Result<Questions, Error> {
    let found = asking::document(state, survey.school_id, survey.revision_id).await?;
    let (instrument, document) = found.ok_or(Error::NotFound)?;
    let asker = &find_asker(state, &survey).await?;
    let of = TermsOf { survey: &survey, instrument: &instrument, after_attempt: true, asker };
    let told = |code: &String| (code.clone(), terms_of_survey(&of, code).at_a_station(guest));
    Ok(Questions {
        terms: instrument.languages.iter().map(told).collect(),
        survey_id: survey.id,
        identity: survey.identity,
        title: survey.title,
        duration_min: instrument.duration_min,
        languages: instrument.languages,
        // Published documents were parsed as TOML, so they are UTF-8.
        instrument_toml: String::from_utf8_lossy(&document).into_owned(),
    })
}

/// Returns the surveys that a station may have to ask a person after any exercise, so that it can
/// ask them while offline.
pub(crate) async fn surveys_at_station(
    state: &AppState,
    school: SchoolId,
    trainee: PersonId,
) -> Result<Vec<StationSurvey>, Error> {
    let reader = state.db.reader();
    let practised = Practised { school, trainee, exercise: None, ended_at: None };
    let open = surveys::after_attempt(reader, practised, state.clock.now()).await?;
    let after = surveys::exercises(reader, school).await?;
    let guest = is_guest(state, trainee).await?;
    let mut asked = Vec::new();
    for survey in open {
        let own = after.iter().filter(|(id, _)| *id == survey.id);
        let exercises = own.map(|(_, exercise)| exercise.clone()).collect();
        let study = survey.study_id.is_some();
        let from_attempt = open_attempts(state, &survey, trainee).await?.max(1);
        asked.push(StationSurvey {
            questions: questions_of_survey(state, survey, guest).await?,
            exercises,
            study,
            from_attempt,
        });
    }
    Ok(asked)
}

/// Lists the unanswered surveys for the trainee after an attempt. A station may request them, too,
/// for its debriefing.
#[utoipa::path(get, path = "/sessions/{id}/survey", tag = "surveys", operation_id = "list_surveys_after", params(("id" = Uuid, Path)),
    responses((status = 200, body = SurveysAfter), (status = 404, body = ProblemDocument)))]
pub(crate) async fn list_surveys_after(
    State(state): State<AppState>,
    caller: Caller,
    ApiId(id): ApiId<SessionId>,
) -> Result<Json<SurveysAfter>, ApiError> {
    let session = find_own_session(&state, &caller, id).await?;
    let reader = state.db.reader();
    let guest = is_guest(&state, session.trainee_id).await?;
    let mut asked = Vec::new();
    for survey in surveys::after_attempt(reader, Practised::by(&session), state.clock.now()).await? {
        let open = open_attempts(&state, &survey, session.trainee_id).await? == 0;
        if open && !surveys::answered(reader, &survey, session.trainee_id, Some(id)).await? {
            let path = format!("/surveys/{}?session={id}", survey.id);
            asked.push(SurveyAfter { questions: questions_of_survey(&state, survey, guest).await?, path });
        }
    }
    Ok(Json(SurveysAfter { surveys: asked }))
}

/// Returns an attempt for the trainee themselves, or for a station of their school, which is only
/// shown the surveys.
async fn find_own_session(state: &AppState, caller: &Caller, id: SessionId) -> Result<Session, Error> {
    let session = sessions::find_session(state.db.reader(), caller.school_id(), id).await?;
    let may_ask = |session: &Session| caller.person().map_or(true, |person| person.id == session.trainee_id);
    session.filter(may_ask).ok_or(Error::NotFound)
}

/// Answers to a survey after an attempt.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct GivenAnswers {
    /// 64 hexadecimal digits drawn at random by the sender: with them the same answers can be sent
    /// again, and the respondent finds them at `/survey/{secret}` to continue or to withdraw them.
    secret: String,
    /// The language of the survey in which they were given.
    language: String,
    /// Whether the person has seen the terms and agrees.
    consent: bool,
    /// By item: a number, a text, or a list of options. An omitted item was not answered.
    #[schema(value_type = Object)]
    answers: BTreeMap<String, Value>,
    /// Whether they are final. Until then they can be changed and sent again; final answers never
    /// change.
    sent: bool,
}

/// The state of a response.
#[derive(Serialize, ToSchema)]
pub(crate) struct TakenAnswers {
    /// `begun`, `submitted` or `withdrawn`.
    #[schema(value_type = String)]
    state: ResponseState,
}

/// Stores answers from the trainee, or from a station on their behalf, also if the survey has
/// closed since the attempt. Idempotent: answers sent again with the same secret are stored once.
#[utoipa::path(put, path = "/sessions/{id}/survey/{survey}", tag = "surveys", operation_id = "answer_survey", params(("id" = Uuid, Path), ("survey" = Uuid, Path)),
    request_body = GivenAnswers,
    responses((status = 200, body = TakenAnswers), (status = 400, body = ProblemDocument),
              (status = 404, body = ProblemDocument, description = "No such attempt (yet), or no such survey"),
              (status = 409, body = ProblemDocument, description = "The person has already answered or started elsewhere"),
              (status = 410, body = ProblemDocument, description = "The survey does not follow this attempt"),
              (status = 422, body = ProblemDocument, description = "An answer that is not allowed, or no consent")))]
pub(crate) async fn take_answers(
    State(state): State<AppState>,
    caller: Caller,
    Path((id, survey)): Path<(String, String)>,
    ApiJson(given): ApiJson<GivenAnswers>,
) -> Result<Json<TakenAnswers>, ApiError> {
    let id = id.parse::<SessionId>().map_err(|_| Error::NotFound)?;
    let session = find_own_session(&state, &caller, id).await?;
    let survey = survey.parse::<SurveyId>().map_err(|_| Error::NotFound)?;
    if !given.consent {
        return Err(Error::Unprocessable("consent: false; without consent no answer is stored".to_owned()).into());
    }
    let said = given.answers.into_iter().map(|(item, value)| Ok((item.clone(), values_of_answers(&item, value)?)));
    let answers = said.collect::<Result<BTreeMap<_, _>, Error>>()?;
    let sheet = AnsweredSheet {
        session: &session,
        survey,
        secret: &given.secret,
        language: &given.language,
        answers: &answers,
        sent: given.sent,
    };
    Ok(Json(TakenAnswers { state: asking::take(&state, &sheet).await? }))
}

/// Converts an answer to the values that a form would send.
fn values_of_answers(item: &str, value: Value) -> Result<Vec<String>, Error> {
    let one = |value: Value| match value {
        Value::String(text) => Some(text),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    };
    let read = match value {
        Value::Null => Some(Vec::new()),
        Value::Array(several) => several.into_iter().map(one).collect(),
        value => one(value).map(|text| vec![text]),
    };
    let allowed = || format!("answers.{item}: allowed: a number, a text or a list of texts");
    read.ok_or_else(|| Error::Unprocessable(allowed()))
}
