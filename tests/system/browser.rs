//! The demonstration school through a real browser: a trainee, an instructor and an administrator sign in and open what they
//! need, at a desk and on a phone. Fails when a page breaks an accessibility rule (axe-core), scrolls sideways on a
//! phone, asks for something its own security policy refuses, or does not show what the visitor came for.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use fantoccini::{Client, ClientBuilder, Locator};
use serde_json::{Value, json};
use tests::{Service, root, run_ok};

pub(super) const PASSWORD: &str = "a long enough demonstration password";

/// How long an element, an address or words are waited for, in ms: on a busy machine signing in alone takes seconds.
const LONGEST_WAIT_MS: u64 = 60_000;
/// Number of looks at a page within that time.
pub(super) const MOST_LOOKS: u64 = LONGEST_WAIT_MS / BETWEEN_LOOKS.as_millis() as u64;
pub(super) const BETWEEN_LOOKS: Duration = Duration::from_millis(100);

/// A WebDriver on a port of its own, ended when dropped.
pub(super) struct Driver {
    child: Child,
    port: u16,
}

impl Driver {
    pub(super) fn start() -> Self {
        let port = std::net::TcpListener::bind("127.0.0.1:0").and_then(|l| l.local_addr()).expect("a free port").port();
        let child = Command::new("chromedriver")
            .arg(format!("--port={port}"))
            .stdout(Stdio::null())
            .spawn()
            .expect("chromedriver is missing: deploy/test installs it (Debian: chromium-driver)");
        Self { child, port }
    }

