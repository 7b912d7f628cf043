//! Badges of mastered courses, as files.

use acts::training::badges;
use askama::Template;
use axum::extract::{Path, State};
use axum::response::Response;
use model::PersonKey;
use model::ids::SchoolId;
use model::training::badge::write_baked;
use pages::training::badge::BadgePicture;
use routes_base::AppState;
use routes_base::auth::Visitor;
use routes_base::error::PageError;
use routes_base::export::attach_file;
use store::training::badges::BadgeGround;

use super::certificate::{CertifiedTrainee, find_earned, find_language};

/// Returns the badge as JSON.
pub(super) async fn export_badge(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    Path((id, course)): Path<(String, String)>,
) -> Result<Response, PageError> {
    let certified = find_earned(&state, &person, &id, &course).await?;
    let ground = ground_of(&certified, person.school_id);
    let badge = badges::sign_badge(&state, &person, ground, &certified.earned.statement).await?;
    let file = format!("badge-{}.json", certified.curriculum.curriculum_id);
    Ok(attach_file("application/vc", &file, badge.to_string()))
}

/// Returns the badge as a picture that contains it.
pub(super) async fn draw_badge(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    Path((id, course)): Path<(String, String)>,
) -> Result<Response, PageError> {
    let certified = find_earned(&state, &person, &id, &course).await?;
    let ground = ground_of(&certified, person.school_id);
    let badge = badges::sign_badge(&state, &person, ground, &certified.earned.statement).await?;
    let CertifiedTrainee { trainee, curriculum, earned } = certified;
    let language = find_language(&state, PersonKey { school_id: person.school_id, person_id: trainee.id }).await?;
    let last = earned.mastered.iter().map(|(_, at)| *at).max();
    let picture = BadgePicture {
        school: &earned.statement.school,
        course: &earned.statement.course,
        mastered_at: last.unwrap_or_else(|| state.clock.now().to_utc()),
        baked: write_baked(&badge),
    };
    let svg = words::within(language, || picture.render()).map_err(anyhow::Error::from)?;
    Ok(attach_file("image/svg+xml", &format!("badge-{}.svg", curriculum.curriculum_id), svg))
}

/// Returns the mastery that a badge certifies.
fn ground_of(certified: &CertifiedTrainee, school_id: SchoolId) -> BadgeGround<'_> {
    let CertifiedTrainee { trainee, earned, .. } = certified;
    BadgeGround {
        person: PersonKey { school_id, person_id: trainee.id },
        curriculum_id: &earned.statement.curriculum_id,
        curriculum_sha256: &earned.statement.curriculum_sha256,
        needed: earned.needed,
    }
}
