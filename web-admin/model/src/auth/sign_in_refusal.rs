//! Reasons why a sign-in by a provider, or a launch from a learning platform, is refused.

/// Why a sign-in by a provider, or a launch from a learning platform, is refused.
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
    /// No learning platform with this issuer and client id is registered.
    Platform,
    /// The launch is another message than a link or a choice of content of LTI 1.3.
    Message,
    /// The launch leads to another host.
    Target,
    /// The launch comes from a deployment that is not admitted.
    Deployment,
    /// The launch does not name the user.
    Anonymous,
    /// The platform asks for content that this service does not have.
    Content,
}

impl SignInRefusal {
    /// Every reason.
    pub const ALL: [Self; 25] = [
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
        Self::Platform,
        Self::Message,
        Self::Target,
        Self::Deployment,
        Self::Anonymous,
        Self::Content,
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
            Self::Platform => "platform",
            Self::Message => "message",
            Self::Target => "target",
            Self::Deployment => "deployment",
            Self::Anonymous => "anonymous",
            Self::Content => "content",
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
            Self::Platform => {
                tr!(
                    "Your learning platform is not registered here. An administrator of your school compares its issuer and its client id."
                )
            }
            Self::Message => {
                tr!(
                    "Your learning platform sends a message that is not supported: only links and the choice of content of LTI 1.3 are."
                )
            }
            Self::Target => tr!("The link in your learning platform leads to another address than this service."),
            Self::Deployment => {
                tr!(
                    "Your learning platform uses this service in a new place. An administrator of your school has to admit it first; then open the link again."
                )
            }
            Self::Anonymous => {
                tr!(
                    "Your learning platform does not say who you are. Ask the teacher of the course to share the names of its members with this service."
                )
            }
            Self::Content => {
                tr!("Your learning platform asks for other content than links, and this service has only links.")
            }
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
