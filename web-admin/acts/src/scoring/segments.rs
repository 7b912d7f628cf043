//! Marking tasks: trainees mark the moment of each pop on blinded traces. Creates tasks, stores
//! marks and evaluates them.

use model::ids::{PersonId, SchoolId, TaskId, TraceId};
use model::scoring::segments::{MarksVerdict, TraceOutcome, pops};
use model::training::due;
use model::{CurrentPerson, Role, SessionKey};
use serde_json::json;
use store::Json;
use store::audit::AuditEntry;
use store::scoring::segments::{Marks, NewTask, SegmentTask, Trace};
use store::scoring::{scores, segments};
use store::training::deadlines;
use store::training::deadlines::{DeadlineKey, DeadlineKind};

use crate::error::Error;
use crate::service::Service;
use crate::training::deadlines::Dated;

/// Creates a marking task.
///
/// # Errors
/// Fails if an attempt or the cohort does not belong to the school, or the database fails.
pub async fn make(state: &Service, by: &CurrentPerson, new: &NewTask) -> Result<TaskId, Error> {
    let mut tx = state.db.write().await?;
    let id = segments::add_segment_task(&mut tx, by, new, state.clock.now()).await?;
    let told = json!({ "cohort": new.cohort_id, "attempts": new.sessions });
    AuditEntry::by(by, "segments.assigned", id).with(told).append(&mut tx, state.clock.now()).await?;
    tx.commit().await?;
    Ok(id)
}

/// Returns the deadline of a task in the form in which deadlines are extended.
#[must_use]
pub fn dated(task: &SegmentTask) -> Dated<'_> {
    Dated {
        kind: DeadlineKind::Segments,
        id: task.id.into(),
        due_local: task.due_local.as_deref(),
        time_zone: &task.time_zone,
    }
}

/// Withdraws a task.
pub async fn withdraw(state: &Service, by: &CurrentPerson, task: TaskId) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    segments::withdraw_task(&mut tx, by.school_id, task, state.clock.now()).await?;
    AuditEntry::by(by, "segments.withdrawn", task).append(&mut tx, state.clock.now()).await?;
    Ok(tx.commit().await?)
}

/// Returns a task that is assigned to a person or managed by them.
///
/// # Errors
/// Returns [`Error::NotFound`] for any other task.
pub async fn task(state: &Service, person: &CurrentPerson, id: TaskId) -> Result<SegmentTask, Error> {
    let reader = state.db.reader();
    let found = match person.role {
        Role::Trainee | Role::Guest => segments::list_trainee_tasks(reader, person.school_id, person.id).await?,
        Role::Instructor | Role::Administrator => segments::list_managed_tasks(reader, person, Some(id)).await?,
    };
    found.into_iter().find(|task| task.id == id).ok_or(Error::NotFound)
}

/// Returns a trace with its task. Trainees do not get traces of their own attempts, whose events
/// they could look up elsewhere.
///
/// # Errors
/// Returns [`Error::NotFound`] for any other trace.
pub async fn trace(state: &Service, person: &CurrentPerson, id: TraceId) -> Result<(SegmentTask, Trace), Error> {
    let trace = segments::find_trace(state.db.reader(), person.school_id, id).await?.ok_or(Error::NotFound)?;
    let task = task(state, person, trace.task_id).await?;
    if person.role == Role::Trainee && trace.trainee_id == person.id {
        return Err(Error::NotFound);
    }
    Ok((task, trace))
}

/// Stores a trainee's marks; `sent` makes them final.
///
/// # Errors
/// Returns [`Error::Conflict`] if the marks are already final.
pub async fn mark(
    state: &Service,
    person: &CurrentPerson,
    trace: &Trace,
    marks: Vec<f64>,
    sent: bool,
) -> Result<(), Error> {
    let now = state.clock.now();
    let new = Marks { person_id: person.id, trace_id: trace.id, marks: Json(marks), sent_at: sent.then_some(now) };
    let mut tx = state.db.write().await?;
    if !segments::put_marks(&mut tx, person.school_id, &new).await? {
        return Err(Error::Conflict(tr!("these marks were already sent; the pops have been shown").to_owned()));
    }
    if sent {
        let told = json!({ "task": trace.task_id });
        AuditEntry::by(person, "segments.marked", trace.id).with(told).append(&mut tx, state.clock.now()).await?;
    }
    Ok(tx.commit().await?)
}

/// Returns the times of the pops in an attempt, in s.
///
/// # Errors
/// Fails if it has not been scored, or the database fails.
pub async fn truth(state: &Service, school_id: SchoolId, trace: &Trace) -> Result<Vec<f64>, Error> {
    let key = SessionKey { school_id, id: trace.session_id };
    let curve = scores::find_curve(state.db.reader(), key).await?.ok_or(Error::NotFound)?;
    Ok(pops(&curve))
}

/// Returns the outcomes of a task, in the order of `people`.
pub async fn outcomes(
    state: &Service,
    school: SchoolId,
    task: &SegmentTask,
    people: &[PersonId],
) -> Result<Vec<TraceOutcome>, Error> {
    let reader = state.db.reader();
    let mut traces = Vec::new();
    for trace in segments::list_traces(reader, school, task.id).await? {
        let pops = truth(state, school, &trace).await?;
        traces.push((trace, pops));
    }
    let marks = segments::find_marks(reader, school, task.id).await?;
    let longer = deadlines::list_extensions(
        reader,
        DeadlineKey { school_id: school, kind: DeadlineKind::Segments, id: task.id.into() },
    )
    .await?;
    let of = |person: &PersonId| {
        let longer = longer.iter().find(|extension| extension.person_id == *person);
        let due_at = longer.map_or(task.due_at, |extension| Some(extension.due_at));
        let begun = TraceOutcome {
            due_at,
            extended_days: longer.map_or(0, |extension| extension.days),
            ..TraceOutcome::default()
        };
        outcome(begun, &traces, &marks, *person)
    };
    Ok(people.iter().map(of).collect())
}

fn outcome(mut outcome: TraceOutcome, traces: &[(Trace, Vec<f64>)], marks: &[Marks], person: PersonId) -> TraceOutcome {
    for (trace, pops) in traces.iter().filter(|(trace, _)| trace.trainee_id != person) {
        outcome.traces += 1;
        let own = marks.iter().find(|marks| marks.person_id == person && marks.trace_id == trace.id);
        let Some((own, sent_at)) = own.and_then(|own| Some((own, own.sent_at?))) else { continue };
        outcome.sent += 1;
        outcome.late |= outcome.due_at.is_some_and(|due| due::is_past(due, sent_at));
        outcome.verdict = outcome.verdict.join(MarksVerdict::of(pops, &own.marks));
    }
    outcome
}
