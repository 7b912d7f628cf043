//! What is proved of an attempt, why one may count nowhere, and what a school asks of those that certify.

use serde::Serialize;

/// Why an attempt counts nowhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, utoipa::ToSchema)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum Uncounted {
    /// The school did not give its exercise when it was made: it had never published it, or replaced it before.
    Unpublished,
    /// The same motion was brought before, under another id.
    Duplicate,
}

impl Uncounted {
    /// As the API, files and the database say it.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Unpublished => "unpublished",
            Self::Duplicate => "duplicate",
        }
    }
}

/// What is proved of an attempt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, utoipa::ToSchema)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct Proof {
    /// A paired station has signed what the hand did, and re-simulated it gives the recorded forces to the bit.
    pub signed: bool,
    /// Re-simulated, the recorded input gives the recorded forces and events to the bit.
    pub resimulated: bool,
    /// Somebody who teaches has confirmed that they were there.
    pub supervised: bool,
}

/// What a school asks to be proved of an attempt before it counts towards a certificate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "snake_case"))]
pub enum Needed {
    /// Nothing.
    Nothing,
    /// The re-simulation.
    Resimulated,
    /// A station's signature, or supervision.
    SignedOrSupervised,
    /// Supervision.
    Supervised,
}

impl Needed {
    /// Every choice, the least first.
    pub const ALL: [Self; 4] = [Self::Nothing, Self::Resimulated, Self::SignedOrSupervised, Self::Supervised];

    /// As a form says it.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::Resimulated => "resimulated",
            Self::SignedOrSupervised => "signed_or_supervised",
            Self::Supervised => "supervised",
        }
    }

    /// The choice that a form says.
    #[must_use]
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|needed| needed.word() == word)
    }

    /// Whether this is enough.
    #[must_use]
    pub const fn met_by(self, proof: Proof) -> bool {
        match self {
            Self::Nothing => true,
            Self::Resimulated => proof.resimulated,
            Self::SignedOrSupervised => proof.signed || proof.supervised,
            Self::Supervised => proof.supervised,
        }
    }
}
