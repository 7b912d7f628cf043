//! A guest professional from a code to an answered survey, through a real browser and the window: an instructor makes a study and a code
//! on its pages, the guest practises at a paired station and goes home, answers by the link that the study's page makes
//! afterwards, and the results have the answers beside that attempt's forces. Fails when one of them cannot
//! get from one step to the next, when an answer is of another attempt or lost on the way, when a page breaks an accessibility rule, or when
//! the guest counts anywhere but in the study.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use fantoccini::Locator;
use serde_json::{Value, json};
use tests::run_ok;

use super::browser::{Driver, complaints, contains, inspect, lands, press, sign_in};
use super::guest::{GuestAtWindow, INSTRUMENT, at_home, found_service};
use super::journeys::School;
use super::window::{with_extension, within};

const TEACHER: &str = "ina@example.org";
const HEAD: &str = "head@example.org";
/// What the guest answers to the first question.
const FIRST_ANSWER: &str = "40";
/// The second question.
const SECOND: &str = r#"
[[item]]
id = "effort"
text = { en = "How much effort?" }
scale = "line"
"#;
/// A force that every attempt at the exercise has.
const FORCE: &str = "m_peak_force_n";
/// Where those who practise are counted and listed; a guest is nobody there. An instructor is refused the last two.
const ELSEWHERE: [&str; 7] =
    ["/", "/cohorts", "/review", "/progress", "/exercises/feel-the-layers", "/progress/attempts.csv", "/people"];
/// The words of a page without its form tokens, or a file.
const WORDS: &str = "
    const [address, done] = arguments;
    const read = (text) => new DOMParser().parseFromString(text, 'text/html').querySelector('main')?.textContent ?? text;
    fetch(address).then((answer) => answer.text()).then((text) => done(read(text)));";

impl School<'_> {
    /// The code that the open page shows once.
    async fn shown_code(&self) -> String {
        self.browser.find(Locator::Css(".code-to-type")).await.expect("a code").text().await.expect("its words")
    }

    /// Ticks a box.
    pub(super) async fn tick(&self, css: &str) {
        let found = self.browser.find(Locator::Css(css)).await.unwrap_or_else(|_| panic!("no box {css}"));
        found.click().await.expect("it is ticked");
    }

    /// Makes a study on its page; its address.
    async fn makes_study(&self) -> String {
        sign_in(self.browser, self.url, TEACHER).await;
        self.open("/studies/new", "a new study").await;
        self.type_into("#title", "Is it like a patient?").await;
        self.tick("input[name=exercise][value=feel-the-layers]").await;
        self.browser.execute("document.querySelector('#attempts').value = '1'", vec![]).await.expect("a field");
        self.tick("input[name=after][value=one-question]").await;
        self.type_into("#contact", "study@example.org").await;
        self.send("/studies/new", "/studies/").await;
        inspect(self.browser, "a study without participants").await;
        self.path().await
    }

    /// The code of a guest, an expert, from the study's page.
    async fn adds_guest(&self, study: &str) -> String {
        self.open(study, "a study").await;
        self.choose("#group", "2").await;
        self.type_into("#fact-0", "Anaesthetist").await;
        self.tick("form[action$='/participants'] input[name=consent]").await;
        self.send("/participants", "/participants").await;
        inspect(self.browser, "a guest's code").await;
        self.shown_code().await
    }

    /// Pairs a station whose user's home is `home`.
    async fn pairs(&self, home: &Path) {
        sign_in(self.browser, self.url, HEAD).await;
        self.open("/admin", "the administration").await;
        press(self.browser, "/admin/pairing-codes").await;
        let code = self.shown_code().await;
        let pair = ["pair", "--server", self.url, "--code", &code, "--name", "lab 2"];
        assert!(at_home(home, &pair).output().expect("stylet starts").status.success());
    }

    /// Makes the link by which the guest answers, and opens it in a browser that nobody has signed in with.
    async fn follows_link(&self, study: &str) {
        sign_in(self.browser, self.url, TEACHER).await;
        self.shows_soon(study, "1 of 1").await;
        let button = self.browser.find(Locator::Css("button[formaction$='/links']")).await.expect("a button");
        button.click().await.expect("it is pressed");
        lands(self.browser, |path| path.ends_with("/links")).await;
        inspect(self.browser, "a link to answer").await;
        let link = self.browser.find(Locator::Css("main table a[href*='/survey/']")).await.expect("a link");
        let link = link.attr("href").await.expect("its address").expect("an address");
        self.browser.delete_all_cookies().await.expect("cookies can be dropped");
        self.browser.goto(&link).await.expect("the link opens");
        inspect(self.browser, "what a guest is told before a survey").await;
    }

    /// Agrees, and answers both questions.
    async fn answers_both(&self) {
        self.tick("input[name=consent]").await;
        self.tick("form.prose button[type=submit]").await;
        contains(self.browser, "the guest's survey", &["how hard?", "how much effort?"]).await;
        self.tick(&format!("fieldset:nth-of-type(1) input[value='{FIRST_ANSWER}']")).await;
        self.tick("fieldset:nth-of-type(2) input[value='55']").await;
        self.tick("button[value=send]").await;
        contains(self.browser, "the end of the survey", &["thank you"]).await;
    }

    /// The words of a page, or a file, as whoever is signed in gets them.
    async fn fetched(&self, address: &str) -> String {
        let text = self.browser.execute_async(WORDS, vec![json!(address)]).await.expect("a script");
        text.as_str().expect("a text").to_owned()
    }

    /// What the school says of those who practise, to an administrator and to an instructor.
    async fn tallies(&self) -> Vec<String> {
        let mut told = Vec::new();
        for (email, places) in [(HEAD, &ELSEWHERE[..]), (TEACHER, &ELSEWHERE[..ELSEWHERE.len() - 2])] {
            sign_in(self.browser, self.url, email).await;
            for path in places {
                told.push(format!("{path} of {email}: {}", self.fetched(path).await));
            }
        }
        told
    }

    /// The study has the answers beside the attempt and its forces.
    async fn study_shows(&self, study: &str, attempt: &Attempt) {
        sign_in(self.browser, self.url, TEACHER).await;
        self.open(&format!("{study}/results"), "the results of a study").await;
        contains(self.browser, "the results of a study", &["how hard?", "how much effort?", FIRST_ANSWER]).await;
        let table = self.fetched(&format!("{study}/results/study.csv")).await;
        let row = row_of(&table, &attempt.session);
        assert_eq!((row["q1_mental"].as_str(), row["q1_effort"].as_str()), (FIRST_ANSWER, "55"));
        assert!(row[FORCE].parse::<f64>().is_ok_and(|force_n| (force_n - attempt.peak_n).abs() < 1e-6), "{row:?}");
        self.open(study, "a study with answers").await;
        contains(self.browser, "a study with answers", &["anaesthetist", "1 of 1", &row["participant"].to_lowercase()])
            .await;
    }
}

