//! Pages: HTML for the signed-in person.

use axum::extract::{DefaultBodyLimit, FromRequestParts, Path};
use axum::http::request::Parts;
use axum::routing::{get, post};
use documents::ExerciseBundle;
use percent_encoding::{NON_ALPHANUMERIC, PercentEncode, utf8_percent_encode};
use uuid::Uuid;

use crate::AppState;
use crate::error::PageError;
use crate::routes::Routes;
use acts::error::Error;
use store::exercises;

mod account;
mod admin;
mod assets;
mod assignments;
mod cohort_people;
mod cohorts;
pub(crate) mod consents;
mod drafts;
mod erasing;
mod exercise;
mod home;
mod links;
mod origins;
mod passkeys;
mod people;
mod progress;
mod ratings;
mod regrading;
pub(crate) mod replay;
mod retention;
pub(crate) mod review;
mod revisions;
mod roster;
mod rows;
mod second_factor;
mod segments;
mod service;
mod sessions;
mod standing;
mod supervision;
mod surveys;
mod tokens;
mod trainees;

/// Pages for whoever is signed in; the layer around them has settled who that is.
#[must_use]
pub fn router() -> Routes {
    progress::router()
        .route("/", get(home::show))
        .route("/curricula", get(exercise::curricula))
        .route("/curricula/{id}/draft", post(drafts::of_course))
        .route("/curricula/{id}/revisions", get(revisions::of_course))
        .route("/drafts", get(drafts::list).post(drafts::copy))
        .route("/drafts/{id}", get(drafts::show).post(drafts::write))
        .route("/drafts/{id}/discard", post(drafts::discard))
        .route("/drafts/{id}/preview", post(drafts::preview))
        .route("/exercises/{id}", get(exercise::show))
        .route("/exercises/{id}/draft", post(drafts::of_exercise))
        .route("/exercises/{id}/revisions", get(revisions::of_exercise))
        .route("/cohorts", get(cohorts::list).post(cohort_people::make))
        .route("/cohorts/{id}", get(cohorts::show))
        .route("/cohorts/{id}/people", get(cohort_people::show).post(cohort_people::add))
        .route("/cohorts/{id}/people/{person}/answer", post(cohort_people::answer))
        .route("/cohorts/{id}/people/{person}/remove", post(cohort_people::remove))
        .route("/trainees/{id}", get(trainees::show))
        .route("/sessions/{id}", get(sessions::show))
        .route("/sessions/{id}/replay", get(replay::show))
        .route("/sessions/{id}/comments", post(replay::comment))
        .route("/sessions/{id}/comments/{comment}/answers", post(replay::answer))
        .route("/sessions/{id}/comments/{comment}/withdraw", post(replay::withdraw))
        .route("/expert-consent", post(replay::consent))
        .route("/sessions/{id}/links", post(links::make))
        .route("/sessions/{id}/grade", get(review::grade))
        .route("/sessions/{id}/override", post(review::put_override))
        .route("/sessions/{id}/override/withdraw", post(review::withdraw_override))
        .route("/sessions/{id}/review", post(review::mark))
        .route("/sessions/{id}/supervision", post(supervision::confirm))
        .route("/sessions/{id}/regrade", get(review::preview).post(review::regrade))
        .route("/review", get(review::queue))
        .route("/sign-in-code", post(trainees::make_sign_in_code))
        .merge(surveys::router())
        .merge(ratings::router())
        .merge(consents::router())
        .merge(segments::router())
        .merge(regrading::router())
        .route("/account", get(account::show))
        .route("/account/cohorts/{cohort}", post(cohort_people::answer_for_oneself))
        .route("/account/password", post(account::set_password))
        .route("/account/language", post(account::set_language))
        .route("/account/export", get(account::export))
        .merge(second_factor::router())
        .merge(passkeys::router())
        .merge(tokens::router())
        .merge(people())
        .route("/assignments", get(assignments::list).post(assignments::make))
        .route("/admin/certificate-needs", post(admin::set_needed))
        .route("/assignments/time-zone", post(assignments::set_zone))
        .route("/assignments/{id}", get(assignments::show))
        .route("/assignments/{id}/extend", post(assignments::extend))
        .route("/assignments/{id}/withdraw", post(assignments::withdraw))
        .route("/admin", get(admin::show))
        .route("/admin/origins", get(origins::show).post(origins::set))
        .route("/admin/service", get(service::show))
        .route("/admin/retention", get(retention::show).post(retention::set))
        .route("/admin/pairing-codes", post(admin::make_pairing_code))
        .route("/admin/stations/{id}/revoke", post(admin::revoke_station))
}

/// Recordings that somebody has made an address for: for whoever has it.
#[must_use]
pub fn linked() -> Routes {
    Routes::new().route("/recordings/{token}/{file}", get(links::open).options(links::open))
}

/// The people of a school.
fn people() -> Routes {
    Routes::new()
        .route("/people", get(people::list).post(people::add))
        .route("/people/roster", get(roster::new).post(roster::send).layer(DefaultBodyLimit::max(roster::MAX_BYTES)))
        .route("/people/rosters/{id}", get(roster::show).post(roster::confirm))
        .route("/people/{id}", get(people::show))
        .route("/people/{id}/change", post(people::change))
        .route("/people/{id}/mail-link", post(people::mail_link))
        .route("/people/{id}/link", post(people::link))
        .route("/people/{id}/disable", post(people::disable))
        .route("/people/{id}/enable", post(people::enable))
        .route("/people/{id}/hold", post(retention::hold))
        .route("/people/{id}/erase", get(erasing::show).post(erasing::erase))
}

/// Style sheets and scripts: for anybody.
#[must_use]
pub fn assets() -> Routes {
    Routes::new().route("/assets/{file}", get(assets::serve))
}

/// A revision as it was published. Publishing has checked it, so a refusal now is our fault.
async fn published(state: &AppState, school: Uuid, revision: Uuid) -> Result<Option<ExerciseBundle>, Error> {
    let Some(bytes) = exercises::bytes(state.db.reader(), school, revision).await? else { return Ok(None) };
    let parsed = ExerciseBundle::from_parts(&bytes.exercise, &bytes.scene, &bytes.meshes);
    Ok(Some(parsed.map_err(|refused| anyhow::Error::new(refused).context("a published exercise is refused"))?))
}

/// A text as a part of an address: nothing in it ends its place.
fn in_query(text: &str) -> PercentEncode<'_> {
    utf8_percent_encode(text, NON_ALPHANUMERIC)
}

/// A text as it was written: a browser sends each end of a line as CR LF.
fn unix_lines(text: &str) -> String {
    text.replace("\r\n", "\n")
}

/// The id in an address. What is no id names nothing: 404, as an id that nobody has.
struct PathId(Uuid);

impl<S: Send + Sync> FromRequestParts<S> for PathId {
    type Rejection = PageError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Self::Rejection> {
        let path = Path::<Uuid>::from_request_parts(parts, state).await;
        path.map(|Path(id)| Self(id)).map_err(|_| PageError(Error::NotFound))
    }
}
