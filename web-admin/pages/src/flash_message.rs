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
pub const SAID_HERE: [&str; 72] = [
    "/account/calendar/revoke",
    "/account/cohorts/{cohort}",
    "/account/identities/{id}/remove",
    "/account/language",
    "/account/learning-records",
    "/account/news",
    "/account/second-factor/passkeys/{id}/remove",
    "/account/second-factor/passkeys/{id}/rename",
    "/account/studies/{id}/join",
    "/account/studies/{id}/leave",
    "/account/tokens/{id}/revoke",
    "/admin/at-risk",
    "/admin/learning-records",
    "/admin/learning-records/disable",
    "/admin/learning-records/retry",
    "/admin/origins",
    "/admin/outcomes",
    "/admin/outcomes/levels",
    "/admin/outcomes/{id}",
    "/admin/platforms",
    "/admin/platforms/{id}",
    "/admin/platforms/{id}/admit",
    "/admin/platforms/{id}/courses/{course}",
    "/admin/platforms/{id}/deliveries/{delivery}/retry",
    "/admin/platforms/{id}/disable",
    "/admin/platforms/{id}/enable",
    "/admin/provisioning/{id}/revoke",
    "/admin/sign-in",
    "/admin/sign-in/local",
    "/admin/sign-in/{id}",
    "/admin/sign-in/{id}/disable",
    "/admin/sign-in/{id}/enable",
    "/admin/stations/{id}/revoke",
    "/admin/terms",
    "/admin/terms/{term}/remove",
    "/assignments",
    "/assignments/{id}/extend",
    "/assignments/{id}/withdraw",
    "/cohorts",
    "/cohorts/{id}/people",
    "/cohorts/{id}/people/{person}/answer",
    "/cohorts/{id}/people/{person}/remove",
    "/cohorts/{id}/term",
    "/drafts/{id}/discard",
    "/exams",
    "/exams/{id}/candidates/{person}",
    "/exams/{id}/candidates/{person}/begin",
    "/exams/{id}/close",
    "/exams/{id}/second-ratings",
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
    "/sessions/{id}/exam-files",
    "/sessions/{id}/override",
    "/sessions/{id}/override/withdraw",
    "/sessions/{id}/regrade",
    "/sessions/{id}/supervision",
    "/surveys/new",
    "/surveys/{id}/close",
    "/surveys/{id}/tags",
    "/trainees/{id}/outcomes/{outcome}",
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
            "/account/tokens/{id}/revoke" | "/admin/provisioning/{id}/revoke" => tr!("Token revoked."),
            "/account/calendar/revoke" => tr!("Address revoked."),
            "/account/second-factor/passkeys/{id}/remove" => tr!("Passkey removed."),
            "/admin/learning-records/disable" => tr!("Nothing more is sent."),
            "/admin/learning-records/retry" => tr!("Everything that was not sent is tried again."),
            "/admin/stations/{id}/revoke" => tr!("Station token revoked."),
            "/admin/platforms/{id}/deliveries/{delivery}/retry" => tr!("The grade will be sent again soon."),
            "/assignments" => tr!("Assigned."),
            "/assignments/{id}/extend" | "/segments/{id}/extend" => tr!("Due date changed."),
            "/assignments/{id}/withdraw" | "/segments/{id}/withdraw" => tr!("Assignment withdrawn."),
            "/cohorts" => tr!("Cohort created."),
            "/cohorts/{id}/people/{person}/remove" => tr!("Removed from the cohort."),
            "/drafts/{id}/discard" => tr!("Draft discarded."),
            "/exams" => tr!("Exam created."),
            "/exams/{id}/candidates/{person}/begin" => tr!("The sitting has begun."),
            "/exams/{id}/close" => tr!("Exam closed."),
            "/exams/{id}/second-ratings" => tr!("Sent to the second rater."),
            "/news/read" => tr!("Everything marked as read."),
            "/people/{id}/consent" => tr!("Consent recorded."),
            "/people/{id}/consent/withdraw" => tr!("Withdrawal of consent recorded."),
            "/ratings" => tr!("Raters invited."),
            "/ratings/{id}/withdraw" => tr!("Round withdrawn."),
            "/regradings/{id}/forget" => tr!("Nothing was re-graded."),
            "/segments" => tr!("Assigned."),
            "/sessions/{id}/comments" => tr!("Comment posted."),
            "/sessions/{id}/comments/{comment}/answers" => tr!("Answer posted."),
            "/sessions/{id}/comments/{comment}/withdraw" => tr!("Comment withdrawn."),
            "/sessions/{id}/exam-files" => tr!("Frozen: the exam file is in the list."),
            "/sessions/{id}/override" => tr!("Score overridden."),
            "/sessions/{id}/override/withdraw" => tr!("Override withdrawn: the computed score counts again."),
            "/sessions/{id}/regrade" => tr!("Attempt re-graded."),
            "/sessions/{id}/supervision" => tr!("Your presence is recorded."),
            "/surveys/new" => tr!("Survey created."),
            "/trainees/{id}/outcomes/{outcome}" => tr!("Decision recorded."),
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
