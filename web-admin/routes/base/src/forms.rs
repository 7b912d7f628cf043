//! Responses to forms.

use acts::error::Error;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Redirect, Response};
use model::ids::PersonId;
use serde::Deserialize;

/// The response to a form: its result, or its page again with the input and the reason for the
/// refusal.
#[derive(Debug)]
pub enum FormAnswer<P> {
    /// The result.
    Answered(Response),
    /// The form's page: the input was refused, and nothing has changed.
    Refused(P),
}

impl<P> FormAnswer<P> {
    /// Redirects to another page.
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

/// Separates invalid input from other errors: returns the result, or the message about the input.
/// Errors that the user cannot correct are passed on.
///
/// # Errors
/// Every error except [`Error::Unprocessable`].
pub fn split_refusal<T>(outcome: Result<T, Error>) -> Result<Result<T, String>, Error> {
    match outcome {
        Ok(made) => Ok(Ok(made)),
        Err(Error::Unprocessable(why)) => Ok(Err(why)),
        Err(other) => Err(other),
    }
}

/// Converts CR LF, which browsers send for each line break, to LF.
#[must_use]
pub fn unix_lines(text: &str) -> String {
    text.replace("\r\n", "\n")
}

/// Query parameter that names a newly published document.
#[derive(Debug, Deserialize)]
pub struct PublishedQuery {
    /// Its id.
    pub published: Option<String>,
}

/// Extension of an assignment for one trainee.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct ExtensionForm {
    /// The trainee.
    pub person: PersonId,
    /// Number of additional calendar days.
    pub days: i64,
}
