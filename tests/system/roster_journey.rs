//! The lists of people that other systems write, by their real column names, through a real browser: an administrator sends each to a
//! school of its own, sees whom it names, imports it and finds them. Fails when a list is not recognised by its headings, when somebody
//! is lost or read under another name, or when a page on the way breaks an accessibility rule.

use std::path::Path;

use tests::{Service, root, run_ok};

use super::browser::{Driver, PASSWORD, complaints, contains, inspect, sign_in};
use super::journeys::School;
use super::visitor::{INITIAL, choose_password};

/// Lists of the same two people in `web-admin/tests/data/rosters`, in the layout of each system.
const LISTS: [&str; 5] = ["moodle.csv", "canvas-gradebook.csv", "canvas-sis.csv", "studip.csv", "hisinone.csv"];

/// The administrator of a list's school.
fn head_of(list: &str) -> String {
    format!("head@{}.example", list.trim_end_matches(".csv"))
}

impl School<'_> {
    /// Sends a list, sees whom it names, imports it and finds both.
    async fn imports(&self, list: &str) {
        sign_in(self.browser, self.url, &head_of(list)).await;
        self.open("/people/roster", "importing a roster").await;
        let file = root().join("web-admin/tests/data/rosters").join(list);
        self.type_into("input[type=file]", &file.to_string_lossy()).await;
        self.send("/people/roster", "/people/rosters/").await;
        let import = self.path().await;
        assert!(!import.ends_with("/columns"), "{list}: its headings are not recognised");
        inspect(self.browser, list).await;
        contains(self.browser, list, &["ana lindqvist", "bo größer"]).await;
        self.send(&import, "/people").await;
        contains(self.browser, list, &["2 people added", "ana@uni.example", "bo@uni.example", "4711"]).await;
        self.open("/people?q=groesser", "somebody who was looked for by another keyboard").await;
        contains(self.browser, list, &["bo größer", "4712"]).await;
    }
}

#[tokio::test]
async fn lists_of_other_systems_from_their_file_to_their_people() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data").to_string_lossy().into_owned();
    run_ok("web-admin", &["migrate", "--data-dir", &data]);
    for list in LISTS {
        let add = ["user", "add", "--data-dir", &data, "--school", list, "--role", "administrator", "--name", "Head"];
        run_ok("web-admin", &[&add[..], &["--email", &head_of(list), "--password", INITIAL]].concat());
    }
    let service = Service::start(Path::new(&data));
    let driver = Driver::start();
    let browser = driver.browser(&folder.path().join("profile")).await;
    let school = School { browser: &browser, url: &service.url, folder: folder.path() };
    for list in LISTS {
        choose_password(&service.url, &head_of(list), PASSWORD);
        school.imports(list).await;
    }
    let complaints = complaints(&browser).await;
    browser.close().await.expect("the browser closes");
    assert!(complaints.is_empty(), "the browser complains: {complaints:#?}");
}
