//! The flash message that confirms a submitted form on the next page. The message is task-local to
//! a request, like the language.

use std::future::Future;

tokio::task_local! {
    static FLASH_MESSAGE: FlashMessage;
}

/// A form that was processed successfully, as its index in `SAID_HERE`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FlashMessage(usize);

/// Routes whose forms are confirmed by a flash message. Other forms confirm on the page they
/// redirect to, or show their result.
pub const SAID_HERE: [&str; 39] = [
    "/account/cohorts/{cohort}",
    "/account/language",
    "/account/news",
    "/account/second-factor/passkeys/{id}/remove",
    "/account/second-factor/passkeys/{id}/rename",
    "/account/studies/{id}/join",
    "/account/studies/{id}/leave",
    "/account/tokens/{id}/revoke",
    "/admin/origins",
    "/admin/stations/{id}/revoke",
    "/assignments",
    "/assignments/{id}/extend",
    "/assignments/{id}/withdraw",
    "/cohorts",
    "/cohorts/{id}/people",
    "/cohorts/{id}/people/{person}/answer",
    "/cohorts/{id}/people/{person}/remove",
    "/drafts/{id}/discard",
    "/expert-consent",
    "/news/read",
    "/people/{id}/consent",
    "/people/{id}/consent/withdraw",
    "/rate/{id}",
    "/ratings",
    "/ratings/{id}/withdraw",
    "/regradings/{id}/forget",
    "/segments",
    "/segments/{id}/extend",
    "/segments/{id}/withdraw",
    "/sessions/{id}/comments",
    "/sessions/{id}/comments/{comment}/answers",
    "/sessions/{id}/comments/{comment}/withdraw",
    "/sessions/{id}/override",
    "/sessions/{id}/override/withdraw",
    "/sessions/{id}/regrade",
    "/sessions/{id}/supervision",
    "/surveys/new",
    "/surveys/{id}/close",
    "/surveys/{id}/tags",
];

impl FlashMessage {
    /// Returns the message of a route's form, if it has a flash message.
    #[must_use]
    pub fn of_route(route: &str) -> Option<Self> {
        SAID_HERE.iter().position(|said| *said == route).map(Self)
    }

    /// Returns the message with a number, as stored in the cookie.
    #[must_use]
    pub fn of_number(number: usize) -> Option<Self> {
        (number < SAID_HERE.len()).then_some(Self(number))
    }

    /// Returns the number to store in the cookie.
    #[must_use]
    pub const fn number(self) -> usize {
        self.0
    }

    fn said(self) -> &'static str {
        match SAID_HERE[self.0] {
            "/account/tokens/{id}/revoke" => tr!("The token is revoked."),
            "/account/second-factor/passkeys/{id}/remove" => tr!("The passkey is removed."),
            "/admin/stations/{id}/revoke" => tr!("The station’s token is revoked."),
            "/assignments" => tr!("It is assigned."),
            "/assignments/{id}/extend" | "/segments/{id}/extend" => tr!("The due date is changed."),
            "/assignments/{id}/withdraw" | "/segments/{id}/withdraw" => tr!("The assignment is withdrawn."),
            "/cohorts" => tr!("The cohort is made."),
            "/cohorts/{id}/people/{person}/remove" => tr!("Taken out of the cohort."),
            "/drafts/{id}/discard" => tr!("The draft is discarded."),
            "/news/read" => tr!("Everything is marked as read."),
            "/people/{id}/consent" => tr!("The consent is recorded."),
            "/people/{id}/consent/withdraw" => tr!("It is recorded that the consent was taken back."),
            "/ratings" => tr!("The raters are asked."),
            "/ratings/{id}/withdraw" => tr!("The round is withdrawn."),
            "/regradings/{id}/forget" => tr!("Nothing was graded again."),
            "/segments" => tr!("It is assigned."),
            "/sessions/{id}/comments" => tr!("Your comment is posted."),
            "/sessions/{id}/comments/{comment}/answers" => tr!("Your answer is posted."),
            "/sessions/{id}/comments/{comment}/withdraw" => tr!("The comment is withdrawn."),
            "/sessions/{id}/override" => tr!("The score is overridden."),
            "/sessions/{id}/override/withdraw" => tr!("The computed score counts again."),
            "/sessions/{id}/regrade" => tr!("The attempt is graded again."),
            "/sessions/{id}/supervision" => tr!("It is recorded whether you were there."),
            "/surveys/new" => tr!("The survey is made."),
            _ => tr!("Saved."),
        }
    }
}

/// Runs a future whose pages show the flash message.
pub async fn with_flash_message<F: Future>(deed: FlashMessage, future: F) -> F::Output {
    FLASH_MESSAGE.scope(deed, future).await
}

/// Returns the text of the current flash message, if there is one.
#[must_use]
pub fn say_done() -> Option<&'static str> {
    FLASH_MESSAGE.try_with(|deed| deed.said()).ok()
}
