//! Passkeys: the prompt in the browser, the user's passkeys, and the creation of a new one.

use askama::Template;
use askama_web::WebTemplate;
use model::auth::passkey::PasskeyQuestion;
use model::limits::LONGEST_NAME;
use time::OffsetDateTime;

use crate::auth::reauthentication::{FactorRefused, ProofAsked, ReauthenticationForm};
use crate::{Shell, assets, format};

/// Returns the address of the script that prompts for passkeys.
#[must_use]
pub fn passkey_script() -> String {
    assets::asset_address("passkey.js")
}

/// A passkey in a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PasskeyRow {
    /// Name given by the user.
    pub name: String,
    /// Time of creation.
    pub made: OffsetDateTime,
    /// Time of last use.
    pub used: Option<OffsetDateTime>,
    /// Address that renames and removes it.
    pub href: String,
}

impl PasskeyRow {
    /// Describes when it was added and last used.
    #[must_use]
    pub fn said(&self) -> String {
        let made = format::format_date(self.made);
        match self.used {
            Some(used) => tr!("added {made}, last used {used}", made = made, used = format::format_date_time(used)),
            None => tr!("added {made}, never used", made = made),
        }
    }
}

/// The page of one of the user's passkeys.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/passkey.html")]
pub struct PasskeyPage {
    /// Page frame.
    pub shell: Shell,
    /// The passkey.
    pub row: PasskeyRow,
    /// Whether it is the user's only second factor.
    pub last: bool,
    /// Whether the school requires a second factor.
    pub asked: bool,
    /// Reauthentication required before removal.
    pub proof: ProofAsked,
    /// Why the change was refused.
    pub refused: Option<FactorRefused>,
}

impl PasskeyPage {
    fn script(&self) -> String {
        passkey_script()
    }
}

/// The page on which the browser creates a new passkey.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/make_passkey.html")]
pub struct MakePasskeyPage {
    /// Page frame.
    pub shell: Shell,
    /// The WebAuthn challenge.
    pub question: PasskeyQuestion,
}

impl MakePasskeyPage {
    fn ask(&self) -> String {
        ReauthenticationForm { question: &self.question, label: tr!("Create the passkey"), lead: true, at_once: true }
            .html()
    }

    fn script(&self) -> String {
        passkey_script()
    }
}

#[cfg(test)]
pub(crate) mod samples {
    //! Sample passkeys for tests.

    use model::ids::CeremonyId;

    use super::*;
    use crate::samples::NOW;

    pub(crate) fn question() -> PasskeyQuestion {
        let options = "{\"publicKey\":{\"challenge\":\"AAAA\",\"rpId\":\"localhost\"}}".to_owned();
        PasskeyQuestion { id: CeremonyId::nil(), options, origin: "http://localhost:8080".to_owned() }
    }

    pub(crate) fn row(name: &str, used: bool) -> PasskeyRow {
        let href = "/account/second-factor/passkeys/1".to_owned();
        PasskeyRow { name: name.to_owned(), made: NOW, used: used.then_some(NOW), href }
    }
}

#[cfg(test)]
mod tests {
    //! A page must contain everything that its script needs.

    use model::Role;

    use super::samples::{question, row};
    use super::*;
    use crate::auth::reauthentication::OwnPassword;
    use crate::samples::{keep_page, shell};

    fn page(last: bool, asked: bool) -> PasskeyPage {
        let proof = ProofAsked { own_password: OwnPassword::Known, on: true, app: false, question: Some(question()) };
        PasskeyPage { shell: shell(Role::Trainee), row: row("Phone", true), last, asked, proof, refused: None }
    }

    #[test]
    fn a_new_one_is_asked_for_at_once() {
        let html = keep_page("passkey-new", &MakePasskeyPage { shell: shell(Role::Trainee), question: question() });
        assert!(html.contains("&#34;challenge&#34;") && html.contains(" data-at-once"), "{html}");
        for words in ["absent", "elsewhere", "waiting", "cancelled", "known", "failed"] {
            assert!(html.contains(&format!(" data-{words}=\"")), "{words} in {html}");
        }
    }

    #[test]
    fn removing_the_last_one_says_what_follows() {
        let html = keep_page("passkey", &page(false, false));
        assert!(html.contains("can no longer sign in with it") && !html.contains(" data-at-once"), "{html}");
        assert!(keep_page("passkey-last", &page(true, false)).contains("password only"));
        assert!(keep_page("passkey-asked", &page(true, true)).contains("must set up a new one"));
    }
}
