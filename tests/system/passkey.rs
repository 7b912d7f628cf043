//! A passkey through a real browser and its virtual authenticator: an instructor adds one, signs in with it, is told when it does not
//! answer, and removes it. Fails when the script of the pages and the service disagree on what is asked and answered, when a page on
//! the way breaks an accessibility rule or its own security policy, or when nobody is told where passkeys are refused.

use fantoccini::{Client, Locator};
use serde_json::{Value, json};
use tests::{Service, run_ok};

use super::browser::{Driver, complaints, contains, inspect, lands};
use super::visitor::{INITIAL, choose_password};

const PASSWORD: &str = "vier Käse im Wind der Nacht";
const TEACHER: &str = "teacher@example.org";
const PAGE: &str = "/account/second-factor";

/// A command of WebDriver's for virtual authenticators: the end of its address, and what is sent.
#[derive(Debug)]
struct Authenticator(String, Value);

impl fantoccini::wd::WebDriverCompatibleCommand for Authenticator {
    fn endpoint(&self, base: &url::Url, session: Option<&str>) -> Result<url::Url, url::ParseError> {
        base.join(&format!("session/{}/webauthn/authenticator{}", session.unwrap_or_default(), self.0))
    }

    fn method_and_body(&self, _: &url::Url) -> (http::Method, Option<String>) {
        (http::Method::POST, Some(self.1.to_string()))
    }
}

/// The service, and a browser that visits it and has a device with passkeys.
struct Visit {
    browser: Client,
    url: String,
    device: String,
}

impl Visit {
    async fn start(driver: &Driver, profile: &std::path::Path, url: String) -> Self {
        let browser = driver.browser(profile).await;
        let kind = json!({ "protocol": "ctap2", "transport": "internal", "hasResidentKey": true,
            "hasUserVerification": true, "isUserVerified": true, "isUserConsenting": true });
        let device = browser.issue_cmd(Authenticator(String::new(), kind)).await.expect("a virtual authenticator");
        let device = device.as_str().expect("its id").to_owned();
        Self { browser, url, device }
    }

    /// Whether the device recognises who holds it.
    async fn recognises(&self, whoever: bool) {
        let command = Authenticator(format!("/{}/uv", self.device), json!({ "isUserVerified": whoever }));
        self.browser.issue_cmd(command).await.expect("the device changes its mind");
    }

    async fn open(&self, path: &str) {
        self.browser.goto(&format!("{}{path}", self.url)).await.expect("a page");
    }

    async fn fill(&self, action: &str, fields: &[(&str, &str)]) {
        let form = self.browser.form(Locator::Css(&format!("main form[action='{action}']"))).await.expect("a form");
        for (name, value) in fields {
            form.set_by_name(name, value).await.expect("a field");
        }
        form.submit().await.expect("the form is sent");
    }

    async fn is_at(&self, path: &str, why: &str) {
        assert_eq!(lands(&self.browser, |at| at == path).await, path, "{why}");
    }

    async fn press(&self, selector: &str) {
        let button = self.browser.find(Locator::Css(selector)).await.expect("a button");
        button.click().await.expect("it is pressed");
    }

    async fn say_password(&self) {
        self.browser.delete_all_cookies().await.expect("cookies can be dropped");
        self.open("/login").await;
        self.fill("/login", &[("email", TEACHER), ("password", PASSWORD)]).await;
    }

    async fn add(&self) {
        self.say_password().await;
        self.is_at("/", "the password alone does yet").await;
        self.open(PAGE).await;
        inspect(&self.browser, "no second factor").await;
        self.fill("/account/second-factor/passkeys", &[("name", "Laptop"), ("password", PASSWORD)]).await;
        contains(&self.browser, "recovery codes", &["the second factor is on", "not be shown again"]).await;
        self.open(PAGE).await;
        contains(&self.browser, "a passkey", &["laptop", "10 recovery codes left"]).await;
        inspect(&self.browser, "a passkey that is on").await;
    }

    async fn sign_in(&self) {
        self.say_password().await;
        self.is_at("/", "the passkey is asked at once, and answers").await;
        self.open(PAGE).await;
        contains(&self.browser, "a used passkey", &["last used"]).await;
    }

    /// It does not answer, and does when it is asked again.
    async fn sign_in_at_the_second_try(&self) {
        self.recognises(false).await;
        self.say_password().await;
        contains(&self.browser, "a passkey that does not answer", &["no passkey responded", "recovery code"]).await;
        inspect(&self.browser, "a passkey that does not answer").await;
        self.open("/cohorts").await;
        self.is_at("/login", "the password alone opens nothing").await;
        self.open("/login/code").await;
        contains(&self.browser, "a passkey that does not answer", &["no passkey responded"]).await;
        self.recognises(true).await;
        self.press("main .ask button").await;
        self.is_at("/", "the button asks again").await;
    }

    /// The device has one already; and the passkey removes itself.
    async fn remove(&self) {
        self.open(PAGE).await;
        let adding = "main form[action='/account/second-factor/passkeys']";
        self.press(&format!("{adding} summary")).await;
        let form = self.browser.form(Locator::Css(adding)).await.expect("a form");
        for (name, value) in [("name", "Laptop again"), ("password", PASSWORD)] {
            form.set_by_name(name, value).await.expect("a field");
        }
        self.press(&format!("{adding} .ask button")).await;
        contains(&self.browser, "a device that has one", &["already has a passkey for this account"]).await;
        inspect(&self.browser, "a device that has one").await;
        self.open(PAGE).await;
        self.press("main .reasons a").await;
        contains(&self.browser, "one passkey", &["passkey laptop", "password only"]).await;
        inspect(&self.browser, "one passkey").await;
        let field = self.browser.find(Locator::Id("password")).await.expect("a field");
        field.send_keys(PASSWORD).await.expect("the password is typed");
        self.press("main .ask button").await;
        self.is_at(PAGE, "the passkey has signed").await;
        contains(&self.browser, "no passkey", &["stored on a device"]).await;
    }

    /// By the address of the machine, to which no passkey answers.
    async fn told_elsewhere(&self) {
        let at = url::Url::parse(&self.url).expect("an address");
        let elsewhere = Self {
            browser: self.browser.clone(),
            url: format!("http://127.0.0.1:{}", at.port().expect("a port")),
            device: self.device.clone(),
        };
        elsewhere.say_password().await;
        elsewhere.is_at("/", "no second factor is left").await;
        elsewhere.open(PAGE).await;
        elsewhere.fill("/account/second-factor/passkeys", &[("name", "Here"), ("password", PASSWORD)]).await;
        contains(&self.browser, "where none answers", &["work only at http://localhost"]).await;
    }
}

#[tokio::test]
async fn an_instructor_adds_a_passkey_and_signs_in_with_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data");
    let at = data.to_string_lossy().into_owned();
    let who = ["--role", "instructor", "--email", TEACHER, "--name", "Somebody Else", "--password", INITIAL];
    run_ok("web-admin", &[&["user", "add", "--data-dir", at.as_str()][..], &who].concat());
    let service = Service::start(&data);
    choose_password(&service.url, TEACHER, PASSWORD);
    let driver = Driver::start();
    let url = service.url.replace("127.0.0.1", "localhost");
    let visit = Visit::start(&driver, &folder.path().join("profile"), url).await;
    visit.add().await;
    visit.sign_in().await;
    visit.sign_in_at_the_second_try().await;
    visit.remove().await;
    visit.told_elsewhere().await;
    let complaints = complaints(&visit.browser).await;
    assert!(complaints.is_empty(), "the browser complains: {complaints:#?}");
    visit.browser.close().await.expect("the browser closes");
}
