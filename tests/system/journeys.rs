//! A course from its roster to its export, through a real browser: an administrator brings people in, an instructor assigns, looks
//! at the attempt, comments on it and judges it, and the trainee who made it reads and answers. Fails when one of them
//! cannot get from one step to the next, or when a page on the way breaks an accessibility rule.

use std::path::Path;

use fantoccini::{Client, Locator};
use tests::{Service, run_ok};

use super::browser::{
    BETWEEN_LOOKS, Driver, MOST_LOOKS, PASSWORD, complaints, contains, follow, inspect, lands, press, sign_in,
};
use super::visitor::{INITIAL, choose_password};

pub(super) const INSTRUCTOR: &str = "ina@journey.example";
pub(super) const TRAINEE: &str = "nia@journey.example";
/// The first exercise of the course that is assigned.
const EXERCISE: &str = "curricula/lower-back-basics/1-feel-the-layers.toml";

/// A school that was just founded, in a data folder.
/// An attempt of this moment, simulated and uploaded by a trainee. `folder` holds what is needed for that.
pub(super) fn upload_attempt(folder: &Path, url: &str, data: &str, email: &str) {
    upload_attempt_at(Upload { folder, url, data, email }, EXERCISE);
}

/// Where an attempt goes, and whose it is.
#[derive(Clone, Copy)]
pub(super) struct Upload<'a> {
    pub folder: &'a Path,
    pub url: &'a str,
    pub data: &'a str,
    pub email: &'a str,
}

/// The same at an exercise in a file.
pub(super) fn upload_attempt_at(Upload { folder, url, data, email }: Upload<'_>, exercise: &str) {
    let recording = folder.join("attempt.mcap").to_string_lossy().into_owned();
    run_ok("stylet", &["simulate", exercise, "--operator", "novice", "--seed", "5", "--out", &recording]);
    let token = run_ok("web-admin", &["user", "token", "--data-dir", data, "--email", email]);
    let file = folder.join("token");
    std::fs::write(&file, token.split_whitespace().last().expect("a token")).expect("a file");
    let (file, outbox) = (file.to_string_lossy(), folder.join("outbox"));
    let upload = ["upload", &recording, "--server", url, "--token-file", &file, "--outbox"];
    run_ok("stylet", &[&upload[..], &[&outbox.to_string_lossy()]].concat());
}

pub(super) struct School<'a> {
    pub browser: &'a Client,
    pub url: &'a str,
    pub folder: &'a Path,
}

