//! What is asked after an attempt.

use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

use super::Id;
use super::caller::Caller;
use crate::AppState;
use crate::error::{ApiError, Error, Problem};
use crate::storage::sessions::{self, Session};
use crate::storage::surveys;
use crate::surveys::instrument_of;

/// The surveys that are asked after an attempt.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct SurveysAfter {
    /// None where nothing is asked, or everything was answered.
    surveys: Vec<SurveyAfter>,
}

/// A survey that is asked after an attempt.
#[derive(Debug, Serialize, ToSchema)]
struct SurveyAfter {
    survey_id: Uuid,
    title: String,
    /// How long it takes, in min.
    duration_min: f64,
    /// Where the trainee answers it, signed in: a path of this service.
    path: String,
}

/// What the trainee of an attempt is asked after it, and has not answered. A station may ask, too, for its debriefing.
#[utoipa::path(get, path = "/sessions/{id}/survey", params(("id" = Uuid, Path)),
    responses((status = 200, body = SurveysAfter), (status = 404, body = Problem)))]
pub(super) async fn after(
    State(state): State<AppState>,
    caller: Caller,
    Id(id): Id,
) -> Result<Json<SurveysAfter>, ApiError> {
    let reader = state.db.reader();
    let session = sessions::find(reader, caller.school_id(), id).await?;
    let session = session.filter(|session| may_ask(&caller, session)).ok_or(Error::NotFound)?;
    let mut asked = Vec::new();
    for survey in surveys::after_attempt(reader, &session, state.clock.now()).await? {
        if !surveys::answered(reader, &survey, session.trainee_id, Some(id)).await? {
            asked.push(SurveyAfter {
                survey_id: survey.id,
                duration_min: instrument_of(&state, &survey).await?.duration_min,
                path: format!("/surveys/{}?session={id}", survey.id),
                title: survey.title,
            });
        }
    }
    Ok(Json(SurveysAfter { surveys: asked }))
}

/// The trainee themselves, or a station of their school: it learns only what is asked.
fn may_ask(caller: &Caller, session: &Session) -> bool {
    caller.person().map_or(true, |person| person.id == session.trainee_id)
}
