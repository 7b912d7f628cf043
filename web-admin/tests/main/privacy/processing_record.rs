//! The record of processing activities, in English and German. Fails when a table or an outgoing connection of the program is not in it, when
//! it names one that is gone, when the languages differ, or when the page of papers shows other settings than those in force.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use model::privacy::recipient::Recipient;

use crate::people::{post, school};
use crate::support::App;

const PAGES: [(&str, &str); 2] = [
    ("processing.md", include_str!("../../../../docs/adopt/processing.md")),
    ("verarbeitung.md", include_str!("../../../../docs/adopt/verarbeitung.md")),
];
/// Signs of a connection in a source, the sources that have them, and the recipient.
const CONNECTIONS: [(&str, &[&str], Recipient); 7] = [
    ("lettre::", &["platform/src/mailer.rs"], Recipient::MailServer),
    (
        "outgoing::{",
        &["acts/src/auth/federation/tokens.rs", "acts/src/auth/federation/documents.rs"],
        Recipient::IdentityProvider,
    ),
    (
        "outgoing::{",
        &[
            "acts/src/auth/lti/registration.rs",
            "acts/src/auth/lti/services.rs",
            "acts/src/auth/lti/members.rs",
            "acts/src/training/grade_delivery.rs",
        ],
        Recipient::LearningPlatform,
    ),
    ("outgoing::{", &["acts/src/training/learning_records/sending.rs"], Recipient::RecordStore),
    ("object_store::", &["platform/src/recording_store/bucket.rs"], Recipient::ObjectStore),
    ("opentelemetry_otlp", &["src/telemetry/collector.rs"], Recipient::Collector),
    ("UnixStream", &["platform/src/scanning.rs"], Recipient::VirusScanner),
];
/// Sources with a sign of a connection that send nothing to others.
const SILENT: [(&str, &str); 2] = [
    ("src/serving.rs", "accepts connections"),
    ("platform/src/helper/confinement.rs", "tests that the sandboxed process cannot connect"),
];

/// Returns the names in backticks of the last cell of each row of the first table.
fn listed_tables(page: &str) -> Vec<String> {
    let rows = page.lines().skip_while(|line| !line.starts_with("|---")).skip(1);
    let rows = rows.take_while(|line| line.starts_with('|'));
    let cells = rows.filter_map(|row| row.trim_end_matches('|').rsplit('|').next());
    cells.flat_map(|cell| cell.split('`').skip(1).step_by(2)).map(str::to_owned).collect()
}

#[tokio::test]
async fn the_record_has_every_table_once() {
    only_on!(Sqlite, "reads SQLite's catalogue: both schemas are one");
    let app = App::new().await;
    let names = "SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE 'sqlite%' AND name NOT LIKE '\\_%' ESCAPE '\\'";
    let stored: Vec<String> = sqlx::query_scalar(names).fetch_all(app.state.db.reader()).await.unwrap();
    let stored: BTreeSet<String> = stored.into_iter().collect();
    for (name, page) in PAGES {
        let listed = listed_tables(page);
        let once: BTreeSet<String> = listed.iter().cloned().collect();
        assert_eq!(once.len(), listed.len(), "docs/adopt/{name}: each table once");
        let (missing, gone): (Vec<_>, Vec<_>) =
            (stored.difference(&once).collect(), once.difference(&stored).collect());
        assert!(missing.is_empty() && gone.is_empty(), "docs/adopt/{name}: missing {missing:?}, gone {gone:?}");
    }
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() && !path.ends_with("tests") {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn the_record_has_every_outgoing_connection() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = Vec::new();
    sources(root, &mut found);
    let known: BTreeSet<&str> = CONNECTIONS.iter().flat_map(|(_, files, _)| files.iter().copied()).collect();
    let signs: BTreeSet<&str> = CONNECTIONS.iter().map(|(sign, _, _)| *sign).chain(["ureq::", "TcpStream"]).collect();
    for path in found {
        let text = std::fs::read_to_string(&path).unwrap();
        let place = path.strip_prefix(root).unwrap().to_str().unwrap();
        let is_known = known.contains(place)
            || SILENT.iter().any(|(silent, _)| *silent == place)
            || place == "platform/src/outgoing.rs";
        let sign = signs.iter().find(|sign| text.contains(**sign));
        assert!(is_known || sign.is_none(), "{place} connects ({sign:?}): add its recipient to docs/adopt");
    }
    for (sign, files, recipient) in CONNECTIONS {
        for file in files {
            assert!(std::fs::read_to_string(root.join(file)).unwrap().contains(sign), "{file} has no {sign}");
        }
        for ((name, page), word) in PAGES.iter().zip(recipient.words()) {
            let recipients = page.split("\n## ").nth(2).expect("the section of recipients");
            assert!(recipients.contains(word), "docs/adopt/{name}: {word}");
        }
    }
}

#[test]
fn the_record_is_the_same_in_both_languages() {
    let [english, german] = PAGES.map(|(_, page)| listed_tables(page));
    assert_eq!(english, german, "the same tables in the same activities");
    let [english, german] =
        PAGES.map(|(_, page)| page.lines().filter(|line| line.starts_with('|') || line.starts_with("- ")).count());
    assert_eq!(english, german, "as many rows and facts");
}

#[tokio::test]
async fn page_of_papers_shows_the_settings_in_force() {
    let (_app, _, mut head) = school().await;
    let papers = |page: String| {
        assert!(page.contains("id=\"settings\""), "{page}");
        page
    };
    let page = papers(head.get("/admin/papers").await.text());
    assert!(page.contains("nobody is erased automatically") && page.contains("not stated yet"), "{page}");
    assert_eq!(page.matches("Off</span>").count() - switches_off(&page), Recipient::ALL.len(), "{page}");
    let rule = [("months", "24"), ("warn_days", "30"), ("recordings", "yes")];
    assert_eq!(post(&mut head, "/admin/retention", "/admin/retention", &rule).await.status, 303);
    let store =
        [("endpoint", "https://records.example.org/xapi"), ("user_name", "u"), ("password", "p"), ("version", "2.0.0")];
    let path = "/admin/learning-records";
    assert_eq!(post(&mut head, path, path, &store).await.status, 303);
    let page = papers(head.get("/admin/papers").await.text());
    assert!(page.contains("after 24 months") && page.contains("records.example.org"), "{page}");
    assert_eq!(page.matches("Off</span>").count() - switches_off(&page), Recipient::ALL.len() - 1, "{page}");
    assert_eq!(post(&mut head, "/account", "/account/language", &[("language", "de")]).await.status, 303);
    let page = papers(head.get("/admin/papers").await.text());
    assert!(page.contains("Empfänger") && page.contains("verarbeitung.md") && !page.contains("Recipients"), "{page}");
}

/// Returns how often something is off among the settings of a school.
fn switches_off(page: &str) -> usize {
    page.split("id=\"section-1\"").next().map_or(0, |settings| settings.matches("Off</span>").count())
}
