//! Reauthentication: proof of identity before a second factor is changed, and the reasons why it is
//! refused.

use askama::Template;
use model::auth::passkey::PasskeyQuestion;

use crate::format;

/// Proof required before a second factor is changed.
#[derive(Clone, Debug)]
pub struct ProofAsked {
    /// How the user proves the first factor.
    pub own_password: OwnPassword,
    /// Whether a second factor is set up and required in addition to the password.
    pub on: bool,
    /// Whether codes of an authenticator app are accepted.
    pub app: bool,
    /// The WebAuthn challenge for passkeys.
    pub question: Option<PasskeyQuestion>,
}

/// How users prove who they are before a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OwnPassword {
    /// They have a password, and enter it.
    Known,
    /// They have no password, and have confirmed themselves at their school's sign-in just now.
    Proved,
    /// They have no password, and must confirm themselves there first.
    Unproved,
}

impl OwnPassword {
    /// Renders the field of a form; `id` is the field's id, `page` the path of the form's page.
    pub(crate) fn field(self, id: &str, page: &str) -> String {
        // Rendering this template into a `String` cannot fail.
        OwnPasswordField { own: self, id, page }.render().unwrap_or_default()
    }
}

#[derive(Debug, Template)]
#[template(path = "auth/own_password.html")]
struct OwnPasswordField<'a> {
    own: OwnPassword,
    id: &'a str,
    page: &'a str,
}

impl ProofAsked {
    /// Renders the field of the password; `id` is its id.
    pub(crate) fn password_field(&self, id: &str) -> String {
        self.own_password.field(id, "/account/second-factor")
    }

    /// Renders the fields and buttons of a form; `id` is the prefix of the fields' ids.
    pub(crate) fn fields(&self, id: &str, label: &str, quiet: bool) -> String {
        ProofPart { on: self.on, app: self.app, question: self.question.as_ref(), id, label, quiet }
            .render()
            .unwrap_or_default()
    }
}

/// Reasons why a change was refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FactorRefused {
    /// The password is wrong.
    Password,
    /// The code is wrong.
    Code,
    /// The WebAuthn challenge is missing, expired or already used.
    Late,
    /// The passkey's response does not match the challenge.
    Answer,
    /// The passkey's signature counter went backwards, which suggests a copy.
    Copied,
    /// No passkey was created.
    NotMade,
    /// Another reason, as text.
    Other(String),
}

impl FactorRefused {
    /// Describes the reason in a sentence.
    #[must_use]
    pub fn said(&self) -> String {
        let fixed = match self {
            Self::Password => tr!("This is not your current password."),
            Self::Code => {
                tr!("This code is wrong, already used or expired. Check the clock of your device.")
            }
            Self::Late => tr!("The passkey responded too late or twice. Try again."),
            Self::Answer => {
                tr!("This passkey was rejected: its response does not match this account.")
            }
            Self::Copied => {
                tr!(
                    "This passkey was rejected: its signature counter went backwards, so a copy may exist. Sign in with a code, and remove the passkey."
                )
            }
            Self::NotMade => tr!("No passkey was added: the response was too late or did not match the request."),
            Self::Other(why) => return format::as_sentence(why),
        };
        fixed.to_owned()
    }
}

#[derive(Debug, Template)]
#[template(path = "auth/proof.html")]
struct ProofPart<'a> {
    on: bool,
    app: bool,
    question: Option<&'a PasskeyQuestion>,
    id: &'a str,
    label: &'a str,
    quiet: bool,
}

impl ProofPart<'_> {
    fn ask(&self) -> Option<String> {
        let question = self.question?;
        let label = tr!("{act}, with a passkey", act = self.label);
        Some(ReauthenticationForm { question, label: &label, lead: false, at_once: false }.html())
    }
}

/// The part of a form that prompts for a passkey.
#[derive(Debug, Template)]
#[template(path = "auth/ask.html")]
pub(crate) struct ReauthenticationForm<'a> {
    /// The WebAuthn challenge.
    pub question: &'a PasskeyQuestion,
    /// Label of the button.
    pub label: &'a str,
    /// Whether it is the main action of the page.
    pub lead: bool,
    /// Whether the browser prompts without the button.
    pub at_once: bool,
}

impl ReauthenticationForm<'_> {
    /// Renders the prompt as HTML.
    pub(crate) fn html(&self) -> String {
        // Rendering this template into a `String` cannot fail.
        self.render().unwrap_or_default()
    }
}
