//! What somebody is asked to prove who they are, and why it was refused.

use askama::Template;
use model::passkey::PasskeyQuestion;

use super::format;

/// What is asked for before a second factor is changed.
#[derive(Clone, Debug)]
pub struct ProofAsked {
    /// One is on: besides the password it is asked for itself.
    pub on: bool,
    /// Codes of an app are good.
    pub app: bool,
    /// What passkeys are asked.
    pub question: Option<PasskeyQuestion>,
}

impl ProofAsked {
    /// The fields of a form, and its buttons: `id` begins those of the fields.
    pub(super) fn fields(&self, id: &str, label: &str, quiet: bool) -> String {
        ProofPart { on: self.on, app: self.app, question: self.question.as_ref(), id, label, quiet }
            .render()
            .unwrap_or_default()
    }
}

/// Why nothing was changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FactorRefused {
    /// The password is wrong.
    Password,
    /// The code is wrong.
    Code,
    /// The passkey was not asked, is too late, or has answered before.
    Late,
    /// The passkey has not answered what was asked.
    Answer,
    /// The passkey has counted fewer signatures than before.
    Copied,
    /// No new passkey came of it.
    NotMade,
    /// Something else, which is said.
    Other(String),
}

impl FactorRefused {
    /// Why, in a sentence.
    #[must_use]
    pub fn said(&self) -> String {
        let fixed = match self {
            Self::Password => tr!("This is not your current password."),
            Self::Code => {
                tr!("This code is wrong, was used before, or is too old. Is the clock of your device right?")
            }
            Self::Late => tr!("The passkey has answered too late, or twice. Try it once more."),
            Self::Answer => {
                tr!("This passkey was refused: its answer does not fit what was asked of this account here.")
            }
            Self::Copied => {
                tr!(
                    "This passkey was refused: it has counted fewer signatures than before, so there may be a copy of it. Sign in by a code, and remove it."
                )
            }
            Self::NotMade => tr!("No passkey was added: the answer was too late, or does not fit what was asked."),
            Self::Other(why) => return format::as_sentence(why),
        };
        fixed.to_owned()
    }
}

#[derive(Debug, Template)]
#[template(path = "account/proof.html")]
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
        let label = tr!("{act}, by passkey", act = self.label);
        Some(AskPart { question, label: &label, lead: false, at_once: false }.html())
    }
}

/// The part of a form that asks a passkey.
#[derive(Debug, Template)]
#[template(path = "account/ask.html")]
pub(super) struct AskPart<'a> {
    /// What is asked.
    pub question: &'a PasskeyQuestion,
    /// What the button says.
    pub label: &'a str,
    /// It is what one came for.
    pub lead: bool,
    /// The browser asks without the button.
    pub at_once: bool,
}

impl AskPart<'_> {
    /// As HTML.
    pub(super) fn html(&self) -> String {
        // Rendering into a String fails for no data we can hold.
        self.render().unwrap_or_default()
    }
}
