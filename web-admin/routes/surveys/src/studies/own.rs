//! `/account/studies`: a member accepts or declines invitations to studies, and leaves studies.

use acts::error::Error;
use acts::privacy::study_consents::revision_of_terms;
use acts::studies as acting;
use axum::extract::State;
use axum::response::Redirect;
use model::ids::StudyId;
use pages::studies::{OwnStudiesPage, OwnStudyCard};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfForm, NoFields, Visitor};
use routes_base::error::PageError;
use serde::Deserialize;
use store::studies::{self, Study};

use super::terms_of_study;

pub(super) async fn list_own_studies(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    csrf: Csrf,
) -> Result<OwnStudiesPage, PageError> {
    let reader = state.db.reader();
    let asked = studies::list_study_requests(reader, (&person).into()).await.map_err(Error::from)?;
    let joined = studies::list_joined_studies(reader, (&person).into()).await.map_err(Error::from)?;
    Ok(OwnStudiesPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Account),
        asked: asked.iter().map(make_card).collect(),
        joined: joined.iter().map(make_card).collect(),
    })
}

fn make_card(study: &Study) -> OwnStudyCard {
    OwnStudyCard {
        href: format!("/account/studies/{}", study.id),
        title: study.title.clone(),
        owner: study.owner.clone(),
        attempts: study.attempts,
        consent: study.consent.clone(),
        terms: terms_of_study(study),
        revision: revision_of_terms(study),
    }
}

#[derive(Deserialize)]
pub(super) struct JoinForm {
    terms: String,
}

pub(super) async fn join_study(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<StudyId>,
    CsrfForm(form): CsrfForm<JoinForm>,
) -> Result<Redirect, PageError> {
    acting::join_study(&state, &person, id, &form.terms).await?;
    Ok(Redirect::to("/account/studies"))
}

pub(super) async fn leave_study(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<StudyId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    acting::leave_study(&state, &person, id).await?;
    Ok(Redirect::to("/account/studies"))
}
