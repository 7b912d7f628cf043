//! The user's API tokens.

use askama::Template;
use askama_web::WebTemplate;
use model::limits::{LONGEST_NAME, TOKEN_LIFETIMES_DAYS};
use time::OffsetDateTime;

use crate::auth::reauthentication::OwnPassword;
use crate::form::FilledForm;
use crate::{Shell, StatusWord, format};

/// The page of the user's tokens.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/tokens.html")]
pub struct TokensPage {
    /// Page frame.
    pub shell: Shell,
    /// Tokens that were not revoked, newest first.
    pub rows: Vec<TokenRow>,
    /// The form for a new token, with the reason if it was refused.
    pub form: FilledForm<TokenFields>,
    /// How the user proves who they are.
    pub own_password: OwnPassword,
}

/// Input of the form for a new token; the password is never shown again.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TokenFields {
    /// Name.
    pub name: String,
    /// Lifetime, in days.
    pub days: i64,
}

impl TokensPage {
    /// Returns the lifetimes to choose from: days, label, and whether it is selected.
    fn lifetimes(&self) -> Vec<(i64, String, bool)> {
        let choice = |days| (days, trn!("{n} day", "{n} days", days), days == self.form.typed.days);
        TOKEN_LIFETIMES_DAYS.into_iter().map(choice).collect()
    }
}

/// A token in a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TokenRow {
    /// Name, if it has one.
    pub name: Option<String>,
    /// Time of creation.
    pub made: OffsetDateTime,
    /// Time of last use, to the hour.
    pub used: Option<OffsetDateTime>,
    /// Expiry time; `None` if it never expires.
    pub expires: Option<OffsetDateTime>,
    /// Whether it has expired.
    pub ended: bool,
    /// Address that revokes it.
    pub revoke_href: String,
}

impl TokenRow {
    fn said(&self) -> &str {
        self.name.as_deref().unwrap_or(tr!("without a name"))
    }
}

/// A newly created token, shown only once.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/token.html")]
pub struct MadeTokenPage {
    /// Page frame.
    pub shell: Shell,
    /// Name.
    pub name: String,
    /// The token.
    pub token: String,
    /// Expiry time.
    pub expires: OffsetDateTime,
}

#[cfg(test)]
mod tests {
    //! Fails when a token is listed as good that is not, or cannot be revoked.

    use model::Role;

    use super::*;
    use crate::samples;

    #[test]
    fn each_token_says_how_long_it_is_good() {
        let row = |name: Option<&str>, expires, ended| TokenRow {
            name: name.map(str::to_owned),
            made: samples::NOW,
            used: name.map(|_| samples::NOW),
            expires,
            ended,
            revoke_href: "/account/tokens/1/revoke".to_owned(),
        };
        let rows = vec![
            row(Some("Analysis <b>"), Some(samples::NOW), false),
            row(Some("Old laptop"), Some(samples::NOW), true),
            row(None, None, false),
        ];
        let shell = samples::shell(Role::Instructor);
        let form = FilledForm::refused(TokenFields { name: "x".to_owned(), days: 90 }, "no".to_owned());
        let page = TokensPage { shell, rows, form, own_password: OwnPassword::Known };
        let html = samples::keep_page("tokens", &page);
        assert!(
            html.contains("Analysis &#60;b&#62;") && html.contains("no expiry") && html.contains("never"),
            "{html}"
        );
        assert_eq!((html.matches("Expired").count(), html.matches("/revoke\"").count()), (1, 3), "{html}");
        let shell = samples::shell(Role::Instructor);
        let form = FilledForm::new(TokenFields { name: String::new(), days: 90 });
        let none = TokensPage { shell, rows: vec![], form, own_password: OwnPassword::Unproved };
        assert!(samples::keep_page("tokens-none", &none).contains("no tokens"));
    }

    #[test]
    fn a_token_is_shown_with_what_to_do_with_it() {
        let (shell, name) = (samples::shell(Role::Trainee), "Analysis".to_owned());
        let page = MadeTokenPage { shell, name, token: "abc".repeat(21), expires: samples::NOW };
        let html = samples::keep_page("token", &page);
        assert!(html.contains(&"abc".repeat(21)) && html.contains("not be shown again"), "{html}");
    }
}
