//! Error pages.

use askama::Template;
use askama_web::WebTemplate;

use crate::{assets, format};

/// The page shown for a failed request.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "error.html")]
pub struct ErrorPage {
    /// HTTP status.
    pub status: u16,
    /// Description of the problem.
    pub message: String,
}

impl ErrorPage {
    /// Returns what happened, as a heading.
    #[must_use]
    pub fn heading(&self) -> &'static str {
        match self.status {
            403 => tr!("No permission"),
            404 => tr!("Not found"),
            429 => tr!("Too many attempts"),
            500.. => tr!("Internal error"),
            _ => tr!("The request failed"),
        }
    }

    /// Returns the problem as a sentence; empty if the heading is sufficient.
    #[must_use]
    pub fn explanation(&self) -> String {
        if self.status == 404 { String::new() } else { format::as_sentence(self.message.trim_end_matches('.')) + "." }
    }

    /// Returns the recommended next step.
    #[must_use]
    pub fn advice(&self) -> &'static str {
        match self.status {
            403 => tr!("If you think you should have access, ask your school’s administrator."),
            404 => tr!("The address may be mistyped, or you may not have access to this record."),
            429 => tr!("Wait a moment, then try again."),
            500.. => {
                tr!(
                    "The error was logged. Try again; if it happens again, tell your school’s administrator when it happened."
                )
            }
            _ => tr!("Go back and try again."),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;

    #[test]
    fn every_error_says_what_happened_and_what_to_do() {
        for status in [403, 404, 429, 500] {
            let page = ErrorPage { status, message: "the <cause>".to_owned() };
            let html = samples::keep_page(&format!("error-{status}"), &page);
            assert!(
                html.contains(page.heading()) && html.contains(page.advice().split('\'').next().unwrap_or_default())
            );
            assert_eq!(html.contains("The &#60;cause&#62;."), status != 404, "{html}");
            assert!(html.contains(r#"href="/""#), "there is a way back");
        }
    }
}
