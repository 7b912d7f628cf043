//! Programs that nobody here wrote, given what we hand out: the rules of OpenAPI, a client generated from the API's description, a
//! client of tus, and another implementation of Ed25519. Fails when one of them refuses what our own programs agree on.

use std::path::Path;

use tests::{Service, python, python_ok, root, run, run_ok};

use crate::visitor::{INITIAL, Visitor, choose_password};
use crate::whole_path::{PASSWORD, found_school, id, json, only_session, scored, simulate};

/// A course of one exercise that is mastered with one pass.
const COURSE: &str = "id = \"one-step\"\ntitle = \"One step\"\n[mastery]\nrule = \"passes\"\npasses = 1\nof = 1\n\
                      [[exercise]]\nfile = \"only.toml\"\n";

/// How the client is to be made; pieces of an upload are bytes under a name of tus's own.
const GENERATOR: &str = "package_name_override: stylet_client\npost_hooks: []\n\
                         content_type_overrides:\n  application/offset+octet-stream: application/octet-stream\n";

/// The API's description, in a file.
fn description(folder: &Path) -> String {
    let file = folder.join("openapi.json").to_string_lossy().into_owned();
    std::fs::write(&file, run_ok("web-admin", &["openapi"])).expect("a file");
    file
}

#[test]
fn the_description_keeps_to_the_rules_of_openapi() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = description(folder.path());
    let operations: usize = python_ok(&["check_api.py", &file]).trim().parse().expect("a count");
    assert!(operations >= 26, "only {operations} operations are described");
    let text = std::fs::read_to_string(&file).expect("the description");
    let broken = text.replacen("\"description\": \"Done\"", "\"summary\": \"Done\"", 1);
    assert!(broken != text, "a response is described");
    std::fs::write(&file, broken).expect("a file");
    assert!(!python(&["check_api.py", &file]).status.success(), "the rules find a response without a description");
}

#[test]
fn generated_client_uploads_and_reads_the_score() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    std::fs::write(at("config.yml"), GENERATOR).expect("a file");
    let (file, config, client) = (description(folder.path()), at("config.yml"), at("stylet_client"));
    let generate = ["-m", "openapi_python_client", "generate", "--path", &file, "--config", &config];
    python_ok(&[&generate[..], &["--meta", "none", "--output-path", &client, "--fail-on-warning"]].concat());

    let data = folder.path().join("data");
    let token = found_school(&data);
    let recording = simulate(folder.path(), "attempt.mcap", "novice");
    let service = Service::start(&data);
    let path = folder.path().to_string_lossy();
    let read = json(&python_ok(&["upload_by_client.py", &path, &service.url, &token, &recording]));
    let ours = json(&run_ok("stylet", &["score", &recording, "--json"]));
    for key in ["score", "passed", "metrics", "deductions", "hard_fails", "rubric", "simulator_version"] {
        assert_eq!(read[key], ours[key], "{key}");
    }
}

#[test]
fn tuspy_uploads_with_nothing_but_a_token() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data");
    let token = found_school(&data);
    let recording = simulate(folder.path(), "attempt.mcap", "novice");
    let service = Service::start(&data);
    let upload = python_ok(&["upload_by_tus.py", &service.url, &token, &recording]);
    assert!(upload.starts_with(&format!("{}/api/v1/uploads/", service.url)), "{upload}");
    only_session(&service.url, &token);
}

/// A school with a course of one exercise that anybody masters, whatever the score; the trainee's token.
fn easy_school(folder: &Path, data: &Path) -> String {
    let token = found_school(data);
    let (course, scenes) = (folder.join("easy/course"), folder.join("easy/scenes"));
    std::fs::create_dir_all(&course).expect("a folder");
    std::fs::create_dir_all(&scenes).expect("a folder");
    for scene in std::fs::read_dir(root().join("curricula/scenes")).expect("scenes").flatten() {
        std::fs::copy(scene.path(), scenes.join(scene.file_name())).expect("a scene");
    }
    let text = std::fs::read_to_string(root().join(tests::first_exercise())).expect("an exercise");
    let mark = text.lines().find(|line| line.starts_with("pass_mark")).expect("a pass mark");
    std::fs::write(course.join("only.toml"), text.replace(mark, "pass_mark = 0")).expect("an exercise");
    std::fs::write(course.join("course.toml"), COURSE).expect("a course");
    let easy = folder.join("easy").to_string_lossy().into_owned();
    run_ok(
        "web-admin",
        &["curricula", "import", &easy, "--school", "Test School", "--data-dir", &data.to_string_lossy()],
    );
    token
}

/// The program that the page on certificates shows.
fn shown_program() -> String {
    let page = std::fs::read_to_string(root().join("docs/certificates.md")).expect("the page");
    let program = page.split("```python\n").nth(1).and_then(|rest| rest.split("```").next());
    program.expect("a program").to_owned()
}

#[test]
fn certificate_verifies_by_its_page_and_the_published_key() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let data = folder.path().join("data");
    let token = easy_school(folder.path(), &data);
    let out = at("attempt.mcap");
    let exercise = at("easy/course/only.toml");
    run_ok("stylet", &["simulate", &exercise, "--operator", "expert", "--seed", "7", "--out", &out]);
    let add = ["user", "add", "--data-dir", &at("data"), "--school", "Test School", "--role", "administrator"];
    run_ok(
        "web-admin",
        &[&add[..], &["--email", "head@example.org", "--name", "Head", "--password", INITIAL]].concat(),
    );
    let service = Service::start(&data);
    std::fs::write(at("token"), &token).expect("a file");
    let outbox = at("outbox");
    run_ok("stylet", &["upload", &out, "--server", &service.url, "--token-file", &at("token"), "--outbox", &outbox]);
    let session = only_session(&service.url, &token);
    scored(&service.url, &token, &id(&session, "session_id"));

    // The school asks for no more than passes: this attempt was neither signed nor supervised.
    for email in ["head@example.org", "ada@example.org"] {
        choose_password(&service.url, email, PASSWORD);
    }
    let head = Visitor::signed_in(&service.url, "head@example.org", PASSWORD);
    head.send("/admin", "/admin/certificate-needs", &[("needed", "nothing")]);
    let trainee = Visitor::signed_in(&service.url, "ada@example.org", PASSWORD);
    let page = trainee.press("/account", &format!("/trainees/{}/certificates/one-step", id(&session, "trainee_id")));
    let (genuine, forged, program) = (at("certificate.html"), at("forged.html"), at("check.py"));
    std::fs::write(&genuine, &page).expect("a file");
    assert!(page.matches("Ada").count() > 1);
    std::fs::write(&forged, page.replace("Ada", "Bob")).expect("a file");
    std::fs::write(&program, shown_program()).expect("a file");
    let mut published = ureq::get(format!("{}/.well-known/stylet-certificate-key", service.url)).call().expect("a key");
    let key = published.body_mut().read_to_string().expect("a body").trim().to_owned();

    let stated = json(&python_ok(&[&program, &genuine, &key]));
    assert_eq!((&stated["trainee"], &stated["course"]), (&"Ada".into(), &"One step".into()), "{stated}");
    run_ok("web-admin", &["certificate", "verify", &genuine, "--key", &key]);
    let elsewhere = "0".repeat(64);
    for (file, key) in [(&forged, &key), (&genuine, &elsewhere)] {
        assert!(!python(&[&program, file, key]).status.success(), "{file} with {key}");
        assert_eq!(run("web-admin", &["certificate", "verify", file, "--key", key]).status.code(), Some(1));
    }
}