impl School<'_> {
    pub(super) async fn open(&self, path: &str, what: &str) {
        self.browser.goto(&format!("{}{path}", self.url)).await.expect("an address");
        inspect(self.browser, what).await;
    }

    pub(super) async fn type_into(&self, css: &str, text: &str) {
        let field = self.browser.find(Locator::Css(css)).await.unwrap_or_else(|_| panic!("no field {css}"));
        field.send_keys(text).await.expect("it takes what is typed");
    }

    pub(super) async fn choose(&self, css: &str, value: &str) {
        let field = self.browser.find(Locator::Css(css)).await.unwrap_or_else(|_| panic!("no list {css}"));
        field.select_by_value(value).await.unwrap_or_else(|_| panic!("{css} has no {value}"));
    }

    /// Presses the button of the form that is sent to an address that ends so, and waits for where it leads.
    pub(super) async fn send(&self, action: &str, lands_at: &str) {
        let css = format!("main form[action$='{action}'] button[type=submit]");
        let button = self.browser.find(Locator::Css(&css)).await.unwrap_or_else(|_| panic!("no button {css}"));
        // A form may lead to the page that it stands on: the next document is waited for, not its address.
        let mark = "document.documentElement.dataset.sent = 'yes'";
        self.browser.execute(mark, Vec::new()).await.expect("a page");
        button.click().await.expect("it is pressed");
        self.waits_for_next_page().await;
        let landed = lands(self.browser, |path| path.contains(lands_at)).await;
        assert!(landed.contains(lands_at), "{action} led to {landed}");
    }

    /// Until the page from which a form was sent is gone. While one goes and the other comes there is none to ask.
    async fn waits_for_next_page(&self) {
        let is_next = "return document.readyState !== 'loading' && !document.documentElement.dataset.sent";
        for _ in 0..MOST_LOOKS {
            if self.browser.execute(is_next, Vec::new()).await.is_ok_and(|answer| answer == true) {
                return;
            }
            tokio::time::sleep(BETWEEN_LOOKS).await;
        }
    }

    pub(super) async fn path(&self) -> String {
        self.browser.current_url().await.expect("an address").path().to_owned()
    }

    /// Opens a page until it shows some words: what is uploaded is scored a little later.
    pub(super) async fn shows_soon(&self, path: &str, word: &str) {
        for _ in 0..MOST_LOOKS {
            self.browser.goto(&format!("{}{path}", self.url)).await.expect("an address");
            let text = self.browser.find(Locator::Css("main")).await.expect("a page").text().await.expect("its words");
            if text.contains(word) {
                return;
            }
            tokio::time::sleep(BETWEEN_LOOKS).await;
        }
        panic!("{path} never showed {word:?}");
    }

    /// Two people by a roster; the link by which the trainee chooses her password.
    pub(super) async fn administrator(&self) -> String {
        sign_in(self.browser, self.url, "head@journey.example").await;
        self.open("/people", "people").await;
        let roster = self.folder.join("roster.csv");
        let lines =
            format!("email,name,role,cohort\n{INSTRUCTOR},Ina,instructor,Autumn\n{TRAINEE},Nia,trainee,Autumn\n");
        std::fs::write(&roster, lines).expect("a roster");
        self.open("/people/roster", "importing a roster").await;
        self.type_into("input[type=file]", &roster.to_string_lossy()).await;
        self.send("/people/roster", "/people/rosters/").await;
        inspect(self.browser, "what a roster would change").await;
        contains(self.browser, "what a roster would change", &["ina", "nia"]).await;
        let import = self.path().await;
        self.send(&import, "/people").await;
        self.open("/people?q=nia", "people who were looked for").await;
        // The first link to a person; the page links to the roster as well.
        let nia = self.browser.find(Locator::Css("main table a[href^='/people/']")).await.expect("she is listed");
        nia.click().await.expect("the link opens");
        lands(self.browser, |path| path.starts_with("/people/")).await;
        inspect(self.browser, "a person").await;
        self.send("/link", "/link").await;
        inspect(self.browser, "a link to hand over").await;
        let link =
            self.browser.find(Locator::Css(".link-to-copy")).await.expect("a link").text().await.expect("its words");
        self.open("/admin", "the administration").await;
        press(self.browser, "/admin/pairing-codes").await;
        inspect(self.browser, "a pairing code").await;
        self.open("/admin/service", "the service").await;
        self.open("/admin/settings", "the settings").await;
        self.open("/admin/audit", "the audit log").await;
        contains(self.browser, "the audit log", &["imported a roster", "added a person"]).await;
        self.open("/progress", "the school's progress").await;
        link[link.find("/join/").expect("a path")..].to_owned()
    }

    /// Assigns a course to her cohort.
    async fn assigns(&self) {
        sign_in(self.browser, self.url, INSTRUCTOR).await;
        self.open("/cohorts", "the cohorts").await;
        follow(self.browser, "/cohorts/").await;
        inspect(self.browser, "a cohort without attempts").await;
        let cohort = self.path().await;
        self.open(&format!("{cohort}/people"), "the people of a cohort").await;
        self.open("/curricula", "the curricula").await;
        self.open("/assignments", "assignments").await;
        self.choose("#task", "course:lower-back-basics").await;
        self.choose("#cohort", cohort.trim_start_matches("/cohorts/")).await;
        self.send("/assignments", "/assignments/").await;
        inspect(self.browser, "an assignment").await;
        contains(self.browser, "an assignment", &["nia"]).await;
    }

    /// Chooses a password, finds what was assigned, and makes an attempt at it; the attempt's page.
    async fn practises(&self, join: &str, data: &str) -> String {
        self.browser.delete_all_cookies().await.expect("cookies can be dropped");
        self.open(join, "an invitation").await;
        self.type_into("#password", PASSWORD).await;
        self.type_into("#again", PASSWORD).await;
        self.send(join, "/").await;
        self.open("/assignments", "a trainee's assignments").await;
        contains(self.browser, "a trainee's assignments", &["lower back"]).await;
        upload_attempt(self.folder, self.url, data, TRAINEE);
        self.shows_soon("/", "1 attempt in all").await;
        inspect(self.browser, "a trainee's home after an attempt").await;
        follow(self.browser, "/sessions/").await;
        // The page is there before the score is.
        let attempt = lands(self.browser, |path| path.starts_with("/sessions/")).await;
        self.shows_soon(&attempt, "out of 100").await;
        inspect(self.browser, "a result").await;
        contains(self.browser, "a result", &["out of 100", "force"]).await;
        self.path().await
    }

    /// Looks at the attempt, comments on it, overrides its score, and takes the figures away.
    async fn judges(&self, session: &str) {
        sign_in(self.browser, self.url, INSTRUCTOR).await;
        self.open("/review", "the queue").await;
        contains(self.browser, "the queue", &["nia"]).await;
        follow(self.browser, session).await;
        self.open(&format!("{session}/replay"), "a replay").await;
        self.type_into("#from_s", "1.5").await;
        self.type_into("#body", "Slower through the skin").await;
        self.send("/comments", "/replay").await;
        self.open(&format!("{session}/grade"), "a grade").await;
        self.type_into("#score", "91").await;
        self.choose("#result", "passed").await;
        self.type_into("#reason", "The target was reached").await;
        self.send("/override", "/grade").await;
        self.shows_soon(&format!("{session}/grade"), "The target was reached").await;
        inspect(self.browser, "an overridden grade").await;
        self.open("/cohorts", "the cohorts with an attempt").await;
        follow(self.browser, "/cohorts/").await;
        inspect(self.browser, "a cohort").await;
        let progress = format!("{}/progress", self.path().await);
        self.open(&progress, "a cohort's progress").await;
        let export =
            "const done = arguments[1]; fetch(arguments[0]).then(a => a.text()).then(done, e => done(String(e)))";
        let address = serde_json::json!(format!("{progress}.csv"));
        let csv = self.browser.execute_async(export, vec![address]).await.expect("a file");
        assert!(csv.as_str().is_some_and(|csv| csv.contains("Nia")), "{csv}");
    }

    /// Reads what was said, and answers.
    async fn answers(&self, session: &str) {
        sign_in(self.browser, self.url, TRAINEE).await;
        self.open(session, "an overridden result").await;
        contains(self.browser, "an overridden result", &["91", "the target was reached"]).await;
        self.open(&format!("{session}/replay"), "a replay with a comment").await;
        contains(self.browser, "a replay with a comment", &["slower through the skin"]).await;
        self.browser
            .find(Locator::Css(".comment summary"))
            .await
            .expect("a way to answer")
            .click()
            .await
            .expect("it opens");
        self.type_into(".comment textarea", "I will").await;
        self.send("/answers", "/replay").await;
        self.shows_soon(&format!("{session}/replay"), "I will").await;
        inspect(self.browser, "an answered comment").await;
    }
}

/// A school with an administrator and the shipped courses.
pub(super) fn found_school(data: &str) {
    let head = ["user", "add", "--data-dir", data, "--school", "North", "--role", "administrator"];
    run_ok("web-admin", &["migrate", "--data-dir", data]);
    run_ok(
        "web-admin",
        &[&head[..], &["--email", "head@journey.example", "--name", "Head", "--password", INITIAL]].concat(),
    );
    run_ok("web-admin", &["curricula", "import", "curricula", "--data-dir", data, "--school", "North"]);
}

#[tokio::test]
async fn a_course_from_its_roster_to_its_export() {
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
    school.assigns().await;
    let session = school.practises(&join, &data).await;
    school.judges(&session).await;
    school.answers(&session).await;
    let complaints = complaints(&browser).await;
    browser.close().await.expect("the browser closes");
    assert!(complaints.is_empty(), "the browser complains: {complaints:#?}");
}
