//! People and their roles.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use words::Language;

use crate::ids::{PersonId, SchoolId};

/// Role of a person.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema, clap::ValueEnum)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum Role {
    /// Practises; sees their own attempts.
    Trainee,
    /// Teaches cohorts; sees the attempts of their trainees.
    Instructor,
    /// Manages the school; sees all attempts.
    Administrator,
    /// Takes part in a study with a code; has no account, can only sign in at a station, and is in
    /// no list of people.
    #[value(skip)]
    Guest,
}

impl Role {
    /// Returns the word used in the database and in URLs.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Trainee => "trainee",
            Self::Instructor => "instructor",
            Self::Administrator => "administrator",
            Self::Guest => "guest",
        }
    }

    /// Returns whether the role may see and grade attempts of others.
    #[must_use]
    pub const fn teaches(self) -> bool {
        match self {
            Self::Trainee | Self::Guest => false,
            Self::Instructor | Self::Administrator => true,
        }
    }

    /// Returns the translated word shown on pages.
    #[must_use]
    pub fn said(self) -> &'static str {
        match self {
            Self::Trainee => tr!("trainee"),
            Self::Instructor => tr!("instructor"),
            Self::Administrator => tr!("administrator"),
            Self::Guest => tr!("guest"),
        }
    }
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// The role does not exist.
#[derive(Debug, thiserror::Error)]
#[error("role: \"{0}\"; allowed: trainee, instructor, administrator")]
pub struct UnknownRole(String);

impl FromStr for Role {
    type Err = UnknownRole;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        [Self::Trainee, Self::Instructor, Self::Administrator]
            .into_iter()
            .find(|role| role.as_str() == text)
            .ok_or_else(|| UnknownRole(text.to_owned()))
    }
}

/// The signed-in person, whose account is enabled at the time of the request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CurrentPerson {
    /// Id.
    pub id: PersonId,
    /// School; every query is limited to it.
    pub school_id: SchoolId,
    /// Role.
    pub role: Role,
    /// Name, for the page header; never for a log.
    pub display_name: String,
    /// Chosen language, if any.
    pub language: Option<Language>,
    /// Number of unread notices.
    pub news: u32,
    /// Version of the school's logo, if it has one.
    pub logo: Option<String>,
}

/// A person within their school.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PersonKey {
    /// School.
    pub school_id: SchoolId,
    /// Person.
    pub person_id: PersonId,
}

impl From<&CurrentPerson> for PersonKey {
    fn from(person: &CurrentPerson) -> Self {
        Self { school_id: person.school_id, person_id: person.id }
    }
}
