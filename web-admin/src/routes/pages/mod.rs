//! Pages: HTML for the signed-in person.

use acts::error::Error;
use axum::extract::{DefaultBodyLimit, FromRequestParts, Path};
use axum::http::request::Parts;
use axum::routing::{get, post};
use documents::ExerciseBundle;
use model::ids::{RevisionId, SchoolId};
use percent_encoding::{NON_ALPHANUMERIC, PercentEncode, utf8_percent_encode};
use serde::de::DeserializeOwned;
use store::exercises;

use crate::AppState;
use crate::error::PageError;
use crate::routes::Routes;

mod account;
mod admin;
mod assets;
mod assignments;
mod audit;
mod backups;
mod cohort_people;
mod cohorts;
pub(crate) mod consents;
mod draft_pictures;
mod drafts;
mod erasing;
mod exercise;
mod gradebook;
mod home;
mod instrument_drafts;
mod links;
mod logo;
mod news;
mod origins;
mod others;
mod passkeys;
mod people;
mod people_bulk;
pub(crate) mod pictures;
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
mod settings;
mod sign_in_code;
mod standing;
mod studies;
mod supervision;
mod surveys;
mod tokens;
mod trainees;
mod transcript;
mod writing;

/// Pages for whoever is signed in; the layer around them has settled who that is.
#[must_use]
pub fn page_routes() -> Routes {
    progress::progress_routes()
        .route("/", get(home::show_home))
        .route("/curricula", get(exercise::show_curricula))
        .route("/curricula/{id}/draft", post(drafts::draft_course))
        .route("/curricula/{id}/revisions", get(revisions::compare_course_revisions))
        .route("/drafts", get(drafts::list_drafts).post(drafts::begin_draft))
        .route("/drafts/{id}", get(drafts::show_draft).post(drafts::write_draft))
        .route("/drafts/{id}/discard", post(drafts::discard_draft))
        .route("/drafts/{id}/preview", post(drafts::preview_draft))
        .route("/drafts/{id}/questions", get(instrument_drafts::show_questions))
        .merge(draft_pictures::draft_picture_routes())
        .route("/exercises/{id}", get(exercise::show_exercise))
        .route("/exercises/{id}/pictures/{number}", get(pictures::serve_exercise_picture))
        .route("/exercises/{id}/course", post(drafts::add_to_course))
        .route("/exercises/{id}/draft", post(drafts::draft_exercise))
        .route("/exercises/{id}/revisions", get(revisions::compare_exercise_revisions))
        .route("/cohorts", get(cohorts::list_cohorts).post(cohort_people::make_cohort))
        .route("/cohorts/{id}", get(cohorts::show_cohort))
        .route("/cohorts/{id}/gradebook", get(gradebook::show_gradebook))
        .route("/cohorts/{id}/gradebook.csv", get(gradebook::download_gradebook))
        .route("/cohorts/{id}/people", get(cohort_people::show_cohort_people).post(cohort_people::add_to_cohort))
        .route("/cohorts/{id}/people/{person}/answer", post(cohort_people::answer_request))
        .route("/cohorts/{id}/people/{person}/remove", post(cohort_people::remove_from_cohort))
        .route("/trainees/{id}", get(trainees::show_trainee))
        .route("/trainees/{id}/transcript", get(transcript::show_transcript))
        .route("/sessions/{id}", get(sessions::show_session))
        .route("/sessions/{id}/replay", get(replay::show_replay))
        .route("/sessions/{id}/comments", post(replay::add_comment))
        .route("/sessions/{id}/comments/{comment}/answers", post(replay::answer_comment))
        .route("/sessions/{id}/comments/{comment}/withdraw", post(replay::withdraw_comment))
        .route("/expert-consent", post(replay::change_own_consent))
        .route("/sessions/{id}/links", post(links::make_link))
        .route("/sessions/{id}/grade", get(review::show_grade))
        .route("/sessions/{id}/override", post(review::put_override))
        .route("/sessions/{id}/override/withdraw", post(review::withdraw_override))
        .route("/sessions/{id}/review", post(review::mark_reviewed))
        .route("/sessions/{id}/supervision", post(supervision::confirm_supervision))
        .route("/sessions/{id}/regrade", get(review::preview_regrade).post(review::regrade_attempt))
        .route("/review", get(review::show_queue))
        .route("/sign-in-code", get(sign_in_code::show_sign_in_code).post(sign_in_code::make_sign_in_code))
        .merge(surveys::survey_routes())
        .merge(studies::study_routes())
        .merge(ratings::rating_routes())
        .merge(consents::consent_routes())
        .merge(segments::segment_routes())
        .merge(regrading::regrading_routes())
        .route("/news/read", post(news::mark_all_read))
        .route("/account", get(account::show_account))
        .route("/account/news", post(news::choose_letters))
        .route("/account/cohorts/{cohort}", post(cohort_people::answer_own_request))
        .route("/account/password", post(account::set_own_password))
        .route("/account/language", post(account::set_own_language))
        .route("/account/export", get(account::export_own_data))
        .merge(second_factor::second_factor_routes())
        .merge(passkeys::passkey_routes())
        .merge(tokens::token_routes())
        .merge(people_routes())
        .merge(admin_routes())
        .route("/assignments", get(assignments::list_assignments).post(assignments::make_assignment))
        .route("/assignments/{id}", get(assignments::show_assignment))
        .route("/assignments/{id}/extend", post(assignments::extend_assignment))
        .route("/assignments/{id}/withdraw", post(assignments::withdraw_assignment))
}

