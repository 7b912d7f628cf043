//! The pictures of pages in docs/pictures: what people of each role see of the demonstration school. The test that draws them is not
//! run with the others; `docs/pictures/draw` runs it:
//!
//! ```sh
//! cargo test --workspace --test system screenshots -- --ignored
//! ```
//!
//! The school is drawn from a fixed seed; days and times are those of the day of drawing. Fails without drawing when a picture is
//! missing, or when pictures grow.

use std::time::Duration;

use fantoccini::{Client, Locator};
use serde_json::{Value, json};
use tests::{Service, root, run_ok};

use super::browser::{Driver, PASSWORD, sign_in};

/// A picture of a page.
struct Picture {
    /// Its file in docs/pictures, without the ending.
    name: &'static str,
    /// Where somebody goes.
    path: &'static str,
    /// What they press there, one after the other: CSS selectors of links and buttons.
    presses: &'static [&'static str],
    /// How much of the page is drawn from its upper end, in pixels.
    height: u32,
}

const WIDTH: u32 = 1080;

/// Of each role, the pictures that somebody of it sees.
const PICTURES: [(&str, &[Picture]); 3] =
    [("trainee", &OF_TRAINEES), ("instructor", &OF_INSTRUCTORS), ("administrator", &OF_ADMINISTRATORS)];

const OF_TRAINEES: [Picture; 1] = [Picture { name: "trainee", path: "/", presses: &[], height: 900 }];

const OF_ADMINISTRATORS: [Picture; 2] = [
    Picture { name: "people", path: "/people", presses: &[], height: 700 },
    Picture { name: "administration", path: "/admin", presses: &[], height: 900 },
];

const NEXT_EVENT: &str = "main button[data-part='after']";

const OF_INSTRUCTORS: [Picture; 11] = [
    Picture { name: "teaching", path: "/", presses: &[], height: 700 },
    Picture { name: "assignments", path: "/assignments", presses: &[], height: 1000 },
    Picture {
        name: "map",
        path: "/cohorts",
        presses: &["main a[href^='/cohorts/']", "main a[href$='/progress']"],
        height: 900,
    },
    Picture {
        name: "curve",
        path: "/",
        presses: &["main a[href^='/trainees/']", "main a[href^='/trainees/'][href*='/exercises/']"],
        height: 900,
    },
    Picture { name: "attempt", path: "/review", presses: &["main a[href^='/sessions/']"], height: 1000 },
    Picture {
        name: "replay",
        path: "/review",
        presses: &["main a[href$='/replay']", NEXT_EVENT, NEXT_EVENT, NEXT_EVENT],
        height: 1000,
    },
    Picture { name: "grade", path: "/review", presses: &["main a[href$='/grade']"], height: 800 },
    Picture { name: "survey", path: "/surveys", presses: &["main a[href$='/results']"], height: 900 },
    Picture {
        name: "rating",
        path: "/ratings",
        presses: &["main a[href^='/ratings/']:not([href$='new'])"],
        height: 900,
    },
    Picture {
        name: "pops",
        path: "/segments",
        presses: &["main a[href^='/segments/']:not([href$='new'])"],
        height: 700,
    },
    Picture {
        name: "editor",
        path: "/exercises/reach-the-muscle",
        presses: &["main form[action$='/draft'] button"],
        height: 900,
    },
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

/// Goes to a picture's page and draws it.
async fn draw(browser: &Client, url: &str, picture: &Picture) {
    browser.goto(&format!("{url}{}", picture.path)).await.expect("the page opens");
    for selector in picture.presses {
        let found = browser.wait().at_most(Duration::from_secs(20)).for_element(Locator::Css(selector)).await;
        let pressed = found.unwrap_or_else(|_| panic!("{}: nothing is {selector}", picture.name));
        pressed.click().await.expect("it is pressed");
        // A page draws its charts, and a replay its body, after it has come.
        tokio::time::sleep(Duration::from_secs(2)).await;
    }
    let clip = json!({ "x": 0, "y": 0, "width": WIDTH, "height": picture.height, "scale": 1 });
    let wanted = json!({ "format": "webp", "quality": 70, "captureBeyondViewport": true, "clip": clip });
    let answer = browser.issue_cmd(Devtools("Page.captureScreenshot", wanted)).await.expect("a picture");
    let bytes = data_encoding::BASE64.decode(answer["data"].as_str().unwrap_or_default().as_bytes()).expect("base64");
    std::fs::write(root().join(format!("docs/pictures/{}.webp", picture.name)), bytes).expect("a file");
}

#[tokio::test]
#[ignore = "draws docs/pictures anew"]
async fn pages_are_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data");
    let printed = run_ok("web-admin", &["demo", "--password", PASSWORD, "--data-dir", &data.to_string_lossy()]);
    let service = Service::start(&data);
    let driver = Driver::start();
    let browser = driver.browser(&folder.path().join("profile")).await;
    browser.set_window_size(WIDTH, 900).await.expect("a window of that size");
    for (role, pictures) in PICTURES {
        let line = printed.lines().find(|line| line.trim_start().starts_with(role)).expect("an account");
        let email = line.split_whitespace().find(|word| word.contains('@')).expect("an address");
        sign_in(&browser, &service.url, email).await;
        for picture in pictures {
            draw(&browser, &service.url, picture).await;
        }
    }
    browser.close().await.expect("the browser closes");
}

#[test]
fn every_picture_is_there_and_small() {
    let size =
        |name: &str| std::fs::metadata(root().join(format!("docs/pictures/{name}"))).map_or(0, |file| file.len());
    for picture in PICTURES.iter().flat_map(|(_, pictures)| *pictures) {
        assert!(size(&format!("{}.webp", picture.name)) > 0, "docs/pictures/{}.webp is missing", picture.name);
    }
    let files = std::fs::read_dir(root().join("docs/pictures")).expect("docs/pictures").flatten();
    let sizes: Vec<u64> = files.map(|file| file.metadata().map_or(0, |known| known.len())).collect();
    assert!(sizes.iter().all(|size| *size <= 150_000), "a picture of docs/ is larger than 150 kB: {sizes:?}");
    assert!(sizes.iter().sum::<u64>() <= 1_000_000, "the pictures of docs/ come to more than 1 MB");
    let films = std::fs::read_dir(root().join("docs/films")).expect("docs/films").flatten();
    let films: Vec<u64> = films.map(|file| file.metadata().map_or(0, |known| known.len())).collect();
    assert!(films.iter().all(|size| *size <= 1_500_000), "a film of docs/ is larger than 1.5 MB: {films:?}");
}
