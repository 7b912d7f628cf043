//! Other sites whose pages may upload.

use askama::Template;
use askama_web::WebTemplate;

use super::Shell;

/// The origins that a school allows.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "origins.html")]
pub struct OriginsPage {
    /// Frame.
    pub shell: Shell,
    /// What is in the field: an origin a line.
    pub typed: String,
    /// What the service allows for every school.
    pub everywhere: Vec<String>,
    /// Why what was typed was not taken.
    pub refused: Option<String>,
}
