//! Sign-in pages.

use askama::Template;
use askama_web::WebTemplate;
use model::auth::passkey::PasskeyQuestion;

use crate::assets;
use crate::auth::federation::ProviderButton;
use crate::auth::passkeys;
use crate::auth::reauthentication::ReauthenticationForm;

/// The sign-in page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/login.html")]
pub struct LoginPage {
    /// Why the previous attempt failed.
    pub error: Option<String>,
    /// Email address entered in the previous attempt.
    pub email: String,
    /// Name of the school whose account is meant, or empty.
    pub school: String,
    /// CSRF token.
    pub csrf: String,
    /// Path on this site to redirect to after sign-in.
    pub next: String,
    /// Providers that sign people in.
    pub providers: Vec<ProviderButton>,
    /// Whether passwords are for administrators only, and their form is folded.
    pub folded: bool,
}

/// The page that asks for the second factor, after a correct password.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/code.html")]
pub struct CodePage {
    /// CSRF token.
    pub csrf: String,
    /// Whether codes of an authenticator app are accepted.
    pub app: bool,
    /// The WebAuthn challenge for passkeys.
    pub question: Option<PasskeyQuestion>,
    /// Why the previous attempt failed.
    pub error: Option<String>,
}

impl CodePage {
    const fn has_ask(&self) -> bool {
        self.question.is_some()
    }

    /// Returns the passkey prompt. It starts by itself, except after a failed attempt.
    fn ask(&self) -> Option<String> {
        let question = self.question.as_ref()?;
        let label = tr!("Sign in with a passkey");
        Some(ReauthenticationForm { question, label, lead: true, at_once: self.error.is_none() }.html())
    }

    fn script(&self) -> String {
        passkeys::passkey_script()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::auth::passkeys::samples::question;
    use crate::samples;

    #[test]
    fn renders_with_its_token_and_without_the_password() {
        let page = LoginPage {
            error: Some("The address or the password is wrong.".to_owned()),
            email: "\"><script>".to_owned(),
            school: "North".to_owned(),
            csrf: "token".to_owned(),
            next: "/sessions/1".to_owned(),
            providers: vec![ProviderButton {
                href: "/sign-in/1".to_owned(),
                name: "North <University>".to_owned(),
                school: None,
            }],
            folded: true,
        };
        let html = samples::keep_page("login", &page);
        assert!(html.contains(r#"name="csrf" value="token""#) && html.contains(r#"role="alert""#));
        assert!(!html.contains("<script>"), "what was typed is escaped");
        assert!(html.contains("North &#60;University&#62;") && html.contains("<details open"), "{html}");
    }

    fn page(app: bool, question: Option<PasskeyQuestion>) -> CodePage {
        CodePage { csrf: "c".to_owned(), app, question, error: Some("Wrong".to_owned()) }
    }

    #[test]
    fn a_code_is_asked_for_and_a_recovery_code_does_too() {
        let html = samples::keep_page("code", &page(true, None));
        assert_eq!(html.matches("action=\"/login/code\"").count(), 2, "{html}");
        assert!(html.contains("one-time-code") && html.contains("role=\"alert\"") && !html.contains("<script"));
    }

    #[test]
    fn a_passkey_is_asked_for_at_once_and_codes_do_too() {
        let first = CodePage { error: None, ..page(true, Some(question())) };
        let html = samples::keep_page("code-passkey", &first);
        assert_eq!(html.matches("action=\"/login/code\"").count(), 3, "{html}");
        assert!(html.contains(" data-at-once") && html.contains("passkey.js"), "{html}");
        let again = samples::keep_page("code-passkey-again", &page(false, Some(question())));
        assert!(!again.contains(" data-at-once"), "whoever was refused presses the button: {again}");
        assert_eq!(again.matches("action=\"/login/code\"").count(), 2, "{again}");
        let nowhere = samples::keep_page("code-nowhere", &page(false, None));
        assert!(nowhere.contains("recovery code") && !nowhere.contains("<script"), "{nowhere}");
    }
}
