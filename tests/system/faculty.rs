//! A year of a faculty, through a real browser: an administrator imports outcomes and compares the cohorts of two terms, an instructor
//! decides on a level, helps a trainee at risk and holds an exam, and the trainee subscribes to due dates and saves a transcript. Fails when one of
//! them cannot get from one step to the next, when a page does not show what was decided, sent or recorded, when a revoked calendar
//! is still served, or when a page on the way breaks an accessibility rule.

use std::path::Path;

use fantoccini::Locator;
use serde_json::json;
use tests::{Service, run_ok};

use super::browser::{Driver, PASSWORD, complaints, contains, follow, sign_in};
use super::journeys::{INSTRUCTOR, School, TRAINEE, found_school};
use super::visitor::{INITIAL, choose_password};

const HEAD: &str = "head@journey.example";
const OUTCOMES: &str =
    "code,title,description\nEPA 1,Punctures the lower back,Finds the level\nEPA 2,Obtains consent,\n";
/// Sets a field of a day, or of a day and a time, to now and a number of days. What its keys enter depends on the browser's language.
const SET_DAY: &str = "
    const [css, days] = arguments;
    const field = document.querySelector(css);
    field.value = new Date(Date.now() + days * 86400000).toISOString().slice(0, field.type === 'date' ? 10 : 16);";
/// Reads a file, a character for each byte.
const BYTES: &str = "
    const [address, done] = arguments;
    const read = (bytes) => new TextDecoder('latin1').decode(bytes);
    fetch(address).then((answer) => answer.arrayBuffer()).then((bytes) => done(read(bytes)), (error) => done(String(error)));";

