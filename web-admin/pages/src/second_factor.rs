//! One's own second factor: made, confirmed, turned off; recovery codes, shown once.

use askama::Template;
use askama_web::WebTemplate;
use model::limits::LONGEST_NAME;
use time::OffsetDateTime;

use super::form::FilledForm;
use super::passkeys::PasskeyRow;
use super::{Shell, StatusWord, format, passkeys};
use crate::proving::{FactorRefused, ProofAsked};

/// Below this many recovery codes new ones are called for.
const FEW_CODES: i64 = 3;

/// How the codes of an app stand.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FactorState {
    /// There is no app.
    Off,
    /// A secret is offered, and a code of it asked for.
    Offered {
        /// The secret, to be typed.
        secret: String,
        /// The address that an app on this device opens.
        address: String,
    },
    /// A code is good when signing in.
    On {
        /// Since when.
        since: OffsetDateTime,
    },
}

/// The page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "account/second_factor.html")]
pub struct SecondFactorPage {
    /// Frame.
    pub shell: Shell,
    /// How the codes of an app stand.
    pub factor: FactorState,
    /// Passkeys, the oldest first.
    pub passkeys: Vec<PasskeyRow>,
    /// Recovery codes that are left; none where no second factor is on.
    pub codes_left: Option<i64>,
    /// What is asked for before anything is changed.
    pub proof: ProofAsked,
    /// Browsers have passkeys for this service.
    pub can_add: bool,
    /// The name of a new passkey, and why nothing was changed.
    pub form: FilledForm<String, FactorRefused>,
    /// The school asks for a second factor.
    pub asked: bool,
    /// Nothing else may be done before one is on.
    pub owed: bool,
}

impl SecondFactorPage {
    /// How many recovery codes are left, marked where they are few.
    fn left(&self, codes: &i64) -> String {
        let words = trn!("{n} recovery code left", "{n} recovery codes left", *codes);
        if *codes < FEW_CODES { StatusWord::Help.badge_saying(&words) } else { words }
    }

    /// The script that asks passkeys.
    fn script(&self) -> String {
        passkeys::passkey_script()
    }
}

/// Recovery codes, shown this once.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "account/recovery_codes.html")]
pub struct RecoveryCodesPage {
    /// Frame.
    pub shell: Shell,
    /// The codes.
    pub codes: Vec<String>,
    /// The second factor was turned on just now.
    pub first: bool,
}

#[cfg(test)]
mod tests {
    //! Fails when a secret is shown longer than it must be, or nobody is told what to do next.

    use model::Role;

    use super::*;
    use crate::passkeys::samples::{question, row};
    use crate::{NavPlace, samples};

    fn page(factor: FactorState, owed: bool) -> SecondFactorPage {
        let place = if owed { NavPlace::Enrolment } else { NavPlace::Account };
        let shell = Shell { place, ..samples::shell(Role::Instructor) };
        SecondFactorPage {
            shell,
            factor,
            passkeys: Vec::new(),
            codes_left: None,
            proof: ProofAsked { on: false, app: false, question: None },
            can_add: true,
            form: FilledForm::refused(String::new(), FactorRefused::Code),
            asked: owed,
            owed,
        }
    }

    #[test]
    fn each_state_says_what_to_do() {
        let off = samples::keep_page("second-factor-off", &page(FactorState::Off, true));
        assert!(off.contains("before you go on") && !off.contains("href=\"/cohorts\""), "{off}");
        assert!(off.contains("name=\"name\"") && !off.contains("name=\"code\""), "{off}");
        let secret = "ABCD-EFGH".to_owned();
        let offered = FactorState::Offered { secret, address: "otpauth://totp/x?secret=ABCDEFGH".to_owned() };
        let offered = samples::keep_page("second-factor-offered", &page(offered, true));
        assert!(offered.contains("ABCD-EFGH") && offered.contains("/account/second-factor/qr.svg"), "{offered}");
        let on = FactorState::On { since: samples::NOW };
        let proof = ProofAsked { on: true, app: true, question: None };
        let on = SecondFactorPage { codes_left: Some(2), proof, can_add: false, ..page(on, false) };
        let on = samples::keep_page("second-factor-on", &on);
        assert!(on.contains("2 recovery codes left") && on.contains("/account/second-factor/off"), "{on}");
        assert!(on.contains("href=\"/cohorts\"") && !on.contains("qr.svg"), "{on}");
        assert!(on.contains("no passkeys here") && !on.contains("data-options"), "{on}");
    }

    #[test]
    fn passkeys_are_listed_and_asked_before_anything_is_changed() {
        let proof = ProofAsked { on: true, app: false, question: Some(question()) };
        let page = SecondFactorPage {
            passkeys: vec![row("Phone", true), row("Key in the drawer", false)],
            codes_left: Some(9),
            proof,
            form: FilledForm::default(),
            ..page(FactorState::Off, false)
        };
        let html = samples::keep_page("second-factor-passkeys", &page);
        assert!(html.contains("Phone") && html.contains("Key in the drawer"), "{html}");
        assert_eq!(html.matches("data-options").count(), 3, "add, app and recovery codes: {html}");
        assert_eq!(html.matches("name=\"code\"").count(), 3, "each does without JavaScript: {html}");
    }

    #[test]
    fn every_refusal_is_said() {
        for refused in [FactorRefused::Late, FactorRefused::Answer, FactorRefused::Copied, FactorRefused::NotMade] {
            assert!(refused.said().contains("asskey"), "{refused:?}");
        }
        assert_eq!(FactorRefused::Other("name: too long".to_owned()).said(), "Name: too long");
    }

    #[test]
    fn recovery_codes_are_listed_once() {
        let codes = vec!["ABCD-EFGH-JKLM".to_owned(), "NPQR-STUV-WXYZ".to_owned()];
        let page = RecoveryCodesPage { shell: samples::shell(Role::Trainee), codes, first: true };
        let html = samples::keep_page("recovery-codes", &page);
        assert!(html.contains("NPQR-STUV-WXYZ") && html.contains("not shown again"), "{html}");
    }
}
