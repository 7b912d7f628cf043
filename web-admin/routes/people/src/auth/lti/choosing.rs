//! `/lti/deep-link`: a teacher chooses content for a course of a learning platform.

use std::collections::BTreeSet;

use acts::auth::lti::deep_linking;
use acts::auth::lti::deep_linking::{OpenChoice, SignedChoice};
use acts::error::Error;
use axum::extract::State;
use axum::http::header::CONTENT_SECURITY_POLICY;
use axum::response::{IntoResponse, Response};
use model::ids::ContentChoiceId;
use pages::auth::deep_linking::{ChooseContentPage, LinkContentPage};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfForm, Teacher, Visit};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use serde::Deserialize;

pub(super) async fn show_content(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
    PathId(id): PathId<ContentChoiceId>,
) -> Result<ChooseContentPage, PageError> {
    Ok(make_page(&state, Visit::new(&person, &csrf), id, None).await?)
}

async fn make_page(
    state: &AppState,
    visit: Visit<'_>,
    id: ContentChoiceId,
    refused: Option<String>,
) -> Result<ChooseContentPage, Error> {
    let OpenChoice { platform, choice, content } = deep_linking::find_choice(state, visit.person, id).await?;
    Ok(ChooseContentPage {
        shell: Shell::new(visit.person, visit.csrf.token(), NavPlace::Curricula),
        platform: platform.settings.name,
        href: format!("/lti/deep-link/{id}"),
        content,
        takes_several: choice.content.accepts_several,
        refused,
    })
}

#[derive(Deserialize)]
pub(super) struct ContentForm {
    #[serde(default)]
    content: Vec<String>,
}

pub(super) async fn choose_content(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
    PathId(id): PathId<ContentChoiceId>,
    CsrfForm(form): CsrfForm<ContentForm>,
) -> Result<FormAnswer<ChooseContentPage>, PageError> {
    let chosen: BTreeSet<String> = form.content.into_iter().collect();
    match split_refusal(deep_linking::choose_content(&state, &person, id, &chosen).await)? {
        Ok(signed) => Ok(FormAnswer::Answered(answer_signed(signed))),
        Err(why) => {
            let page = make_page(&state, Visit::new(&person, &csrf), id, Some(why)).await?;
            Ok(FormAnswer::Refused(page))
        }
    }
}

/// Shows the page whose form posts the response to the platform: the only one that may send a form
/// to another site.
fn answer_signed(signed: SignedChoice) -> Response {
    let SignedChoice { platform, return_url, return_origin, jwt, links } = signed;
    let policy = format!(
        "default-src 'none'; style-src 'self'; img-src 'self' data:; form-action {return_origin}; \
         frame-ancestors 'none'; base-uri 'none'"
    );
    ([(CONTENT_SECURITY_POLICY, policy)], LinkContentPage { platform, return_url, jwt, links }).into_response()
}
