//! Members of a course, by the preview of rosters. Fails when a member is missing from the preview or taken in twice, when anything changes
//! before it is confirmed, when staff become trainees or leave a cohort, and when a first launch does not find who was taken in.

use acts::people::course_rosters;
use model::Role;
use serde_json::{Value, json};
use store::people;

use super::{ADA, ADMIN, HEAD, World};
use crate::auth::federation::{invite, is_signed_in_as, texts};
use crate::support::client::{Answer, Client, csrf_in};
use crate::support::course_members::{MemberService, MembersFault, learner};
use crate::support::learning_platform::LaunchMessage;

const TEACHER: &str = "teacher@example.org";
const IN_COHORT: &str =
    "SELECT p.display_name FROM cohort_members m JOIN people p ON p.id = m.person_id ORDER BY p.display_name";

/// A school with the cohort `Spring`, a platform with a course, and the service that lists its members.
struct Course {
    world: World,
    service: MemberService,
    /// Address of the course here.
    href: String,
    /// Id of the cohort.
    cohort: String,
}

impl Course {
    async fn new() -> Self {
        let service = MemberService::start().await;
        let token_url = service.token_url();
        let changes = [("token_url", token_url.as_str()), ("number_claim", "person_sourcedid")];
        let world = World::calling(&changes, vec![service.address.clone()]).await;
        let teacher = world.known(Role::Instructor, TEACHER, "t1").await;
        world.app.cohort(world.school, "Spring", &[&teacher.person]).await;
        let mut course = Self { world, service, href: String::new(), cohort: String::new() };
        let launch = course.message("t1");
        assert_eq!(course.world.launch_anew(&launch).await.1.header("location"), "/");
        let page = course.page().await;
        let start = format!("action=\"{ADMIN}/{}/courses/", course.world.id);
        let id = page.split(&start).nth(1).unwrap_or_else(|| panic!("no course in {page}")).get(..36).unwrap();
        course.href = format!("{ADMIN}/{}/courses/{id}", course.world.id);
        let options = page.split("<select name=\"cohort\">").nth(1).unwrap();
        course.cohort = options.split("<option value=\"").nth(2).unwrap().get(..36).unwrap().to_owned();
        course
    }

    /// A launch from the course.
    fn message(&self, by: &str) -> LaunchMessage {
        let members = json!({ "context_memberships_url": self.service.members_url(), "service_versions": ["2.0"] });
        LaunchMessage::by(by).with("https://purl.imsglobal.org/spec/lti-nrps/claim/namesroleservice", members)
    }

    async fn page(&mut self) -> String {
        self.world.head.get(&format!("{ADMIN}/{}", self.world.id)).await.text()
    }

    /// Sends the form of the course.
    async fn send(&mut self, fields: &[(&str, &str)]) -> Answer {
        let csrf = csrf_in(&self.page().await);
        self.world.head.form(&self.href, &[&[("csrf", csrf.as_str())], fields].concat()).await
    }

    /// Reads the members; the answer leads to the preview.
    async fn read(&mut self) -> Answer {
        let cohort = self.cohort.clone();
        self.send(&[("cohort", &cohort), ("remove_missing", "true"), ("read", "true")]).await
    }

    /// Reads the members; path and page of the preview.
    async fn preview(&mut self) -> (String, String) {
        let answer = self.read().await;
        let path = answer.header("location").to_owned();
        assert!(path.starts_with("/people/rosters/"), "{}", answer.text());
        let page = self.world.head.get(&path).await.text();
        (path, page)
    }

    async fn confirm(&mut self, path: &str, page: &str) -> Answer {
        let digest = page.split("name=\"digest\" value=\"").nth(1).unwrap().split('"').next().unwrap();
        self.world.head.form(path, &[("csrf", &csrf_in(page)), ("digest", digest), ("invite", "yes")]).await
    }

    /// Compares courses that were not compared today; the page then shows the result.
    async fn check(&mut self, result: &str) {
        course_rosters::check_courses(&self.world.app.state).await.unwrap();
        let page = self.page().await;
        assert!(page.contains(result), "{result}: {page}");
    }

    async fn in_cohort(&self) -> Vec<String> {
        texts(&self.world.app, IN_COHORT).await
    }
}

