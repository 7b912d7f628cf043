//! The people of a school as lists show them.

use crate::Role;
use crate::folding::fold_text;
use crate::ids::PersonId;

/// How an account stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
#[serde(rename_all = "lowercase")]
pub enum AccountState {
    /// Can sign in.
    Active,
    /// Has no password yet.
    Invited,
    /// May not sign in.
    Disabled,
    /// Nothing tells who it was.
    Erased,
}

/// By what people are sorted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PeopleKey {
    /// Name, without marks and case.
    #[default]
    Name,
    /// Address.
    Email,
    /// The registrar's number; whoever has none comes first.
    Number,
}

/// How people are sorted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PeopleOrder {
    /// By what.
    pub by: PeopleKey,
    /// From the end.
    pub down: bool,
}

impl PeopleOrder {
    /// What somebody is sorted by.
    #[must_use]
    pub fn key_of(self, person: &DirectoryEntry) -> String {
        match self.by {
            PeopleKey::Name => fold_text(&person.name),
            PeopleKey::Email => person.email.clone(),
            PeopleKey::Number => person.registrar_id.clone().unwrap_or_default(),
        }
    }
}

/// What is done to many people at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BulkAct {
    /// Their invitation is sent again.
    Invite,
    /// They join a cohort.
    Join,
    /// They are taken out of a cohort.
    Leave,
    /// They may not sign in.
    Disable,
    /// They may sign in again.
    Enable,
}

/// Why somebody is left out when something is done to many.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BulkExemption {
    /// Nobody disables themselves.
    Themselves,
    /// They have chosen a password already.
    SignedUp,
    /// Their account is disabled.
    Disabled,
    /// It is not.
    Enabled,
    /// Nothing tells any more who they were.
    Anonymous,
    /// An administrator is in no cohort.
    Administrator,
    /// They are in the cohort.
    Member,
    /// They are not.
    Stranger,
}

impl BulkAct {
    /// Whether it is about a cohort.
    #[must_use]
    pub const fn needs_cohort(self) -> bool {
        matches!(self, Self::Join | Self::Leave)
    }

    /// Why it is not done to somebody, who is or is not in the cohort that it is about and may be whoever does it.
    #[must_use]
    pub fn exempts(self, person: &DirectoryEntry, is_member: bool, by: PersonId) -> Option<BulkExemption> {
        let (state, of_state) = (person.state, |state, why| (person.state == state).then_some(why));
        if state == AccountState::Erased {
            return Some(BulkExemption::Anonymous);
        }
        match self {
            Self::Invite => of_state(AccountState::Active, BulkExemption::SignedUp)
                .or(of_state(AccountState::Disabled, BulkExemption::Disabled)),
            Self::Join if person.role == Role::Administrator => Some(BulkExemption::Administrator),
            Self::Join => is_member.then_some(BulkExemption::Member),
            Self::Leave => (!is_member).then_some(BulkExemption::Stranger),
            Self::Disable if person.id == by => Some(BulkExemption::Themselves),
            Self::Disable => of_state(AccountState::Disabled, BulkExemption::Disabled),
            Self::Enable => (state != AccountState::Disabled).then_some(BulkExemption::Enabled),
        }
    }
}

/// Somebody to whom something is not done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExemptPerson {
    /// Who.
    pub person: DirectoryEntry,
    /// Why.
    pub why: BulkExemption,
}

/// To whom something is done, and to whom it is not.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BulkPlan {
    /// Those to whom it is done.
    pub people: Vec<DirectoryEntry>,
    /// Those who are left out.
    pub exempt: Vec<ExemptPerson>,
}

/// A person in a list, or on their own page.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct DirectoryEntry {
    /// Id.
    pub id: PersonId,
    /// Name.
    pub name: String,
    /// Address.
    pub email: String,
    /// Role.
    pub role: Role,
    /// State of the account.
    pub state: AccountState,
    /// What recordings say instead of a name.
    pub pseudonym: String,
    /// What the registrar knows them by.
    pub registrar_id: Option<String>,
    /// Names of their cohorts.
    pub cohorts: String,
}
