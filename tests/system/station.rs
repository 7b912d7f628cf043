//! A station's day: it joins, a trainee signs in, the attempt goes home over a network that keeps breaking. Fails when
//! a byte is lost or sent into another attempt, when the attempt is listed twice or not at all, when it leaves the
//! outbox before it has arrived, or when the attempt is not the trainee's.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::SeqCst;
use std::thread;

use recording::{EventKind, Recording};
use serde_json::{Value, json};
use tests::{Service, first_exercise, program, root, run_ok};

use crate::visitor::{INITIAL, Visitor, choose_password};
use crate::window::{Display, with_extension, within};

pub const PASSWORD: &str = "a long enough password";
/// Connections that the network breaks before it behaves.
const CUTS: usize = 20;

/// A school with an administrator and a trainee; the trainee's own token.
pub fn found_school(data: &str) -> String {
    run_ok("web-admin", &["migrate", "--data-dir", data]);
    for (role, email) in [("administrator", "head@example.org"), ("trainee", "ada@example.org")] {
        let add = ["user", "add", "--data-dir", data, "--school", "North", "--role", role];
        run_ok("web-admin", &[&add[..], &["--email", email, "--name", "Ada", "--password", INITIAL]].concat());
    }
    let token = run_ok("web-admin", &["user", "token", "--data-dir", data, "--email", "ada@example.org"]);
    token.trim_end().to_owned()
}

/// Runs `stylet` at a station whose user's home is `home`; what it printed, and whether it ended well.
fn stylet(home: &Path, arguments: &[&str]) -> (bool, String) {
    let output = at_home(home, arguments).current_dir(root()).output().expect("stylet starts");
    let said = [output.stdout, output.stderr].concat();
    (output.status.success(), String::from_utf8_lossy(&said).into_owned())
}

fn at_home(home: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(program("stylet"));
    command.args(arguments).env("XDG_DATA_HOME", home.join("data")).env("XDG_CONFIG_HOME", home.join("config"));
    command.env_remove("STYLET_TOKEN").env_remove("STYLET_OUTBOX");
    command
}

/// The code that a page shows.
pub fn code_on(page: &str) -> String {
    let code = page.split("code-to-type\">").nth(1).and_then(|rest| rest.split('<').next());
    code.expect("a code on the page").to_owned()
}

/// A network in front of a service: until it has broken so often, it cuts each connection after a number of bytes, in a
/// known sequence. One that ends by itself before that is no cut.
pub struct Network {
    /// Address with scheme.
    pub address: String,
    /// Connections cut so far.
    pub cuts: Arc<AtomicUsize>,
}

impl Network {
    /// A network that breaks so often before it behaves. Few of its connections let a piece pass.
    pub fn before(service: &str, breaks: usize) -> Self {
        Self::letting_pass(300_000, service, breaks)
    }

    /// A network that breaks so often, each time after fewer than `most_bytes` of the client's.
    pub fn letting_pass(most_bytes: usize, service: &str, breaks: usize) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = format!("http://{}", listener.local_addr().expect("an address"));
        let service = service.trim_start_matches("http://").to_owned();
        let cuts = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&cuts);
        thread::spawn(move || {
            let mut word = 2026_u32;
            for client in listener.incoming().flatten() {
                // The generator of Numerical Recipes; the seed is of no importance.
                word = word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let allowance =
                    if counted.load(SeqCst) < breaks { (word >> 8) as usize % most_bytes } else { usize::MAX };
                let server = TcpStream::connect(&service).expect("the service is there");
                let counted = Arc::clone(&counted);
                thread::spawn(move || carry(client, server, allowance, &counted));
            }
        });
        Self { address, cuts }
    }
}

/// Carries bytes both ways until the client has sent `allowance` of them; then both sides lose each other. The cut is
/// counted before anybody can know of it.
fn carry(mut client: TcpStream, mut server: TcpStream, mut allowance: usize, cuts: &AtomicUsize) {
    let (mut back_from, mut back_to) = (server.try_clone().expect("a handle"), client.try_clone().expect("a handle"));
    let back = thread::spawn(move || std::io::copy(&mut back_from, &mut back_to));
    let mut piece = [0; 4096];
    while let Ok(read) = client.read(&mut piece) {
        let passed = read.min(allowance);
        let cut = passed < read;
        cuts.fetch_add(usize::from(cut), SeqCst);
        if read == 0 || server.write_all(&piece[..passed]).is_err() || cut {
            break;
        }
        allowance -= passed;
    }
    // Whoever is gone already needs no telling.
    let _ = server.shutdown(Shutdown::Both);
    let _ = client.shutdown(Shutdown::Both);
    let _ = back.join();
}