#[tokio::test]
async fn a_course_of_450_members_fills_a_cohort() {
    let mut course = Course::new().await;
    let address = |n: usize| n.is_multiple_of(2).then(|| format!("m{n}@example.edu"));
    let members = (0..450).map(|n| learner(&format!("m{n}"), json!({ "email": address(n) }))).collect();
    course.service.set_members(members);
    let (path, page) = course.preview().await;
    assert_eq!(course.service.requests(), 9);
    course.check("450 differences from the course").await;
    assert!(page.contains("Import 450 lines") && !page.contains("name=\"invite\""), "{page}");
    assert_eq!(course.in_cohort().await.len(), 1, "nothing changes before it is confirmed");
    let done = course.confirm(&path, &page).await;
    assert_eq!(done.header("location"), "/people?added=450&changed=0", "{}", done.text());
    assert_eq!(course.in_cohort().await.len(), 451);
    let made = "SELECT how FROM identities WHERE subject LIKE 'm%'";
    assert_eq!(texts(&course.world.app, made).await, vec!["by_administrator"; 450]);
    assert_eq!(texts(&course.world.app, "SELECT kind FROM mails").await, Vec::<String>::new(), "no invitation");
    let before = course.world.identities().await;
    let (mut browser, answer) = course.world.launch_anew(&course.message("m7")).await;
    assert_eq!(answer.header("location"), "/");
    assert!(browser.get("/account").await.text().contains("Name of m7"));
    assert_eq!(course.world.identities().await, before, "the first launch finds them");
    let (_, page) = course.preview().await;
    assert!(page.contains("Nothing to import"), "{page}");
    course.check("the cohort agrees with the course").await;
    course.service.set_members(Vec::new());
    course.check("the cohort agrees with the course").await;
    course.world.clock().advance(25 * 3600);
    course.world.head = course.world.app.signed_in(HEAD).await;
    course.check("450 differences from the course").await;
    course.world.clock().advance(25 * 3600);
    course.world.head = course.world.app.signed_in(HEAD).await;
    course.service.set_fault(Some(MembersFault::Forbidden));
    course.check("the members could not be read").await;
}

#[tokio::test]
async fn members_are_matched_as_launches_do() {
    let mut course = Course::new().await;
    let world = &course.world;
    world.known(Role::Trainee, ADA, "a1").await;
    let (school_id, role) = (world.school, Role::Trainee);
    let new = people::NewPerson { school_id, role, email: "bo@example.org", display_name: "Bo", password_hash: "" };
    let bo = invite(&world.app, new, Some("4711")).await;
    course.service.set_members(vec![
        learner("a1", json!({ "name": "Another", "email": "another@example.org" })),
        learner("b1", json!({ "name": "Robert", "lis_person_sourcedid": "4711" })),
        learner("a1", json!({})),
        learner("n1", json!({ "name": Value::Null })),
        learner("s1", json!({ "roles": ["Instructor"] })),
        learner("t1", json!({ "roles": ["Instructor"] })),
        learner("h1", json!({ "email": HEAD })),
        learner("g1", json!({ "status": "Deleted" })),
        learner("f1", json!({ "name": "=1+1" })),
    ]);
    let (path, page) = course.preview().await;
    for shown in [
        "joins Spring",
        "links of the learning platform open this account from now on",
        "Member ",
        "does not only learn in the course",
        "is instructor here",
        "another person in this school has this address",
        "begins like a formula",
        "Import 3 lines, skip 4",
    ] {
        assert!(page.contains(shown), "{shown}: {page}");
    }
    assert!(!page.contains("Name of g1") && !page.contains("name was"), "{page}");
    assert_eq!(course.confirm(&path, &page).await.status, 303);
    let names = course.in_cohort().await;
    let [bo_name, nameless, ada_name, teacher] = &names[..] else { panic!("{names:?}") };
    assert_eq!((bo_name.as_str(), ada_name.as_str(), teacher.as_str()), ("Bo", "Somebody", "Somebody"));
    assert!(nameless.starts_with("Member "), "{nameless}");
    let (mut browser, _) = course.world.launch_anew(&course.message("b1")).await;
    assert!(is_signed_in_as(&mut browser, &bo).await);
    let mails = texts(&course.world.app, "SELECT kind FROM mails").await;
    assert_eq!(mails.len(), 1, "a letter tells who has an account: {mails:?}");
    let (_, answer) = course.world.launch_anew(&course.message("h1")).await;
    assert_eq!(answer.header("location"), "/sign-in/join", "an address opens no account");
}