impl School<'_> {
    async fn set_day(&self, css: &str, days: i32) {
        self.browser.execute(SET_DAY, vec![json!(css), json!(days)]).await.unwrap_or_else(|_| panic!("no field {css}"));
    }

    /// Opens the page of a cohort by its name; returns its path.
    async fn open_cohort(&self, name: &str) -> String {
        self.open("/cohorts", "the cohorts").await;
        let link = self.browser.find(Locator::LinkText(name)).await.unwrap_or_else(|_| panic!("no cohort {name}"));
        let path = link.attr("href").await.expect("a link").expect("an address");
        self.open(&path, "a cohort").await;
        path
    }

    /// Imports a catalogue, and names the course that leads to its first outcome; returns the outcome's id.
    async fn imports_outcomes(&self) -> String {
        sign_in(self.browser, self.url, HEAD).await;
        self.open("/admin/outcomes", "a school without outcomes").await;
        let file = self.folder.join("outcomes.csv");
        std::fs::write(&file, OUTCOMES).expect("a catalogue");
        self.type_into("#file", &file.to_string_lossy()).await;
        self.send("/admin/outcomes/file", "/admin/outcomes").await;
        contains(self.browser, "the imported outcomes", &["added: 2", "punctures the lower back"]).await;
        follow(self.browser, "/admin/outcomes/").await;
        self.tick("input[name=courses][value='lower-back-basics']").await;
        let outcome = self.path().await;
        self.send(&outcome, "/admin/outcomes").await;
        contains(self.browser, "the outcomes with their courses", &["lower back: first punctures"]).await;
        outcome.trim_start_matches("/admin/outcomes/").to_owned()
    }

    /// Puts two cohorts into the terms of two years, and compares them.
    async fn compares_terms(&self) {
        for (name, days) in [("This term", -8), ("Last term", -373)] {
            self.open("/admin/terms", "the terms").await;
            self.type_into("#name", name).await;
            self.set_day("#starts_on", days).await;
            self.send("/admin/terms", "/admin/terms").await;
        }
        for (cohort, term) in [("Spring", "Last term"), ("Autumn", "This term")] {
            let programme = format!("{}/programme", self.open_cohort(cohort).await);
            self.open(&programme, "a cohort without a term").await;
            let terms = self.browser.find(Locator::Css("#term")).await.expect("a list of terms");
            terms.select_by_label(term).await.unwrap_or_else(|_| panic!("no term {term}"));
            self.send("/term", "/programme").await;
        }
        let shown = ["end of week 2", "autumn · this term, n = 1", "spring · last term, n = 1"];
        contains(self.browser, "a comparison", &shown).await;
    }

    /// Assigns a course that is due soon, and decides on a level of an outcome; returns the path of the trainee's page.
    async fn decides(&self, outcome: &str) -> String {
        sign_in(self.browser, self.url, INSTRUCTOR).await;
        let cohort = self.open_cohort("Autumn").await;
        self.open("/assignments", "assignments").await;
        self.choose("#task", "course:lower-back-basics").await;
        self.choose("#cohort", cohort.trim_start_matches("/cohorts/")).await;
        self.set_day("#due", 3).await;
        self.send("/assignments", "/assignments/").await;
        self.open(&cohort, "a cohort with an assignment").await;
        follow(self.browser, "/trainees/").await;
        let trainee = self.path().await;
        self.open(&format!("{trainee}/outcomes"), "a trainee's outcomes").await;
        self.tick("main details.ask summary").await;
        self.choose("#level-1", "3").await;
        self.type_into("#note-1", "Steady hands in June").await;
        self.send(&format!("/outcomes/{outcome}"), "/outcomes").await;
        let decided = ["3 – acts with supervision on call", "steady hands in june"];
        contains(self.browser, "a decision", &decided).await;
        trainee
    }

    /// Examines a trainee at a station with a checklist, and closes the exam.
    async fn examines(&self) {
        self.open("/exams", "no exams").await;
        self.type_into("#title", "Back station").await;
        self.choose("#exercise", "feel-the-layers").await;
        self.choose("#instrument", "puncture-checklist").await;
        self.browser.execute("document.querySelector('#limit').value = '10'", Vec::new()).await.expect("a field");
        self.send("/exams", "/exams/").await;
        let exam = self.path().await;
        follow(self.browser, &format!("{exam}/candidates/")).await;
        self.send("/begin", "/candidates/").await;
        contains(self.browser, "a sitting", &["min left", "examiner: ina"]).await;
        let all_done = "document.querySelectorAll('main fieldset input[value=\"1\"]').forEach((box) => box.click())";
        self.browser.execute(all_done, Vec::new()).await.expect("a checklist");
        self.send(&self.path().await, "/exams/").await;
        self.open(&exam, "an exam with a finished sitting").await;
        self.tick("#sure").await;
        self.send("/close", "/exams/").await;
        contains(self.browser, "a closed exam", &["closed", "ina", "not received"]).await;
    }

    /// Writes to a trainee at risk, and records a conversation.
    async fn helps(&self, trainee: &str) {
        let chosen = "#support input[aria-label='Nia']";
        self.open("/at-risk", "people at risk").await;
        contains(self.browser, "people at risk", &["nia", "not started"]).await;
        self.tick(chosen).await;
        self.type_into("#subject", "An hour together?").await;
        self.type_into("#body", "I am at the station on Monday.").await;
        self.send("/at-risk", "/at-risk").await;
        contains(self.browser, "a sent message", &["mailed to 1 person", "mailed by ina"]).await;
        self.tick(chosen).await;
        self.tick("#support input[value=spoken]").await;
        self.type_into("#body", "Two attempts a week.").await;
        self.send("/at-risk", "/at-risk").await;
        contains(self.browser, "a recorded conversation", &["recorded for 1 person", "spoken to by ina"]).await;
        self.open(trainee, "a trainee who was helped").await;
        contains(self.browser, "a trainee who was helped", &["an hour together?", "two attempts a week."]).await;
    }

    /// Reads the message, subscribes to due dates by a secret address, and revokes it.
    async fn subscribes(&self) {
        sign_in(self.browser, self.url, TRAINEE).await;
        contains(self.browser, "a trainee's home", &["i am at the station on monday."]).await;
        self.open("/account/calendar", "no calendar").await;
        self.send("/account/calendar", "/account/calendar").await;
        let field = self.browser.find(Locator::Css("#feed")).await.expect("a field of the address");
        let address = field.prop("value").await.expect("a field").expect("an address");
        let feed = format!("{}{}", self.url, &address[address.find("/calendar/").expect("a path")..]);
        // A calendar program has no cookies.
        let mut served = ureq::get(&feed).call().expect("a calendar");
        let calendar = served.body_mut().read_to_string().expect("a text");
        assert!(calendar.starts_with("BEGIN:VCALENDAR"), "{calendar}");
        assert!(calendar.contains("SUMMARY:Due: Lower back: first punctures"), "{calendar}");
        self.tick("main details.ask summary").await;
        self.send("/revoke", "/account/calendar").await;
        let revoked = ureq::get(&feed).call();
        assert!(matches!(revoked, Err(ureq::Error::StatusCode(404))), "a revoked calendar is served: {revoked:?}");
    }

    /// Sees the own result of the closed exam.
    async fn sees_result(&self) {
        self.open("/exams", "a trainee's results").await;
        contains(self.browser, "a trainee's results", &["back station", "the examiner’s answers"]).await;
    }

    /// Finds the level on the transcript, and saves it as a PDF.
    async fn saves_transcript(&self, trainee: &str) {
        self.open(&format!("{trainee}/transcript"), "a transcript").await;
        let level = ["epa 1 punctures the lower back", "acts with supervision on call", "ina, "];
        contains(self.browser, "a transcript", &level).await;
        let link = self.browser.find(Locator::Css("main a[href$='/transcript.pdf']")).await.expect("a PDF");
        let address = link.attr("href").await.expect("a link").expect("an address");
        let file = self.browser.execute_async(BYTES, vec![json!(address)]).await.expect("a file");
        let file = file.as_str().unwrap_or_default();
        assert!(file.starts_with("%PDF-"), "not a PDF: {}", file.chars().take(200).collect::<String>());
        assert!(file.contains("Transcript of Nia"), "the PDF has another title");
    }
}

/// A school with courses, an instructor, and a trainee in each of two cohorts, in a data folder.
fn found_faculty(data: &str) {
    found_school(data);
    for (name, email, role, cohort) in [
        ("Ina", INSTRUCTOR, "instructor", "Autumn"),
        ("Nia", TRAINEE, "trainee", "Autumn"),
        ("Bo", "bo@journey.example", "trainee", "Spring"),
    ] {
        let person = ["--name", name, "--email", email, "--role", role, "--cohort", cohort, "--password", INITIAL];
        run_ok("web-admin", &[&["user", "add", "--data-dir", data][..], &person].concat());
    }
}

#[tokio::test]
async fn a_year_from_its_outcomes_to_a_transcript() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data").to_string_lossy().into_owned();
    found_faculty(&data);
    let service = Service::start(Path::new(&data));
    for email in [HEAD, INSTRUCTOR, TRAINEE] {
        choose_password(&service.url, email, PASSWORD);
    }
    let driver = Driver::start();
    let browser = driver.browser(&folder.path().join("profile")).await;
    let school = School { browser: &browser, url: &service.url, folder: folder.path() };
    let outcome = school.imports_outcomes().await;
    school.compares_terms().await;
    let trainee = school.decides(&outcome).await;
    school.helps(&trainee).await;
    school.examines().await;
    school.subscribes().await;
    school.sees_result().await;
    school.saves_transcript(&trainee).await;
    let complaints = complaints(&browser).await;
    browser.close().await.expect("the browser closes");
    assert!(complaints.is_empty(), "the browser complains: {complaints:#?}");
}
