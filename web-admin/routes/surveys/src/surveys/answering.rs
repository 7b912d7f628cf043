//! `/survey/{token}`: the form of a survey, for everyone who has its address.
//!
//! No cookie identifies the respondent, so no other site can make a browser submit in their name:
//! the secret in the address takes the place of the CSRF token, and a form left open overnight can
//! still be submitted.

use acts::error::Error;
use acts::surveys::answering;
use acts::surveys::answering::Answering;
use axum::extract::{Path, Query, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use model::surveys::ResponseState;
use model::surveys::given::GivenAnswers;
use pages::form::read_ticked_box;
use pages::surveys::form::{
    ConsentPage, EndPage, FormPage, FormQuestion, GivenField, Refusals, SurveyEnd, respond_in_language, speak_language,
};
use routes_base::auth::OpenForm;
use routes_base::error::PageError;
use routes_base::forms::FormAnswer;
use routes_base::surveys::{TermsOf, find_asker, preferred_languages, terms_of_survey};
use routes_base::{AppState, Routes, get, post};
use serde::Deserialize;

/// Returns the public routes of surveys, which require the token in the address.
#[must_use]
pub fn survey_link_routes() -> Routes {
    Routes::new().route("/survey/{token}", get(show_survey_page).merge(post(act_on_form)))
}

#[derive(Deserialize)]
struct SurveyPageQuery {
    page: Option<usize>,
    lang: Option<String>,
}

async fn show_survey_page(
    State(state): State<AppState>,
    Path(token): Path<String>,
    Query(query): Query<SurveyPageQuery>,
    headers: HeaderMap,
) -> Result<Response, PageError> {
    let answering = answering::open(&state, &token).await?;
    let wanted = query.lang.unwrap_or_else(|| preferred_languages(&headers));
    Ok(match answering.response.state {
        ResponseState::Invited => {
            show_consent(&state, &answering, &token, ConsentShown { wanted: &wanted, refused: false }).await?
        }
        ResponseState::Begun => show_form(&answering, &token, query.page, &Refusals::default()),
        ResponseState::Submitted => show_end(&answering, &token, SurveyEnd::Sent),
        ResponseState::Withdrawn => show_end(&answering, &token, SurveyEnd::Withdrawn),
    })
}

/// How a survey's terms are shown.
struct ConsentShown<'a> {
    /// Languages, the one that is wanted most first.
    wanted: &'a str,
    /// The box was not ticked.
    refused: bool,
}

async fn show_consent(
    state: &AppState,
    answering: &Answering,
    token: &str,
    ConsentShown { wanted, refused }: ConsentShown<'_>,
) -> Result<Response, Error> {
    let (survey, instrument) = (&answering.survey, &answering.instrument);
    let asker = &find_asker(state, survey).await?;
    let of = TermsOf { survey, instrument, after_attempt: false, asker };
    let href = |code: &String| (code.clone(), format!("/survey/{token}?lang={code}"));
    let page = ConsentPage {
        terms: terms_of_survey(&of, wanted),
        action: format!("/survey/{token}"),
        hidden: Vec::new(),
        languages: answering.instrument.languages.iter().map(href).collect(),
        refused,
        begun: false,
    };
    Ok(respond_in_language(&page.terms.language.clone(), page))
}

fn show_end(answering: &Answering, token: &str, end: SurveyEnd) -> Response {
    let page = EndPage {
        language: answering.response.language.clone(),
        title: answering.survey.title.clone(),
        end,
        identity: answering.survey.identity,
        action: format!("/survey/{token}"),
    };
    respond_in_language(&answering.response.language, page)
}

fn show_form(answering: &Answering, token: &str, page: Option<usize>, refusals: &Refusals) -> Response {
    let pages = answering.instrument.pages();
    let asked = answering.asked_pages();
    let step = page.and_then(|page| asked.iter().position(|at| *at == page)).unwrap_or(0);
    let at = asked.get(step).copied().unwrap_or(0);
    let language = answering.instrument.language_for(&answering.response.language).to_owned();
    let (section, items) = pages.get(at).cloned().unwrap_or_default();
    let heading = section.map(|section| {
        let text = section.text.as_ref().map_or("", |text| text.in_language(&language));
        (section.title.in_language(&language).to_owned(), text.to_owned())
    });
    let questions = items.into_iter().filter(|item| answering.asks(*item));
    let page = speak_language(&language, || FormPage {
        title: answering.survey.title.clone(),
        heading,
        step: (at + 1, pages.len().max(1)),
        is_last: step + 1 >= asked.len(),
        page: at,
        questions: questions.map(|item| make_question(answering, item, &language, refusals)).collect(),
        action: format!("/survey/{token}"),
        language: language.clone(),
        preview: None,
    });
    respond_in_language(&language, page)
}

fn make_question(answering: &Answering, item: usize, language: &str, refusals: &Refusals) -> FormQuestion {
    let given =
        GivenField { answer: answering.response.answers.0[item].as_ref(), refused: refusals.at(item), left_out: None };
    FormQuestion::new(&answering.instrument, &answering.instrument.items[item], language, &given)
}

