//! One's own account, and the pages by which somebody gets into theirs.

use std::borrow::Borrow;

use askama::Template;
use askama_web::WebTemplate;
use model::Role;
use model::limits::MIN_PASSWORD;
use model::membership::{MembershipAct, MembershipEvent, MembershipRequest};
use model::password_refused::PasswordRefused;
use time::OffsetDateTime;
use words::Language;

use super::{Shell, StatusWord, assets, format};

/// One's own account.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "account/account.html")]
pub struct AccountPage {
    /// Frame.
    pub shell: Shell,
    /// Address.
    pub email: String,
    /// What recordings say instead of a name.
    pub pseudonym: String,
    /// School.
    pub school: String,
    /// Cohorts by name.
    pub cohorts: String,
    /// Who asks to have them in a cohort.
    pub requests: Vec<MembershipRequest>,
    /// What was done about their places in cohorts, the latest first.
    pub acts: Vec<MembershipEvent>,
    /// The language that they have chosen, if any.
    pub language: Option<Language>,
    /// They are mailed what is new for them.
    pub mailed: bool,
    /// How many studies they are asked to take part in.
    pub study_requests: usize,
    /// They have a second factor.
    pub second_factor: bool,
    /// The page of their own attempts.
    pub practice: String,
    /// Since when they have had a sign-in code, if they have one.
    pub sign_in_code: Option<OffsetDateTime>,
    /// Why the new password was not taken.
    pub refused: Option<PasswordRefused>,
}

impl AccountPage {
    /// What was done, in words.
    fn deed(&self, noted: &MembershipEvent) -> String {
        let MembershipEvent { cohort, act, by, .. } = noted;
        let by = by.as_deref().unwrap_or(tr!("the administration"));
        match act {
            MembershipAct::Asked => tr!("{name} has asked to have you in {cohort}.", name = by, cohort = cohort),
            MembershipAct::Declined => tr!("{name} has declined that you join {cohort}.", name = by, cohort = cohort),
            MembershipAct::Joined => tr!("{name} has agreed that you are in {cohort}.", name = by, cohort = cohort),
            MembershipAct::Left => tr!("{name} has taken you out of {cohort}.", name = by, cohort = cohort),
        }
    }

    fn chose(&self, language: impl Borrow<Language>) -> bool {
        self.language.as_ref() == Some(language.borrow())
    }
}

/// Where a link leads: a password is chosen.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "account/join.html")]
pub struct JoinPage {
    /// CSRF token.
    pub csrf: String,
    /// The link's token.
    pub token: String,
    /// Whose password.
    pub name: String,
    /// Their address.
    pub email: String,
    /// Their school.
    pub school: String,
    /// It is their first password.
    pub first: bool,
    /// Why it was not taken.
    pub refused: Option<PasswordRefused>,
}

/// A link that is not good.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "account/dead_link.html")]
pub struct DeadLinkPage;

/// Where a new password is asked for.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "account/forgotten.html")]
pub struct ForgottenPage {
    /// CSRF token.
    pub csrf: String,
    /// It was asked for.
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
            refused: Some(PasswordRefused::WrongOld),
        };
        let html = samples::keep_page("account", &page);
        assert!(html.contains("/account/cohorts/") && html.contains("asked to have you in Spring"), "{html}");
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
                .contains("on its way")
        );
    }
}
