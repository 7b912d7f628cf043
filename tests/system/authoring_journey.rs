//! An exercise from its title to an answered attempt, through a real browser: an instructor writes it in a form, publishes it, adds it to a
//! course and assigns it, sees who is late, and comments at a moment; the trainee finds both under "New for you". Fails when one of
//! them cannot get from one step to the next without TOML, or when a page on the way breaks an accessibility rule.

use std::path::{Path, PathBuf};

use fantoccini::Locator;
use tests::{Service, root, run_ok};

use super::browser::{Driver, PASSWORD, complaints, contains, follow, inspect, lands, sign_in};
use super::journeys::{INSTRUCTOR, School, TRAINEE, Upload, found_school, upload_attempt_at};
use super::visitor::{INITIAL, choose_password};

const EXERCISE: &str = "/exercises/gentle-first-steps";

impl School<'_> {
    /// Puts a text in the place of what stands in a field.
    async fn retype(&self, css: &str, text: &str) {
        let field = self.browser.find(Locator::Css(css)).await.unwrap_or_else(|_| panic!("no field {css}"));
        field.clear().await.expect("it can be emptied");
        field.send_keys(text).await.expect("it takes what is typed");
    }

    /// Presses a button of the draft's form by what it sends, and waits for an element of the page that follows.
    async fn press_act(&self, act: &str, then: &str) {
        let css = format!(".editor button[value='{act}']:not(.visually-hidden)");
        let button = self.browser.find(Locator::Css(&css)).await.unwrap_or_else(|_| panic!("no button {act}"));
        button.click().await.expect("it is pressed");
        let found =
            self.browser.wait().at_most(std::time::Duration::from_secs(20)).for_element(Locator::Css(then)).await;
        found.unwrap_or_else(|_| panic!("after {act} there is no {then}"));
    }

    async fn value_of(&self, css: &str) -> String {
        let script = "return document.querySelector(arguments[0]).value";
        let value = self.browser.execute(script, vec![css.into()]).await.expect("a value");
        value.as_str().unwrap_or_default().to_owned()
    }

    /// Writes an exercise in a form; its file, as it is published.
    async fn writes(&self) -> PathBuf {
        sign_in(self.browser, self.url, INSTRUCTOR).await;
        self.open("/drafts", "drafts").await;
        self.choose("#copy", "feel-the-layers").await;
        self.type_into("#new-title", "Gentle first steps").await;
        self.send("/drafts", "/drafts/").await;
        inspect(self.browser, "the form of an exercise").await;
        self.type_into("#f-title-de", "Sanfte erste Schritte").await;
        self.retype("#f-target-depth-mm", "17,5").await;
        self.choose("#f-rubric-new", "overshoot_mm").await;
        let rows = self.browser.find_all(Locator::Css(".form-row[id^='f-rubric-']")).await.expect("rows").len();
        self.press_act("add:rubric", &format!("#f-rubric-{rows}-full")).await;
        inspect(self.browser, "a form with a row that lacks its numbers").await;
        contains(self.browser, "a form with a new row", &["missing; allowed: a number"]).await;
        self.type_into(&format!("#f-rubric-{rows}-full"), "0.50").await;
        self.type_into(&format!("#f-rubric-{rows}-zero"), "9").await;
        self.press_act("save", ".notice.good").await;
        self.press_act("toml", "#document").await;
        inspect(self.browser, "the same as TOML").await;
        let document = self.value_of("#document").await;
        assert!(document.contains("depth_mm = 17.5\n") && document.contains("full = 0.50\n"), "{document}");
        self.press_act("form", "#f-title-en").await;
        let folder = self.folder.join("written");
        std::fs::create_dir_all(folder.join("course")).expect("a folder");
        std::fs::create_dir_all(folder.join("scenes")).expect("a folder");
        let scene = "scenes/lower-back-training.toml";
        std::fs::copy(root().join("curricula").join(scene), folder.join(scene)).expect("a scene");
        let file = folder.join("course/gentle.toml");
        std::fs::write(&file, document).expect("a file");
        file
    }

    /// Publishes it, puts it into a course, and assigns it until the next minute.
    async fn puts_to_use(&self) -> String {
        self.press_act("publish", ".card.teaching").await;
        inspect(self.browser, "an exercise that was just published").await;
        contains(self.browser, "an exercise that was just published", &["published.", "use in teaching"]).await;
        self.choose("#to-course", "lower-back-basics").await;
        self.send(&format!("{EXERCISE}/course"), "/drafts/").await;
        inspect(self.browser, "the form of a course").await;
        self.press_act("publish", ".notice.good").await;
        contains(self.browser, "the curricula", &["published.", "gentle first steps"]).await;
        self.open(&format!("/assignments?task=exercise:{}", EXERCISE.trim_start_matches("/exercises/")), "assigning")
            .await;
        let cohort = "return [...document.querySelectorAll('#cohort option')].map(o => o.value).find(v => v)";
        let cohort = self.browser.execute(cohort, vec![]).await.expect("a cohort");
        self.choose("#cohort", cohort.as_str().expect("an id")).await;
        let soon = "const zone = document.querySelector('label[for=due]').textContent.split(' ').pop();
            const at = new Date(Date.now() + 75000).toLocaleString('sv-SE', { timeZone: zone });
            document.querySelector('#due').value = at.slice(0, 16).replace(' ', 'T')";
        self.browser.execute(soon, vec![]).await.expect("a due date");
        self.send("/assignments", "/assignments/").await;
        contains(self.browser, "an assignment", &["gentle first steps", "nia"]).await;
        self.path().await
    }

    /// Accepts the invitation and finds what was assigned.
    async fn finds_assignment(&self, join: &str) {
        self.browser.delete_all_cookies().await.expect("cookies can be dropped");
        self.open(join, "an invitation").await;
        self.type_into("#password", PASSWORD).await;
        self.type_into("#again", PASSWORD).await;
        self.send(join, "/").await;
        self.open("/", "a trainee's home with an assignment").await;
        contains(self.browser, "a trainee's home", &["news", "gentle first steps"]).await;
    }

    /// Sees who is late, and comments at a moment of the attempt.
    async fn comments(&self) {
        sign_in(self.browser, self.url, INSTRUCTOR).await;
        self.shows_soon("/review", "Nia").await;
        follow(self.browser, "/sessions/").await;
        let attempt = lands(self.browser, |path| path.starts_with("/sessions/")).await;
        self.open(&format!("{attempt}/replay"), "a replay").await;
        self.type_into("#from_s", "1.5").await;
        self.type_into("#body", "Slower through the skin").await;
        self.send("/comments", "/replay").await;
        contains(self.browser, "a replay with a comment", &["slower through the skin"]).await;
        // Away from the replay, which loads for a while, before somebody else signs in.
        self.open("/review", "the queue after a comment").await;
    }
}

