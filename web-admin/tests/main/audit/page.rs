//! An administrator reads who did what. Fails when an act has no words, when a search misses what it names or shows another school's,
//! when the file says other than the page, and when a search reads the whole log for one page.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use model::{Moment, Role};
use pages::audit::{AUDIT_THEMES, describe_act};
use platform::clock::Clock;
use store::audit::search::{AuditSearch, find_audit_place, search_audit_log};
use store::audit::{Actor, AuditEntry};

use crate::support::App;
use crate::support::client::Client;
use crate::support::recordings::{Attempt, record};

const NOW: Moment = Moment::from_micros(1_767_268_800_000_000); // 2026-01-01 12:00

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let (folders, files): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
    let of_folders = folders.iter().flat_map(|folder| sources(folder));
    of_folders.chain(files.into_iter().filter(|file| file.extension().is_some_and(|e| e == "rs"))).collect()
}

/// Every text `"thing.done"` of the acts, as the programs write them.
fn acts_in_sources() -> BTreeSet<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = [root.join("acts/src"), root.join("src")];
    let mut found = BTreeSet::new();
    for file in folders.iter().flat_map(|folder| sources(folder)) {
        let text = std::fs::read_to_string(&file).unwrap();
        for literal in text.split('"').skip(1).step_by(2) {
            let parts: Vec<&str> = literal.split('.').collect();
            let is_word = |part: &&str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_lowercase() || b == b'_');
            if parts.len() == 2 && parts.iter().all(is_word) {
                found.insert(literal.to_owned());
            }
        }
    }
    found
}

/// Endings of files and of an example's address, a layer of a metric, and what OpenTelemetry calls an outcome and a version: no acts.
const NO_ACTS: [&str; 15] = [
    "bin",
    "csv",
    "db",
    "html",
    "json",
    "jsonl",
    "md",
    "org",
    "rs",
    "sh",
    "skin",
    "status_code",
    "toml",
    "txt",
    "version",
];
/// What a browser calls a passkey that is made, and one that signs: no theme of acts.
const WEBAUTHN: &str = "webauthn.";

#[test]
fn every_act_has_words_and_a_theme() {
    let is_act = |word: &&String| {
        !word.starts_with(WEBAUTHN) && !NO_ACTS.iter().any(|ending| word.ends_with(&format!(".{ending}")))
    };
    let acts = acts_in_sources();
    let acts: Vec<&String> = acts.iter().filter(is_act).collect();
    assert!(acts.len() > 90, "{acts:?}");
    let wordless: Vec<_> = acts.iter().filter(|act| describe_act(act).is_none()).collect();
    assert!(wordless.is_empty(), "these acts have no words: {wordless:?}");
    let themed = |act: &str| {
        let theme = act.split('.').next().unwrap();
        AUDIT_THEMES.iter().filter(|of| of.actions.contains(&theme)).count()
    };
    let astray: Vec<_> = acts.iter().filter(|act| themed(act) != 1).collect();
    assert!(astray.is_empty(), "these acts are of no theme, or of several: {astray:?}");
}

async fn text(client: &mut Client, path: &str) -> String {
    let answer = client.get(path).await;
    assert_eq!(answer.status, 200, "{path}: {}", answer.text());
    answer.text()
}

#[tokio::test]
async fn a_search_finds_what_it_names_and_the_file_says_the_same() {
    let clock = Clock::fixed(NOW);
    let app = App::with(clock.clone(), |_| {}).await;
    let (north, south) = (app.school("North").await, app.school("South").await);
    app.member(north, Role::Administrator, "head@example.org").await;
    let ada = app.member(north, Role::Trainee, "ada@example.org").await;
    app.member(south, Role::Trainee, "abroad@example.org").await;
    app.signed_in("abroad@example.org").await;
    app.with_token(&ada.token).upload(&record(&Attempt::default())).await;
    clock.advance(86_400);
    let mut head = app.signed_in("head@example.org").await;
    let all = text(&mut head, "/admin/audit").await;
    for words in ["Uploaded an attempt", "Signed in", "An attempt of Somebody", "Added a person"] {
        assert!(all.to_lowercase().contains(&words.to_lowercase()), "{words}: {all}");
    }
    let rows = |page: &str| page.matches("data-label=\"Who\"").count();
    let attempts = text(&mut head, "/admin/audit?theme=attempts").await;
    assert!(rows(&attempts) == 1 && attempts.contains("ploaded an attempt"), "{attempts}");
    let today = text(&mut head, "/admin/audit?since=2026-01-02").await;
    assert!(rows(&today) == 1 && today.contains("igned in"), "{today}");
    let before = text(&mut head, "/admin/audit?until=2026-01-01").await;
    assert_eq!(rows(&all), rows(&today) + rows(&before));
    let of_ada = text(&mut head, &format!("/admin/audit?words={}", ada.person.id)).await;
    assert_eq!(rows(&of_ada), 2, "what was done to her, and what she did: {of_ada}");
    assert!(text(&mut head, "/admin/audit?words=100%25_of").await.contains("No entries"));
    for query in ["", "theme=attempts", "since=2026-01-02", "words=somebody"] {
        let page = text(&mut head, &format!("/admin/audit?{query}")).await;
        let file = text(&mut head, &format!("/admin/audit.csv?{query}")).await;
        assert_eq!(file.lines().count() - 1, rows(&page), "{query}: {file}");
        assert!(!file.contains("abroad"), "{file}");
    }
    for nonsense in ["since=yesterday", "until=2026-13-01", "theme=weather"] {
        assert_eq!(head.get(&format!("/admin/audit?{nonsense}")).await.status, 400, "{nonsense}");
    }
}

#[tokio::test]
async fn a_search_reads_so_many_rows_and_says_where_to_go_on() {
    let app = App::with(Clock::fixed(NOW), |_| {}).await;
    let school = app.school("North").await;
    app.write(async |tx| {
        for n in 0..100 {
            let action = if n == 3 { "school.named" } else { "session.scored" };
            let entry = AuditEntry::new(school, Actor::Worker, action, format!("{n}"));
            entry.append(tx, NOW.plus_s(n)).await.unwrap();
        }
    })
    .await;
    let reader = app.state.db.reader();
    let themes = r#"["school"]"#.to_owned();
    let search = AuditSearch { school, themes, words: String::new(), since: None, window: 30, limit: 50 };
    let (mut place, mut found, mut steps) = (Some(i64::MAX), Vec::new(), 0);
    while let Some(before) = place {
        let part = search_audit_log(reader, &search, before).await.unwrap();
        found.extend(part.acts.into_iter().map(|act| act.object));
        (place, steps) = (part.before, steps + 1);
    }
    assert_eq!((found, steps), (vec!["3".to_owned()], 4), "a hundred rows, thirty at a time");
    let recent = AuditSearch { since: Some(NOW.plus_s(90)), ..search };
    let part = search_audit_log(reader, &recent, i64::MAX).await.unwrap();
    assert_eq!((part.acts.len(), part.before), (0, None), "what is older is not looked for");
    let first: i64 = sqlx::query_scalar("SELECT min(seq) FROM audit_log").fetch_one(reader).await.unwrap();
    for n in [0, 1, 50, 99, 100] {
        assert_eq!(find_audit_place(reader, NOW.plus_s(n)).await.unwrap(), first + n, "second {n}");
    }
}
