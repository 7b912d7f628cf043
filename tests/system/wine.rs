//! The station for Windows under Wine, against the same program and a service on Linux; `tests/wine/run` builds it and runs these. Fails
//! when Windows computes, scores or draws something else, when a path with a space or an umlaut is lost, when a recording is lost,
//! changed or doubled on its way to the school, or when the window does not open. Timing and graphics drivers are not tested: Wine has
//! none of its own.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output};
use std::sync::atomic::Ordering::SeqCst;

use data_encoding::HEXLOWER;
use serde_json::Value;
use sha2::{Digest, Sha256};
use tests::{Service, documents, first_exercise, program, root, run, run_ok};

use crate::station::{Network, PASSWORD, code_on, found_school, get, sign_in_by, sign_in_code};
use crate::visitor::{Visitor, choose_password};
use crate::window::{Display, with_extension, within};

/// Environment variable with the folder of the station for Windows, as it is in the zip.
const STATION: &str = "STYLET_TEST_WINDOWS";
/// Connections that the network breaks, and recordings that it brings nevertheless.
const CUTS: usize = 60;
const RECORDINGS: usize = 100;
/// Attempts that are performed on both systems.
const CASES: usize = 40;

/// A program of the station for Windows.
fn for_windows(program: &str) -> Command {
    let station = std::env::var(STATION).expect("tests/wine/run names the folder");
    let mut command = Command::new("wine");
    command.arg(Path::new(&station).join(program)).current_dir(root());
    command.env_remove("STYLET_TOKEN").env_remove("STYLET_OUTBOX");
    command
}

/// Runs the program for Windows.
fn wine(arguments: &[&str]) -> Output {
    for_windows("bin/stylet.exe").args(arguments).output().expect("wine starts")
}

/// Runs it to a good end, and returns what it printed.
fn wine_ok(arguments: &[&str]) -> String {
    let output = wine(arguments);
    let [out, err] = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    assert!(output.status.success(), "{arguments:?} {}: {out}{err}", output.status);
    out
}

/// A path as Windows has it: Wine shows all of Linux as drive Z.
fn z(path: &Path) -> String {
    format!("Z:{}", path.to_string_lossy().replace('/', "\\"))
}

fn exercises() -> Vec<String> {
    let is_exercise = |path: &String| {
        let folder = Path::new(path).parent().and_then(Path::file_name).unwrap_or_default();
        !["scenes", "instruments"].iter().any(|other| folder == *other) && !path.ends_with("course.toml")
    };
    documents().into_iter().filter(is_exercise).collect()
}

/// Lines that differ between two outputs.
fn difference(linux: &str, windows: &str) -> Vec<String> {
    let pairs = linux.lines().zip(windows.lines()).filter(|(a, b)| a != b);
    let mut found: Vec<String> = pairs.map(|(a, b)| format!("{a} / {b}")).take(5).collect();
    if linux.lines().count() != windows.lines().count() {
        found.push(format!("{} / {} lines", linux.lines().count(), windows.lines().count()));
    }
    found
}

#[test]
#[ignore = "tests/wine/run builds the program for Windows"]
fn windows_records_and_scores_what_linux_does() {
    let folder = tempfile::Builder::new().prefix("Übung für alle ").tempdir().expect("a folder");
    let [linux, windows] = ["linux.mcap", "Versuch übers Gewebe.mcap"].map(|name| folder.path().join(name));
    let (exercises, operators) = (exercises(), ["expert", "novice", "intermediate", "constant:7"]);
    for case in 0..CASES {
        let exercise = &exercises[case % exercises.len()];
        let operator = operators[(case / exercises.len() + case) % operators.len()];
        let (seed, session) = (case.to_string(), format!("01890a5d-ac96-774b-bcce-b302099a{case:04}"));
        let made = |out: &str| {
            let fixed = ["--started-at", "2026-01-31T09:00:00Z", "--force", "--session-id", &session];
            let choice = ["simulate", exercise, "--operator", operator, "--seed", &seed, "--out", out];
            [&choice[..], &fixed[..]].concat().into_iter().map(str::to_owned).collect::<Vec<_>>()
        };
        let (linux, windows_name) = (linux.to_string_lossy(), z(&windows));
        run_ok("stylet", &made(&linux).iter().map(String::as_str).collect::<Vec<_>>());
        wine_ok(&made(&windows_name).iter().map(String::as_str).collect::<Vec<_>>());
        let windows = windows.to_string_lossy();
        let what = format!("{exercise}, {operator}, seed {seed}");
        let [a, b] = [&linux, &windows].map(|file| fs::read(&**file).expect("a recording"));
        assert!(a == b, "{what}: the recordings differ, of {} and {} bytes", a.len(), b.len());
        let scores = [run_ok("stylet", &["score", &linux, "--json"]), wine_ok(&["score", &windows_name, "--json"])];
        assert_eq!(difference(&scores[0], &scores[1]), [""; 0], "{what}: the scores");
        let verified: Value = serde_json::from_str(&wine_ok(&["verify", &windows_name, "--json"])).expect("JSON");
        assert_eq!(verified["largest_deviation_n"], 0.0, "{what}: {verified}");
    }
}