#[tokio::test]
async fn an_exercise_from_its_title_to_a_comment() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data").to_string_lossy().into_owned();
    found_school(&data);
    let service = Service::start(Path::new(&data));
    choose_password(&service.url, "head@journey.example", PASSWORD);
    let driver = Driver::start();
    let browser = driver.browser(&folder.path().join("profile")).await;
    let school = School { browser: &browser, url: &service.url, folder: folder.path() };
    let join = school.administrator().await;
    run_ok("web-admin", &["user", "reset-password", "--data-dir", &data, "--email", INSTRUCTOR, "--password", INITIAL]);
    choose_password(&service.url, INSTRUCTOR, PASSWORD);
    let file = school.writes().await;
    let assignment = school.puts_to_use().await;
    school.finds_assignment(&join).await;
    sign_in(&browser, &service.url, INSTRUCTOR).await;
    school.shows_soon("/", "Gentle first steps").await;
    school.shows_soon(&assignment, "Late").await;
    let upload = Upload { folder: folder.path(), url: &service.url, data: &data, email: TRAINEE };
    upload_attempt_at(upload, &file.to_string_lossy());
    school.comments().await;
    sign_in(&browser, &service.url, TRAINEE).await;
    school.open("/", "a trainee's home with a comment").await;
    contains(&browser, "a trainee's home", &["news", "ina"]).await;
    let complaints = complaints(&browser).await;
    browser.close().await.expect("the browser closes");
    assert!(complaints.is_empty(), "the browser complains: {complaints:#?}");
}
