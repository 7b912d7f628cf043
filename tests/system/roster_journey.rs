//! The lists of people that other systems write, by their real column names, through a real browser: an administrator sends each to a
//! service of its own, sees whom it names, imports it and finds them. Fails when a list is not recognised by its headings, when somebody
//! is lost or read under another name, or when a page on the way breaks an accessibility rule.

use std::path::Path;

use tests::{Service, root, run_ok};

use super::browser::{Driver, PASSWORD, complaints, contains, inspect, sign_in};
use super::journeys::School;
use super::visitor::{INITIAL, choose_password};

/// Lists of the same two people in `web-admin/tests/data/rosters`, in the layout of each system.
const LISTS: [&str; 5] = ["moodle.csv", "canvas-gradebook.csv", "canvas-sis.csv", "studip.csv", "hisinone.csv"];

const HEAD: &str = "head@journey.example";

impl School<'_> {
    /// Sends a list, sees whom it names, imports it and finds both.
    async fn imports(&self, list: &str) {
        sign_in(self.browser, self.url, HEAD).await;
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

/// A service with a school of its own for a list: an address belongs to one person of a service.
fn found_service(folder: &Path, list: &str) -> Service {
    let data = folder.join(list).to_string_lossy().into_owned();
    run_ok("web-admin", &["migrate", "--data-dir", &data]);
    let add = ["user", "add", "--data-dir", &data, "--school", "North", "--role", "administrator", "--name", "Head"];
    run_ok("web-admin", &[&add[..], &["--email", HEAD, "--password", INITIAL]].concat());
    let service = Service::start(Path::new(&data));
    choose_password(&service.url, HEAD, PASSWORD);
    service
}

#[tokio::test]
async fn lists_of_other_systems_from_their_file_to_their_people() {
    let folder = tempfile::tempdir().expect("a folder");
    let driver = Driver::start();
    let browser = driver.browser(&folder.path().join("profile")).await;
    for list in LISTS {
        let service = found_service(folder.path(), list);
        let school = School { browser: &browser, url: &service.url, folder: folder.path() };
        school.imports(list).await;
        let complaints = complaints(&browser).await;
        assert!(complaints.is_empty(), "{list}: the browser complains: {complaints:#?}");
    }
    browser.close().await.expect("the browser closes");
}