#[test]
#[ignore = "tests/wine/run builds the program for Windows"]
fn windows_checks_documents_as_linux_does() {
    let exercises = exercises();
    assert!(exercises.len() > 12, "{exercises:?}");
    for exercise in &exercises {
        let check = ["check", exercise, "--json"];
        let on_linux: Value = serde_json::from_slice(&run("stylet", &check).stdout).expect("JSON");
        let on_windows: Value = serde_json::from_slice(&wine(&check).stdout).expect("JSON");
        assert_eq!(without_times(on_linux), without_times(on_windows), "{exercise}");
    }
}

/// A report without what a machine took for it.
fn without_times(mut report: Value) -> Value {
    match &mut report {
        Value::Object(members) => {
            members.retain(|name, _| !name.ends_with("_s") && !name.ends_with("_ms"));
            members.values_mut().for_each(|value| *value = without_times(value.take()));
        }
        Value::Array(values) => values.iter_mut().for_each(|value| *value = without_times(value.take())),
        _ => {}
    }
    report
}

#[test]
#[ignore = "tests/wine/run builds the program for Windows"]
fn windows_pairs_and_delivers_over_sixty_cuts() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data");
    found_school(&data.to_string_lossy());
    let service = Service::start(&data);
    for email in ["head@example.org", "ada@example.org"] {
        choose_password(&service.url, email, PASSWORD);
    }
    let head = Visitor::signed_in(&service.url, "head@example.org", PASSWORD);
    let code = code_on(&head.press("/admin", "/admin/pairing-codes"));
    let paired = wine_ok(&["pair", "--server", &service.url, "--code", &code, "--name", "Übungsraum 2"]);
    assert!(paired.contains("\"Übungsraum 2\" of North"), "{paired}");
    let station: Value = serde_json::from_slice(&fs::read(local_data("station.json")).expect("paired")).expect("JSON");
    assert!(local_data("station-key.json").exists(), "the station has a key");

    let ada = Visitor::signed_in(&service.url, "ada@example.org", PASSWORD);
    let signed_in = sign_in_by(&service.url, &station, &sign_in_code(&ada));
    let trainee = signed_in["trainee"].as_str().expect("a pseudonym");

    let token_file = folder.path().join("token");
    fs::write(&token_file, station["token"].as_str().expect("a token")).expect("a file");
    let made: Vec<PathBuf> = (0..RECORDINGS).map(|seed| record(folder.path(), seed, trainee)).collect();
    // Half of the connections let a piece of 256 KiB pass, so that no upload has to wait long.
    let network = Network::letting_pass(600_000, &service.url, CUTS);
    let (names, token_file) = (made.iter().map(|file| z(file)).collect::<Vec<_>>(), z(&token_file));
    let mut upload = vec!["upload", "--server", &network.address, "--token-file", &token_file];
    upload.extend(["--retry-wait-ms", "1", "--retries", "20"]);
    upload.extend(names.iter().map(String::as_str));
    let said = wine_ok(&upload);
    assert_eq!(network.cuts.load(SeqCst), CUTS, "the network was meant to break: {said}");

    assert_eq!(wine_ok(&["outbox", "--json"]).trim(), "[]", "the outbox is empty");
    assert_eq!(hashes(&made), hashes(&files_below(&data.join("recordings"))), "the service's files are others");
    run_ok("web-admin", &["verify", "--data-dir", &data.to_string_lossy()]);
    // With the token of the school's administrator, who sees all.
    let token =
        run_ok("web-admin", &["user", "token", "--data-dir", &data.to_string_lossy(), "--email", "head@example.org"]);
    let listed: Value =
        serde_json::from_slice(&get(&format!("{}/api/v1/sessions", service.url), token.trim_end())).expect("JSON");
    assert!(listed["sessions"].as_array().is_some_and(|sessions| !sessions.is_empty()), "{listed}");
}

