//! Passkeys: what a browser is to ask of them, one's own, and a new one.

use askama::Template;
use askama_web::WebTemplate;
use model::limits::LONGEST_NAME;
use model::passkey::PasskeyQuestion;
use time::OffsetDateTime;

use super::{Shell, assets, format};
use crate::proving::{AskPart, FactorRefused, ProofAsked};

/// The address of the script that asks passkeys.
#[must_use]
pub fn passkey_script() -> String {
    assets::asset_address("passkey.js")
}

/// A passkey of a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PasskeyRow {
    /// What it is called.
    pub name: String,
    /// When it was added.
    pub made: OffsetDateTime,
    /// When it was last used.
    pub used: Option<OffsetDateTime>,
    /// Where it is renamed and removed.
    pub href: String,
}

impl PasskeyRow {
    /// When it was added and last used.
    #[must_use]
    pub fn said(&self) -> String {
        let made = format::format_date(self.made);
        match self.used {
            Some(used) => tr!("added {made}, last used {used}", made = made, used = format::format_date_time(used)),
            None => tr!("added {made}, not used since", made = made),
        }
    }
}

/// One of one's own passkeys.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "account/passkey.html")]
pub struct PasskeyPage {
    /// Frame.
    pub shell: Shell,
    /// The passkey.
    pub row: PasskeyRow,
    /// There is no other second factor.
    pub last: bool,
    /// The school asks for a second factor.
    pub asked: bool,
    /// What is asked for before it is removed.
    pub proof: ProofAsked,
    /// Why nothing was changed.
    pub refused: Option<FactorRefused>,
}

impl PasskeyPage {
    fn script(&self) -> String {
        passkey_script()
    }
}

/// Where a browser makes a new passkey.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "account/make_passkey.html")]
pub struct MakePasskeyPage {
    /// Frame.
    pub shell: Shell,
    /// What the browser is told.
    pub question: PasskeyQuestion,
}

impl MakePasskeyPage {
    fn ask(&self) -> String {
        AskPart { question: &self.question, label: tr!("Make the passkey"), lead: true, at_once: true }.html()
    }

    fn script(&self) -> String {
        passkey_script()
    }
}

#[cfg(test)]
pub(super) mod samples {
    //! Passkeys for the pages' own tests.

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
    //! A page whose script is told half of what it needs asks nothing.

    use model::Role;

    use super::samples::{question, row};
    use super::*;
    use crate::samples::{keep_page, shell};

    fn page(last: bool, asked: bool) -> PasskeyPage {
        let proof = ProofAsked { on: true, app: false, question: Some(question()) };
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
        assert!(html.contains("signs you in no more") && !html.contains(" data-at-once"), "{html}");
        assert!(keep_page("passkey-last", &page(true, false)).contains("password alone"));
        assert!(keep_page("passkey-asked", &page(true, true)).contains("make another before anything else"));
    }
}