#[tokio::test]
async fn who_has_left_a_course_is_proposed_to_leave() {
    let mut course = Course::new().await;
    course.service.set_members(vec![learner("a1", json!({})), learner("b1", json!({}))]);
    let (path, page) = course.preview().await;
    assert_eq!(course.confirm(&path, &page).await.status, 303);
    let other = course.world.app.member(course.world.school, Role::Trainee, "other@example.org").await;
    course.world.app.cohort(course.world.school, "Spring", &[&other.person]).await;
    course.service.set_members(vec![learner("b1", json!({}))]);
    let (path, page) = course.preview().await;
    assert!(page.contains("Name of a1 leaves Spring"), "{page}");
    assert_eq!(page.matches(" leaves Spring").count(), 1, "neither staff, nor who has joined in another way: {page}");
    assert_eq!(course.in_cohort().await.len(), 4);
    assert_eq!(course.confirm(&path, &page).await.status, 303);
    assert_eq!(course.in_cohort().await, ["Name of b1", "Somebody", "Somebody"]);
    course.service.set_members(vec![]);
    let cohort = course.cohort.clone();
    let unasked = course.send(&[("cohort", &cohort), ("read", "true")]).await;
    let page = course.world.head.get(unasked.header("location")).await.text();
    assert!(!page.contains("leaves Spring"), "{page}");
}

#[tokio::test]
async fn a_course_that_cannot_be_read_stores_nothing() {
    let mut course = Course::new().await;
    course.service.set_members((0..60).map(|n| learner(&format!("m{n}"), json!({}))).collect());
    for (fault, why) in [
        (MembersFault::Circle, "form a circle"),
        (MembersFault::TooLarge, "exceeds 1048576 bytes"),
        (MembersFault::AnotherHost, "on another host"),
        (MembersFault::Forbidden, "HTTP status 403"),
        (MembersFault::Html, "JSON: false"),
        (MembersFault::Nobody, "without user_id"),
    ] {
        course.service.set_fault(Some(fault));
        let refused = course.read().await;
        assert!(refused.status == 422 && refused.text().contains(why), "{fault:?}: {}", refused.text());
    }
    assert_eq!(texts(&course.world.app, "SELECT file_name FROM rosters").await, Vec::<String>::new());
    course.service.set_fault(None);
    course.preview().await;
}

#[tokio::test]
async fn a_course_is_tied_to_a_cohort_of_its_school() {
    let mut course = Course::new().await;
    let untied = course.send(&[("cohort", ""), ("read", "true")]).await;
    assert!(untied.status == 422 && untied.text().contains("Choose the cohort"), "{}", untied.text());
    let cohort = course.cohort.clone();
    assert_eq!(course.send(&[("cohort", &cohort)]).await.status, 303);
    assert!(course.page().await.contains(&format!("value=\"{cohort}\" selected")));
    for nothing in ["x", "0190b5d8-7c4b-7000-8000-000000000000"] {
        assert_eq!(course.send(&[("cohort", nothing)]).await.status, 404, "{nothing}");
    }
    let south = course.world.app.school("South").await;
    course.world.app.member(south, Role::Administrator, "abroad@example.org").await;
    course.world.app.member(course.world.school, Role::Trainee, ADA).await;
    for (email, status) in [("abroad@example.org", 404), (ADA, 403), (TEACHER, 403)] {
        let mut other: Client = course.world.app.signed_in(email).await;
        let csrf = csrf_in(&other.get("/account").await.text());
        let fields = [("csrf", csrf.as_str()), ("cohort", &cohort), ("read", "true")];
        assert_eq!(other.form(&course.href, &fields).await.status, status, "{email}");
    }
    assert_eq!(course.service.requests(), 0);
    assert_eq!(course.send(&[("cohort", "")]).await.status, 303);
    assert!(!course.page().await.contains(" selected>Spring"));
    let acts = "SELECT action FROM audit_log WHERE action = 'platform.course_tied'";
    assert_eq!(texts(&course.world.app, acts).await.len(), 2);
}

#[tokio::test]
async fn without_their_address_members_are_not_read() {
    let mut course = Course::new().await;
    let launch = LaunchMessage::by("t1");
    assert_eq!(course.world.launch_anew(&launch).await.1.header("location"), "/");
    assert!(course.page().await.contains("does not share its members"));
    let refused = course.read().await;
    assert!(refused.status == 422 && refused.text().contains("does not share the members"), "{}", refused.text());
}
