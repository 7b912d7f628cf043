//! Proofs of attempts, reasons why attempts do not count, and the proof that a school requires for
//! certificates.

use serde::Serialize;

/// Reason why an attempt does not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, utoipa::ToSchema)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum Uncounted {
    /// The school did not offer the exercise at the time of the attempt: it had never published
    /// this revision, or had already replaced it.
    Unpublished,
    /// An earlier upload under another id contains the same motion.
    Duplicate,
}

impl Uncounted {
    /// Returns the word used in the API, in files and in the database.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Unpublished => "unpublished",
            Self::Duplicate => "duplicate",
        }
    }
}

/// Proofs of an attempt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, utoipa::ToSchema)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct Proof {
    /// A paired station has signed the recorded input, and its re-simulation reproduces the
    /// recorded forces exactly.
    pub signed: bool,
    /// The re-simulation of the recorded input reproduces the recorded forces and events exactly.
    pub resimulated: bool,
    /// An instructor or administrator has confirmed that they supervised the attempt.
    pub supervised: bool,
}

/// Proof that a school requires before an attempt counts towards a certificate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "snake_case"))]
pub enum Needed {
    /// None.
    Nothing,
    /// Re-simulation.
    Resimulated,
    /// Signature of a station, or supervision.
    SignedOrSupervised,
    /// Supervision.
    Supervised,
}

impl Needed {
    /// All values, weakest first.
    pub const ALL: [Self; 4] = [Self::Nothing, Self::Resimulated, Self::SignedOrSupervised, Self::Supervised];

    /// Returns the word used in forms.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::Resimulated => "resimulated",
            Self::SignedOrSupervised => "signed_or_supervised",
            Self::Supervised => "supervised",
        }
    }

    /// Returns the value for a word used in forms.
    #[must_use]
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|needed| needed.word() == word)
    }

    /// Returns whether a proof is sufficient.
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
