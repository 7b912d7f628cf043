//! Pages of the user's own account, and the pages that let a user sign in with a link or reset a
//! password.

use std::borrow::Borrow;

use askama::Template;
use askama_web::WebTemplate;
use model::Role;
use model::auth::password_refused::PasswordRefused;
use model::limits::MIN_PASSWORD;
use model::training::membership::{MembershipAct, MembershipEvent, MembershipRequest};
use time::OffsetDateTime;
use words::Language;

use crate::auth::reauthentication::OwnPassword;
use crate::{Shell, StatusWord, assets, format};

/// The user's own account page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/account.html")]
pub struct AccountPage {
    /// Page frame.
    pub shell: Shell,
    /// Email address.
    pub email: String,
    /// Pseudonym that stands for the user's name in recordings.
    pub pseudonym: String,
    /// Name of the user's school.
    pub school: String,
    /// Names of the user's cohorts.
    pub cohorts: String,
    /// Open requests to add the user to a cohort.
    pub requests: Vec<MembershipRequest>,
    /// Changes to the user's cohort memberships, latest first.
    pub acts: Vec<MembershipEvent>,
    /// Language the user has chosen, if any.
    pub language: Option<Language>,
    /// Whether news is also sent by email.
    pub mailed: bool,
    /// Number of open study invitations.
    pub study_requests: usize,
    /// Whether a second factor is set up.
    pub second_factor: bool,
    /// Address of the page with the user's own attempts.
    pub practice: String,
    /// When the user's sign-in code was created; `None` without a code.
    pub sign_in_code: Option<OffsetDateTime>,
    /// How the user proves who they are before the password changes.
    pub own_password: OwnPassword,
    /// Why the new password was refused.
    pub refused: Option<PasswordRefused>,
}

impl AccountPage {
    /// Describes a membership event to the user.
    fn deed(&self, noted: &MembershipEvent) -> String {
        let MembershipEvent { cohort, act, by, .. } = noted;
        let by = by.as_deref().unwrap_or(tr!("the administration"));
        match act {
            MembershipAct::Asked => {
                tr!("{name} has asked for a place in {cohort} for you.", name = by, cohort = cohort)
            }
            MembershipAct::Declined => tr!("{name} has declined your place in {cohort}.", name = by, cohort = cohort),
            MembershipAct::Joined => tr!("{name} has agreed to your place in {cohort}.", name = by, cohort = cohort),
            MembershipAct::Left => tr!("{name} has removed you from {cohort}.", name = by, cohort = cohort),
        }
    }

    fn chose(&self, language: impl Borrow<Language>) -> bool {
        self.language.as_ref() == Some(language.borrow())
    }
}

/// The page behind a sign-in link, where the user chooses a password.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/join.html")]
pub struct JoinPage {
    /// CSRF token.
    pub csrf: String,
    /// Token of the link.
    pub token: String,
    /// Name of the user who sets the password.
    pub name: String,
    /// Email address of the user.
    pub email: String,
    /// Name of the user's school.
    pub school: String,
    /// Whether this is the user's first password.
    pub first: bool,
    /// Why the password was refused.
    pub refused: Option<PasswordRefused>,
}

/// Shown for a link that is invalid, used or expired.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/dead_link.html")]
pub struct DeadLinkPage;

/// The form that requests a password reset link.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/forgotten.html")]
pub struct ForgottenPage {
    /// CSRF token.
    pub csrf: String,
    /// Whether the request has been sent.
    pub asked: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;

    #[test]
    fn every_page_tells_what_to_do() {
        let page = AccountPage {
            shell: samples::shell(Role::Trainee),
            email: "ana@example.org".to_owned(),
            pseudonym: "p-1".to_owned(),
            school: "North".to_owned(),
            cohorts: "Spring".to_owned(),
            requests: vec![samples::request()],
            acts: [MembershipAct::Left, MembershipAct::Joined, MembershipAct::Declined, MembershipAct::Asked]
                .map(samples::noted)
                .to_vec(),
            language: None,
            mailed: true,
            study_requests: 1,
            second_factor: false,
            practice: "/trainees/1".to_owned(),
            sign_in_code: None,
            own_password: OwnPassword::Known,
            refused: Some(PasswordRefused::WrongOld),
        };
        let html = samples::keep_page("account", &page);
        assert!(html.contains("/account/cohorts/") && html.contains("asked for a place in Spring for you"), "{html}");
        assert!(html.contains("/account/export") && html.contains("not your current password"), "{html}");
        let page = JoinPage {
            csrf: "c".to_owned(),
            token: "t".to_owned(),
            name: "Ana".to_owned(),
            email: "ana@example.org".to_owned(),
            school: "North".to_owned(),
            first: true,
            refused: Some(PasswordRefused::Different),
        };
        assert!(samples::keep_page("join", &page).contains("Welcome"));
        assert!(samples::keep_page("dead-link", &DeadLinkPage).contains("no longer works"));
        assert!(
            samples::keep_page("forgotten", &ForgottenPage { csrf: "c".to_owned(), asked: true })
                .contains("is being sent")
        );
    }
}
