//! Why a password is refused.

/// Why a password was not set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PasswordRefused {
    /// It is too short.
    Short,
    /// The two are not the same.
    Different,
    /// The old one is wrong.
    WrongOld,
    /// Little but common words and runs is in it.
    Common,
    /// Little but one's own name, address and school is in it.
    Own,
    /// It is the one that somebody else has set.
    Initial,
}

impl PasswordRefused {
    /// Why, in English, for the command line.
    #[must_use]
    pub const fn said(self) -> &'static str {
        match self {
            Self::Short => "too short; at least 10 characters are needed",
            Self::Different => "the two are not the same",
            Self::WrongOld => "the old one is wrong",
            Self::Common => "too common; several words that do not belong together make a good one",
            Self::Own => "made of the person's own name, address or school; choose another",
            Self::Initial => "the one that was set by somebody else; choose another",
        }
    }
}