/// An attempt recorded on Windows.
fn record(folder: &Path, seed: usize, trainee: &str) -> PathBuf {
    let file = folder.join(format!("Versuch {seed}.mcap"));
    let (seed, name) = (seed.to_string(), z(&file));
    let choice = ["--operator", "constant:20", "--seed", &seed, "--trainee", trainee, "--out", &name];
    wine_ok(&[&["simulate", &first_exercise()], &choice[..]].concat());
    file
}

/// A file in the folder for local data of Wine's user.
fn local_data(name: &str) -> PathBuf {
    let users = Path::new(&std::env::var("WINEPREFIX").expect("tests/wine/run sets it")).join("drive_c/users");
    let found = fs::read_dir(users).expect("users").flatten().map(|user| user.path().join("AppData/Local/stylet"));
    found.into_iter().find(|folder| folder.is_dir()).expect("a folder of ours").join(name)
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let (mut found, mut open) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).expect("a folder").flatten() {
            let path = entry.path();
            if path.is_dir() { open.push(path) } else { found.push(path) }
        }
    }
    found.retain(|path| path.extension().is_some_and(|extension| extension == "mcap"));
    found
}

/// How often each content is there.
fn hashes(files: &[PathBuf]) -> BTreeMap<String, usize> {
    let mut counted = BTreeMap::new();
    for file in files {
        let hash = HEXLOWER.encode(&Sha256::digest(fs::read(file).expect("a file")));
        *counted.entry(hash).or_default() += 1;
    }
    assert_eq!(counted.values().sum::<usize>(), RECORDINGS);
    counted
}

#[test]
#[ignore = "tests/wine/run builds the program for Windows"]
fn windows_draws_the_pictures_that_linux_draws() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = record(folder.path(), 1, "");
    let [linux, windows] = ["Linux.png", "Bild.png"].map(|name| folder.path().join(name));
    let mut pictures = Vec::new();
    for (at, api) in [("0", "vulkan"), ("1", "vulkan"), ("1", "gl")] {
        let draw = |mut command: Command, recording: &str, out: &str| {
            let choice = ["render", recording, "--at", at, "--size", "320x180", "--out", out];
            let output = command.args(choice).env("WGPU_BACKEND", api).output().expect("it starts");
            assert!(output.status.success(), "{at} s, {api}: {}", String::from_utf8_lossy(&output.stderr));
        };
        draw(Command::new(program("stylet")), &recording.to_string_lossy(), &linux.to_string_lossy());
        draw(for_windows("bin/stylet.exe"), &z(&recording), &z(&windows));
        let [a, b] = [&linux, &windows].map(|file| fs::read(file).expect("a picture"));
        assert!(a == b, "{at} s, {api}: the pictures differ");
        pictures.push(a);
    }
    assert!(pictures[0] != pictures[1], "the needle has moved");
    // Wine reports an adapter of Direct3D 12 before these, which does not open.
    wine_ok(&["render", &z(&recording), "--at", "1", "--size", "320x180", "--out", &z(&windows)]);
    assert_eq!(fs::read(windows).expect("a picture"), pictures[1], "by the next adapter");
}

#[test]
#[ignore = "tests/wine/run builds the program for Windows"]
fn windows_plays_in_its_window() {
    let (display, folder) = (Display::open(), tempfile::tempdir().expect("a folder"));
    let end = |mut program: Child| within(60, "the end", || program.try_wait().expect("its state"));
    // The list of the shipped exercises; then a message box.
    let list = display.open_window(&mut for_windows("Stylet.exe"));
    display.close();
    assert!(end(list).success(), "a closed window is no error");
    let message = display.open_window(for_windows("Stylet.exe").args(["--device", "nothing"]));
    display.press("Return");
    assert_eq!(end(message).code(), Some(1), "an error is shown until it is confirmed");

    let choice = ["--device", "operator:constant:10", "--recordings", &z(folder.path())];
    let play = display.start(for_windows("bin/stylet.exe").args(["play", &first_exercise()]).args(choice));
    display.begin_attempt(folder.path());
    display.wait_for_picture();
    let recording = within(120, "the recording", || with_extension(folder.path(), "mcap"));
    let verified = run_ok("stylet", &["verify", &recording.to_string_lossy(), "--json"]);
    let verified: Value = serde_json::from_str(&verified).expect("JSON");
    assert_eq!(verified["largest_deviation_n"], 0.0, "it re-simulates to the bit on Linux: {verified}");
    display.close();
    assert!(end(play).success(), "what is saved may be closed");
}
