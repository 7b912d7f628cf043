//! Drafts whose scenes cost much. Fails when the work on one goes on after nobody waits for it, holds up another school, or cannot be put
//! right by its author.

use std::io::{Read, Write};
use std::net::SocketAddr;
use std::time::Duration;

use model::Role;
use platform::clock::Clock;
use platform::helper::Helper;
use tokio::net::TcpListener;
use web_admin::serving::{self, ConnectionLimits};

use crate::support::App;
use crate::support::client::{Answer, Client, csrf_in, encoded};

const EXERCISE: &str = "oblique-approach";

/// A service whose helpers are told by their memory, in MB; and how long they may look at a draft.
async fn service(memory_mb: u64, preview_s: u64) -> App {
    App::with(Clock::system(), |config| {
        let program = env!("CARGO_BIN_EXE_web-admin").into();
        config.helper = Some(Helper { program, memory_mb, time: Duration::from_secs(300) });
        config.preview_time = Duration::from_secs(preview_s);
    })
    .await
}

/// How many helpers with so much memory there are.
fn helpers(memory_mb: u64) -> usize {
    let wanted = format!("judge\0--memory-mb\0{memory_mb}\0");
    let processes = std::fs::read_dir("/proc").unwrap().flatten();
    let lines = processes.filter_map(|process| std::fs::read_to_string(process.path().join("cmdline")).ok());
    lines.filter(|line| line.contains(&wanted)).count()
}

async fn within(time: Duration, mut is_so: impl FnMut() -> bool) -> bool {
    let wait = async {
        while !is_so() {
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    };
    tokio::time::timeout(time, wait).await.is_ok()
}

/// An instructor at the draft of an exercise.
#[derive(Clone)]
struct Writer {
    client: Client,
    draft: String,
    csrf: String,
    document: String,
    scene: String,
}

impl Writer {
    async fn of_school(app: &App, name: &str) -> Self {
        let school = app.school(name).await;
        app.publish(school).await;
        let email = format!("osei@{name}.example");
        app.member(school, Role::Instructor, &email).await;
        let mut client = app.signed_in(&email).await;
        let csrf = csrf_in(&client.get("/curricula").await.text());
        let begun = client.form(&format!("/exercises/{EXERCISE}/draft"), &[("csrf", &csrf)]).await;
        let folder = crate::support::course_folder();
        let document = std::fs::read_to_string(folder.join("5-oblique-approach.toml")).unwrap();
        let scene = std::fs::read_to_string(folder.join("../scenes/lower-back-training.toml")).unwrap();
        Self { client, draft: begun.header("location").to_owned(), csrf, document, scene }
    }

    /// A tissue that takes minutes.
    fn costly(mut self) -> Self {
        self.scene.push_str("\n[tissue]\nmodel = \"volumetric\"\ntolerance = 0.000001\n");
        self
    }

    fn fields(&self) -> [(&str, &str); 5] {
        let texts = [("document", self.document.as_str()), ("scene", &self.scene)];
        [("csrf", &self.csrf), texts[0], texts[1], ("seen", "1"), ("act", "save")]
    }

    async fn preview(&mut self) -> Answer {
        let typed = self.clone();
        self.client.form(&format!("{}/preview", self.draft), &typed.fields()[..3]).await
    }

    async fn save(&mut self) -> Answer {
        let typed = self.clone();
        self.client.form(&self.draft, &typed.fields()).await
    }
}

#[tokio::test]
async fn costly_draft_is_abandoned_and_delays_no_other_school() {
    let app = service(1501, 25).await;
    let mut north = Writer::of_school(&app, "north").await.costly();
    let mut south = Writer::of_school(&app, "south").await;
    let costly = tokio::spawn(async move { (north.save().await, north) });
    assert!(within(Duration::from_secs(20), || helpers(1501) == 1).await, "it is looked at by a helper");
    let honest = south.preview().await;
    assert!(honest.status == 200 && honest.text().contains("<svg"), "{}", honest.text());
    assert_eq!(helpers(1501), 1, "the costly one is still under way");
    let (saved, mut north) = costly.await.unwrap();
    assert!(saved.status == 200 && saved.text().contains("Too expensive to check"), "{}", saved.text());
    assert!(saved.text().contains("25 s"), "its author is told what is allowed");
    assert_eq!(helpers(1501), 0, "nobody computes on");
    north.scene = south.scene.clone();
    let again = north.preview().await.text();
    assert!(again.contains("<svg") && !again.contains("Too expensive to check"), "{again}");
}

#[tokio::test]
async fn school_checks_one_draft_at_a_time_and_gets_a_retry_time() {
    let app = service(1502, 60).await;
    let north = Writer::of_school(&app, "north").await;
    let (mut costly, mut honest) = (north.clone().costly(), north);
    let first = tokio::spawn(async move { costly.preview().await });
    assert!(within(Duration::from_secs(20), || helpers(1502) == 1).await);
    let refused = honest.preview().await;
    assert_eq!((refused.status.as_u16(), refused.header("retry-after")), (503, "5"), "{}", refused.text());
    assert!(refused.text().contains("Not checked yet"), "{}", refused.text());
    // Its page is there all the same, with what was written.
    let page = honest.client.get(&honest.draft).await;
    assert!(page.status == 503 && page.text().contains("<textarea"), "{}", page.text());
    // Whoever waits no more, as at a 408, ends the work.
    first.abort();
    assert!(within(Duration::from_secs(2), || helpers(1502) == 0).await, "nobody waits, and it goes on");
    assert_eq!(honest.preview().await.status, 200);
}

#[tokio::test]
async fn a_connection_that_is_closed_ends_the_work() {
    let app = service(1503, 60).await;
    let writer = Writer::of_school(&app, "north").await.costly();
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address: SocketAddr = listener.local_addr().unwrap();
    let limits = ConnectionLimits::of_process(false);
    tokio::spawn(serving::serve_connections(listener, app.router.clone(), limits, std::future::pending()));
    let body = encoded(&writer.fields()[..3]);
    let head = format!(
        "POST {}/preview HTTP/1.1\r\nHost: localhost\r\nCookie: {}\r\nContent-Type: application/x-www-form-urlencoded\r\n\
         Content-Length: {}\r\n\r\n",
        writer.draft,
        writer.client.cookie.clone().unwrap(),
        body.len()
    );
    let mut stream = std::net::TcpStream::connect(address).unwrap();
    stream.write_all((head + &body).as_bytes()).unwrap();
    let begun = within(Duration::from_secs(20), || helpers(1503) == 1).await;
    if !begun {
        let mut said = String::new();
        let _ = stream.read_to_string(&mut said);
        panic!("it is not looked at: {said}");
    }
    drop(stream);
    assert!(within(Duration::from_secs(2), || helpers(1503) == 0).await, "its browser has gone, and it goes on");
}
