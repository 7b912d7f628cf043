//! People, as a directory provisions them.

use model::ids::PersonId;
use model::people::email::{make_absent_email, present_email};
use model::people::scim::{Filter, Object, PatchRequest, ScimError, ScimUser, WantedUser};
use model::search_key::make_search_text;
use model::{PersonKey, Role, new_id};
use serde_json::json;
use store::Connection;
use store::audit::{Actor, AuditEntry};
use store::auth::tokens;
use store::people::directory::{self, Details};
use store::people::{self, NewPerson, provisioning};

use super::{DirectoryRequest, ProvisioningError, forbidden};
use crate::error::Error;

type Result<T> = std::result::Result<T, ProvisioningError>;

/// A part of a list.
#[derive(Clone, Debug)]
pub struct Listed {
    /// Number of all matching resources.
    pub total: u32,
    /// The resources of this part.
    pub resources: Vec<Object>,
}

/// Maximum number of people that a filter without a unique attribute searches.
const MOST_SEARCHED: u32 = 100_000;

impl DirectoryRequest<'_> {
    const fn key(&self, person_id: PersonId) -> PersonKey {
        PersonKey { school_id: self.token.school_id, person_id }
    }

    /// Returns a person.
    ///
    /// # Errors
    /// Fails if the directory does not see them, or the database fails.
    pub async fn show_user(&self, id: PersonId) -> Result<Object> {
        let found = provisioning::find_user(self.service.db.reader(), self.token.school_id, id).await?;
        Ok(found.ok_or(Error::NotFound)?.to_json(self.address))
    }

    /// Returns the people that match a filter.
    ///
    /// # Errors
    /// Fails if the database fails.
    pub async fn list_users(&self, filter: Option<&Filter>, offset: u32, limit: u32) -> Result<Listed> {
        let (reader, school) = (self.service.db.reader(), self.token.school_id);
        let Some(filter) = filter else {
            let total = provisioning::count_users(reader, school).await?;
            let users = provisioning::list_users(reader, school, offset, limit).await?;
            return Ok(Listed { total, resources: users.iter().map(|user| user.to_json(self.address)).collect() });
        };
        let id = filter.text_of("id").map(str::parse);
        let found = match (filter.text_of("userName"), filter.text_of("externalId"), id) {
            (Some(name), _, _) => provisioning::list_users_by_name(reader, school, name).await?,
            (None, Some(number), _) => {
                provisioning::find_user_by_number(reader, school, number).await?.into_iter().collect()
            }
            (None, None, Some(Ok(id))) => provisioning::find_user(reader, school, id).await?.into_iter().collect(),
            (None, None, Some(Err(_))) => Vec::new(),
            (None, None, None) => provisioning::list_users(reader, school, 0, MOST_SEARCHED).await?,
        };
        let mut resources: Vec<Object> = found.iter().map(|user| user.to_json(self.address)).collect();
        resources.retain(|fields| filter.matches(fields));
        Ok(Listed::of(resources, offset, limit))
    }

    /// Creates a trainee, or admits one again whom the directory had deleted.
    ///
    /// # Errors
    /// Fails if an attribute is invalid or taken, or the database fails.
    pub async fn create_user(&self, fields: &Object) -> Result<Object> {
        let wanted = WantedUser::read(fields, None).map_err(ProvisioningError::of)?;
        let (school_id, now) = (self.token.school_id, self.service.clock.now());
        let mut tx = self.service.db.write().await?;
        let id = match provisioning::find_deleted_user(&mut *tx, school_id, &wanted.user_name).await? {
            Some(known) => known,
            None => {
                let email = wanted.email.clone().unwrap_or_else(|| make_absent_email(new_id(now)));
                if people::find_member_by_email(&mut *tx, school_id, &email).await?.is_some() {
                    return Err(ProvisioningError::Scim(ScimError::taken("emails: an account has this address")));
                }
                let new = NewPerson {
                    school_id,
                    role: Role::Trainee,
                    email: &email,
                    display_name: &wanted.display_name,
                    password_hash: "",
                };
                let person = people::add_person(&mut tx, &new, now).await?;
                AuditEntry::new(school_id, Actor::Directory, "person.added", person.id)
                    .with(json!({ "role": Role::Trainee, "token": self.token.id }))
                    .append(&mut tx, now)
                    .await?;
                person.id
            }
        };
        self.settle(&mut tx, id, &wanted).await?;
        let made = self.read(&mut tx, id).await?;
        tx.commit().await?;
        Ok(made.to_json(self.address))
    }

    /// Replaces what the directory may change of a person.
    ///
    /// # Errors
    /// Fails if the directory does not see them, an attribute is invalid or taken, or the database
    /// fails.
    pub async fn replace_user(&self, id: PersonId, fields: &Object) -> Result<Object> {
        self.change(id, |_| Ok(fields.clone())).await
    }

    /// Changes a person by a patch.
    ///
    /// # Errors
    /// As [`DirectoryRequest::replace_user`].
    pub async fn patch_user(&self, id: PersonId, patch: PatchRequest) -> Result<Object> {
        self.change(id, |mut fields| patch.apply(&mut fields).map(|()| fields)).await
    }

    async fn change(
        &self,
        id: PersonId,
        change: impl FnOnce(Object) -> std::result::Result<Object, ScimError> + Send,
    ) -> Result<Object> {
        let mut tx = self.service.db.write().await?;
        let before = self.read(&mut tx, id).await?;
        let fields = before.to_json(self.address);
        self.check_version(&fields)?;
        let fields = change(fields).map_err(ProvisioningError::of)?;
        let wanted = WantedUser::read(&fields, Some(&before)).map_err(ProvisioningError::of)?;
        self.settle(&mut tx, id, &wanted).await?;
        let after = self.read(&mut tx, id).await?;
        tx.commit().await?;
        Ok(after.to_json(self.address))
    }

    /// Disables a person and hides them from the directory.
    ///
    /// # Errors
    /// Fails if the directory does not see them or may not disable them, or the database fails.
    pub async fn delete_user(&self, id: PersonId) -> Result<()> {
        let mut tx = self.service.db.write().await?;
        let known = self.read(&mut tx, id).await?;
        self.check_version(&known.to_json(self.address))?;
        self.set_active(&mut tx, &known, false).await?;
        provisioning::hide_user(&mut tx, self.key(id), &known.user_name, self.service.clock.now()).await?;
        Ok(tx.commit().await?)
    }

    async fn read(&self, tx: &mut Connection, id: PersonId) -> Result<ScimUser> {
        Ok(provisioning::find_user(tx, self.token.school_id, id).await?.ok_or(Error::NotFound)?)
    }

    /// Makes a person what the directory wants.
    async fn settle(&self, tx: &mut Connection, id: PersonId, wanted: &WantedUser) -> Result<()> {
        let (school_id, now) = (self.token.school_id, self.service.clock.now());
        if !provisioning::put_user_name(tx, self.key(id), &wanted.user_name).await? {
            return Err(ProvisioningError::Scim(ScimError::taken("userName: another user has it")));
        }
        let before = self.read(tx, id).await?;
        let email = match (&wanted.email, present_email(&before.email)) {
            (Some(email), _) => email.clone(),
            (None, None) => before.email.clone(),
            (None, Some(_)) => make_absent_email(new_id(now)),
        };
        let holder = people::find_member_by_email(&mut *tx, school_id, &email).await?;
        if holder.is_some_and(|holder| holder.id != id) {
            return Err(ProvisioningError::Scim(ScimError::taken("emails: an account has this address")));
        }
        if let Some(number) = &wanted.external_id
            && directory::find_number_holder(&mut *tx, school_id, number).await?.is_some_and(|holder| holder != id)
        {
            return Err(ProvisioningError::Scim(ScimError::taken("externalId: another user has it")));
        }
        let is_changed = (&before.display_name, &before.email, &before.external_id)
            != (&wanted.display_name, &email, &wanted.external_id);
        if is_changed {
            let details = Details { name: &wanted.display_name, email: &email, registrar_id: None };
            directory::change_details(tx, school_id, id, details).await?;
            let number = wanted.external_id.as_deref();
            let search = make_search_text(&wanted.display_name, present_email(&email).unwrap_or_default(), number);
            provisioning::change_user(tx, self.key(id), number, &search).await?;
            AuditEntry::new(school_id, Actor::Directory, "person.changed", id)
                .with(json!({
                    "name": before.display_name != wanted.display_name,
                    "email": before.email != email,
                    "number": before.external_id != wanted.external_id,
                    "token": self.token.id,
                }))
                .append(tx, now)
                .await?;
        }
        self.set_active(tx, &before, wanted.active).await
    }

    async fn set_active(&self, tx: &mut Connection, known: &ScimUser, active: bool) -> Result<()> {
        let (school_id, now) = (self.token.school_id, self.service.clock.now());
        if active == known.disabled_at.is_none() {
            return Ok(());
        }
        let action = if active {
            directory::enable_account(tx, school_id, known.id).await?;
            "person.enabled"
        } else {
            if known.role.teaches() && !self.token.may_disable_staff {
                return Err(forbidden("this token may not disable people who teach or administer"));
            }
            let is_last = known.role == Role::Administrator
                && provisioning::count_administrators(&mut *tx, school_id).await? <= 1;
            if is_last {
                return Err(forbidden("this is the school's last administrator"));
            }
            people::disable_person(tx, known.id, now).await?;
            tokens::revoke_all_tokens(tx, known.id, now).await?;
            "person.disabled"
        };
        let entry = AuditEntry::new(school_id, Actor::Directory, action, known.id);
        Ok(entry.with(json!({ "token": self.token.id })).append(tx, now).await?)
    }
}

impl Listed {
    /// Returns a part of all matching resources.
    pub(super) fn of(all: Vec<Object>, offset: u32, limit: u32) -> Self {
        let total = all.len() as u32;
        let resources = all.into_iter().skip(offset as usize).take(limit as usize).collect();
        Self { total, resources }
    }
}
