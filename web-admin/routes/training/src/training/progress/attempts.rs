//! Exports every attempt of a school as a file, for its administrators.

use std::time::Duration;

use assessment::words::failure_in_words;
use axum::extract::State;
use axum::response::Response;
use futures::stream;
use model::AttemptPlace;
use model::ids::SchoolId;
use pages::format;
use routes_base::AppState;
use routes_base::auth::Administrator;
use routes_base::error::PageError;
use routes_base::export::{CsvCell, stream_csv};
use store::training::reports;
use store::training::reports::AttemptRecord;

/// Attempts read per batch: a long export then keeps neither memory nor the database busy for long.
const AT_ONCE: u32 = 200;

/// Maximum time that an export waits for earlier exports of the same school.
const PATIENCE: Duration = Duration::from_secs(5);

/// Columns of the file.
const NAMES: [&str; 25] = [
    "session",
    "started_at",
    "received_at",
    "trainee",
    "trainee_id",
    "pseudonym",
    "exercise",
    "exercise_id",
    "exercise_sha256",
    "state",
    "refusal",
    "flagged",
    "score",
    "passed",
    "computed_score",
    "hard_fails",
    "duration_s",
    "complete",
    "device",
    "simulator_version",
    "uncounted",
    "claimed_started_at",
    "signed",
    "resimulated",
    "supervised",
];

pub(super) async fn export_attempts(
    State(state): State<AppState>,
    Administrator(person): Administrator,
) -> Result<Response, PageError> {
    let school = person.school_id;
    let place = state.exports.enter(school, PATIENCE).await?;
    let rows = stream::try_unfold(Some(AttemptPlace::START), move |after| {
        // Held until the last row is written, or the client disconnects.
        let (state, _held) = (state.clone(), &place);
        async move { next_attempts(&state, school, after).await }
    });
    Ok(stream_csv("attempts", &NAMES, rows)?)
}

/// Returns the next rows, and the position after them; `None` after the last attempt.
async fn next_attempts(
    state: &AppState,
    school: SchoolId,
    after: Option<AttemptPlace>,
) -> anyhow::Result<Option<(Vec<Vec<CsvCell>>, Option<AttemptPlace>)>> {
    let Some(after) = after else { return Ok(None) };
    let found = reports::records_after(state.db.reader(), school, after, AT_ONCE).await?;
    let last = found.last().filter(|_| found.len() == AT_ONCE as usize);
    let next = last.map(|last| AttemptPlace { started_at: last.listed.started_at, id: last.listed.id });
    Ok(Some((found.into_iter().map(attempt_cells).collect(), next)))
}

fn attempt_cells(record: AttemptRecord) -> Vec<CsvCell> {
    let listed = &record.listed;
    vec![
        CsvCell::from(listed.id.to_string()),
        CsvCell::from(format::format_machine_time(listed.started_at.to_utc())),
        CsvCell::from(format::format_machine_time(record.received_at.to_utc())),
        CsvCell::from(listed.trainee.as_str()),
        CsvCell::from(record.trainee_id.to_string()),
        CsvCell::from(record.pseudonym),
        CsvCell::from(listed.exercise.as_str()),
        CsvCell::from(record.exercise_id),
        CsvCell::from(record.exercise_sha256),
        CsvCell::from(listed.state.word()),
        listed.refusal.as_deref().map_or(CsvCell::Empty, CsvCell::from),
        CsvCell::from(listed.flagged),
        CsvCell::from(listed.score),
        listed.passed.map_or(CsvCell::Empty, CsvCell::from),
        CsvCell::from(listed.computed.or(listed.score)),
        listed.hard_fails.as_ref().map_or(CsvCell::Empty, |fails| {
            CsvCell::from(fails.iter().map(failure_in_words).collect::<Vec<_>>().join("; "))
        }),
        CsvCell::Number(record.duration_s),
        CsvCell::from(record.complete),
        CsvCell::from(record.device),
        CsvCell::from(record.simulator_version),
        listed.uncounted.map_or(CsvCell::Empty, |why| CsvCell::from(why.word())),
        record.claimed_started_at.map_or(CsvCell::Empty, |at| CsvCell::from(format::format_machine_time(at.to_utc()))),
        CsvCell::from(record.proof.signed),
        CsvCell::from(record.proof.resimulated),
        CsvCell::from(record.proof.supervised),
    ]
}
