//! A questionnaire from its title to an answer, through a real browser: an instructor writes it in a form in two languages, looks at it as
//! whoever answers does, publishes it and makes a survey with it; the trainee answers in German. Fails when one of them cannot get from one
//! step to the next without TOML, or when a page on the way breaks an accessibility rule.

use std::path::Path;

use fantoccini::Locator;
use tests::{Service, run_ok};

use super::browser::{Driver, PASSWORD, complaints, contains, inspect, lands, sign_in};
use super::journeys::{INSTRUCTOR, School, found_school};
use super::visitor::{INITIAL, choose_password};

impl School<'_> {
    /// Presses something, and waits until the page's address has a part.
    async fn press_until(&self, css: &str, lands_at: &str) {
        let button = self.browser.find(Locator::Css(css)).await.unwrap_or_else(|_| panic!("no button {css}"));
        button.click().await.expect("it is pressed");
        let landed = lands(self.browser, |path| path.contains(lands_at)).await;
        assert!(landed.contains(lands_at), "{css} led to {landed}");
    }

    /// Presses something away from the bar at the foot of the window.
    async fn press_in_sight(&self, css: &str) {
        let show = "document.querySelector(arguments[0])?.scrollIntoView({ block: 'center' })";
        self.browser.execute(show, vec![css.into()]).await.expect("it is scrolled to");
        let found = self.browser.find(Locator::Css(css)).await.unwrap_or_else(|_| panic!("no {css}"));
        found.click().await.expect("it is pressed");
    }

    async fn press_in_draft(&self, act: &str, then: &str) {
        self.press_in_sight(&format!(".split button[value='{act}']:not(.visually-hidden)")).await;
        let found =
            self.browser.wait().at_most(std::time::Duration::from_secs(20)).for_element(Locator::Css(then)).await;
        found.unwrap_or_else(|_| panic!("after {act} there is no {then}"));
    }

    /// Writes a questionnaire of two questions with a score, in English and German, and publishes it.
    async fn writes_questionnaire(&self) {
        sign_in(self.browser, self.url, INSTRUCTOR).await;
        self.open("/surveys/instruments", "the instruments").await;
        self.open("/drafts#new-instrument", "drafts").await;
        self.type_into("#instrument-title", "How was the course?").await;
        self.press_until("form:has(#instrument-title) button", "/drafts/").await;
        inspect(self.browser, "the form of an instrument with nothing in it").await;
        self.choose("#f-languages-new", "de").await;
        self.press_in_draft("add:languages", "#f-title-de").await;
        self.type_into("#f-title-de", "Wie war der Kurs?").await;
        self.type_into("#f-source", "Ours").await;
        self.type_into("#f-licence", "Free to use").await;
        self.choose("#f-item-new", "new:likert").await;
        self.press_in_draft("add:item", "#f-item-0[open] #f-item-0-text-de").await;
        self.type_into("#f-item-0-text-en", "It was useful.").await;
        self.type_into("#f-item-0-text-de", "Er war nützlich.").await;
        self.choose("#f-item-new", "new:yes-no").await;
        self.press_in_draft("add:item", "#f-item-1[open] #f-item-1-text-de").await;
        inspect(self.browser, "the form of an instrument that lacks words").await;
        contains(self.browser, "a form that lacks words", &["1 text is missing or wrong in it"]).await;
        self.type_into("#f-item-1-text-en", "Would you come again?").await;
        self.type_into("#f-item-1-text-de", "Würden Sie wiederkommen?").await;
        self.press_in_draft("add:score", "#f-score-0[open] #f-score-0-title-de").await;
        self.type_into("#f-score-0-title-en", "Usefulness").await;
        self.type_into("#f-score-0-title-de", "Nutzen").await;
        self.press_in_sight("#f-score-0-items-q-1").await;
        self.press_until("button[value='look:de']", "/questions").await;
        inspect(self.browser, "what whoever answers will see").await;
        contains(self.browser, "a preview", &["er war nützlich", "stimme völlig zu", "nichts wird gespeichert"]).await;
        self.press_until("main a[href^='/drafts/']:not([hreflang])", "/drafts/").await;
        self.press_in_draft("publish", ".card.teaching").await;
        inspect(self.browser, "an instrument that was just published").await;
        contains(self.browser, "an instrument that was just published", &["published.", "create a survey"]).await;
    }

    /// Asks a cohort by it.
    async fn asks_cohort(&self) {
        self.press_until("a[href^='/surveys/new?instrument=']", "/surveys/new").await;
        inspect(self.browser, "a new survey of what was written").await;
        self.type_into("#title", "Your course").await;
        self.browser.find(Locator::Css("input[name=cohort]")).await.expect("a cohort").click().await.expect("a tick");
        let css = "main form[action='/surveys/new'] button[type=submit]";
        self.browser.find(Locator::Css(css)).await.expect("a button").click().await.expect("it is pressed");
        let made = lands(self.browser, |path| path.starts_with("/surveys/") && !path.ends_with("/new")).await;
        assert!(!made.ends_with("/new"), "no survey was made");
        contains(self.browser, "a survey", &["your course", "once: autumn"]).await;
    }

    /// Answers in German.
    async fn answers_in_german(&self, join: &str) {
        self.browser.delete_all_cookies().await.expect("cookies can be dropped");
        self.open(join, "an invitation").await;
        self.type_into("#password", PASSWORD).await;
        self.type_into("#again", PASSWORD).await;
        self.send(join, "/").await;
        contains(self.browser, "a trainee's home", &["your training"]).await;
        self.open("/surveys", "a trainee's surveys").await;
        contains(self.browser, "a trainee's surveys", &["your course"]).await;
        self.press_until("main a[href^='/surveys/']", "/surveys/").await;
        self.press_until("a[hreflang=de]", "/surveys/").await;
        let consent =
            "const box = document.querySelector('input[name=consent]'); box.click(); box.form.requestSubmit()";
        self.browser.execute(consent, vec![]).await.expect("consent");
        lands(self.browser, |path| path.starts_with("/survey/")).await;
        inspect(self.browser, "the questions in German").await;
        contains(self.browser, "the questions", &["er war nützlich", "würden sie wiederkommen", "ja"]).await;
        for answer in ["input[name='q.q-1'][value='4']", "input[name='q.q-2'][value='yes']"] {
            self.browser.find(Locator::Css(answer)).await.expect(answer).click().await.expect("it is chosen");
        }
        self.press_until("button[value=send]", "/survey/").await;
        let sent = "main h1";
        self.browser.wait().for_element(Locator::Css(sent)).await.expect("the end");
        self.shows_soon(&self.path().await, "gesendet").await;
    }
}

#[tokio::test]
async fn a_questionnaire_from_its_title_to_an_answer_in_german() {
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
    school.writes_questionnaire().await;
    school.asks_cohort().await;
    school.answers_in_german(&join).await;
    let complaints = complaints(&browser).await;
    browser.close().await.expect("the browser closes");
    assert!(complaints.is_empty(), "the browser complains: {complaints:#?}");
}
