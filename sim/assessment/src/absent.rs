//! Reasons why a metric has no value.

use serde::{Deserialize, Deserializer, Serialize};

/// The reason why a metric has no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", from = "String")]
pub enum Absent {
    /// The tip never touched the skin.
    Untouched,
    /// The tip never went through the skin.
    NotInside,
    /// The tip went in, but did not reach this layer.
    LayerNotReached,
    /// The tip went in, but this boundary did not rupture.
    NoRupture,
    /// The needle was still moving when the recording ended.
    NeverStopped,
    /// The recording holds no energy ledger of this scene.
    NoLedger,
    /// The recording is too short to compute a speed.
    TooShort,
    /// The trainee was not given the pictures of the C-arm.
    NoFluoroscopy,
    /// No X-rays were taken.
    NoPulse,
    /// The recorded numbers do not yield a finite value.
    NotFinite,
    /// An unknown reason, stored by another version of the program.
    OfAnotherVersion,
}

impl Absent {
    /// Every reason that this version can produce.
    pub const ALL: [Self; 10] = [
        Self::Untouched,
        Self::NotInside,
        Self::LayerNotReached,
        Self::NoRupture,
        Self::NeverStopped,
        Self::NoLedger,
        Self::TooShort,
        Self::NoFluoroscopy,
        Self::NoPulse,
        Self::NotFinite,
    ];

    /// Returns the code in files, databases and the API.
    #[must_use]
    pub fn code(self) -> &'static str {
        match self {
            Self::Untouched => "untouched",
            Self::NotInside => "not_inside",
            Self::LayerNotReached => "layer_not_reached",
            Self::NoRupture => "no_rupture",
            Self::NeverStopped => "never_stopped",
            Self::NoLedger => "no_ledger",
            Self::TooShort => "too_short",
            Self::NoFluoroscopy => "no_fluoroscopy",
            Self::NoPulse => "no_pulse",
            Self::NotFinite => "not_finite",
            Self::OfAnotherVersion => "of_another_version",
        }
    }

    /// Returns the reason in words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Untouched => "the needle never reached the skin",
            Self::NotInside => "the needle never punctured the skin",
            Self::LayerNotReached => "the needle did not reach this layer",
            Self::NoRupture => "this boundary was not opened",
            Self::NeverStopped => "the needle was still moving when the recording ended",
            Self::NoLedger => "the recording contains no energy ledger",
            Self::TooShort => "the recording is too short to determine a speed",
            Self::NoFluoroscopy => "the pictures of the C-arm were not shown",
            Self::NoPulse => "no X-rays were taken",
            Self::NotFinite => "the recorded data yield no value",
            Self::OfAnotherVersion => "a reason from another version of this program",
        }
    }

    /// Parses a stored reason; `None` for an empty text. Earlier versions stored the words instead
    /// of the code.
    #[must_use]
    pub fn from_stored(text: &str) -> Option<Self> {
        let known = Self::ALL.into_iter().find(|absent| absent.code() == text || absent.words() == text);
        (!text.is_empty()).then(|| known.unwrap_or(Self::OfAnotherVersion))
    }

    /// Deserialises a field that may be empty or missing.
    ///
    /// # Errors
    /// If the value is not text.
    pub(crate) fn deserialize_field<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Self>, D::Error> {
        let text: Option<String> = Option::deserialize(deserializer)?;
        Ok(text.as_deref().and_then(Self::from_stored))
    }

    /// Returns whether the reason costs no points: a layer or boundary that was not reached did no
    /// damage to the tissue. Insufficient depth is penalised by the depth metrics.
    pub(crate) fn is_harmless(self) -> bool {
        matches!(self, Self::LayerNotReached | Self::NoRupture | Self::NoPulse)
    }
}

impl From<String> for Absent {
    fn from(stored: String) -> Self {
        Self::from_stored(&stored).unwrap_or(Self::OfAnotherVersion)
    }
}

#[cfg(test)]
mod tests {
    //! A stored reason must be read back unchanged, regardless of the version that stored it.

    use super::*;

    #[test]
    fn codes_and_the_words_of_before_mean_the_same() {
        for absent in Absent::ALL {
            assert_eq!([absent.code(), absent.words()].map(Absent::from_stored), [Some(absent); 2]);
            assert_eq!(serde_json::to_value(absent).expect("a text"), absent.code());
        }
        assert_eq!(Absent::from_stored(""), None);
        assert_eq!(Absent::from_stored("for a reason of another version"), Some(Absent::OfAnotherVersion));
    }
}
