//! `/admin/service`: the health of the service.

use acts::operations::inspection::InspectionState;
use axum::extract::State;
use model::count_i64;
use pages::operations::service::{DatabaseCheck, FailedLetterRow, ServicePage};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::auth::{Administrator, Csrf};
use routes_base::error::PageError;
use store::letters::mails;
use store::operations::service;
use store::stations;
use store::training::reports;

use crate::operations::admin;

/// Maximum number of failed mails listed.
const MOST_LETTERS: u32 = 100;

pub(super) async fn show_service_log(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
) -> Result<ServicePage, PageError> {
    let reader = state.db.reader();
    let counts = admin::count_people(&state, person.school_id).await?;
    let failing = reports::failing_jobs(reader, person.school_id).await?.len();
    let letters = mails::list_failed_letters(reader, person.school_id, MOST_LETTERS).await?;
    let joined = stations::list_stations(reader, person.school_id).await?;
    let stations = count_i64(joined.iter().filter(|station| !station.revoked).count());
    Ok(ServicePage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Administration),
        version: env!("CARGO_PKG_VERSION"),
        database_bytes: service::database_bytes(reader).await?,
        check: tell_check(state.inspection.state()),
        counts: vec![
            (counts.trainees, tr!("trainees")),
            (counts.instructors, tr!("instructors")),
            (counts.administrators, tr!("administrators")),
            (stations, tr!("stations")),
            (counts.attempts, tr!("scored attempts")),
            (counts.waiting, tr!("recordings in the queue")),
            (counts.refused, tr!("rejected recordings")),
            (counts.flagged, tr!("differing re-simulations")),
        ],
        failing: count_i64(failing),
        letters: letters
            .into_iter()
            .map(|letter| FailedLetterRow {
                href: letter.person_id.map(|id| format!("/people/{id}")),
                name: letter.name,
                why: letter.error,
            })
            .collect(),
    })
}

fn tell_check(inspection: InspectionState) -> DatabaseCheck {
    let InspectionState { tables, tables_read, audit_rows, audit_rows_read, going, findings } = inspection;
    match (going, findings.is_empty()) {
        (_, false) => DatabaseCheck::Damaged(findings),
        (true, true) => DatabaseCheck::Going { tables_read, tables, rows_read: audit_rows_read, rows: audit_rows },
        (false, true) => DatabaseCheck::Whole,
    }
}
