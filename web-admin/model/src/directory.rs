//! The people of a school as lists show them.

use crate::Role;
use crate::ids::PersonId;

/// How an account stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(rename_all = "lowercase"))]
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
