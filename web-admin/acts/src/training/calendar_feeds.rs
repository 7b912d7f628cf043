//! Calendars of due dates at secret addresses.

use std::net::IpAddr;

use data_encoding::HEXLOWER;
use model::training::assignment::{Assigned, AssignmentStanding};
use model::{CurrentPerson, Moment, PersonKey};
use platform::secret;
use serde_json::json;
use store::audit::AuditEntry;
use store::scoring::segments;
use store::scoring::segments::SegmentTask;
use store::surveys;
use store::training::calendar_feeds;
use store::training::calendar_feeds::FeedOwner;

use crate::auth::rate_limits;
use crate::error::Error;
use crate::service::Service;
use crate::training::assignments;

/// Creates the secret of a person's calendar; an earlier one ends. It is returned only here.
pub async fn make_feed(state: &Service, person: &CurrentPerson) -> Result<String, Error> {
    let (now, secret) = (state.clock.now(), secret::random_hex()?);
    let mut tx = state.db.write().await?;
    calendar_feeds::put_feed(&mut tx, person.into(), &secret::token_sha256(&secret), now).await?;
    AuditEntry::by(person, "calendar_feed.made", person.id).with(json!({})).append(&mut tx, now).await?;
    tx.commit().await?;
    Ok(secret)
}

/// Ends the address of a person's calendar; without one, nothing changes.
pub async fn revoke_feed(state: &Service, person: &CurrentPerson) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    if calendar_feeds::end_feed(&mut tx, person.into()).await? {
        let entry = AuditEntry::by(person, "calendar_feed.revoked", person.id).with(json!({}));
        entry.append(&mut tx, state.clock.now()).await?;
    }
    Ok(tx.commit().await?)
}

/// Returns whose calendar has this secret.
///
/// # Errors
/// [`Error::NotFound`] if nobody's has, or the person is disabled; [`Error::TooMany`] after too many
/// wrong secrets from one address.
pub async fn find_owner(state: &Service, address: IpAddr, secret: &str) -> Result<FeedOwner, Error> {
    match calendar_feeds::find_feed_owner(state.db.reader(), &secret::token_sha256(secret)).await? {
        Some(owner) => Ok(owner),
        None => {
            rate_limits::take_calendar_guess(state, address).await?;
            Err(Error::NotFound)
        }
    }
}

/// Returns the entity tag of a calendar: a hash of its text.
#[must_use]
pub fn entity_tag(calendar: &str) -> String {
    format!("\"{}\"", HEXLOWER.encode(&secret::token_sha256(calendar)))
}

/// Something that a person has to do until a time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DueItem {
    /// Id, as text.
    pub id: String,
    /// What it is.
    pub kind: DueKind,
    /// Its title.
    pub title: String,
    /// When it is due.
    pub due_at: Moment,
    /// When it was made.
    pub made_at: Moment,
    /// Days by which it was extended for the person.
    pub extended_days: i64,
}

/// Kind of a due item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DueKind {
    /// An exercise or a course to train.
    Assignment,
    /// A task to mark pops.
    Marking,
    /// A survey to answer, of the school or of a study.
    Survey,
}

/// Returns what a person has not done yet and has a due date, earliest first.
pub async fn list_due_items(state: &Service, owner: PersonKey) -> Result<Vec<DueItem>, Error> {
    let PersonKey { school_id, person_id } = owner;
    let reader = state.db.reader();
    let standings = assignments::standings(state, school_id, person_id).await?;
    let open = standings.into_iter().filter(AssignmentStanding::is_open);
    let mut items: Vec<DueItem> = open.filter_map(|standing| due_assignment(standing.assigned)).collect();
    let tasks = segments::list_trainee_tasks(reader, school_id, person_id).await?;
    items.extend(tasks.into_iter().filter(|task| task.sent < task.traces).filter_map(due_task));
    items.extend(list_due_surveys(state, owner).await?);
    items.sort_by(|a, b| (a.due_at, &a.id).cmp(&(b.due_at, &b.id)));
    Ok(items)
}

fn due_assignment(assigned: Assigned) -> Option<DueItem> {
    Some(DueItem {
        id: assigned.id.to_string(),
        kind: DueKind::Assignment,
        due_at: assigned.due_at?,
        title: assigned.title,
        made_at: assigned.made_at,
        extended_days: assigned.extended_days,
    })
}

fn due_task(task: SegmentTask) -> Option<DueItem> {
    Some(DueItem {
        id: task.id.to_string(),
        kind: DueKind::Marking,
        due_at: task.due_at?,
        title: task.title,
        made_at: task.made_at,
        extended_days: task.extended_days,
    })
}

async fn list_due_surveys(state: &Service, owner: PersonKey) -> Result<Vec<DueItem>, Error> {
    let PersonKey { school_id, person_id: person } = owner;
    let reader = state.db.reader();
    let mut items = Vec::new();
    for survey in surveys::of_person(reader, school_id, person, state.clock.now()).await? {
        let Some(due_at) = survey.closes_at else { continue };
        if !surveys::answered(reader, &survey, person, None).await? {
            items.push(DueItem {
                id: survey.id.to_string(),
                kind: DueKind::Survey,
                title: survey.title,
                due_at,
                made_at: survey.created_at,
                extended_days: 0,
            });
        }
    }
    Ok(items)
}
