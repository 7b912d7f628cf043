//! The user's second factor: setup, confirmation and removal of an authenticator app; recovery
//! codes, shown only once.

use askama::Template;
use askama_web::WebTemplate;
use model::limits::LONGEST_NAME;
use time::OffsetDateTime;

use crate::auth::passkeys;
use crate::auth::passkeys::PasskeyRow;
use crate::auth::reauthentication::{FactorRefused, ProofAsked};
use crate::form::FilledForm;
use crate::{Shell, StatusWord, format};

/// Below this number of recovery codes the page suggests making new ones.
const FEW_CODES: i64 = 3;

/// State of the authenticator app.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FactorState {
    /// No app is set up.
    Off,
    /// A secret is offered, to be confirmed with a code.
    Offered {
        /// The secret, for manual entry.
        secret: String,
        /// The `otpauth` address, which opens an app on this device.
        address: String,
    },
    /// Codes are accepted at sign-in.
    On {
        /// Time of setup.
        since: OffsetDateTime,
    },
}

/// The page of the user's second factor.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/second_factor.html")]
pub struct SecondFactorPage {
    /// Page frame.
    pub shell: Shell,
    /// State of the authenticator app.
    pub factor: FactorState,
    /// Passkeys, oldest first.
    pub passkeys: Vec<PasskeyRow>,
    /// Number of unused recovery codes; `None` without a second factor.
    pub codes_left: Option<i64>,
    /// Reauthentication required before a change.
    pub proof: ProofAsked,
    /// Whether passkeys can be used at this service's address.
    pub can_add: bool,
    /// The form with the name of a new passkey, and why a change was refused.
    pub form: FilledForm<String, FactorRefused>,
    /// Whether the school requires a second factor of this user.
    pub asked: bool,
    /// Whether the user must set one up before using any other page.
    pub owed: bool,
}

impl SecondFactorPage {
    /// Describes the number of unused recovery codes, with a warning if there are few.
    fn left(&self, codes: &i64) -> String {
        let words = trn!("{n} recovery code left", "{n} recovery codes left", *codes);
        if *codes < FEW_CODES { StatusWord::Help.badge_saying(&words) } else { words }
    }

    /// Returns the address of the script that prompts for passkeys.
    fn script(&self) -> String {
        passkeys::passkey_script()
    }
}

/// Recovery codes, shown only once.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/recovery_codes.html")]
pub struct RecoveryCodesPage {
    /// Page frame.
    pub shell: Shell,
    /// The codes.
    pub codes: Vec<String>,
    /// Whether the second factor has just been set up.
    pub first: bool,
}

#[cfg(test)]
mod tests {
    //! A secret must not be shown longer than needed, and each state must show the next step.

    use model::Role;

    use super::*;
    use crate::auth::passkeys::samples::{question, row};
    use crate::auth::reauthentication::OwnPassword;
    use crate::{NavPlace, samples};

    fn page(factor: FactorState, owed: bool) -> SecondFactorPage {
        let place = if owed { NavPlace::Enrolment } else { NavPlace::Account };
        let shell = Shell { place, ..samples::shell(Role::Instructor) };
        SecondFactorPage {
            shell,
            factor,
            passkeys: Vec::new(),
            codes_left: None,
            proof: ProofAsked { own_password: OwnPassword::Known, on: false, app: false, question: None },
            can_add: true,
            form: FilledForm::refused(String::new(), FactorRefused::Code),
            asked: owed,
            owed,
        }
    }

    #[test]
    fn each_state_says_what_to_do() {
        let off = samples::keep_page("second-factor-off", &page(FactorState::Off, true));
        assert!(off.contains("before you continue") && !off.contains("href=\"/cohorts\""), "{off}");
        assert!(off.contains("name=\"name\"") && !off.contains("name=\"code\""), "{off}");
        let secret = "ABCD-EFGH".to_owned();
        let offered = FactorState::Offered { secret, address: "otpauth://totp/x?secret=ABCDEFGH".to_owned() };
        let offered = samples::keep_page("second-factor-offered", &page(offered, true));
        assert!(offered.contains("ABCD-EFGH") && offered.contains("/account/second-factor/qr.svg"), "{offered}");
        let on = FactorState::On { since: samples::NOW };
        let proof = ProofAsked { own_password: OwnPassword::Known, on: true, app: true, question: None };
        let on = SecondFactorPage { codes_left: Some(2), proof, can_add: false, ..page(on, false) };
        let on = samples::keep_page("second-factor-on", &on);
        assert!(on.contains("2 recovery codes left") && on.contains("/account/second-factor/off"), "{on}");
        assert!(on.contains("href=\"/cohorts\"") && !on.contains("qr.svg"), "{on}");
        assert!(on.contains("not available here") && !on.contains("data-options"), "{on}");
    }

    #[test]
    fn passkeys_are_listed_and_asked_before_anything_is_changed() {
        let proof = ProofAsked { own_password: OwnPassword::Known, on: true, app: false, question: Some(question()) };
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
        assert!(html.contains("NPQR-STUV-WXYZ") && html.contains("not be shown again"), "{html}");
    }
}