    pub(super) async fn browser(&self, profile: &Path) -> Client {
        let arguments = [
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-quic",
            "--disable-dev-shm-usage",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
            &format!("--user-data-dir={}", profile.display()),
        ];
        let options = json!({
            "goog:chromeOptions": { "args": arguments },
            "goog:loggingPrefs": { "browser": "ALL" },
            "timeouts": { "implicit": LONGEST_WAIT_MS, "script": LONGEST_WAIT_MS },
        });
        let Value::Object(capabilities) = options else { unreachable!("an object was just made") };
        let driver = format!("http://127.0.0.1:{}", self.port);
        for _ in 0..MOST_LOOKS {
            let mut builder = ClientBuilder::new(hyper_util::client::legacy::connect::HttpConnector::new());
            match builder.capabilities(capabilities.clone()).connect(&driver).await {
                Ok(client) => return client,
                Err(_) => tokio::time::sleep(BETWEEN_LOOKS).await,
            }
        }
        panic!("chromedriver did not open a browser in time");
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What every page must satisfy, at both widths.
pub(super) async fn inspect(browser: &Client, what: &str) {
    for (width, height) in [(1280, 900), (500, 900)] {
        browser.set_window_size(width, height).await.expect("a window of that size");
        let overflow = browser
            .execute("return document.documentElement.scrollWidth - document.documentElement.clientWidth", vec![])
            .await
            .expect("the page measures itself");
        assert!(overflow.as_i64() <= Some(0), "{what} scrolls sideways by {overflow} px at {width} px");
    }
    let axe = std::fs::read_to_string(root().join("tests/browser/node_modules/axe-core/axe.min.js"))
        .expect("axe-core is missing: deploy/test installs it (npm ci in tests/browser)");
    browser.execute(&axe, vec![]).await.expect("axe-core loads");
    for scheme in ["dark", "light"] {
        browser.issue_cmd(ColorScheme(scheme)).await.expect("a page changes its colours");
        let report = browser.execute_async(RULES, vec![]).await.expect("axe-core runs");
        assert_eq!(report, json!([]), "{what}, {scheme}, breaks accessibility rules");
    }
}

/// What of the open page breaks the rules of WCAG 2.2, level AA, or skips a level of headings.
const RULES: &str = "
    const done = arguments[0];
    const runOnly = { type: 'tag', values: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa'] };
    axe.run(document, { runOnly, rules: { 'heading-order': { enabled: true } } })
        .then(r => done(r.violations.map(v => v.id + ': ' + v.help + ' at ' + v.nodes.map(n => n.target).join(', '))))
        .catch(e => done(['axe failed: ' + e]))";

/// The colours that whoever reads prefers: `light` or `dark`.
#[derive(Debug)]
struct ColorScheme(&'static str);

impl fantoccini::wd::WebDriverCompatibleCommand for ColorScheme {
    fn endpoint(&self, base: &url::Url, session: Option<&str>) -> Result<url::Url, url::ParseError> {
        base.join(&format!("session/{}/goog/cdp/execute", session.unwrap_or_default()))
    }

    fn method_and_body(&self, _: &url::Url) -> (http::Method, Option<String>) {
        let features = json!([{ "name": "prefers-color-scheme", "value": self.0 }]);
        let command = json!({ "cmd": "Emulation.setEmulatedMedia", "params": { "features": features } });
        (http::Method::POST, Some(command.to_string()))
    }
}

/// The words of the page, in one step: between finding and reading there may be the next page. Empty while there is none.
async fn text(browser: &Client) -> String {
    let words = browser.execute("return document.querySelector('main')?.innerText ?? ''", vec![]).await;
    words.ok().and_then(|words| words.as_str().map(str::to_owned)).unwrap_or_default()
}

pub(super) async fn sign_in(browser: &Client, url: &str, email: &str) {
    sign_in_with(browser, url, (email, PASSWORD)).await;
}

pub(super) async fn sign_in_with(browser: &Client, url: &str, (email, password): (&str, &str)) {
    browser.delete_all_cookies().await.expect("cookies can be dropped");
    browser.goto(&format!("{url}/login")).await.expect("the sign-in page");
    let form = browser.form(Locator::Css("main form")).await.expect("a form");
    form.set_by_name("email", email).await.expect("an e-mail field");
    form.set_by_name("password", password).await.expect("a password field");
    form.submit().await.expect("the form is sent");
    let landed = lands(browser, |path| path == "/").await;
    assert_eq!(landed, "/", "{email} was not let in: {}", text(browser).await);
}

/// Waits for an address: a click and a sent form return before the next page is there.
pub(super) async fn lands(browser: &Client, wanted: impl Fn(&str) -> bool) -> String {
    let mut path = String::new();
    for _ in 0..MOST_LOOKS {
        browser.current_url().await.expect("an address").path().clone_into(&mut path);
        if wanted(&path) {
            break;
        }
        tokio::time::sleep(BETWEEN_LOOKS).await;
    }
    path
}

/// Follows the first link in the page whose address begins with `prefix`.
pub(super) async fn follow(browser: &Client, prefix: &str) {
    let link = browser.find(Locator::Css(&format!("main a[href^='{prefix}']"))).await;
    let link = link.unwrap_or_else(|_| panic!("no link to {prefix}"));
    link.click().await.expect("the link opens");
    let landed = lands(browser, |path| path.starts_with(prefix)).await;
    assert!(landed.starts_with(prefix), "the link to {prefix} led to {landed}");
}

/// Presses the button of the form that is sent to `path`, and waits for the page it leads to.
pub(super) async fn press(browser: &Client, path: &str) {
    let button = browser.find(Locator::Css(&format!("main form[action='{path}'] button"))).await;
    button.unwrap_or_else(|_| panic!("no button for {path}")).click().await.expect("the button is pressed");
    assert_eq!(lands(browser, |at| at == path).await, path);
}

/// Waits for words on the page: what a pressed button leads to may have the same address.
pub(super) async fn contains(browser: &Client, what: &str, words: &[&str]) {
    let mut said = String::new();
    for _ in 0..MOST_LOOKS {
        said = text(browser).await.to_lowercase();
        if words.iter().all(|word| said.contains(word)) {
            return;
        }
        tokio::time::sleep(BETWEEN_LOOKS).await;
    }
    panic!("{what} does not show all of {words:?}:\n{said}");
}

// Rules that hold on every page are asked by `every_page`; here those of pages to which no link leads.

async fn trainee(browser: &Client, url: &str, email: &str) {
    sign_in(browser, url, email).await;
    contains(browser, "the trainee's home", &["next", "attempt"]).await;
    follow(browser, "/sessions/").await;
    contains(browser, "a session", &["score", "force", "depth", "rupture", "mj"]).await;
    let charts = browser.find_all(Locator::Css("main svg")).await.expect("pictures").len();
    assert!(charts >= 2, "a session shows {charts} charts");
    browser.goto(&format!("{url}/curricula")).await.expect("the curricula");
    follow(browser, "/exercises/").await;
    browser.goto(&format!("{url}/")).await.expect("the trainee's home");
    press(browser, "/sign-in-code").await;
    inspect(browser, "a sign-in code").await;
}

async fn instructor(browser: &Client, url: &str, email: &str) {
    sign_in(browser, url, email).await;
    browser.goto(&format!("{url}/cohorts")).await.expect("the cohorts");
    follow(browser, "/cohorts/").await;
    contains(browser, "a cohort", &["help"]).await;
    follow(browser, "/trainees/").await;
}

/// Refusals by the page's own policy and missing files appear in the browser's log.
pub(super) async fn complaints(browser: &Client) -> Vec<Value> {
    let log = browser.issue_cmd(BrowserLog).await.expect("the browser's log");
    let entries = log.as_array().cloned().unwrap_or_default();
    entries.into_iter().filter(|e| e["level"] == "SEVERE").collect()
}

#[derive(Debug)]
struct BrowserLog;

impl fantoccini::wd::WebDriverCompatibleCommand for BrowserLog {
    fn endpoint(&self, base: &url::Url, session: Option<&str>) -> Result<url::Url, url::ParseError> {
        base.join(&format!("session/{}/se/log", session.unwrap_or_default()))
    }

    fn method_and_body(&self, _: &url::Url) -> (http::Method, Option<String>) {
        (http::Method::POST, Some(json!({ "type": "browser" }).to_string()))
    }
}

#[tokio::test]
async fn the_school_in_a_browser() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data");
    let arguments = ["demo", "--weeks", "1", "--password", PASSWORD, "--data-dir"];
    let printed = run_ok("web-admin", &[&arguments[..], &[&data.to_string_lossy()]].concat());
    let account = |role: &str| {
        let line = printed.lines().find(|l| l.contains(role)).unwrap_or_else(|| panic!("no {role} in:\n{printed}"));
        line.split_whitespace().find(|w| w.contains('@')).expect("an e-mail address").to_owned()
    };
    super::research_tables::check(&data, folder.path(), &printed);
    let service = Service::start(&data);
    let driver = Driver::start();
    let browser = driver.browser(&folder.path().join("profile")).await;
    browser.goto(&format!("{}/", service.url)).await.expect("the front door");
    inspect(&browser, "the sign-in page").await;
    trainee(&browser, &service.url, &account("trainee")).await;
    instructor(&browser, &service.url, &account("instructor")).await;
    sign_in(&browser, &service.url, &account("administrator")).await;
    browser.goto(&format!("{}/admin", service.url)).await.expect("the administrator's page");
    press(&browser, "/admin/pairing-codes").await;
    inspect(&browser, "a pairing code").await;
    super::study_figures::of(&browser, &service.url, folder.path()).await;
    let mut opened = BTreeSet::new();
    for role in ["trainee", "instructor", "administrator"] {
        opened.extend(super::every_page::of(&browser, &service.url, (role, &account(role))).await);
    }
    super::every_page::compare(&opened);
    // What is asked after an attempt is asked while it is fresh: those of the demonstration are days old.
    super::journeys::upload_attempt(folder.path(), &service.url, &data.to_string_lossy(), &account("trainee"));
    super::surveys::trainee(&browser, &service.url, &account("trainee")).await;
    let link = super::surveys::owner(&browser, &service.url, &account("instructor")).await;
    super::surveys::professional(&browser, &link).await;
    let complaints = complaints(&browser).await;
    assert!(complaints.is_empty(), "the browser complains: {complaints:#?}");
    // A browser complains of a lost connection, too: so this comes last.
    let _service = super::surveys::lost_connection(&browser, &link, (service, &data)).await;
    browser.close().await.expect("the browser closes");
}
