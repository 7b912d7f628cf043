//! `/admin/service`: health, and who did what.

use axum::extract::{Query, State};
use model::count_i64;
use pages::service::{ActRow, ServicePage};
use pages::{NavPlace, Shell};
use serde::Deserialize;
use store::service::SchoolAct;
use store::{reports, service, stations};

use super::admin::{self};
use crate::AppState;
use crate::error::PageError;
use crate::routes::auth::{Administrator, Csrf};

/// Acts on one page.
const PER_PAGE: u32 = 50;

/// Where to go on.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
pub(super) struct BeforeQuery {
    /// Acts before this place in the log.
    before: Option<i64>,
}

pub(super) async fn show_service_log(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    Query(query): Query<BeforeQuery>,
) -> Result<ServicePage, PageError> {
    let reader = state.db.reader();
    let counts = admin::count_people(&state, person.school_id).await?;
    let failing = reports::failing_jobs(reader, person.school_id).await?.len();
    let joined = stations::list_stations(reader, person.school_id).await?;
    let stations = count_i64(joined.iter().filter(|station| !station.revoked).count());
    let acts = service::list_school_acts(reader, person.school_id, query.before.unwrap_or(i64::MAX), PER_PAGE).await?;
    let full = acts.len() >= PER_PAGE as usize;
    let last = acts.last().filter(|_| full).map(|act| act.seq);
    Ok(ServicePage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Administration),
        version: env!("CARGO_PKG_VERSION"),
        database_bytes: service::database_bytes(reader).await?,
        counts: vec![
            (counts.trainees, tr!("trainees")),
            (counts.instructors, tr!("instructors")),
            (counts.administrators, tr!("administrators")),
            (stations, tr!("stations")),
            (counts.attempts, tr!("scored attempts")),
            (counts.waiting, tr!("recordings in the queue")),
            (counts.refused, tr!("refused recordings")),
            (counts.flagged, tr!("re-simulations that differ")),
        ],
        failing: count_i64(failing),
        acts: acts.into_iter().map(make_act_row).collect(),
        older: last.map(|seq| format!("/admin/service?before={seq}#acts")),
    })
}

fn make_act_row(act: SchoolAct) -> ActRow {
    let SchoolAct { seq, at, actor, action, object, details } = act;
    ActRow { seq, at: at.to_utc(), actor, action, object, details }
}
