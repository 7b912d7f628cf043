//! Bulk actions: previews them with the people left out and the reasons, then carries them out in
//! one transaction.

use std::collections::BTreeSet;

use model::ids::{CohortId, PersonId};
use model::people::directory::{BulkAct, BulkPlan, DirectoryEntry, ExemptPerson};
use model::{CurrentPerson, PersonKey, Role, count_u32};
use serde_json::json;
use store::Connection;
use store::audit::AuditEntry;
use store::auth::account_links::Purpose;
use store::people::directory;
use store::training::cohorts;
use store::training::cohorts::{Attribution, Membership, MembershipKey};

use crate::error::Error;
use crate::people::accounts;
use crate::service::Service;

/// Maximum number of people in one bulk action.
pub const MOST_PEOPLE: u32 = 1000;

/// A bulk action and its targets.
#[derive(Clone, Debug)]
pub struct BulkRequest {
    /// Action.
    pub act: BulkAct,
    /// Cohort, for actions that need one.
    pub cohort: Option<CohortId>,
    /// People selected.
    pub people: Vec<PersonId>,
}

/// Returns the people to whom the action would apply, and those left out.
///
/// # Errors
/// Returns [`Error::NotFound`] if the cohort does not belong to this school, and
/// [`Error::BadRequest`] if a required cohort is missing or there are too many people.
pub async fn plan_bulk_act(state: &Service, by: &CurrentPerson, request: &BulkRequest) -> Result<BulkPlan, Error> {
    plan_within(&mut *state.db.reader().acquire().await?, by, request).await
}

async fn plan_within(
    connection: &mut Connection,
    by: &CurrentPerson,
    request: &BulkRequest,
) -> Result<BulkPlan, Error> {
    let asked = request.people.len();
    if count_u32(asked) > MOST_PEOPLE {
        return Err(Error::BadRequest(format!("people: {asked}; allowed: {MOST_PEOPLE} at once")));
    }
    let members = match request.cohort.filter(|_| request.act.needs_cohort()) {
        Some(cohort) => {
            cohorts::find_cohort(&mut *connection, by.school_id, cohort).await?.ok_or(Error::NotFound)?;
            cohorts::list_members_among(&mut *connection, by.school_id, cohort, &request.people).await?
        }
        None if request.act.needs_cohort() => return Err(Error::BadRequest("cohort: none chosen".to_owned())),
        None => BTreeSet::new(),
    };
    let mut plan = BulkPlan::default();
    for person in directory::list_people_by_id(&mut *connection, by.school_id, &request.people).await? {
        match request.act.exempts(&person, members.contains(&person.id), by.id) {
            Some(why) => plan.exempt.push(ExemptPerson { person, why }),
            None => plan.people.push(person),
        }
    }
    Ok(plan)
}

/// Carries out the action for everyone to whom it still applies, and returns them.
///
/// # Errors
/// As [`plan_bulk_act`]; nothing is changed then.
pub async fn do_bulk_act(state: &Service, by: &CurrentPerson, request: &BulkRequest) -> Result<BulkPlan, Error> {
    let mut tx = state.db.write().await?;
    let plan = plan_within(&mut tx, by, request).await?;
    for person in &plan.people {
        act_on(&mut tx, state, by, request, person).await?;
    }
    tx.commit().await?;
    if request.act == BulkAct::Invite {
        state.mails.notify_one();
    }
    Ok(plan)
}

async fn act_on(
    tx: &mut Connection,
    state: &Service,
    by: &CurrentPerson,
    request: &BulkRequest,
    person: &DirectoryEntry,
) -> Result<(), Error> {
    let (school_id, person_id, now) = (by.school_id, person.id, state.clock.now());
    let deed = Attribution { by: Some(by.id), at: now };
    let told = json!({ "cohort": request.cohort });
    match (request.act, request.cohort) {
        (BulkAct::Invite, _) => {
            accounts::queue_link(tx, state, PersonKey { school_id, person_id }, Purpose::Invitation).await?;
            AuditEntry::by(by, "person.link_mailed", person_id).append(tx, now).await?;
        }
        (BulkAct::Join, Some(cohort_id)) => {
            debug_assert!(person.role != Role::Administrator, "the plan leaves administrators out");
            cohorts::join_cohort(tx, Membership { school_id, cohort_id, person_id, role: person.role }, deed).await?;
            AuditEntry::by(by, "cohort.joined", person_id).with(told).append(tx, now).await?;
        }
        (BulkAct::Leave, Some(cohort_id)) => {
            cohorts::leave_cohort(tx, MembershipKey { school_id, cohort_id, person_id }, deed).await?;
            AuditEntry::by(by, "cohort.left", person_id).with(told).append(tx, now).await?;
        }
        (BulkAct::Disable, _) => accounts::disable_in(tx, state, by, person_id).await?,
        (BulkAct::Enable, _) => accounts::enable_in(tx, state, by, person_id).await?,
        (BulkAct::Join | BulkAct::Leave, None) => {
            return Err(Error::BadRequest("cohort: none chosen".to_owned()));
        }
    }
    Ok(())
}