/// A network whose first connection falls silent after a number of bytes: the client knows at once, the service never does.
fn falls_silent(service: &str, after: usize) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = format!("http://{}", listener.local_addr().expect("an address"));
    let service = service.trim_start_matches("http://").to_owned();
    thread::spawn(move || {
        let mut connections = listener.incoming().flatten();
        let mut first = connections.next().expect("a client");
        let mut silent = TcpStream::connect(&service).expect("the service is there");
        let (mut from, mut to) = (silent.try_clone().expect("a handle"), first.try_clone().expect("a handle"));
        thread::spawn(move || std::io::copy(&mut from, &mut to));
        let (mut piece, mut left) = ([0; 4096], after);
        while left > 0 {
            let read = first.read(&mut piece).expect("bytes");
            silent.write_all(&piece[..read]).expect("the service is there");
            left = left.saturating_sub(read);
        }
        first.shutdown(Shutdown::Both).expect("an end");
        for client in connections {
            let server = TcpStream::connect(&service).expect("the service is there");
            thread::spawn(move || carry(client, server, usize::MAX, &AtomicUsize::new(0)));
        }
        drop(silent);
    });
    address
}

/// The body of an answer.
pub fn get(url: &str, token: &str) -> Vec<u8> {
    let answer = ureq::get(url).header("Authorization", format!("Bearer {token}")).call().expect("an answer");
    answer.into_body().read_to_vec().expect("a body")
}

fn sign_in(url: &str, home: &Path, code: &str) -> Value {
    let pairing = std::fs::read(home.join("config/stylet/station.json")).expect("the station is paired");
    sign_in_by(url, &serde_json::from_slice(&pairing).expect("JSON"), code)
}

/// Signs a trainee in at a station, whose file with the token is given.
pub fn sign_in_by(url: &str, pairing: &Value, code: &str) -> Value {
    let answer = ureq::post(format!("{url}/api/v1/stations/sign-in"))
        .header("Authorization", format!("Bearer {}", pairing["token"].as_str().expect("a token")))
        .content_type("application/json")
        .send(json!({ "code": code }).to_string())
        .expect("signed in");
    serde_json::from_str(&answer.into_body().read_to_string().expect("a body")).expect("JSON")
}

/// A sign-in code, made and read from the page that shows it.
pub fn sign_in_code(visitor: &Visitor) -> String {
    visitor.press("/", "/sign-in-code");
    code_on(&visitor.page("/sign-in-code"))
}

#[test]
fn an_attempt_goes_home_over_a_network_that_breaks_twenty_times() {
    let folder = tempfile::tempdir().expect("a folder");
    let (data, home) = (folder.path().join("data"), folder.path().join("home"));
    let token = found_school(&data.to_string_lossy());
    let service = Service::start(&data);
    for email in ["head@example.org", "ada@example.org"] {
        choose_password(&service.url, email, PASSWORD);
    }
    let head = Visitor::signed_in(&service.url, "head@example.org", PASSWORD);
    let code = code_on(&head.press("/admin", "/admin/pairing-codes"));
    let network = Network::before(&service.url, CUTS);
    let (paired, said) = stylet(&home, &["pair", "--server", &service.url, "--code", &code, "--name", "lab 2"]);
    assert!(paired && said.contains("\"lab 2\" of North"), "{said}");
    let ada = Visitor::signed_in(&service.url, "ada@example.org", PASSWORD);
    let signed_in = sign_in(&service.url, &home, &sign_in_code(&ada));

    let recording = folder.path().join("attempt.mcap").to_string_lossy().into_owned();
    let trainee = signed_in["trainee"].as_str().expect("a pseudonym");
    let attempt = ["simulate", &first_exercise(), "--operator", "novice", "--seed", "3", "--trainee", trainee];
    run_ok("stylet", &[&attempt[..], &["--out", &recording]].concat());
    let station: Value =
        serde_json::from_slice(&std::fs::read(home.join("config/stylet/station.json")).expect("a pairing"))
            .expect("JSON");
    let token_file = folder.path().join("token").to_string_lossy().into_owned();
    std::fs::write(&token_file, station["token"].as_str().expect("a token")).expect("a file");
    let upload =
        ["upload", &recording, "--server", &network.address, "--token-file", &token_file, "--retry-wait-ms", "1"];
    let (sent, said) = stylet(&home, &[&upload[..], &["--retries", "20"]].concat());
    assert!(sent, "{said}");
    assert_eq!(network.cuts.load(SeqCst), CUTS, "the network was meant to break: {said}");

    let listed: Value =
        serde_json::from_slice(&get(&format!("{}/api/v1/sessions", service.url), &token)).expect("JSON");
    let sessions = listed["sessions"].as_array().expect("a list");
    assert_eq!(sessions.len(), 1, "listed once, as the trainee's own: {listed}");
    let session = sessions[0]["session_id"].as_str().expect("an id");
    let kept = get(&format!("{}/api/v1/sessions/{session}/recording", service.url), &token);
    assert!(kept == std::fs::read(&recording).expect("the recording"), "the service's file is another");
    let (_, left) = stylet(&home, &["outbox", "--json"]);
    assert_eq!(left.trim(), "[]");
    run_ok("web-admin", &["verify", "--data-dir", &data.to_string_lossy()]);
}

