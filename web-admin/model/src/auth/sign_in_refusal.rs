//! Reasons why a sign-in by a provider is refused.

/// Why a sign-in by a provider is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SignInRefusal {
    /// The sign-in was not begun in this browser, was used already, or has expired.
    NoFlow,
    /// The user or the provider has cancelled.
    Denied,
    /// The provider refused the authorization code.
    Code,
    /// The provider does not answer, or not as it should.
    Unreachable,
    /// An answer cannot be parsed.
    Malformed,
    /// The token names another issuer.
    Issuer,
    /// The token is for another client.
    Audience,
    /// The token belongs to another sign-in.
    Nonce,
    /// The token is signed by an algorithm that is not accepted.
    Algorithm,
    /// The token is signed with a key that the provider does not publish.
    Key,
    /// The signature does not match.
    Signature,
    /// The token has expired.
    Expired,
    /// The token is from the future.
    FromTheFuture,
    /// The token was issued too long ago.
    TooOld,
    /// The token names nobody.
    Subject,
    /// The user information is about somebody else.
    UserInfo,
    /// The access token does not match the ID token.
    AccessToken,
    /// The user has not signed in anew.
    NotAnew,
    /// The account here, or the provider, is disabled.
    Disabled,
}

impl SignInRefusal {
    /// Every reason.
    pub const ALL: [Self; 19] = [
        Self::NoFlow,
        Self::Denied,
        Self::Code,
        Self::Unreachable,
        Self::Malformed,
        Self::Issuer,
        Self::Audience,
        Self::Nonce,
        Self::Algorithm,
        Self::Key,
        Self::Signature,
        Self::Expired,
        Self::FromTheFuture,
        Self::TooOld,
        Self::Subject,
        Self::UserInfo,
        Self::AccessToken,
        Self::NotAnew,
        Self::Disabled,
    ];

    /// Returns the code used in the audit log and on the page.
    #[must_use]
    pub const fn code(self) -> &'static str {
        match self {
            Self::NoFlow => "no_flow",
            Self::Denied => "denied",
            Self::Code => "code",
            Self::Unreachable => "unreachable",
            Self::Malformed => "malformed",
            Self::Issuer => "issuer",
            Self::Audience => "audience",
            Self::Nonce => "nonce",
            Self::Algorithm => "algorithm",
            Self::Key => "key",
            Self::Signature => "signature",
            Self::Expired => "expired",
            Self::FromTheFuture => "from_the_future",
            Self::TooOld => "too_old",
            Self::Subject => "subject",
            Self::UserInfo => "userinfo",
            Self::AccessToken => "access_token",
            Self::NotAnew => "not_anew",
            Self::Disabled => "disabled",
        }
    }

    /// Explains the reason to the user in a sentence.
    #[must_use]
    pub fn said(self) -> &'static str {
        match self {
            Self::NoFlow => {
                tr!("This sign-in was begun in another browser, took longer than ten minutes, or was already used.")
            }
            Self::Denied => tr!("The sign-in was cancelled, or your school’s system did not allow it."),
            Self::Unreachable => tr!("Your school’s sign-in does not answer right now. Try again in a few minutes."),
            Self::Expired | Self::FromTheFuture | Self::TooOld => {
                tr!(
                    "The confirmation from your school’s system was issued at another time: one of the two clocks is wrong."
                )
            }
            Self::NotAnew => {
                tr!(
                    "Your school’s system has not asked you to sign in again, so this does not prove who is at the keyboard."
                )
            }
            Self::Disabled => tr!("This account, or this way to sign in, is disabled."),
            Self::Code
            | Self::Malformed
            | Self::Issuer
            | Self::Audience
            | Self::Nonce
            | Self::Algorithm
            | Self::Key
            | Self::Signature
            | Self::Subject
            | Self::UserInfo
            | Self::AccessToken => tr!("The confirmation from your school’s system could not be verified."),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::SignInRefusal;

    #[test]
    fn each_reason_has_a_code_of_its_own() {
        let codes: BTreeSet<&str> = SignInRefusal::ALL.map(SignInRefusal::code).into();
        assert_eq!(codes.len(), SignInRefusal::ALL.len());
    }
}
