//! `/admin/platforms`: the learning platforms of the school.

use acts::auth::federation::client_keys;
use acts::auth::lti::launches;
use acts::auth::lti::platforms as settling;
use acts::auth::lti::registration;
use acts::error::Error;
use axum::extract::State;
use axum::response::Redirect;
use model::CurrentPerson;
use model::ids::PlatformId;
use pages::auth::lti::{DeploymentRow, PlatformEntries, PlatformForm, PlatformPage, PlatformRow, PlatformsPage};
use pages::form::FilledForm;
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Administrator, Csrf, CsrfForm, NoFields, Visit};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use serde::Deserialize;
use store::auth::lti::platforms;
use store::auth::lti::platforms::{Deployment, Platform};

use super::courses;

pub(super) const PAGE: &str = "/admin/platforms";

fn list_entries(state: &AppState) -> PlatformEntries {
    PlatformEntries {
        login_url: launches::login_url(state),
        launch_url: launches::launch_url(state),
        keys_uri: client_keys::keys_uri(state),
        register_url: registration::register_url(state),
    }
}

pub(super) async fn show_platforms(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
) -> Result<PlatformsPage, PageError> {
    Ok(make_page(&state, Visit::new(&person, &csrf), FilledForm::default()).await?)
}

async fn make_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    form: FilledForm<PlatformForm>,
) -> Result<PlatformsPage, Error> {
    let reader = state.db.reader();
    let waiting = platforms::count_waiting_deployments(reader, person.school_id).await?;
    let row = |platform: Platform| PlatformRow {
        href: format!("{PAGE}/{}", platform.id),
        name: platform.settings.name,
        issuer: platform.settings.issuer,
        client_id: platform.settings.client_id,
        waiting: waiting
            .iter()
            .filter(|waiting| waiting.platform_id == platform.id)
            .map(|of| of.deployments as usize)
            .sum(),
        disabled: platform.disabled_at.is_some(),
    };
    Ok(PlatformsPage {
        shell: Shell::new(person, csrf.token(), NavPlace::Administration),
        rows: platforms::list_platforms(reader, person.school_id).await?.into_iter().map(row).collect(),
        form,
        entries: list_entries(state),
    })
}

pub(super) async fn add_platform(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfForm(fields): CsrfForm<PlatformForm>,
) -> Result<FormAnswer<PlatformsPage>, PageError> {
    let added = match fields.read() {
        Ok(settings) => split_refusal(settling::add_platform(&state, &person, &settings).await)?,
        Err(why) => Err(why),
    };
    match added {
        Ok(id) => Ok(FormAnswer::lead_to(&format!("{PAGE}/{id}"))),
        Err(why) => {
            let form = FilledForm::refused(fields, why);
            Ok(FormAnswer::Refused(make_page(&state, Visit::new(&person, &csrf), form).await?))
        }
    }
}

pub(super) async fn find(state: &AppState, person: &CurrentPerson, id: PlatformId) -> Result<Platform, Error> {
    platforms::find_platform(state.db.reader(), person.school_id, id).await?.ok_or(Error::NotFound)
}

pub(super) async fn make_platform_page(
    state: &AppState,
    visit: Visit<'_>,
    known: &Platform,
    form: FilledForm<PlatformForm>,
) -> Result<PlatformPage, Error> {
    let deployments = platforms::list_deployments(state.db.reader(), known.school_id, known.id).await?;
    let row = |deployment: Deployment| DeploymentRow {
        deployment: deployment.deployment_id,
        seen: deployment.first_seen_at.to_utc(),
        admitted: deployment.admitted_at.map(|at| at.to_utc()),
    };
    Ok(PlatformPage {
        shell: Shell::new(visit.person, visit.csrf.token(), NavPlace::Administration),
        title: known.settings.name.clone(),
        href: format!("{PAGE}/{}", known.id),
        form,
        deployments: deployments.into_iter().map(row).collect(),
        courses: courses::list_courses(state, visit.person, known.id).await?,
        course_refused: None,
        entries: list_entries(state),
    })
}

pub(super) async fn show_platform(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    PathId(id): PathId<PlatformId>,
) -> Result<PlatformPage, PageError> {
    let known = find(&state, &person, id).await?;
    let form = FilledForm::new(PlatformForm::from(&known.settings));
    Ok(make_platform_page(&state, Visit::new(&person, &csrf), &known, form).await?)
}

pub(super) async fn change_platform(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    PathId(id): PathId<PlatformId>,
    CsrfForm(fields): CsrfForm<PlatformForm>,
) -> Result<FormAnswer<PlatformPage>, PageError> {
    let known = find(&state, &person, id).await?;
    let changed = match fields.read() {
        Ok(settings) => split_refusal(settling::change_platform(&state, &person, id, &settings).await)?,
        Err(why) => Err(why),
    };
    match changed {
        Ok(()) => Ok(FormAnswer::lead_to(PAGE)),
        Err(why) => {
            let form = FilledForm::refused(fields, why);
            let page = make_platform_page(&state, Visit::new(&person, &csrf), &known, form).await?;
            Ok(FormAnswer::Refused(page))
        }
    }
}

#[derive(Deserialize)]
pub(super) struct AdmissionForm {
    deployment: String,
}

pub(super) async fn admit_deployment(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    PathId(id): PathId<PlatformId>,
    CsrfForm(form): CsrfForm<AdmissionForm>,
) -> Result<Redirect, PageError> {
    settling::admit_deployment(&state, &person, id, &form.deployment).await?;
    Ok(Redirect::to(&format!("{PAGE}/{id}")))
}

pub(super) async fn disable_platform(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    PathId(id): PathId<PlatformId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    settling::set_disabled(&state, &person, id, true).await?;
    Ok(Redirect::to(PAGE))
}

pub(super) async fn enable_platform(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    PathId(id): PathId<PlatformId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    settling::set_disabled(&state, &person, id, false).await?;
    Ok(Redirect::to(PAGE))
}
