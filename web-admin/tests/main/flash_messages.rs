//! Every act says that it was done. Fails when a form's route says so nowhere, when a page says it that was not led to, or says it twice.

use model::Role;
use pages::flash_message::SAID_HERE;

use crate::people::{post, school};

/// Forms that lead to a page which says itself what came of them, or shows it.
const SAID_THERE: [&str; 78] = [
    "/account/calendar",
    "/account/identities/join/{}",
    "/account/password",
    "/account/prove/{}",
    "/account/second-factor",
    "/account/second-factor/confirm",
    "/account/second-factor/off",
    "/account/second-factor/passkeys",
    "/account/second-factor/passkeys/confirm",
    "/account/second-factor/recovery-codes",
    "/account/tokens",
    "/admin/certificate-needs",
    "/admin/outcomes/file",
    "/admin/pairing-codes",
    "/admin/platforms/register",
    "/admin/provisioning",
    "/admin/retention",
    "/admin/second-factor",
    "/admin/settings",
    "/admin/settings/logo",
    "/admin/settings/logo/remove",
    "/admin/settings/test-letter",
    "/admin/sign-in/{}/try",
    "/at-risk",
    "/curricula/{}/draft",
    "/drafts",
    "/drafts/{}",
    "/drafts/{}/pictures",
    "/drafts/{}/preview",
    "/exercises/{}/course",
    "/exercises/{}/draft",
    "/exercises/{}/regrade",
    "/forgotten",
    "/join/{}",
    "/language",
    "/login",
    "/login/code",
    "/logout",
    "/lti/deep-link/{}",
    "/lti/launch",
    "/lti/login",
    "/people",
    "/people/bulk",
    "/people/bulk/do",
    "/people/roster",
    "/people/rosters/{}",
    "/people/rosters/{}/columns",
    "/people/{}/change",
    "/people/{}/disable",
    "/people/{}/enable",
    "/people/{}/erase",
    "/people/{}/hold",
    "/people/{}/link",
    "/people/{}/mail-link",
    "/people/{}/second-factor/reset",
    "/regradings/{}",
    "/segments/traces/{}",
    "/sessions/{}/links",
    "/sessions/{}/review",
    "/sign-in-code",
    "/sign-in/begin",
    "/sign-in/join",
    "/sign-in/{}",
    "/studies/new",
    "/studies/{}/change",
    "/studies/{}/close",
    "/studies/{}/participants",
    "/studies/{}/participants/{}/code",
    "/studies/{}/participants/{}/links",
    "/studies/{}/participants/{}/withdraw",
    "/survey/{}",
    "/surveys/instruments/new",
    "/surveys/instruments/{}/course",
    "/surveys/instruments/{}/draft",
    "/surveys/instruments/{}/edit",
    "/surveys/{}/answer",
    "/surveys/{}/links",
    "/trainees/{}/certificates/{}",
];

/// A path without the names of what varies in it.
fn shape(path: &str) -> String {
    let parts = path.split('/').map(|part| if part.starts_with('{') { "{}" } else { part });
    parts.collect::<Vec<_>>().join("/")
}

#[test]
fn every_form_says_that_it_was_taken() {
    let listed = include_str!("every_route.txt").lines().filter_map(|line| line.strip_prefix("POST "));
    let listed = listed
        .filter_map(|line| line.split_whitespace().next())
        .filter(|path| !path.starts_with("/api/") && !path.starts_with("/scim/"));
    let here: Vec<String> = SAID_HERE.iter().map(|path| shape(path)).collect();
    let mut listed: Vec<String> = listed.map(shape).collect();
    listed.sort();
    listed.dedup();
    for path in &listed {
        let (here, there) = (here.contains(path), SAID_THERE.contains(&path.as_str()));
        assert!(
            here != there,
            "{path}: said by pages::flash_message ({here}) or by the page that it leads to ({there})"
        );
    }
    for path in here.iter().map(String::as_str).chain(SAID_THERE) {
        assert!(listed.iter().any(|known| known == path), "{path} is no form any more");
    }
}

#[tokio::test]
async fn flash_message_is_shown_once_in_the_readers_language() {
    let (app, school, mut head) = school().await;
    app.member(school, Role::Trainee, "ana@example.org").await;
    let made = post(&mut head, "/cohorts", "/cohorts", &[("name", "Spring")]).await;
    let page = made.header("location").to_owned();
    assert!(head.get(&page).await.text().contains("Cohort created."));
    assert!(!head.get(&page).await.text().contains("Cohort created."), "once");
    let refused = post(&mut head, &page, &page, &[("email", "nobody@example.org")]).await;
    assert!(refused.status == 422 && !refused.text().contains("Saved."), "{}", refused.text());
    post(&mut head, "/account", "/account/language", &[("language", "de")]).await;
    assert!(head.get("/account").await.text().contains("Gespeichert."));
}
