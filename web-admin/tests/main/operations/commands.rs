//! The program as somebody at a terminal meets it: exit codes, one line for an error, and what `verify` finds.

use std::path::Path;
use std::process::Command;

use model::Role;
use web_admin::worker;

use crate::support::database::drop_trigger;
use crate::support::recordings::{Attempt, record};
use crate::support::{App, PASSWORD, course_folder, web_admin};

/// Runs what must succeed; what it printed.
fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = web_admin(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Runs what must fail with a code; its one line of complaint.
fn fails(folder: &Path, arguments: &[&str], code: i32) -> String {
    let output = web_admin(folder, arguments);
    let words = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {words}");
    assert_eq!(words.trim_end().lines().count(), 1, "{arguments:?}: {words}");
    words
}

#[test]
fn a_school_is_set_up_from_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path();
    done(data, &["migrate"]);
    let added =
        done(data, &["user", "add", "--email", "Head@example.org", "--name", "Head", "--role", "administrator"]);
    assert!(added.contains("administrator head@example.org") && added.contains("password: "), "{added}");
    let ada = ["user", "add", "--email", "ada@example.org", "--name", "Ada", "--cohort", "2026", "--token"];
    let added = done(data, &[&ada[..], &["--password", PASSWORD]].concat());
    assert!(added.contains("token: ") && !added.contains(PASSWORD) && added.contains("chooses their own"), "{added}");
    let course = course_folder().parent().unwrap().to_string_lossy().into_owned();
    assert!(done(data, &["curricula", "import", &course]).contains("new       course lower-back-basics"));
    let again = done(data, &["curricula", "import", &course]);
    assert!(again.lines().all(|line| line.starts_with("unchanged")), "{again}");
    for whose in [["--email", "ada@example.org"], ["--station", "room 2"]] {
        let printed = done(data, &[&["user", "token"], &whose[..]].concat());
        let token = printed.strip_suffix('\n').expect("a line");
        assert!(token.len() == 64 && token.bytes().all(|byte| byte.is_ascii_hexdigit()), "a token alone: {printed:?}");
    }
    assert!(done(data, &["user", "reset-password", "--email", "ada@example.org"]).contains("password: "));
    assert!(done(data, &["user", "disable", "--email", "ada@example.org"]).contains("2 tokens revoked"));
    assert!(done(data, &["user", "disable", "--email", "ada@example.org"]).contains("already"));
    assert!(done(data, &["verify"]).contains("0 findings"));
}

#[test]
fn a_wrong_call_is_told_what_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path();
    let add = |email: &'static str, rest: &[&'static str]| {
        [&["user", "add", "--name", "Ada", "--email", email], rest].concat()
    };
    assert!(fails(data, &add("ada", &[]), 2).contains("name@example.org"));
    assert!(fails(data, &add("a@b.c", &["--password", "short"]), 2).contains("at least 10"));
    assert!(fails(data, &["user", "disable", "--email", "a@b.c"], 2).contains("no person has this address"));
    done(data, &add("a@b.c", &["--school", "North"]));
    assert!(fails(data, &add("A@B.C", &["--school", "North"]), 2).contains("already"));
    done(data, &add("d@e.f", &["--school", "South"]));
    done(data, &add("a@b.c", &["--school", "South"]));
    let both = fails(data, &["user", "disable", "--email", "a@b.c"], 2);
    assert!(both.contains("--school: required") && both.contains("North") && both.contains("South"), "{both}");
    done(data, &["user", "disable", "--email", "a@b.c", "--school", "South"]);
    assert!(fails(data, &add("g@h.i", &[]), 2).contains("North, South"));
    let head = ["--school", "North", "--role", "administrator", "--cohort", "A"];
    assert!(fails(data, &add("g@h.i", &head), 2).contains("--cohort"));
    let refused = fails(data, &["migrate", "--database", "mysql://ada:secret@x/y"], 2);
    assert!(
        refused.contains("a sqlite: URL, a path, or a postgres:// URL") && !refused.contains("secret"),
        "{refused}"
    );
    assert!(fails(data, &["curricula", "import", "/nonexistent"], 2).contains("/nonexistent"));
    let empty = tempfile::tempdir().unwrap();
    assert!(
        fails(data, &["curricula", "import", &empty.path().to_string_lossy()], 2).contains("neither a course.toml")
    );
    for nowhere in ["postgres://127.0.0.1:1/x", "nothing-here/x.db"] {
        assert!(fails(data, &["verify", "--database", nowhere], 1).contains("cannot open the database"));
    }
    let output = Command::new(env!("CARGO_BIN_EXE_web-admin")).arg("openapi").output().unwrap();
    assert!(output.status.success() && output.stdout.starts_with(b"{"));
}

#[test]
fn keys_are_made_once_if_writable_and_required_otherwise() {
    let folder = tempfile::tempdir().unwrap();
    let (data, keys) = (folder.path(), folder.path().join("keys"));
    let make = ["keys", "--keys", keys.to_str().unwrap()];
    done(data, &make);
    let read =
        || ["certificate-key", "second-factor-key"].map(|name| std::fs::read_to_string(keys.join(name)).unwrap());
    let made = read();
    done(data, &make);
    assert_eq!(read(), made);
    let refused = fails(data, &["work", "--keys", "/proc/nobody-can-write-here"], 1);
    assert!(refused.contains("here/certificate-key; ") && refused.contains("`web-admin keys --keys"), "{refused}");
    std::fs::write(keys.join("second-factor-key"), "short").unwrap();
    let refused = fails(data, &["work", "--keys", keys.to_str().unwrap()], 1);
    assert!(refused.contains("second-factor-key: allowed: 64 hexadecimal digits"), "{refused}");
}

