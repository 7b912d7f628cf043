//! Cohorts, as a directory provisions them: their trainees are the members of a group.

use std::collections::BTreeSet;

use model::ids::{CohortId, PersonId};
use model::people::scim::{Filter, Object, PatchRequest, ScimError, ScimGroup, WantedGroup};
use model::{Moment, Role};
use serde_json::json;
use store::Connection;
use store::audit::{Actor, AuditEntry};
use store::people::provisioning;
use store::training::cohorts;
use store::training::cohorts::{Attribution, Membership, MembershipKey};

use super::users::Listed;
use super::{DirectoryRequest, ProvisioningError};
use crate::error::Error;

type Result<T> = std::result::Result<T, ProvisioningError>;

impl DirectoryRequest<'_> {
    async fn read_group(&self, tx: &mut Connection, id: CohortId) -> Result<ScimGroup> {
        let school = self.token.school_id;
        let found = provisioning::find_group(&mut *tx, school, id).await?.ok_or(Error::NotFound)?;
        let members = provisioning::list_group_members(tx, school, id).await?;
        Ok(ScimGroup { members, ..found })
    }

    /// Returns a cohort.
    ///
    /// # Errors
    /// Fails if the directory does not see it, or the database fails.
    pub async fn show_group(&self, id: CohortId) -> Result<Object> {
        let (reader, school) = (self.service.db.reader(), self.token.school_id);
        let found = provisioning::find_group(reader, school, id).await?.ok_or(Error::NotFound)?;
        let members = provisioning::list_group_members(reader, school, id).await?;
        Ok(ScimGroup { members, ..found }.to_json(self.address))
    }

    /// Returns the cohorts that match a filter, with their members.
    ///
    /// # Errors
    /// Fails if the database fails.
    pub async fn list_groups(&self, filter: Option<&Filter>, offset: u32, limit: u32) -> Result<Listed> {
        let (reader, school) = (self.service.db.reader(), self.token.school_id);
        let mut found = provisioning::list_groups(reader, school).await?;
        found.retain(|group| filter.is_none_or(|filter| filter.matches(&group.to_json(self.address))));
        let total = found.len() as u32;
        let mut resources = Vec::new();
        for group in found.into_iter().skip(offset as usize).take(limit as usize) {
            let members = provisioning::list_group_members(reader, school, group.id).await?;
            resources.push(ScimGroup { members, ..group }.to_json(self.address));
        }
        Ok(Listed { total, resources })
    }

    /// Creates a cohort, or takes up one that the directory had deleted.
    ///
    /// # Errors
    /// Fails if an attribute is invalid or taken, or the database fails.
    pub async fn create_group(&self, fields: &Object) -> Result<Object> {
        let wanted = WantedGroup::read(fields).map_err(ProvisioningError::of)?;
        let (school, now) = (self.token.school_id, self.service.clock.now());
        let mut tx = self.service.db.write().await?;
        let seen = provisioning::list_groups(&mut *tx, school).await?;
        if seen.iter().any(|group| group.name == wanted.name) {
            return Err(ProvisioningError::Scim(ScimError::taken("displayName: another group has it")));
        }
        let cohort = cohorts::find_or_create(&mut tx, school, &wanted.name, now).await?;
        AuditEntry::new(school, Actor::Directory, "cohort.made", cohort.id)
            .with(json!({ "token": self.token.id }))
            .append(&mut tx, now)
            .await?;
        self.settle_group(&mut tx, cohort.id, &wanted).await?;
        let made = self.read_group(&mut tx, cohort.id).await?;
        tx.commit().await?;
        Ok(made.to_json(self.address))
    }

    /// Replaces name and members of a cohort.
    ///
    /// # Errors
    /// Fails if the directory does not see it, an attribute is invalid or taken, or the database
    /// fails.
    pub async fn replace_group(&self, id: CohortId, fields: &Object) -> Result<Object> {
        self.change_group(id, |_| Ok(fields.clone())).await
    }

    /// Changes a cohort by a patch.
    ///
    /// # Errors
    /// As [`DirectoryRequest::replace_group`].
    pub async fn patch_group(&self, id: CohortId, patch: PatchRequest) -> Result<Object> {
        self.change_group(id, |mut fields| patch.apply(&mut fields).map(|()| fields)).await
    }

    async fn change_group(
        &self,
        id: CohortId,
        change: impl FnOnce(Object) -> std::result::Result<Object, ScimError> + Send,
    ) -> Result<Object> {
        let mut tx = self.service.db.write().await?;
        let before = self.read_group(&mut tx, id).await?.to_json(self.address);
        self.check_version(&before)?;
        let fields = change(before).map_err(ProvisioningError::of)?;
        let wanted = WantedGroup::read(&fields).map_err(ProvisioningError::of)?;
        self.settle_group(&mut tx, id, &wanted).await?;
        let after = self.read_group(&mut tx, id).await?;
        tx.commit().await?;
        Ok(after.to_json(self.address))
    }

    /// Removes all trainees from a cohort and hides it from the directory. The cohort, its
    /// assignments and its teachers stay.
    ///
    /// # Errors
    /// Fails if the directory does not see it, or the database fails.
    pub async fn delete_group(&self, id: CohortId) -> Result<()> {
        let now = self.service.clock.now();
        let mut tx = self.service.db.write().await?;
        let known = self.read_group(&mut tx, id).await?;
        self.check_version(&known.to_json(self.address))?;
        self.set_members(&mut tx, &known, &[], now).await?;
        provisioning::put_group(&mut tx, self.token.school_id, &known, Some(now)).await?;
        Ok(tx.commit().await?)
    }

    async fn settle_group(&self, tx: &mut Connection, id: CohortId, wanted: &WantedGroup) -> Result<()> {
        let (school, now) = (self.token.school_id, self.service.clock.now());
        let others = cohorts::list_cohorts(&mut *tx, school).await?;
        if others.iter().any(|other| other.name == wanted.name && other.id != id) {
            return Err(ProvisioningError::Scim(ScimError::taken("displayName: another group has it")));
        }
        let group = ScimGroup {
            id,
            name: wanted.name.clone(),
            external_id: wanted.external_id.clone(),
            members: provisioning::list_group_members(&mut *tx, school, id).await?,
        };
        provisioning::put_group(tx, school, &group, None).await?;
        self.set_members(tx, &group, &wanted.members, now).await
    }

    /// Makes people the trainees of a cohort. People who teach are left as they are.
    async fn set_members(
        &self,
        tx: &mut Connection,
        group: &ScimGroup,
        wanted: &[PersonId],
        now: Moment,
    ) -> Result<()> {
        let school_id = self.token.school_id;
        let (before, wanted): (BTreeSet<PersonId>, BTreeSet<PersonId>) =
            (group.members.iter().copied().collect(), wanted.iter().copied().collect());
        let act = Attribution { by: None, at: now };
        for &person_id in wanted.difference(&before) {
            let known = provisioning::find_user(&mut *tx, school_id, person_id).await?;
            let Some(known) = known else {
                let detail = format!("members: there is no user {person_id}");
                return Err(ProvisioningError::Scim(ScimError { status: 400, kind: Some("invalidValue"), detail }));
            };
            if known.role == Role::Trainee {
                let membership = Membership { school_id, cohort_id: group.id, person_id, role: Role::Trainee };
                cohorts::join_cohort(tx, membership, act).await?;
                self.note_member(tx, group.id, person_id, "cohort.joined").await?;
            }
        }
        for &person_id in before.difference(&wanted) {
            let key = MembershipKey { school_id, cohort_id: group.id, person_id };
            cohorts::leave_cohort(tx, key, act).await?;
            self.note_member(tx, group.id, person_id, "cohort.left").await?;
        }
        Ok(())
    }

    async fn note_member(&self, tx: &mut Connection, cohort: CohortId, person: PersonId, action: &str) -> Result<()> {
        AuditEntry::new(self.token.school_id, Actor::Directory, action, person)
            .with(json!({ "cohort": cohort, "token": self.token.id }))
            .append(tx, self.service.clock.now())
            .await?;
        Ok(())
    }
}
