//! One's own second factor: made, confirmed, turned off; recovery codes, shown once.

use askama::Template;
use askama_web::WebTemplate;
use time::OffsetDateTime;

use super::{Shell, Status, format};

/// Below this many recovery codes new ones are called for.
const FEW_CODES: i64 = 3;

/// How a second factor stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FactorState {
    /// There is none.
    Off,
    /// A secret is offered, and a code of it asked for.
    Offered {
        /// The secret, to be typed.
        secret: String,
        /// The address that an app on this device opens.
        address: String,
    },
    /// A code is asked for when signing in.
    On {
        /// Since when.
        since: OffsetDateTime,
        /// Recovery codes that are left.
        codes_left: i64,
    },
}

/// Why nothing was changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FactorRefused {
    /// The password is wrong.
    Password,
    /// The code is wrong.
    Code,
}

/// The page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "account/second_factor.html")]
pub struct SecondFactorPage {
    /// Frame.
    pub shell: Shell,
    /// How it stands.
    pub factor: FactorState,
    /// The school asks for it.
    pub asked: bool,
    /// Nothing else may be done before it is on.
    pub owed: bool,
    /// Why nothing was changed.
    pub refused: Option<FactorRefused>,
}

impl SecondFactorPage {
    /// How many recovery codes are left, marked where they are few.
    fn left(&self, codes: &i64) -> String {
        let words = trn!("{n} recovery code left", "{n} recovery codes left", *codes);
        if *codes < FEW_CODES { Status::Help.badge_saying(&words) } else { words }
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

    use super::*;
    use crate::domain::Role;
    use crate::views::{Place, samples};

    fn page(factor: FactorState, owed: bool) -> SecondFactorPage {
        let place = if owed { Place::Enrolment } else { Place::Account };
        let shell = Shell { place, ..samples::shell(Role::Instructor) };
        SecondFactorPage { shell, factor, asked: owed, owed, refused: Some(FactorRefused::Code) }
    }

    #[test]
    fn each_state_says_what_to_do() {
        let off = samples::keep("second-factor-off", &page(FactorState::Off, true));
        assert!(off.contains("before you go on") && !off.contains("href=\"/cohorts\""), "{off}");
        let secret = "ABCD-EFGH".to_owned();
        let offered = FactorState::Offered { secret, address: "otpauth://totp/x?secret=ABCDEFGH".to_owned() };
        let offered = samples::keep("second-factor-offered", &page(offered, true));
        assert!(offered.contains("ABCD-EFGH") && offered.contains("/account/second-factor/qr.svg"), "{offered}");
        let on = FactorState::On { since: samples::NOW, codes_left: 2 };
        let on = samples::keep("second-factor-on", &page(on, false));
        assert!(on.contains("2 recovery codes left") && on.contains("/account/second-factor/off"), "{on}");
        assert!(on.contains("href=\"/cohorts\"") && !on.contains("qr.svg"), "{on}");
    }

    #[test]
    fn recovery_codes_are_listed_once() {
        let codes = vec!["ABCD-EFGH-JKLM".to_owned(), "NPQR-STUV-WXYZ".to_owned()];
        let page = RecoveryCodesPage { shell: samples::shell(Role::Trainee), codes, first: true };
        let html = samples::keep("recovery-codes", &page);
        assert!(html.contains("NPQR-STUV-WXYZ") && html.contains("not shown again"), "{html}");
    }
}
