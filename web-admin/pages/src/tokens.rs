//! One's own tokens for programs.

use askama::Template;
use askama_web::WebTemplate;
use model::limits::{LONGEST_NAME, TOKEN_LIFETIMES_DAYS};
use time::OffsetDateTime;

use super::form::FilledForm;
use super::{Shell, StatusWord, format};

/// The page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "account/tokens.html")]
pub struct TokensPage {
    /// Frame.
    pub shell: Shell,
    /// The tokens that were not revoked, the newest first.
    pub rows: Vec<TokenRow>,
    /// What is typed, and why no token was made.
    pub form: FilledForm<TokenFields>,
}

/// What is typed about a new token; its password is never shown again.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TokenFields {
    /// Name.
    pub name: String,
    /// How long it is good, in days.
    pub days: i64,
}

impl TokensPage {
    /// Times to choose from: days, words, and whether it is the one chosen.
    fn lifetimes(&self) -> Vec<(i64, String, bool)> {
        let choice = |days| (days, trn!("{n} day", "{n} days", days), days == self.form.typed.days);
        TOKEN_LIFETIMES_DAYS.into_iter().map(choice).collect()
    }
}

/// A token of a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TokenRow {
    /// What it is called, if anything.
    pub name: Option<String>,
    /// When it was made.
    pub made: OffsetDateTime,
    /// When it was last used, to the hour.
    pub used: Option<OffsetDateTime>,
    /// When it ends or ended; never, where there is none.
    pub expires: Option<OffsetDateTime>,
    /// It has ended.
    pub ended: bool,
    /// Where it is revoked.
    pub revoke_href: String,
}

impl TokenRow {
    fn said(&self) -> &str {
        self.name.as_deref().unwrap_or(tr!("without a name"))
    }
}

/// A token that was made, shown this once.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "account/token.html")]
pub struct MadeTokenPage {
    /// Frame.
    pub shell: Shell,
    /// What it is called.
    pub name: String,
    /// The token.
    pub token: String,
    /// When it ends.
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
        let page = TokensPage { shell, rows, form };
        let html = samples::keep_page("tokens", &page);
        assert!(
            html.contains("Analysis &#60;b&#62;") && html.contains("no expiry") && html.contains("never"),
            "{html}"
        );
        assert_eq!((html.matches("Expired").count(), html.matches("/revoke\"").count()), (1, 3), "{html}");
        let shell = samples::shell(Role::Instructor);
        let none =
            TokensPage { shell, rows: vec![], form: FilledForm::new(TokenFields { name: String::new(), days: 90 }) };
        assert!(samples::keep_page("tokens-none", &none).contains("no tokens"));
    }

    #[test]
    fn a_token_is_shown_with_what_to_do_with_it() {
        let (shell, name) = (samples::shell(Role::Trainee), "Analysis".to_owned());
        let page = MadeTokenPage { shell, name, token: "abc".repeat(21), expires: samples::NOW };
        let html = samples::keep_page("token", &page);
        assert!(html.contains(&"abc".repeat(21)) && html.contains("not shown again"), "{html}");
    }
}
