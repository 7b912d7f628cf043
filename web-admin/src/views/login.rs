//! Signing in.

use askama::Template;
use askama_web::WebTemplate;

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
