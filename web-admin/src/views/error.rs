//! A request that was not done.

use askama::Template;
use askama_web::WebTemplate;

/// The page of an error.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "error.html")]
pub struct ErrorPage {
    /// HTTP status.
    pub status: u16,
    /// The status in words.
    pub title: &'static str,
    /// What is wrong with this request.
    pub message: String,
}