/// What the guest has made.
struct Attempt {
    session: String,
    /// The largest force of the recording, in N.
    peak_n: f64,
}

/// The row of an attempt, by the names of the columns.
fn row_of(table: &str, session: &str) -> BTreeMap<String, String> {
    let names = table.trim_start_matches('\u{feff}').lines().next().expect("names");
    let row = table.lines().find(|line| line.contains(session)).expect("the attempt");
    names.split(',').zip(row.split(',')).map(|(name, cell)| (name.to_owned(), cell.to_owned())).collect()
}

/// The largest force of a recording, as the simulator itself tells it.
fn largest_force_n(recording: &Path) -> f64 {
    let told = run_ok("stylet", &["score", &recording.to_string_lossy(), "--json"]);
    let told: Value = serde_json::from_str(&told).expect("JSON");
    let mut metrics = told["metrics"].as_array().expect("metrics").iter();
    let peak = metrics.find(|metric| metric["id"] == "peak_force_n").expect("the largest force");
    peak["value"].as_f64().expect("a number")
}

/// At the window: agrees and practises. The guest, still there, and the recording.
fn practises(home: &Path, kept: &Path, code: &str) -> (GuestAtWindow, PathBuf) {
    let guest = GuestAtWindow::sit_down(home, kept);
    guest.type_code(code);
    guest.press(&["Tab", "space"]);
    guest.display.begin_attempt(kept);
    (guest, within(90, "the recording", || with_extension(kept, "mcap")))
}

/// Leaves the questions of the debriefing, and goes home.
fn goes_home(mut guest: GuestAtWindow, home: &Path) {
    guest.display.close();
    within(60, "the end of the window", || guest.play.try_wait().expect("its state"));
    let sent = at_home(home, &["outbox", "send"]).output().expect("stylet starts");
    assert!(sent.status.success(), "{}", String::from_utf8_lossy(&sent.stderr));
}

#[tokio::test]
async fn a_guest_from_a_code_to_an_answered_survey() {
    let folder = tempfile::tempdir().expect("a folder");
    let (home, kept) = (folder.path().join("home"), folder.path().join("kept"));
    fs::create_dir(&kept).expect("a folder");
    let service = found_service(folder.path(), &[INSTRUMENT, SECOND].concat());
    let driver = Driver::start();
    let browser = driver.browser(&folder.path().join("profile")).await;
    let school = School { browser: &browser, url: &service.url, folder: folder.path() };
    school.pairs(&home).await;
    let study = school.makes_study().await;
    let before = school.tallies().await;
    sign_in(&browser, &service.url, TEACHER).await;
    let code = school.adds_guest(&study).await;
    let (guest, recording) = practises(&home, &kept, &code);
    school.shows_soon(&study, "1 of 1").await;
    goes_home(guest, &home);
    school.follows_link(&study).await;
    school.answers_both().await;
    let session = recording.file_stem().expect("a name").to_string_lossy().into_owned();
    let peak_n = largest_force_n(&recording);
    school.study_shows(&study, &Attempt { session, peak_n }).await;
    assert_eq!(school.tallies().await, before, "a guest counts nowhere but in the study");
    let complaints = complaints(&browser).await;
    browser.close().await.expect("the browser closes");
    assert!(complaints.is_empty(), "the browser complains: {complaints:#?}");
}