#[test]
fn a_connection_that_is_half_dead_holds_nobody_up() {
    let folder = tempfile::tempdir().expect("a folder");
    let (data, home) = (folder.path().join("data"), folder.path().join("home"));
    let token_file = folder.path().join("token").to_string_lossy().into_owned();
    std::fs::write(&token_file, found_school(&data.to_string_lossy())).expect("a file");
    let service = Service::start(&data);
    let recording = folder.path().join("attempt.mcap").to_string_lossy().into_owned();
    run_ok("stylet", &["simulate", &first_exercise(), "--operator", "novice", "--seed", "3", "--out", &recording]);
    assert!(std::fs::metadata(&recording).expect("a recording").len() > 300_000);
    let network = falls_silent(&service.url, 100_000);
    let upload = ["upload", &recording, "--server", &network, "--token-file", &token_file, "--retry-wait-ms", "50"];
    let (sent, said) = stylet(&home, &upload);
    // One try more, and none of them was told that the upload is locked.
    assert!(sent && said.contains("after 2 tries"), "{said}");
}

#[test]
fn trainee_signs_in_at_the_window_and_the_attempt_is_uploaded() {
    let folder = tempfile::tempdir().expect("a folder");
    let (data, home, kept) = (folder.path().join("data"), folder.path().join("home"), folder.path().join("kept"));
    let token = found_school(&data.to_string_lossy());
    let service = Service::start(&data);
    for email in ["head@example.org", "ada@example.org"] {
        choose_password(&service.url, email, PASSWORD);
    }
    let head = Visitor::signed_in(&service.url, "head@example.org", PASSWORD);
    let code = code_on(&head.press("/admin", "/admin/pairing-codes"));
    let (paired, said) = stylet(&home, &["pair", "--server", &service.url, "--code", &code, "--name", "lab 2"]);
    assert!(paired, "{said}");
    let ada = Visitor::signed_in(&service.url, "ada@example.org", PASSWORD);
    let code = sign_in_code(&ada);

    std::fs::create_dir(&kept).expect("a folder");
    let (display, kept_in) = (Display::open(), kept.to_string_lossy());
    let exercise = "curricula/lower-back-basics/1-feel-the-layers.toml";
    let play = ["play", exercise, "--device", "operator:constant:20", "--recordings", &kept_in];
    let mut play = display.open_window(&mut at_home(&home, &play));
    // What is typed before the field is shown as chosen goes nowhere.
    display.and_settles(|| display.press("Tab"));
    display.and_settles(|| display.write(&code));
    display.press("Return");
    // While the school is asked, nothing begins: the attempt would be nobody's.
    display.begin_attempt(&kept);
    let recording = within(60, "the recording", || with_extension(&kept, "mcap"));
    let recording = Recording::read(std::fs::File::open(recording).expect("a file")).expect("a recording");
    let coached = recording.events.iter().any(|event| event.kind == EventKind::Coaching);
    assert!(coached, "20 mm/s is too fast, and that was said: {:?}", recording.events);
    let sessions = within(60, "the attempt at school", || {
        let listed = get(&format!("{}/api/v1/sessions", service.url), &token);
        let listed: Value = serde_json::from_slice(&listed).expect("JSON");
        listed["sessions"].as_array().cloned().filter(|sessions| !sessions.is_empty())
    });
    assert_eq!(sessions.len(), 1, "{sessions:?}");
    assert_eq!(sessions[0]["session_id"], recording.session.session_id.to_string());
    let _ = play.kill();
    let _ = play.wait();
}
