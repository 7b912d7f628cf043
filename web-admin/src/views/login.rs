//! Signing in.

use askama::Template;
use askama_web::WebTemplate;

use super::assets;

/// The sign-in page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "login.html")]
pub struct LoginPage {
    /// Why the last try failed.
    pub error: Option<String>,
    /// The address typed in the last try.
    pub email: String,
    /// CSRF token.
    pub csrf: String,
    /// Where to go afterwards: a path of this site.
    pub next: String,
}

/// The page that asks for the code of a second factor, once the password was right.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "account/code.html")]
pub struct CodePage {
    /// CSRF token.
    pub csrf: String,
    /// Why the last try failed.
    pub error: Option<String>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::views::samples;

    #[test]
    fn renders_with_its_token_and_without_the_password() {
        let page = LoginPage {
            error: Some("The address or the password is wrong.".to_owned()),
            email: "\"><script>".to_owned(),
            csrf: "token".to_owned(),
            next: "/sessions/1".to_owned(),
        };
        let html = samples::keep("login", &page);
        assert!(html.contains(r#"name="csrf" value="token""#) && html.contains(r#"role="alert""#));
        assert!(!html.contains("<script>"), "what was typed is escaped");
    }

    #[test]
    fn a_code_is_asked_for_and_a_recovery_code_does_too() {
        let html = samples::keep("code", &CodePage { csrf: "c".to_owned(), error: Some("Wrong".to_owned()) });
        assert_eq!(html.matches("action=\"/login/code\"").count(), 2, "{html}");
        assert!(html.contains("one-time-code") && html.contains("role=\"alert\""));
    }
}
