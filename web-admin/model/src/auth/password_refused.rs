//! Reasons for refusing a password.

/// Reason why a password was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PasswordRefused {
    /// It is too short.
    Short,
    /// The two entered passwords differ.
    Different,
    /// The old password is wrong.
    WrongOld,
    /// The person has no old password, and has not signed in at their school again instead.
    Unproved,
    /// It consists mostly of common words and sequences.
    Common,
    /// It consists mostly of the person's own name, email address and school.
    Own,
    /// It is the initial password set by another person.
    Initial,
}

impl PasswordRefused {
    /// Returns the reason in English, for the command line.
    #[must_use]
    pub const fn said(self) -> &'static str {
        match self {
            Self::Short => "too short; at least 10 characters are needed",
            Self::Different => "the two passwords do not match",
            Self::WrongOld => "the old password is wrong",
            Self::Unproved => "sign in at your school again first",
            Self::Common => "too common; use several unrelated words",
            Self::Own => "contains little more than the person's name, address or school; choose another",
            Self::Initial => "the password that was created for the person; choose another",
        }
    }
}
