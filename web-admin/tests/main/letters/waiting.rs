//! What waits for somebody, and letters that reach nobody. Fails when a survey or a rating that waits is said nowhere, when whoever is
//! asked does not learn who asks, and when an invitation is called sent that nobody receives.

use crate::people::{post, school as people_school};
use crate::support::client::csrf_in;
use crate::surveys::{School, send};

#[tokio::test]
async fn home_page_lists_a_waiting_survey_and_its_controller() {
    let school = School::new().await;
    let mut head = school.app.signed_in("head@example.org").await;
    let notice = "Controller: North Hospital, Way 1.\nDeleted after 24 months.";
    let settings = [
        ("name", "North"),
        ("time_zone", "UTC"),
        ("letter_language", "en"),
        ("replaced_grace_days", "7"),
        ("data_notice", notice),
    ];
    assert_eq!(post(&mut head, "/admin/settings", "/admin/settings", &settings).await.status, 303);
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let cohort = school.cohort(&mut teacher).await;
    let survey = school.survey(&mut teacher, "sus", &[("identity", "pseudonymous"), ("cohort", &cohort)]).await;
    let mut ada = school.app.signed_in("ada@example.org").await;
    let home = ada.get("/").await.text();
    assert!(home.contains("A survey is waiting for your answers: “What do you think?”"), "{home}");
    assert!(home.contains(&format!("href=\"{survey}\"")), "{home}");
    let link = school.links(&mut teacher, &survey, "Dr A").await.remove(0);
    let pages = [ada.get(&survey).await.text(), school.app.stranger().get(&link).await.text()];
    for page in &pages {
        for said in ["teacher@example.org", "for North", "Controller: North Hospital", "after 24 months"] {
            assert!(page.contains(said), "{said} is not in {page}");
        }
        assert!(page.contains("North could find out who is behind a pseudonym"), "{page}");
    }
    let csrf = csrf_in(&pages[0]);
    let begun =
        send(&mut ada, &format!("{survey}/answer"), &[("csrf", &csrf), ("consent", "yes"), ("lang", "en")]).await;
    let form = begun.header("location").to_owned();
    let page = ada.get(&form).await.text();
    assert!(page.contains("no answer") && !page.contains(" checked"), "nothing is chosen beforehand: {page}");
    assert_eq!(send(&mut ada, &form, &[("do", "send"), ("page", "0")]).await.status, 303);
    assert!(!ada.get("/").await.text().contains("A survey is waiting"), "answered");
}

#[tokio::test]
async fn page_states_that_no_invitation_is_sent_without_a_mail_server() {
    let (_app, _, mut head) = people_school().await;
    let ana = [("name", "Ana"), ("email", "ana@example.org"), ("role", "trainee"), ("number", "4711")];
    let added = post(&mut head, "/people", "/people", &ana).await;
    let page = head.get(added.header("location")).await.text();
    assert!(page.contains("nobody receives it") && !page.contains("is being sent"), "{page}");
    assert!(page.contains("4711"), "the registrar's number is kept: {page}");
    let bo = [("name", "Bo"), ("email", "bo@example.org"), ("role", "trainee"), ("number", "4711")];
    let refused = post(&mut head, "/people", "/people", &bo).await;
    assert_eq!(refused.status, 422);
    assert!(refused.text().contains("Another person in the school has this registrar"), "{}", refused.text());
    let person = added.header("location").split('?').next().unwrap().to_owned();
    let change = [("name", "Ana"), ("email", "ana@example.org"), ("role", "trainee"), ("number", "4712")];
    assert_eq!(post(&mut head, &person, &format!("{person}/change"), &change).await.status, 303);
    assert!(head.get(&person).await.text().contains("4712"));
}
