//! Cohort membership: administrators decide; instructors request a member, and the trainee or an
//! administrator accepts or declines.

use model::ids::{CohortId, PersonId};
use model::{CurrentPerson, Role};
use serde_json::json;
use store::audit::AuditEntry;
use store::people;
use store::training::cohorts;
use store::training::cohorts::{Attribution, Cohort, Membership, MembershipKey};

use crate::error::Error;
use crate::service::Service;

fn deed(service: &Service, by: &CurrentPerson) -> Attribution {
    Attribution { by: Some(by.id), at: service.clock.now() }
}

/// Creates a cohort. An instructor who creates one becomes a member of it.
///
/// # Errors
/// Returns [`Error::Conflict`] if a cohort has this name already; fails if the database fails.
pub async fn make_cohort(service: &Service, by: &CurrentPerson, name: &str) -> Result<Cohort, Error> {
    let school_id = by.school_id;
    let mut tx = service.db.write().await?;
    let before = cohorts::list_cohorts(&mut *tx, school_id).await?;
    if before.iter().any(|cohort| cohort.name == name) {
        return Err(Error::Conflict(tr!("a cohort “{name}” already exists", name = name)));
    }
    let cohort = cohorts::find_or_create(&mut tx, school_id, name, service.clock.now()).await?;
    if by.role == Role::Instructor {
        let own = Membership { school_id, cohort_id: cohort.id, person_id: by.id, role: Role::Instructor };
        cohorts::join_cohort(&mut tx, own, deed(service, by)).await?;
    }
    AuditEntry::by(by, "cohort.made", cohort.id).append(&mut tx, service.clock.now()).await?;
    tx.commit().await?;
    Ok(cohort)
}

/// Adds a person of the school if called by an administrator, and requests them otherwise. Returns
/// false if no eligible person of this school has the address; a person of another school gives the
/// same result as an unknown address.
pub async fn add_member(service: &Service, by: &CurrentPerson, cohort: CohortId, email: &str) -> Result<bool, Error> {
    let mut tx = service.db.write().await?;
    let known = people::find_member_by_email(&mut *tx, by.school_id, email).await?;
    let known = known.filter(|known| known.role != Role::Administrator);
    let Some(known) = known else { return Ok(false) };
    let (school_id, deed) = (by.school_id, deed(service, by));
    let (done, action) = match by.role {
        Role::Administrator => {
            let membership = Membership { school_id, cohort_id: cohort, person_id: known.id, role: known.role };
            cohorts::join_cohort(&mut tx, membership, deed).await?;
            (true, "cohort.joined")
        }
        _ => (
            cohorts::ask_for_member(
                &mut tx,
                MembershipKey { school_id, cohort_id: cohort, person_id: known.id },
                by.id,
                deed.at,
            )
            .await?,
            "cohort.asked",
        ),
    };
    if done {
        AuditEntry::by(by, action, known.id).with(json!({ "cohort": cohort })).append(&mut tx, deed.at).await?;
    }
    tx.commit().await?;
    Ok(true)
}

/// A membership request: the person and the cohort.
#[derive(Clone, Copy, Debug)]
pub struct RequestKey {
    /// The cohort.
    pub cohort_id: CohortId,
    /// The person.
    pub person_id: PersonId,
}

/// Accepts or declines a membership request.
///
/// # Errors
/// Returns [`Error::NotFound`] if there is no such request; fails if the database fails.
pub async fn answer_request(
    service: &Service,
    by: &CurrentPerson,
    RequestKey { cohort_id, person_id }: RequestKey,
    joins: bool,
) -> Result<(), Error> {
    let (school_id, deed) = (by.school_id, deed(service, by));
    let mut tx = service.db.write().await?;
    let asked = cohorts::list_membership_requests(&mut *tx, school_id, Some(cohort_id), Some(person_id)).await?;
    let role = asked.first().ok_or(Error::NotFound)?.role;
    let action = if joins {
        cohorts::join_cohort(&mut tx, Membership { school_id, cohort_id, person_id, role }, deed).await?;
        "cohort.joined"
    } else {
        cohorts::decline_request(&mut tx, MembershipKey { school_id, cohort_id, person_id }, deed).await?;
        "cohort.declined"
    };
    AuditEntry::by(by, action, person_id).with(json!({ "cohort": cohort_id })).append(&mut tx, deed.at).await?;
    Ok(tx.commit().await?)
}

/// Removes a person from a cohort.
///
/// # Errors
/// Returns [`Error::NotFound`] if they are not a member; fails if the database fails.
pub async fn remove_member(
    service: &Service,
    by: &CurrentPerson,
    cohort: CohortId,
    member: PersonId,
) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    if !cohorts::leave_cohort(
        &mut tx,
        MembershipKey { school_id: by.school_id, cohort_id: cohort, person_id: member },
        deed(service, by),
    )
    .await?
    {
        return Err(Error::NotFound);
    }
    AuditEntry::by(by, "cohort.left", member)
        .with(json!({ "cohort": cohort }))
        .append(&mut tx, service.clock.now())
        .await?;
    Ok(tx.commit().await?)
}
