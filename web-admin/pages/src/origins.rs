//! Other sites whose pages may upload.

use askama::Template;
use askama_web::WebTemplate;
use serde::Deserialize;

use super::Shell;
use super::form::FilledForm;

/// The origins that a school allows.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "origins.html")]
pub struct OriginsPage {
    /// Frame.
    pub shell: Shell,
    /// What is typed.
    pub form: FilledForm<OriginsForm>,
    /// What the service allows for every school.
    pub everywhere: Vec<String>,
}

/// The fields of the origins that a school allows.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct OriginsForm {
    /// An origin a line.
    pub origins: String,
}
