//! Draws the pictures of pages in docs/: what people of each role see of the demonstration school. Not run with the other tests:
//!
//! ```sh
//! cargo test --workspace --test system screenshots -- --ignored
//! ```
//!
//! The school is drawn from a fixed seed; days and times are those of the day of drawing.

use fantoccini::Client;
use serde_json::{Value, json};
use tests::{Service, root, run_ok};

use super::browser::{Driver, PASSWORD, follow, sign_in};

/// A picture of a page.
struct Picture {
    /// Its file in docs/pictures, without the ending.
    name: &'static str,
    /// Who looks.
    role: &'static str,
    /// Where they go, and the beginnings of the links that they follow from there.
    path: &'static str,
    links: &'static [&'static str],
    /// What stands at the upper edge; the page's own where it is empty.
    top: &'static str,
    /// How high the picture is, in pixels.
    height: u32,
}

const WIDTH: u32 = 1080;

const PICTURES: [Picture; 10] = [
    Picture { name: "trainee", role: "trainee", path: "/", links: &[], top: "", height: 760 },
    Picture { name: "teaching", role: "instructor", path: "/", links: &[], top: "", height: 620 },
    Picture { name: "people", role: "administrator", path: "/people", links: &[], top: "", height: 620 },
    Picture { name: "assignments", role: "instructor", path: "/assignments", links: &[], top: "", height: 620 },
    Picture { name: "cohort", role: "instructor", path: "/cohorts", links: &["/cohorts/"], top: "", height: 760 },
    Picture { name: "review", role: "instructor", path: "/review", links: &[], top: "", height: 520 },
    Picture { name: "attempt", role: "instructor", path: "/review", links: &["/sessions/"], top: "", height: 900 },
    Picture { name: "survey", role: "instructor", path: "/surveys", links: &["/surveys/"], top: "", height: 760 },
    Picture { name: "rating", role: "instructor", path: "/ratings", links: &["/ratings/"], top: "", height: 620 },
    Picture { name: "editor", role: "instructor", path: "/drafts", links: &["/drafts/"], top: "", height: 760 },
];

/// What a browser is asked for in the words of its own protocol.
#[derive(Debug)]
struct Devtools(&'static str, Value);

impl fantoccini::wd::WebDriverCompatibleCommand for Devtools {
    fn endpoint(&self, base: &url::Url, session: Option<&str>) -> Result<url::Url, url::ParseError> {
        base.join(&format!("session/{}/goog/cdp/execute", session.unwrap_or_default()))
    }

    fn method_and_body(&self, _: &url::Url) -> (http::Method, Option<String>) {
        (http::Method::POST, Some(json!({ "cmd": self.0, "params": self.1 }).to_string()))
    }
}

/// Where something on the open page begins, in pixels from its upper end.
async fn upper_edge(browser: &Client, selector: &str) -> f64 {
    let script = "return document.querySelector(arguments[0]).getBoundingClientRect().top + scrollY - 12";
    let found = browser.execute(script, vec![json!(selector)]).await;
    found.unwrap_or_else(|_| panic!("nothing on the page is {selector}")).as_f64().unwrap_or_default()
}

async fn draw(browser: &Client, picture: &Picture) {
    let top = if picture.top.is_empty() { 0.0 } else { upper_edge(browser, picture.top).await };
    let clip = json!({ "x": 0, "y": top, "width": WIDTH, "height": picture.height, "scale": 1 });
    let wanted = json!({ "format": "webp", "quality": 70, "captureBeyondViewport": true, "clip": clip });
    let answer = browser.issue_cmd(Devtools("Page.captureScreenshot", wanted)).await.expect("a picture");
    let bytes = data_encoding::BASE64.decode(answer["data"].as_str().unwrap_or_default().as_bytes()).expect("base64");
    assert!(bytes.len() <= 150_000, "{} is of {} bytes", picture.name, bytes.len());
    std::fs::write(root().join(format!("docs/pictures/{}.webp", picture.name)), bytes).expect("a file");
}

#[tokio::test]
#[ignore = "draws docs/pictures anew"]
async fn pages_are_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data");
    let arguments = ["demo", "--password", PASSWORD, "--data-dir", &data.to_string_lossy()];
    let printed = run_ok("web-admin", &arguments);
    let service = Service::start(&data);
    let driver = Driver::start();
    let browser = driver.browser(&folder.path().join("profile")).await;
    browser.set_window_size(WIDTH, 900).await.expect("a window of that size");
    std::fs::create_dir_all(root().join("docs/pictures")).expect("a folder");
    for role in ["trainee", "instructor", "administrator"] {
        let line = printed.lines().find(|line| line.trim_start().starts_with(role)).expect("an account");
        let email = line.split_whitespace().find(|word| word.contains('@')).expect("an address");
        sign_in(&browser, &service.url, email).await;
        for picture in PICTURES.iter().filter(|picture| picture.role == role) {
            browser.goto(&format!("{}{}", service.url, picture.path)).await.expect("the page opens");
            for link in picture.links {
                follow(&browser, link).await;
            }
            draw(&browser, picture).await;
        }
    }
    browser.close().await.expect("the browser closes");
}

#[test]
fn every_picture_is_there_and_small() {
    let size =
        |name: &str| std::fs::metadata(root().join(format!("docs/pictures/{name}"))).map_or(0, |file| file.len());
    for picture in &PICTURES {
        assert!(size(&format!("{}.webp", picture.name)) > 0, "docs/pictures/{}.webp is missing", picture.name);
    }
    let files = std::fs::read_dir(root().join("docs/pictures")).expect("docs/pictures").flatten();
    let sizes: Vec<u64> = files.map(|file| file.metadata().map_or(0, |known| known.len())).collect();
    assert!(sizes.iter().all(|size| *size <= 150_000), "a picture of docs/ is larger than 150 kB: {sizes:?}");
    assert!(sizes.iter().sum::<u64>() <= 1_000_000, "the pictures of docs/ come to more than 1 MB");
}
