//! Surveys, as used by pages and the API: when they are due, in which language, under which terms.

use acts::error::Error;
use acts::surveys::instrument_of;
use axum::http::HeaderMap;
use axum::http::header::ACCEPT_LANGUAGE;
use model::ids::PersonId;
use model::surveys::Survey;
use model::{CurrentPerson, PersonKey};
use pages::surveys::form::{SurveyAsker, SurveyContact, Terms};
use store::operations::schools;
use store::recordings::sessions;
use store::surveys::Practised;
use store::{people, studies, surveys};
use words::Language;

use crate::AppState;

/// Returns the number of attempts that a person still has to make before a survey is due: those of
/// a study that asks it at its end.
///
/// # Errors
/// When the database fails.
pub async fn open_attempts(state: &AppState, survey: &Survey, person: PersonId) -> Result<u32, Error> {
    let person = PersonKey { school_id: survey.school_id, person_id: person };
    match survey.study_id.filter(|_| survey.at_end) {
        Some(study) => Ok(studies::count_open_attempts(state.db.reader(), person, study).await?),
        None => Ok(0),
    }
}

/// Returns title, address and duration in min of each unanswered survey after an attempt of the
/// visitor's own.
///
/// # Errors
/// When the database fails.
pub async fn list_surveys_after(
    state: &AppState,
    person: &CurrentPerson,
    session: &sessions::Session,
) -> Result<Vec<(String, String, f64)>, Error> {
    if person.id != session.trainee_id {
        return Ok(Vec::new());
    }
    let reader = state.db.reader();
    let mut found = Vec::new();
    for survey in surveys::after_attempt(reader, Practised::by(session), state.clock.now()).await? {
        let open = open_attempts(state, &survey, person.id).await? == 0;
        if open && !surveys::answered(reader, &survey, person.id, Some(session.id)).await? {
            let minutes = instrument_of(state, &survey).await?.duration_min;
            found.push((survey.title, format!("/surveys/{}?session={}", survey.id, session.id), minutes));
        }
    }
    Ok(found)
}

/// Returns the preferred languages: the one chosen in this service, followed by those of the
/// browser.
#[must_use]
pub fn preferred_languages(headers: &HeaderMap) -> String {
    let asked = headers.get(ACCEPT_LANGUAGE).and_then(|value| value.to_str().ok()).unwrap_or_default();
    // English is also the fallback for browsers in unsupported languages, and an instrument may
    // support those.
    match words::current() {
        Language::ENGLISH => asked.to_owned(),
        chosen => format!("{chosen},{asked}"),
    }
}

/// Returns the information shown before the first question.
#[must_use]
pub fn terms_of_survey(answering: &TermsOf<'_>, wanted: &str) -> Terms {
    let language = answering.instrument.language_for(wanted).to_owned();
    Terms {
        title: answering.survey.title.clone(),
        intro: answering.instrument.intro.as_ref().map_or_else(String::new, |w| w.in_language(&language).to_owned()),
        duration_min: answering.instrument.duration_min,
        questions: answering.instrument.items.len(),
        identity: answering.survey.identity,
        after_attempt: answering.after_attempt,
        asker: answering.asker.clone(),
        language,
    }
}

/// The subject of survey terms.
#[derive(Clone, Copy, Debug)]
pub struct TermsOf<'a> {
    /// The survey.
    pub survey: &'a Survey,
    /// Its instrument.
    pub instrument: &'a documents::Instrument,
    /// Whether it is asked after an attempt.
    pub after_attempt: bool,
    /// Who asks.
    pub asker: &'a SurveyAsker,
}

/// Who asks a survey, and who answers for what is told.
///
/// # Errors
/// When the database fails.
pub async fn find_asker(state: &AppState, survey: &Survey) -> Result<SurveyAsker, Error> {
    let settled = schools::find_school_settings(state.db.reader(), survey.school_id).await?;
    let owner = match survey.owner_id {
        Some(owner) => people::find_person(state.db.reader(), owner).await?,
        None => None,
    };
    let contact = owner.map(|owner| SurveyContact { name: owner.display_name, email: owner.email });
    Ok(SurveyAsker { school: settled.name, contact, data_notice: settled.data_notice })
}