/// What an administrator looks after.
fn admin_routes() -> Routes {
    Routes::new()
        .route("/admin/certificate-needs", post(settings::set_certificate_needs))
        .route("/admin", get(admin::show_administration))
        .route("/admin/origins", get(origins::show_origins).post(origins::set_origins))
        .route("/admin/settings", get(settings::show_settings).post(settings::put_settings))
        .route("/school/logo", get(logo::serve_logo))
        .route("/admin/settings/logo", post(logo::put_logo).layer(DefaultBodyLimit::max(2 * logo::MOST_LOGO_BYTES)))
        .route("/admin/settings/logo/remove", post(logo::remove_logo))
        .route("/admin/settings/test-letter", post(settings::send_test_letter))
        .route("/admin/audit", get(audit::show_audit_log))
        .route("/admin/audit.csv", get(audit::download_audit_log))
        .route("/admin/backups", get(backups::show_backups))
        .route("/admin/service", get(service::show_service_log))
        .route("/admin/retention", get(retention::show_retention).post(retention::set_retention))
        .route("/admin/pairing-codes", post(admin::make_pairing_code))
        .route("/admin/stations/{id}/revoke", post(admin::revoke_station))
}

/// Recordings that somebody has made an address for: for whoever has it.
#[must_use]
pub fn linked_routes() -> Routes {
    Routes::new().route("/recordings/{token}/{file}", get(links::open_link).options(links::open_link))
}

/// The people of a school.
fn people_routes() -> Routes {
    Routes::new()
        .route("/people", get(people::list_people).post(people::add_person))
        .route(
            "/people/roster",
            get(roster::show_new_roster).post(roster::send_roster).layer(DefaultBodyLimit::max(roster::MAX_BYTES)),
        )
        .route("/people/rosters/{id}", get(roster::show_roster).post(roster::confirm_roster))
        .route("/people/rosters/{id}/columns", get(roster::show_roster_columns).post(roster::assign_roster_columns))
        .route("/people/bulk", post(people_bulk::show_bulk_act))
        .route("/people/bulk/do", post(people_bulk::do_bulk_act))
        .route("/people/{id}", get(people::show_person))
        .route("/people/{id}/change", post(people::change_person))
        .route("/people/{id}/mail-link", post(people::mail_link))
        .route("/people/{id}/link", post(people::show_link))
        .route("/people/{id}/disable", post(people::disable_person))
        .route("/people/{id}/enable", post(people::enable_person))
        .route("/people/{id}/hold", post(retention::hold_person))
        .route("/people/{id}/erase", get(erasing::show_erasing).post(erasing::erase_person))
}

/// Style sheets and scripts: for anybody.
#[must_use]
pub fn asset_routes() -> Routes {
    Routes::new().route("/assets/{file}", get(assets::serve_asset))
}

/// A revision as it was published. Publishing has checked it, so a refusal now is our fault.
async fn published_bundle(
    state: &AppState,
    school: SchoolId,
    revision: RevisionId,
) -> Result<Option<ExerciseBundle>, Error> {
    let Some(bytes) = exercises::read_exercise_bytes(state.db.reader(), school, revision).await? else {
        return Ok(None);
    };
    let parsed = ExerciseBundle::from_parts(&bytes.exercise, &bytes.scene, &bytes.meshes);
    Ok(Some(parsed.map_err(|refused| anyhow::Error::new(refused).context("a published exercise is refused"))?))
}

/// A text as a part of an address: nothing in it ends its place.
fn encode_in_query(text: &str) -> PercentEncode<'_> {
    utf8_percent_encode(text, NON_ALPHANUMERIC)
}

/// A text as it was written: a browser sends each end of a line as CR LF.
fn unix_lines(text: &str) -> String {
    text.replace("\r\n", "\n")
}

/// The id in an address. What is no id names nothing: 404, as an id that nobody has.
struct PathId<T>(T);

impl<T: DeserializeOwned + Send, S: Send + Sync> FromRequestParts<S> for PathId<T> {
    type Rejection = PageError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Self::Rejection> {
        let path = Path::<T>::from_request_parts(parts, state).await;
        path.map(|Path(id)| Self(id)).map_err(|_| PageError(Error::NotFound))
    }
}
