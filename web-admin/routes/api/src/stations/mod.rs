//! Training stations: pairing with a school by a code, and signing in trainees by theirs.

use acts::auth::rate_limits;
use acts::privacy::study_consents::revision_of_terms;
use acts::stations::{self, StationVisit, TypedCode};
use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use model::Role;
use model::ids::StationId;
use routes_base::AppState;
use routes_base::auth::ClientAddress;
use routes_base::error::{ApiError, ProblemDocument};
use serde::{Deserialize, Serialize};
use store::operations::schools;
use store::people::Person;
use store::studies::Study;
use utoipa::ToSchema;

use crate::caller::Caller;
use crate::surveys::StationSurvey;
use crate::training::documents;
use crate::training::documents::ListedExercise;
use crate::{ApiJson, surveys};

/// A station that requests to join.
#[derive(Deserialize, ToSchema)]
pub(crate) struct PairRequest {
    /// The code from the administrator's page; case, spaces and hyphens are ignored.
    code: String,
    /// Name of the station at its school, 1 to 60 characters.
    name: String,
    /// The station's Ed25519 public key, 64 hexadecimal digits, which verifies the recordings that
    /// the station signs. Without it, no recording is proved to come from the station.
    #[schema(nullable = false)]
    public_key: Option<String>,
}

/// A station that has joined.
#[derive(Serialize, ToSchema)]
pub(crate) struct PairedView {
    #[schema(value_type = Uuid)]
    station_id: StationId,
    name: String,
    /// The school's name.
    school: String,
    /// The bearer token, shown only once.
    token: String,
}

/// Joins a station to a school. The code is valid once, for ten minutes.
#[utoipa::path(post, path = "/stations/pair", tag = "stations", operation_id = "pair_station", request_body = PairRequest, security(()),
    responses((status = 201, body = PairedView), (status = 400, body = ProblemDocument),
              (status = 403, body = ProblemDocument, description = "The code is unknown, used or expired"),
              (status = 409, body = ProblemDocument, description = "Another station of the school has this name"),
              (status = 422, body = ProblemDocument), (status = 429, body = ProblemDocument)))]
pub(crate) async fn pair_station(
    State(state): State<AppState>,
    ClientAddress(address): ClientAddress,
    ApiJson(asked): ApiJson<PairRequest>,
) -> Result<(StatusCode, Json<PairedView>), ApiError> {
    rate_limits::take_pairing(&state, address).await?;
    let stations::Paired { station_id, name, school, token } =
        stations::pair(&state, &asked.code, &asked.name, asked.public_key.as_deref()).await?;
    Ok((StatusCode::CREATED, Json(PairedView { station_id, name, school, token })))
}

/// The calling station.
#[derive(Serialize, ToSchema)]
pub(crate) struct StationView {
    #[schema(value_type = Uuid)]
    station_id: StationId,
    name: String,
    /// The school's name.
    school: String,
}

/// Returns the calling station: whether its token is still valid, and for which school.
#[utoipa::path(get, path = "/stations/me", tag = "stations", operation_id = "show_station",
    responses((status = 200, body = StationView), (status = 401, body = ProblemDocument), (status = 403, body = ProblemDocument)))]
pub(crate) async fn show_station(State(state): State<AppState>, caller: Caller) -> Result<Json<StationView>, ApiError> {
    let station = caller.station()?;
    let school = schools::find_school_name(state.db.reader(), station.school_id).await?;
    Ok(Json(StationView { station_id: station.id, name: station.name.clone(), school }))
}

/// A request to sign in at a station.
#[derive(Deserialize, ToSchema)]
pub(crate) struct SignInRequest {
    /// The code from the person's own page, or a guest's code of a study; case, spaces and hyphens
    /// are ignored.
    #[serde(alias = "pin")]
    code: String,
    /// The `revision` of the terms that a guest has read at the station and agreed to.
    #[schema(nullable = false)]
    consent: Option<String>,
}

/// The person signed in at the station.
#[derive(Serialize, ToSchema)]
pub(crate) struct SignedInView {
    /// The pseudonym that recordings contain as `trainee`.
    trainee: String,
    /// For the station's screen; never for a recording.
    display_name: String,
    /// Code of the language that they have chosen at their school.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    language: Option<String>,
    /// Whether they are a guest of a study: `exercises` are those of the study, and no others may
    /// be practised.
    guest: bool,
    /// The exercises to train, those due first.
    exercises: Vec<ListedExercise>,
    /// Surveys that may be asked after an attempt.
    surveys: Vec<StationSurvey>,
}

/// The terms that a guest of a study must agree to before practising.
#[derive(Serialize, ToSchema)]
pub(crate) struct ConsentAskedView {
    /// Title of the study.
    study: String,
    /// The text that participants agree to, as written by the study's owner.
    consent: String,
    /// The controller of the data.
    controller: String,
    /// The contact person.
    contact: String,
    /// Retention of the data after the study has ended, in months.
    kept_months: u32,
    /// Revision to be sent as `consent` with the code to agree: the SHA-256 of all these terms.
    revision: String,
}

impl From<&Study> for ConsentAskedView {
    fn from(study: &Study) -> Self {
        Self {
            study: study.title.clone(),
            consent: study.consent.clone(),
            controller: study.controller.clone(),
            contact: study.contact.clone(),
            kept_months: study.kept_months,
            revision: revision_of_terms(study),
        }
    }
}

/// Signs in a person of the station's school, or a guest of a study, whose code is valid once. A
/// guest is first asked for consent: until they agree, nothing is stored about them and their code
/// remains valid. After 20 wrong codes in an hour the station is locked for the rest of the hour.
#[utoipa::path(post, path = "/stations/sign-in", tag = "stations", operation_id = "sign_in_at_station", request_body = SignInRequest,
    responses((status = 200, body = SignedInView),
              (status = 202, body = ConsentAskedView, description = "A guest must agree first: nobody is signed in yet"),
              (status = 401, body = ProblemDocument),
              (status = 403, body = ProblemDocument, description = "An unknown code, a code of a study that has ended, or not a station's token"),
              (status = 429, body = ProblemDocument)))]
pub(crate) async fn sign_in_at_station(
    State(state): State<AppState>,
    caller: Caller,
    ApiJson(asked): ApiJson<SignInRequest>,
) -> Result<Response, ApiError> {
    let typed = TypedCode { code: &asked.code, agreed: asked.consent.as_deref() };
    let person = match stations::sign_in(&state, caller.station()?, typed).await? {
        StationVisit::SignedIn(person) => *person,
        StationVisit::ConsentAsked(study) => {
            return Ok((StatusCode::ACCEPTED, Json(ConsentAskedView::from(&*study))).into_response());
        }
    };
    let guest = person.role == Role::Guest;
    let exercises = if guest {
        documents::studied_exercises(&state, person.school_id, person.id).await?
    } else {
        documents::listed_exercises(&state, person.school_id, Some(person.id)).await?
    };
    let surveys = surveys::surveys_at_station(&state, person.school_id, person.id).await?;
    let Person { pseudonym: trainee, display_name, language, .. } = person;
    Ok(Json(SignedInView { trainee, display_name, language, guest, exercises, surveys }).into_response())
}
