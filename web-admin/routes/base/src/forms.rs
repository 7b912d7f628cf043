//! How a form is answered.

use acts::error::Error;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Redirect, Response};
use model::ids::PersonId;
use serde::Deserialize;

/// The answer to a form: what came of it, or its page once more, with what was typed and why it was refused.
#[derive(Debug)]
pub enum FormAnswer<P> {
    /// What came of it.
    Answered(Response),
    /// Its page: it was refused, and nothing has changed.
    Refused(P),
}

impl<P> FormAnswer<P> {
    /// It leads to another page.
    pub fn lead_to(href: &str) -> Self {
        Self::Answered(Redirect::to(href).into_response())
    }
}

impl<P: IntoResponse> IntoResponse for FormAnswer<P> {
    fn into_response(self) -> Response {
        match self {
            Self::Answered(response) => response,
            Self::Refused(page) => (StatusCode::UNPROCESSABLE_ENTITY, page).into_response(),
        }
    }
}

/// What came of a form, or what is wrong with what was typed. An error that whoever has typed cannot mend goes on.
///
/// # Errors
/// Every one but [`Error::Unprocessable`].
pub fn split_refusal<T>(outcome: Result<T, Error>) -> Result<Result<T, String>, Error> {
    match outcome {
        Ok(made) => Ok(Ok(made)),
        Err(Error::Unprocessable(why)) => Ok(Err(why)),
        Err(other) => Err(other),
    }
}

/// A text as it was written: a browser sends each end of a line as CR LF.
#[must_use]
pub fn unix_lines(text: &str) -> String {
    text.replace("\r\n", "\n")
}

/// What was just published.
#[derive(Debug, Deserialize)]
pub struct PublishedQuery {
    /// Its id.
    pub published: Option<String>,
}

/// Calendar days that one trainee has longer.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct ExtensionForm {
    /// The trainee.
    pub person: PersonId,
    /// So many.
    pub days: i64,
}