/// A submitted page of a survey.
#[derive(Deserialize)]
struct SurveyAnswerForm {
    #[serde(rename = "do", default)]
    step: String,
    #[serde(default, deserialize_with = "read_ticked_box")]
    consent: bool,
    #[serde(default)]
    lang: String,
    #[serde(default)]
    page: String,
    #[serde(flatten)]
    given: GivenAnswers,
}

async fn act_on_form(
    State(state): State<AppState>,
    Path(token): Path<String>,
    OpenForm(form): OpenForm<SurveyAnswerForm>,
) -> Result<FormAnswer<Response>, PageError> {
    let mut answering = answering::open(&state, &token).await?;
    match form.step.as_str() {
        "begin" => begin_answers(&state, answering, &token, form.consent, &form.lang).await,
        "discard" => {
            answering.discard(&state).await?;
            Ok(FormAnswer::Answered(show_end(&answering, &token, SurveyEnd::Discarded)))
        }
        "withdraw" => {
            answering.withdraw(&state).await?;
            Ok(FormAnswer::lead_to(&format!("/survey/{token}")))
        }
        step @ ("save" | "next" | "back" | "send") => {
            if answering.response.state != ResponseState::Begun {
                return Err(
                    Error::Conflict(tr!("these answers were not started or were already sent").to_owned()).into()
                );
            }
            let page = form.page.parse().unwrap_or(0);
            let refused = answering.read_page(page, &form.given);
            if !refused.is_empty() {
                let language = &answering.response.language;
                let refusals = speak_language(language, || Refusals::new(&answering.instrument, &form.given, &refused));
                return Ok(FormAnswer::Refused(show_form(&answering, &token, Some(page), &refusals)));
            }
            go_to_page(&state, answering, &token, step, page).await
        }
        other => Err(Error::BadRequest(format!(
            "do: \"{other}\"; allowed: begin, save, next, back, send, discard, withdraw"
        ))
        .into()),
    }
}

async fn begin_answers(
    state: &AppState,
    mut answering: Answering,
    token: &str,
    agreed: bool,
    language: &str,
) -> Result<FormAnswer<Response>, PageError> {
    if !agreed {
        let shown = ConsentShown { wanted: language, refused: true };
        return Ok(FormAnswer::Refused(show_consent(state, &answering, token, shown).await?));
    }
    answering.response.language = answering.instrument.language_for(language).to_owned();
    answering.save(state).await?;
    Ok(FormAnswer::lead_to(&format!("/survey/{token}")))
}

/// Saves the answers, and opens the page of the pressed button.
async fn go_to_page(
    state: &AppState,
    mut answering: Answering,
    token: &str,
    step: &str,
    page: usize,
) -> Result<FormAnswer<Response>, PageError> {
    if step == "send" {
        answering.send(state).await?;
        return Ok(FormAnswer::lead_to(&format!("/survey/{token}")));
    }
    answering.save(state).await?;
    let asked = answering.asked_pages();
    let next = match step {
        "save" => return Ok(FormAnswer::Answered(StatusCode::NO_CONTENT.into_response())),
        "next" => asked.iter().find(|at| **at > page),
        _ => asked.iter().rev().find(|at| **at < page),
    };
    Ok(FormAnswer::lead_to(&format!("/survey/{token}?page={}", next.copied().unwrap_or(page))))
}

#[cfg(test)]
mod tests {
    //! Fails when an answer with several choices loses one during parsing, or a single choice is
    //! not accepted.

    use axum::body::Body;
    use axum::extract::{FromRequest, Request};
    use axum::http::header::CONTENT_TYPE;
    use documents::Instrument;

    use super::*;

    const INSTRUMENT: &str = r#"
id = "habits"
title = { en = "Habits" }
languages = ["en"]
duration_min = 1
source = "Made up"
licence = "None"

[[scale]]
id = "places"
kind = "choices"

[[scale.option]]
id = "home"
text = { en = "At home" }

[[scale.option]]
id = "ward"
text = { en = "On the ward" }

[[item]]
id = "one"
text = { en = "Where?" }
scale = "places"

[[item]]
id = "several"
text = { en = "Where else?" }
scale = "places"

[[item]]
id = "none"
text = { en = "Nowhere?" }
scale = "places"
"#;

    #[tokio::test]
    async fn a_question_brings_as_many_answers_as_were_ticked() {
        let body = "do=send&page=2&q.one=ward&q.several=ward&lang=en&q.several=at+home";
        let request = Request::post("/").header(CONTENT_TYPE, "application/x-www-form-urlencoded");
        let request = request.body(Body::from(body)).unwrap();
        let OpenForm(form) = OpenForm::<SurveyAnswerForm>::from_request(request, &()).await.unwrap();
        assert_eq!((form.step.as_str(), form.page.as_str(), form.consent), ("send", "2", false));
        let instrument = Instrument::from_bytes("habits.toml", INSTRUMENT.as_bytes()).unwrap();
        let given: Vec<Vec<&str>> = instrument.items.iter().map(|item| form.given.texts_for(item)).collect();
        assert_eq!(given, [vec!["ward"], vec!["ward", "at home"], vec![]]);
    }
}
