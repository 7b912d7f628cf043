//! Other sites whose pages may upload recordings.

use askama::Template;
use askama_web::WebTemplate;
use serde::Deserialize;

use crate::Shell;
use crate::form::FilledForm;

/// The page of the origins that a school allows.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "operations/origins.html")]
pub struct OriginsPage {
    /// Page frame.
    pub shell: Shell,
    /// The form.
    pub form: FilledForm<OriginsForm>,
    /// Origins that the service allows for every school.
    pub everywhere: Vec<String>,
}

/// Input of the form of allowed origins.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct OriginsForm {
    /// Origins, one per line.
    pub origins: String,
}
