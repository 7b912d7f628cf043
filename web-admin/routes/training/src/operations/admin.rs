//! The administrator's pages.

use acts::error::Error;
use acts::stations as pairing;
use axum::extract::State;
use axum::response::Redirect;
use model::ids::{SchoolId, StationId};
use model::{CurrentPerson, Moment};
use pages::operations::admin::{AdminHomePage, AdminPage, PairingCodePage, Queue, StationRow};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::{PathId, own_address};
use routes_base::auth::{Administrator, Csrf, CsrfForm, NoFields, PageHead};
use routes_base::error::PageError;
use store::operations::schools;
use store::privacy::retention;
use store::stations::{self, Station};
use store::training::reports::SchoolCounts;
use store::training::{cohorts as cohort_storage, reports};

use crate::training::{cohorts, news};

/// Number of cohorts on the home page; the others are on a page of their own.
const FEW: usize = 10;
/// Period that counts as recent, in s.
const WEEK_S: i64 = 7 * 24 * 3600;

/// Builds the administrator's home page.
pub(super) async fn make_admin_home(
    state: &AppState,
    shell: Shell,
    person: &CurrentPerson,
) -> Result<AdminHomePage, Error> {
    let counts = count_people(state, person.school_id).await?;
    let (cohorts, more) = cohorts::list_cohorts_in_short(state, person, "", FEW).await?;
    let time_zone = schools::find_time_zone(state.db.reader(), person.school_id).await?;
    Ok(AdminHomePage {
        shell,
        clock_open: time_zone == "UTC" && counts.attempts == 0,
        news: news::list_news(state, person).await?,
        queue: queue_figures(state, person.school_id, &counts).await?,
        counts: vec![
            (counts.trainees, tr!("trainees")),
            (counts.instructors, tr!("instructors")),
            (counts.attempts, tr!("scored attempts")),
            (counts.recent, tr!("attempts in the last 7 days")),
        ],
        school: counts.school,
        cohorts,
        more: more.is_some(),
    })
}

pub(super) async fn show_administration(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
) -> Result<AdminPage, PageError> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let counts = count_people(&state, school).await?;
    Ok(AdminPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Administration),
        queue: queue_figures(&state, school, &counts).await?,
        school: counts.school,
        requests: cohort_storage::list_membership_requests(reader, school, None, None).await?,
        stations: stations::list_stations(reader, school).await?.into_iter().map(make_station_row).collect(),
        warned: retention::count_warned(reader, school).await?,
    })
}

/// Creates a pairing code and renders it directly: with a redirect it would have to be stored until
/// it is shown.
pub(super) async fn make_pairing_code(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    head: PageHead,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<PairingCodePage, PageError> {
    let (code, expires_at) = pairing::make_pairing_code(&state, &person).await?;
    Ok(PairingCodePage {
        shell: Shell::new(&person, head.csrf.token(), NavPlace::Administration),
        code,
        expires_at: expires_at.to_utc(),
        minutes: pairing::PAIRING_CODE_LIFETIME_S / 60,
        address: own_address(&state, &head.headers),
    })
}

/// Revokes a station's token.
pub(super) async fn revoke_station(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    PathId(station): PathId<StationId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    match pairing::revoke(&state, &person, station).await? {
        true => Ok(Redirect::to("/admin#stations")),
        false => Err(Error::NotFound.into()),
    }
}

pub(super) async fn count_people(state: &AppState, school: SchoolId) -> Result<SchoolCounts, Error> {
    let since: Moment = state.clock.now().plus_s(-WEEK_S);
    Ok(reports::counts(state.db.reader(), school, since).await?)
}

async fn queue_figures(state: &AppState, school: SchoolId, counts: &SchoolCounts) -> Result<Queue, Error> {
    let failing = reports::failing_jobs(state.db.reader(), school).await?;
    let row = |job: reports::FailingJob| (format!("/sessions/{}", job.session_id), job.attempts, job.error);
    Ok(Queue {
        waiting: counts.waiting,
        failing: failing.into_iter().map(row).collect(),
        refused: counts.refused,
        flagged: counts.flagged,
    })
}

fn make_station_row(station: Station) -> StationRow {
    StationRow {
        revoke_href: (!station.revoked).then(|| format!("/admin/stations/{}/revoke", station.id)),
        name: station.station,
        signs: station.signs,
        since: station.created_at.to_utc(),
        seen: station.last_seen_at.map(Moment::to_utc),
    }
}
