//! Who is in a cohort: administrators decide it; its instructors ask, and the trainee or an administrator answers.

use model::ids::{CohortId, PersonId};
use model::{CurrentPerson, Role};
use serde_json::json;
use store::audit::AuditEntry;
use store::cohorts::{self, Cohort, Deed, Membership, MembershipKey};
use store::people;

use crate::error::Error;
use crate::service::Service;

fn deed(service: &Service, by: &CurrentPerson) -> Deed {
    Deed { by: Some(by.id), at: service.clock.now() }
}

/// Makes a cohort; an instructor teaches what they have made.
///
/// # Errors
/// [`Error::Conflict`] when there is one of the name; else when the database fails.
pub async fn make_cohort(service: &Service, by: &CurrentPerson, name: &str) -> Result<Cohort, Error> {
    let school_id = by.school_id;
    let mut tx = service.db.write().await?;
    let before = cohorts::list_cohorts(&mut *tx, school_id).await?;
    if before.iter().any(|cohort| cohort.name == name) {
        return Err(Error::Conflict(tr!("there is a cohort “{name}” already", name = name)));
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

/// Adds somebody of the school, where an administrator does it, else asks for them. False where nobody of the school who could be
/// in a cohort has the address: whoever is of another school is answered like nobody.
pub async fn add_member(service: &Service, by: &CurrentPerson, cohort: CohortId, email: &str) -> Result<bool, Error> {
    let mut tx = service.db.write().await?;
    let known = people::find_person_by_email(&mut *tx, email).await?;
    let known = known.filter(|known| known.school_id == by.school_id && known.role != Role::Administrator);
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

/// Who is asked for, and for which cohort.
#[derive(Clone, Copy, Debug)]
pub struct RequestKey {
    /// The cohort.
    pub cohort_id: CohortId,
    /// Who.
    pub person_id: PersonId,
}

/// Answers the request for somebody.
///
/// # Errors
/// [`Error::NotFound`] when nobody has asked for them; else when the database fails.
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

/// Takes somebody out of a cohort.
///
/// # Errors
/// [`Error::NotFound`] when they are not in it; else when the database fails.
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