/// Where a server keeps the database.
#[test]
fn backup_of_a_server_is_refused_and_its_password_stays_hidden() {
    only_on!(Postgres, "about a server");
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path();
    done(data, &["migrate"]);
    let to = data.join("backup.tar");
    let to = to.to_str().unwrap();
    for asked in [&["backup", "--to", to][..], &["restore", to]] {
        let refused = fails(data, asked, 1);
        assert!(refused.contains("pg_dump") && refused.contains("WAL"), "{refused}");
    }
    let left: Vec<_> = std::fs::read_dir(data).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(left.iter().all(|name| !name.to_string_lossy().starts_with("backup")), "{left:?}");
    for nowhere in ["postgres://ada:secret@127.0.0.1:1/x", "postgres://ada:secret@127.0.0.1:none/x"] {
        for asked in ["migrate", "verify", "serve"] {
            let refused = fails(data, &[asked, "--database", nowhere], 1);
            assert!(!refused.contains("secret"), "{refused}");
        }
    }
}

#[tokio::test]
async fn grading_again_is_shown_first_and_done_for_a_reason() {
    let app = App::new().await;
    let school = app.school("North").await;
    app.publish(school).await;
    let mut ada = app.with_token(&app.member(school, Role::Trainee, "ada@example.org").await.token);
    let attempt = Attempt::default();
    assert_eq!(ada.upload(&record(&attempt)).await.status, 201);
    worker::work_off_jobs(&app.state).await.unwrap();
    app.publish_with_pass_mark(school, 100).await;
    let data = app.folder.path();
    let rescore = |rest: &[&str]| done(data, &[&["rescore", "feel-the-layers"], rest].concat());
    let acts = async || {
        let acts = sqlx::query_scalar::<_, String>("SELECT details FROM audit_log WHERE action = 'session.regraded'");
        acts.fetch_all(app.state.db.reader()).await.unwrap()
    };

    let shown = rescore(&[]);
    assert!(shown.contains(&attempt.session_id.to_string()) && shown.contains(" passed -> "), "{shown}");
    assert!(shown.contains("1 of 1 attempts would be"), "{shown}");
    assert!(fails(data, &["rescore", "feel-the-layers", "--apply", "--reason", " "], 2).contains("reason"));
    assert!(!web_admin(data, &["rescore", "feel-the-layers", "--apply"]).status.success());
    assert!(acts().await.is_empty(), "looking changes nothing, nor does what has no reason");
    let done_so = rescore(&["--apply", "--reason", "A stricter mark"]);
    assert!(done_so.contains("not passed") && done_so.contains("1 of 1 attempts re-graded"), "{done_so}");
    app.member(school, Role::Administrator, "admin@example.org").await;
    let history =
        app.signed_in("admin@example.org").await.get(&format!("/sessions/{}/grade", attempt.session_id)).await;
    assert!(history.text().contains("<strong>At the command line</strong>: A stricter mark"), "{}", history.text());
    let acts = acts().await;
    assert!(acts.len() == 1 && acts[0].contains("reason_sha256"), "{acts:?}");
    assert!(rescore(&[]).contains("0 of 1"), "nothing is left to do");
    assert!(fails(data, &["rescore", "nothing"], 2).contains("no scored attempt"));
    app.state.db.close().await;
}

#[tokio::test]
async fn verify_names_every_damage() {
    let app = App::new().await;
    let school = app.school("North").await;
    let mut ada = app.with_token(&app.member(school, Role::Trainee, "ada@example.org").await.token);
    let attempts: Vec<_> = (0..3).map(|_| Attempt::default()).collect();
    for attempt in &attempts {
        assert_eq!(ada.upload(&record(attempt)).await.status, 201);
    }
    let mut tx = app.state.db.write().await.unwrap();
    sqlx::raw_sql(drop_trigger("audit_log_never_changes", "audit_log")).execute(&mut *tx).await.unwrap();
    sqlx::raw_sql("UPDATE audit_log SET object = 'x' WHERE seq = 2").execute(&mut *tx).await.unwrap();
    tx.commit().await.unwrap();
    let file = |n: usize| {
        app.state.config.recordings_dir.join(school.to_string()).join(format!("{}.mcap", attempts[n].session_id))
    };
    std::fs::remove_file(file(0)).unwrap();
    let mut bytes = std::fs::read(file(1)).unwrap();
    std::fs::write(file(1), &bytes[1..]).unwrap();
    bytes = std::fs::read(file(2)).unwrap();
    bytes[100] ^= 1;
    std::fs::write(file(2), bytes).unwrap();
    app.state.db.close().await;
    let output = web_admin(app.folder.path(), &["verify"]);
    let words = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(1), "{words}");
    for (attempt, finding) in attempts.iter().zip(["No such file", "were stored", "do not match the stored hash"]) {
        let line = words.lines().find(|line| line.contains(&attempt.session_id.to_string())).unwrap();
        assert!(line.contains(finding), "{line}");
    }
    let trigger = "audit_log_never_changes is missing or changed";
    assert!(words.contains("row 2 was changed") && words.contains(trigger), "{words}");
    assert!(words.contains("5 findings"), "{words}");
}
