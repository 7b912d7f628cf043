//! A second factor through a real browser: the school asks for it, an instructor is led to it, their app is set up from what the
//! page shows, and from then on the password alone opens nothing. Tokens for programs, too. Fails when a page on the way breaks
//! an accessibility rule or its own security policy, or when another program's codes are not taken.

use std::time::Duration;

use fantoccini::{Client, Locator};
use tests::{Service, python_ok, run_ok};

use super::browser::{Driver, complaints, contains, inspect, lands};
use super::visitor::{INITIAL, choose_password};

const PASSWORD: &str = "vier Käse im Wind der Nacht";
const TEACHER: &str = "teacher@example.org";
const PAGE: &str = "/account/second-factor";
const HEAD: &str = "head@example.org";

/// What an app shows now that was given the secret: another program than ours.
fn code(secret: &str) -> String {
    python_ok(&["totp.py", secret]).trim().to_owned()
}

/// The service, and a browser that visits it.
struct Visit {
    browser: Client,
    url: String,
}

impl Visit {
    async fn open(&self, path: &str) {
        self.browser.goto(&format!("{}{path}", self.url)).await.expect("a page");
    }

    /// Sends the first form with an action.
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

    /// Says the password; where that leads.
    async fn say_password(&self, email: &str, path: &str) {
        self.browser.delete_all_cookies().await.expect("cookies can be dropped");
        self.open("/login").await;
        self.fill("/login", &[("email", email), ("password", PASSWORD)]).await;
        self.is_at(path, "where the password leads").await;
    }

    /// The text of the first element that a selector names.
    async fn text_of(&self, selector: &str) -> String {
        let found = self.browser.find(Locator::Css(selector)).await.expect("an element");
        found.text().await.expect("its text")
    }

    /// The school asks for it, and whoever has set the rule is the first to be led to it.
    async fn school_asks(&self) {
        self.say_password(HEAD, "/").await;
        self.open("/admin/settings").await;
        let rule = self.browser.find(Locator::Css("input[name=rule][value=teachers]")).await.expect("a rule");
        rule.click().await.expect("it is chosen");
        self.fill("/admin/second-factor", &[]).await;
        self.is_at(PAGE, "whoever sets the rule has to keep it").await;
    }

    /// The secret, the code that has confirmed it, and a recovery code.
    async fn enrol(&self) -> [String; 3] {
        self.say_password(TEACHER, PAGE).await;
        contains(&self.browser, "where a second factor is made", &["before you continue"]).await;
        self.open("/cohorts").await;
        self.is_at(PAGE, "nothing else is shown").await;
        inspect(&self.browser, "a second factor that is owed").await;
        self.fill(PAGE, &[("password", PASSWORD)]).await;
        contains(&self.browser, "an offered secret", &["key", "six digits"]).await;
        let drawn = "const i = document.querySelector('img.qr'); return i.complete && i.naturalWidth > 0";
        let drawn = self.browser.execute(drawn, vec![]).await.expect("a picture");
        assert_eq!(drawn, true, "the policy lets the picture through");
        inspect(&self.browser, "an offered secret").await;
        let secret = self.text_of("code.link-to-copy").await;
        let first = code(&secret);
        self.fill("/account/second-factor/confirm", &[("code", &first)]).await;
        contains(&self.browser, "recovery codes", &["the second factor is on", "not be shown again"]).await;
        inspect(&self.browser, "recovery codes").await;
        let recovery = self.text_of(".codes code").await;
        self.open(PAGE).await;
        inspect(&self.browser, "a second factor that is on").await;
        [secret, first, recovery]
    }

    /// Signs in by a code; one that was used before, and the password alone, open nothing.
    async fn sign_in_by_app(&self, secret: &str, used: &str) {
        self.say_password(TEACHER, "/login/code").await;
        inspect(&self.browser, "the page that asks for the code").await;
        self.open("/cohorts").await;
        self.is_at("/login", "the password alone opens nothing").await;
        self.open("/login/code").await;
        self.fill("/login/code", &[("code", used)]).await;
        contains(&self.browser, "a used code", &["already used"]).await;
        let mut next = code(secret);
        while next == used {
            tokio::time::sleep(Duration::from_secs(1)).await;
            next = code(secret);
        }
        self.fill("/login/code", &[("code", &next)]).await;
        self.is_at("/", "a code of the app").await;
    }

    async fn make_token(&self) {
        self.open("/account/tokens").await;
        inspect(&self.browser, "no tokens").await;
        self.fill("/account/tokens", &[("name", "Laboratory"), ("password", PASSWORD)]).await;
        contains(&self.browser, "a token", &["laboratory", "not be shown again"]).await;
        inspect(&self.browser, "a token").await;
        self.open("/account/tokens").await;
        contains(&self.browser, "the tokens", &["laboratory", "never"]).await;
        inspect(&self.browser, "the tokens").await;
    }

    async fn sign_in_by_recovery_code(&self, recovery: &str) {
        self.say_password(TEACHER, "/login/code").await;
        let other = self.browser.find(Locator::Css("main summary")).await.expect("another way");
        other.click().await.expect("it opens");
        let field = self.browser.find(Locator::Id("recovery")).await.expect("a field");
        field.send_keys(recovery).await.expect("the recovery code is typed");
        let button = self.browser.find(Locator::Css("main details button")).await.expect("a button");
        button.click().await.expect("it is sent");
        self.is_at("/", "a recovery code").await;
    }
}

#[tokio::test]
async fn an_instructor_is_led_to_a_second_factor_and_signs_in_with_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data");
    let at = data.to_string_lossy().into_owned();
    for (role, email) in [("instructor", TEACHER), ("administrator", HEAD)] {
        let who = ["--role", role, "--email", email, "--name", "Somebody Else", "--password", INITIAL];
        run_ok("web-admin", &[&["user", "add", "--data-dir", at.as_str()][..], &who].concat());
    }
    let service = Service::start(&data);
    [TEACHER, HEAD].into_iter().for_each(|email| choose_password(&service.url, email, PASSWORD));
    let driver = Driver::start();
    let browser = driver.browser(&folder.path().join("profile")).await;
    let visit = Visit { browser, url: service.url.clone() };
    visit.school_asks().await;
    let [secret, used, recovery] = visit.enrol().await;
    visit.sign_in_by_app(&secret, &used).await;
    visit.make_token().await;
    visit.sign_in_by_recovery_code(&recovery).await;
    // The code that was refused is answered 401, of which a browser complains; of the pages it must not.
    let complaints = complaints(&visit.browser).await;
    let others: Vec<_> = complaints.iter().filter(|entry| !entry["message"].to_string().contains(" 401 ")).collect();
    assert!(others.is_empty(), "the browser complains: {others:#?}");
    visit.browser.close().await.expect("the browser closes");
}
