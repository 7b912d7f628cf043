//! Assignments of the demonstration: one due soon, and one overdue with an extension for one
//! trainee.

use acts::operations::schools;
use acts::training::{assignments, deadlines, risks, terms};
use anyhow::Context;
use model::ids::{AssignmentId, CohortId, SchoolId};
use model::training::assignment::AssignmentTask;
use model::training::due;
use model::training::support_note::{SupportKind, SupportText};
use model::{CurrentPerson, Moment};
use routes_base::AppState;
use store::operations::schools::{SchoolSettings, find_school_settings};
use store::people;
use store::training::assignments::NewAssignment;
use store::training::{assignments as stored, cohorts, terms as stored_terms};
use worker::outbox;

use crate::DAY_S;
use crate::school::{self, ADMINISTRATOR, COHORTS, LEARNERS};

/// Time zone of the school.
const TIME_ZONE: &str = "Europe/Berlin";

/// Creates the assignments.
///
/// # Errors
/// Fails if the people are missing, or the database fails.
pub async fn assign_demo_tasks(state: &AppState, now: Moment) -> anyhow::Result<()> {
    let administrator = find_demo_person(state, ADMINISTRATOR).await?.into_current().context("an administrator")?;
    let settled = find_school_settings(state.db.reader(), administrator.school_id).await?;
    let settled = SchoolSettings { time_zone: TIME_ZONE.to_owned(), ..settled };
    schools::settle_school(state, &administrator, &settled).await?;
    let instructor = find_demo_person(state, COHORTS[0].instructor).await?.into_current().context("an instructor")?;
    let course = AssignmentTask::Course(super::COURSE.to_owned());
    make_demo_assignment(state, &instructor, course, now, now.plus_s(DAY_S)).await?;
    let exercise = AssignmentTask::Exercise("reach-the-muscle".to_owned());
    let late =
        make_demo_assignment(state, &instructor, exercise, now.plus_s(-14 * DAY_S), now.plus_s(-2 * DAY_S)).await?;
    let listed = stored::list_managed_assignments(state.db.reader(), &instructor, Some(late), 1).await?;
    let absent =
        LEARNERS.iter().find(|learner| learner.cohort == 0 && learner.absent_weeks > 0).context("an absent one")?;
    let absent = find_demo_person(state, absent.name).await?.id;
    let listed = listed.first().context("what was just assigned")?;
    Ok(deadlines::extend(state, &instructor, assignments::dated(listed), absent, 7).await?)
}

/// Puts the cohorts with the given names into a term that begins now.
///
/// # Errors
/// Fails if the people are missing, or the database fails.
pub async fn begin_demo_term(state: &AppState, names: &[&str]) -> anyhow::Result<()> {
    let administrator = find_demo_person(state, ADMINISTRATOR).await?.into_current().context("an administrator")?;
    let day = due::local(state.clock.now(), TIME_ZONE).machine;
    let day = day.get(..10).context("a date")?;
    terms::add_term(state, &administrator, &format!("Term from {day}"), day).await?;
    let reader = state.db.reader();
    let term = stored_terms::list_terms(reader, administrator.school_id).await?.first().context("the term")?.id;
    let known = cohorts::list_cohorts(reader, administrator.school_id).await?;
    for cohort in known.iter().filter(|cohort| names.contains(&&*cohort.name)) {
        terms::set_cohort_term(state, &administrator, cohort.id, Some(term)).await?;
    }
    Ok(())
}

/// Writes to a trainee who is stuck.
///
/// # Errors
/// Fails if the people are missing, or the database fails.
pub async fn support_demo_trainee(state: &AppState, now: Moment) -> anyhow::Result<()> {
    let instructor = find_demo_person(state, COHORTS[0].instructor).await?.into_current().context("an instructor")?;
    let stuck = LEARNERS.iter().filter(|learner| learner.cohort == 0);
    let stuck = stuck.min_by(|a, b| a.gain.total_cmp(&b.gain)).context("somebody who learns slowly")?;
    let stuck = find_demo_person(state, stuck.name).await?.id;
    let text = SupportText {
        kind: SupportKind::Message,
        subject: Some("An hour at the station together?".to_owned()),
        body: "Station 2 is free on Thursday from 14:00. Let us go through your last attempts.".to_owned(),
    };
    risks::record_support(&state.at(now.plus_s(-3 * DAY_S)), &instructor, &[stuck], &text).await?;
    Ok(())
}

/// Sends reminders of the deadlines until tomorrow; the mails are files in the mail folder.
///
/// # Errors
/// Fails if the database fails, or a mail cannot be written.
pub async fn remind_demo_people(state: &AppState, now: Moment) -> anyhow::Result<()> {
    let now = state.at(now);
    deadlines::remind(&now).await?;
    Ok(outbox::work_off_letters(&now).await?)
}

/// Returns a person of the demonstration by name.
///
/// # Errors
/// If they are missing, or the database fails.
pub(crate) async fn find_demo_person(state: &AppState, name: &str) -> anyhow::Result<people::Person> {
    people::find_person_by_email(state.db.reader(), &school::email_of(name))
        .await?
        .context("somebody of the demonstration is missing")
}

/// Returns the first of [`COHORTS`].
///
/// # Errors
/// If it is missing, or the database fails.
pub(crate) async fn find_first_cohort(state: &AppState, school: SchoolId) -> anyhow::Result<CohortId> {
    let known = cohorts::list_cohorts(state.db.reader(), school).await?;
    let first = known.into_iter().find(|cohort| cohort.name == COHORTS[0].name);
    Ok(first.context("the first cohort")?.id)
}

/// Assigns a task to the first cohort at time `made`, due at 18:00 on the day of `due_at`.
async fn make_demo_assignment(
    state: &AppState,
    by: &CurrentPerson,
    task: AssignmentTask,
    made: Moment,
    due_at: Moment,
) -> anyhow::Result<AssignmentId> {
    let day = due::local(due_at, TIME_ZONE).machine;
    let due = due::read(&format!("{}T18:00", day.get(..10).context("a date")?), TIME_ZONE)?;
    let new = NewAssignment {
        task,
        cohort_id: Some(find_first_cohort(state, by.school_id).await?),
        person_id: None,
        since_only: false,
        supervised: false,
        attempt_limit: None,
        due: Some((due.local, due.at)),
        time_zone: TIME_ZONE.to_owned(),
    };
    let then = state.at(made);
    Ok(assignments::make(&then, by, &new).await?)
}
