//! Directory of a school's people.

use crate::Role;
use crate::ids::PersonId;
use crate::search_key::fold_text;

/// State of an account.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
#[serde(rename_all = "lowercase")]
pub enum AccountState {
    /// The person can sign in.
    Active,
    /// The person has not set a password yet.
    Invited,
    /// The person cannot sign in.
    Disabled,
    /// The personal data were erased.
    Erased,
}

/// Sort key of people.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PeopleKey {
    /// Name, without diacritics and case.
    #[default]
    Name,
    /// Email address.
    Email,
    /// Registration number; people without one come first.
    Number,
}

/// Sort order of people.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PeopleOrder {
    /// Sort key.
    pub by: PeopleKey,
    /// Descending.
    pub down: bool,
}

impl PeopleOrder {
    /// Returns the sort key of a person.
    #[must_use]
    pub fn key_of(self, person: &DirectoryEntry) -> String {
        match self.by {
            PeopleKey::Name => fold_text(&person.name),
            PeopleKey::Email => person.email.clone(),
            PeopleKey::Number => person.registrar_id.clone().unwrap_or_default(),
        }
    }
}

/// An action on several people at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BulkAct {
    /// Send the invitation again.
    Invite,
    /// Add them to a cohort.
    Join,
    /// Remove them from a cohort.
    Leave,
    /// Disable their accounts.
    Disable,
    /// Enable their accounts.
    Enable,
}

/// Reason why a person is left out of a bulk action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BulkExemption {
    /// People cannot disable themselves.
    Themselves,
    /// The person has already set a password.
    SignedUp,
    /// The account is disabled.
    Disabled,
    /// The account is not disabled.
    Enabled,
    /// The personal data were erased.
    Anonymous,
    /// Administrators cannot be in a cohort.
    Administrator,
    /// The person is already in the cohort.
    Member,
    /// The person is not in the cohort.
    Stranger,
}

impl BulkAct {
    /// Returns whether the action concerns a cohort.
    #[must_use]
    pub const fn needs_cohort(self) -> bool {
        matches!(self, Self::Join | Self::Leave)
    }

    /// Returns the reason for leaving a person out, if there is one. `is_member` is their
    /// membership of the cohort, `by` the person who performs the action.
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

/// A person left out of a bulk action.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExemptPerson {
    /// The person.
    pub person: DirectoryEntry,
    /// Reason.
    pub why: BulkExemption,
}

/// Preview of a bulk action.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BulkPlan {
    /// People to whom it applies.
    pub people: Vec<DirectoryEntry>,
    /// People who are left out.
    pub exempt: Vec<ExemptPerson>,
}

/// A person in a list or on their own page.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct DirectoryEntry {
    /// Id.
    pub id: PersonId,
    /// Name.
    pub name: String,
    /// Email address.
    pub email: String,
    /// Role.
    pub role: Role,
    /// State of the account.
    pub state: AccountState,
    /// Pseudonym, used in recordings.
    pub pseudonym: String,
    /// Registration number.
    pub registrar_id: Option<String>,
    /// Names of the cohorts, separated by commas.
    pub cohorts: String,
}
