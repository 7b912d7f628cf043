//! What a browser says of pages, beyond their own tests: a replay has its place before it comes, and a page of another origin uploads
//! with somebody else's client of tus. Fails when what is read moves away under the reader, and when a browser refuses what the service
//! allows, or allows what it refuses.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpListener;
use std::path::Path;
use std::time::Duration;

use serde_json::json;
use tests::{Service, root};

use super::browser::{Driver, sign_in_with};
use crate::visitor::choose_password;
use crate::whole_path::{PASSWORD, found_school, id, only_session, scored, simulate};

/// Above this, a page is said to jump (web.dev, Cumulative Layout Shift: "good").
const STEADY: f64 = 0.1;

/// All that has moved on the page since it was opened.
const SHIFT: &str = "
    const done = arguments[0];
    let sum = 0;
    const add = (list) => list.getEntries().forEach((entry) => { if (!entry.hadRecentInput) sum += entry.value; });
    new PerformanceObserver(add).observe({ type: 'layout-shift', buffered: true });
    setTimeout(() => done(sum), 500);";

/// A school with an attempt that was scored; its session, and the trainee's token.
fn practised(folder: &Path, service: &Service, token: &str) -> String {
    let at = |name: &str| folder.join(name).to_string_lossy().into_owned();
    let recording = simulate(folder, "attempt.mcap", "novice");
    std::fs::write(at("token"), token).expect("a file");
    let (file, outbox) = (at("token"), at("outbox"));
    tests::run_ok(
        "stylet",
        &["upload", &recording, "--server", &service.url, "--token-file", &file, "--outbox", &outbox],
    );
    let session = id(&only_session(&service.url, token), "session_id");
    scored(&service.url, token, &session);
    session
}

#[tokio::test]
async fn a_replay_does_not_push_away_what_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data");
    let token = found_school(&data);
    let service = Service::start(&data);
    choose_password(&service.url, "ada@example.org", PASSWORD);
    let session = practised(folder.path(), &service, &token);
    let driver = Driver::start();
    let browser = driver.browser(&folder.path().join("profile")).await;
    sign_in_with(&browser, &service.url, ("ada@example.org", PASSWORD)).await;
    for (width, height) in [(1350, 940), (412, 823)] {
        browser.set_window_size(width, height).await.expect("a window of that size");
        browser.goto(&format!("{}/sessions/{session}/replay", service.url)).await.expect("the replay");
        for _ in 0..200 {
            let ready = browser.execute("return document.querySelector('#replay').dataset.ready ?? ''", vec![]).await;
            if ready.expect("the page answers") == json!("yes") {
                break;
            }
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
        let shift = browser.execute_async(SHIFT, vec![]).await.expect("the browser has watched");
        let shift = shift.as_f64().expect("a number");
        assert!(shift < STEADY, "at {width} px the page has moved by {shift}");
        let shown = browser
            .execute("return document.querySelector('#replay').checkVisibility({ visibilityProperty: true })", vec![]);
        assert_eq!(shown.await.expect("the page answers"), json!(true), "the replay is shown at {width} px");
    }
    browser.close().await.expect("the browser closes");
}

/// The page that uploads, and what it needs of its own origin: somebody else's client of tus, and the recording.
struct Lab {
    /// Its origin.
    origin: String,
}

impl Lab {
    /// Serves files by their paths until the test ends.
    fn open(files: BTreeMap<&'static str, Vec<u8>>) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let origin = format!("http://{}", listener.local_addr().expect("an address"));
        std::thread::spawn(move || {
            for mut asked in listener.incoming().flatten() {
                let mut line = String::new();
                // Who asks for nothing is answered nothing.
                let _ = BufReader::new(&asked).read_line(&mut line);
                let path = line.split(' ').nth(1).unwrap_or_default();
                let body = files.get(path).map_or(&[][..], Vec::as_slice);
                let kind = if path.ends_with(".js") { "text/javascript" } else { "text/html" };
                let status = if body.is_empty() { "404 Not Found" } else { "200 OK" };
                let length = body.len();
                let head = format!(
                    "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n"
                );
                let _ = asked.write_all(&[head.as_bytes(), body].concat());
            }
        });
        Self { origin }
    }
}

/// Uploads as the README of tus-js-client does; done with the address of the upload, or with what went wrong.
const UPLOAD: &str = "
    const [url, token, done] = arguments;
    fetch('/attempt.mcap').then((answer) => answer.blob()).then((file) => new tus.Upload(file, {
        endpoint: `${url}/api/v1/uploads`,
        headers: { Authorization: `Bearer ${token}` },
        chunkSize: 100000,
        retryDelays: null,
        onError: (error) => done(`failed: ${error}`),
        onSuccess: (result) => done(`${result.lastResponse.getHeader('Stylet-Session')}`),
    }).start()).catch((error) => done(`failed: ${error}`));";

#[tokio::test]
async fn tus_js_client_uploads_from_a_page_of_an_allowed_origin() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data");
    let token = found_school(&data);
    let recording = std::fs::read(simulate(folder.path(), "attempt.mcap", "novice")).expect("a recording");
    let client = std::fs::read(root().join("tests/browser/node_modules/tus-js-client/dist/tus.min.js"))
        .expect("tus-js-client is missing: deploy/test installs it (npm ci in tests/browser)");
    let page = b"<!doctype html><title>A lab</title><script src=\"/tus.js\"></script>".to_vec();
    let lab = || {
        Lab::open(BTreeMap::from([
            ("/", page.clone()),
            ("/tus.js", client.clone()),
            ("/attempt.mcap", recording.clone()),
        ]))
    };
    let (allowed, other) = (lab(), lab());
    let service = Service::start_with(&data, &["--listen", "127.0.0.1:0", "--allow-origin", &allowed.origin]);
    let driver = Driver::start();
    let browser = driver.browser(&folder.path().join("profile")).await;
    let upload = async |lab: &Lab| {
        browser.goto(&format!("{}/", lab.origin)).await.expect("the lab's page");
        let said = browser.execute_async(UPLOAD, vec![json!(service.url), json!(token)]).await.expect("it ends");
        said.as_str().unwrap_or_default().to_owned()
    };
    let refused = upload(&other).await;
    assert!(refused.starts_with("failed"), "another origin was let in: {refused}");
    let session = upload(&allowed).await;
    assert_eq!(session, id(&only_session(&service.url, &token), "session_id"));
    browser.close().await.expect("the browser closes");
}
