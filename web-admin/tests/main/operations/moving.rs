//! A school moves from SQLite and a folder to PostgreSQL and a bucket, and back. Fails when a row, a byte or the order of what has
//! arrived differs afterwards, when half a school is left anywhere, when a school is moved while somebody serves it, and when a move
//! goes over data.

use std::io::{BufRead, BufReader, Read};
use std::net::TcpStream;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use platform::fail_points::{FailPoint, VARIABLE};
use sqlx::{AssertSqlSafe, Connection, SqliteConnection};
use store::Database;
use tempfile::TempDir;

use crate::operations::crowd::crowded;
use crate::support::bucket::TestBucket;
use crate::support::database::{address_of, program, url_of};
use crate::support::recordings::{Attempt, record};
use crate::support::service::{Service, founded};
use crate::support::{App, web_admin};

/// A school on PostgreSQL, and places to move it to.
struct Removal {
    app: App,
    places: TempDir,
    bucket: TestBucket,
}

/// What a command has said, whichever way.
fn said(output: &Output) -> String {
    [String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr)].concat()
}

impl Removal {
    async fn new() -> Self {
        Self { app: crowded().await, places: tempfile::tempdir().unwrap(), bucket: TestBucket::new() }
    }

    fn folder(&self, name: &str) -> PathBuf {
        let folder = self.places.path().join(name);
        std::fs::create_dir_all(&folder).unwrap();
        folder
    }

    fn file(&self, name: &str) -> String {
        self.folder(name).join("stylet.db").to_str().unwrap().to_owned()
    }

    /// `web-admin move`, with these arguments and a bucket at hand.
    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_web-admin"));
        command.arg("move").args(arguments).envs(self.bucket.environment());
        command
    }

    /// From the school's own place to a file and a folder.
    fn to_file(&self, name: &str) -> Command {
        let (from, to) = (url_of(self.app.folder.path()), self.file(name));
        let (own, folder) = (self.app.folder.path().to_str().unwrap(), self.folder(name));
        self.command(&["--from", &from, "--from-data-dir", own, "--to", &to, "--to-data-dir", folder.to_str().unwrap()])
    }

    /// From a file and a folder to PostgreSQL and the bucket.
    fn to_server(&self, name: &str, server: &Path) -> Command {
        let (from, folder) = (self.file(name), self.folder(name));
        let (to, bucket) = (url_of(server), self.bucket.url());
        self.command(&[
            "--from",
            &from,
            "--from-data-dir",
            folder.to_str().unwrap(),
            "--to",
            &to,
            "--to-data-dir",
            server.to_str().unwrap(),
            "--to-recordings",
            &bucket,
        ])
    }
}

fn succeeds(command: &mut Command) -> String {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
    said(&output)
}

/// Everything that is in a file, table by table, and what the schema says: with the rows' own numbers where they count.
async fn dump(file: &str) -> Vec<String> {
    let mut connection = SqliteConnection::connect(&format!("sqlite://{file}")).await.unwrap();
    let tables: Vec<String> = sqlx::query_scalar(
        "SELECT name FROM sqlite_schema WHERE type = 'table' AND name <> '_sqlx_migrations' AND name NOT LIKE 'sqlite_%' ORDER BY name",
    )
    .fetch_all(&mut connection)
    .await
    .unwrap();
    let mut found: Vec<String> = sqlx::query_scalar("SELECT coalesce(sql, name) FROM sqlite_schema ORDER BY name")
        .fetch_all(&mut connection)
        .await
        .unwrap();
    for table in tables {
        let columns =
            format!("SELECT group_concat('quote(\"' || name || '\")', ' || ') FROM pragma_table_xinfo('{table}')");
        let columns: String = sqlx::query_scalar(AssertSqlSafe(columns)).fetch_one(&mut connection).await.unwrap();
        let order = if ARRIVING.contains(&&*table) { "rowid" } else { "1" };
        let rows = format!("SELECT '{table} ' || {columns} FROM \"{table}\" ORDER BY {order}");
        let rows: Vec<String> = sqlx::query_scalar(AssertSqlSafe(rows)).fetch_all(&mut connection).await.unwrap();
        found.extend(rows);
    }
    found
}

/// Tables whose rows are read in the order in which they have arrived.
const ARRIVING: [&str; 4] = ["scores", "sessions", "score_overrides", "exercise_revisions"];

#[tokio::test]
async fn a_school_that_went_and_came_back_is_what_it_was() {
    only_on!(Postgres, "about a server");
    let removal = Removal::new().await;
    let server = tempfile::tempdir().unwrap();
    let first = succeeds(&mut removal.to_file("first"));
    assert!(first.contains("moved postgres://") && !first.contains("secret"), "{first}");
    let second = succeeds(&mut removal.to_server("first", server.path()));
    assert!(
        second.contains("281 in ") && second.contains("of which 1 were copied to s3://"),
        "one file of all attempts: {second}"
    );
    assert!(second.contains(" all 281 were read and match the stored hash"), "{second}");
    let hashes = |said: &str| -> Vec<String> {
        said.lines().filter(|line| line.contains(" rows of hash ")).map(str::to_owned).collect()
    };
    assert!(hashes(&first).len() > 80);
    assert_eq!(hashes(&first), hashes(&second), "what was read there is what was written here");
    let (to, bucket) = (removal.file("second"), removal.bucket.url());
    let (url, folder) = (url_of(server.path()), removal.folder("second"));
    let third = succeeds(&mut removal.command(&[
        "--from",
        &url,
        "--from-data-dir",
        server.path().to_str().unwrap(),
        "--from-recordings",
        &bucket,
        "--to",
        &to,
        "--to-data-dir",
        folder.to_str().unwrap(),
    ]));
    assert_eq!(hashes(&first), hashes(&third));
    let (before, after) = (dump(&removal.file("first")).await, dump(&to).await);
    assert!(before.len() > 1000);
    assert_eq!(before, after);
    let recordings = |name: &str| {
        Command::new("find")
            .args([".", "-name", "*.mcap", "-exec", "sha256sum", "{}", ";"])
            .current_dir(removal.folder(name))
            .output()
            .unwrap()
            .stdout
    };
    assert!(!recordings("first").is_empty());
    assert_eq!(recordings("first"), recordings("second"));
}

#[tokio::test]
async fn what_was_moved_is_served_and_found_whole() {
    only_on!(Postgres, "about a server");
    let removal = Removal::new().await;
    let server = tempfile::tempdir().unwrap();
    succeeds(&mut removal.to_file("first"));
    succeeds(&mut removal.to_server("first", server.path()));
    let mut verify = program(server.path());
    verify.arg("verify").envs(removal.bucket.environment()).env("STYLET_RECORDINGS", removal.bucket.url());
    assert!(succeeds(&mut verify).contains(" 0 findings"));
    let bucket = &removal.bucket;
    let moved = App::in_folder(server, platform::clock::Clock::system(), |config| bucket.keep(config)).await;
    for path in ["/", "/people", "/progress", "/review", "/cohorts"] {
        let mut before = removal.app.signed_in("admin@north.example").await;
        let mut after = moved.signed_in("admin@north.example").await;
        let (before, after) = (before.get(path).await, after.get(path).await);
        assert_eq!((before.status.as_u16(), after.status.as_u16()), (200, 200), "{path}");
        assert_eq!(without_marks(&before.text()), without_marks(&after.text()), "{path}");
    }
    // Rows that come now are behind those that were carried.
    let school = moved.school("South").await;
    moved.publish(school).await;
}

/// A page without what is new for every visit.
fn without_marks(page: &str) -> String {
    page.lines().filter(|line| !line.contains("csrf")).collect()
}

#[tokio::test]
async fn killed_move_leaves_the_target_empty_and_can_be_repeated() {
    only_on!(Postgres, "about a server");
    let removal = Removal::new().await;
    let server = tempfile::tempdir().unwrap();
    succeeds(&mut removal.to_file("first"));
    for point in [FailPoint::MoveCopied, FailPoint::MoveCarried] {
        for mut command in [removal.to_file("second"), removal.to_server("first", server.path())] {
            let killed = command.env(VARIABLE, point.name()).output().unwrap();
            assert_eq!(killed.status.signal(), Some(9), "{}", said(&killed));
        }
        let db = Database::open(&address_of(server.path())).await.unwrap();
        let schools: i64 = sqlx::query_scalar("SELECT count(*) FROM schools").fetch_one(db.reader()).await.unwrap();
        assert_eq!(schools, 0, "{}", point.name());
        db.close().await;
        let file = removal.file("second");
        assert!(!dump(&file).await.iter().any(|row| row.starts_with("schools ")), "{}", point.name());
    }
    let again = succeeds(&mut removal.to_server("first", server.path()));
    assert!(again.contains("of which 0 were copied"), "what was copied before is there: {again}");
    let over = removal.to_server("first", server.path()).output().unwrap();
    assert_eq!(over.status.code(), Some(2));
    assert!(said(&over).contains("a move never overwrites data"), "{}", said(&over));
    let kept = removal.to_file("second").env(VARIABLE, FailPoint::MoveKept.name()).output().unwrap();
    assert!(!kept.status.success());
    assert_eq!(dump(&removal.file("first")).await, dump(&removal.file("second")).await);
}

#[tokio::test]
async fn a_damaged_recording_is_found_and_nothing_is_moved() {
    only_on!(Postgres, "about a server");
    let removal = Removal::new().await;
    let recording = removal.app.files().into_iter().find(|file| file.extension().is_some_and(|e| e == "mcap")).unwrap();
    let path = removal.app.state.config.recordings_dir.join(&recording);
    let mut bytes = std::fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&path, bytes).unwrap();
    let found = removal.to_file("first").output().unwrap();
    assert_eq!(found.status.code(), Some(1), "{}", said(&found));
    let words = said(&found);
    assert!(words.contains("the bytes do not match the stored hash") && words.contains("nothing was moved"), "{words}");
    assert!(!dump(&removal.file("first")).await.iter().any(|row| row.starts_with("schools ")));
}

#[tokio::test]
async fn move_drops_unfinished_uploads_and_names_an_invalid_value() {
    only_on!(Postgres, "about a server");
    let removal = Removal::new().await;
    let server = tempfile::tempdir().unwrap();
    succeeds(&mut removal.to_file("first"));
    let mut file = SqliteConnection::connect(&format!("sqlite://{}", removal.file("first"))).await.unwrap();
    let change = "INSERT INTO uploads (id, school_id, person_id, length, received, metadata, expires_at)
            SELECT randomblob(16), school_id, id, 10, 5, '', 4102444800000000 FROM people LIMIT 1;
        UPDATE people SET display_name = 'A' || char(0) || 'B' WHERE email = 'admin@north.example'";
    sqlx::raw_sql(change).execute(&mut file).await.unwrap();
    let refused = removal.to_server("first", server.path()).output().unwrap();
    let words = said(&refused);
    assert!(refused.status.code() == Some(1) && words.contains("people.display_name: a text with U+0000"), "{words}");
    let mended = "UPDATE people SET display_name = 'A' WHERE email = 'admin@north.example'";
    sqlx::raw_sql(mended).execute(&mut file).await.unwrap();
    file.close().await.unwrap();
    let moved = succeeds(&mut removal.to_server("first", server.path()));
    assert!(moved.contains("unfinished uploads, which the senders must restart: 1"), "{moved}");
    let db = Database::open(&address_of(server.path())).await.unwrap();
    let uploads: i64 = sqlx::query_scalar("SELECT count(*) FROM uploads").fetch_one(db.reader()).await.unwrap();
    assert_eq!(uploads, 0);
}

/// Whether an upload was acknowledged.
fn is_taken(mut stream: TcpStream) -> bool {
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer.starts_with("HTTP/1.1 201")
}

#[tokio::test]
async fn move_copies_while_served_and_finishes_when_service_stops() {
    only_on!(Postgres, "about a server");
    let (folder, token) = founded().await;
    let service = Service::start(folder.path());
    let bytes = record(&Attempt::default());
    assert!(is_taken(service.upload(&token, &bytes, bytes.len())));
    let place = tempfile::tempdir().unwrap();
    let mut moving = Command::new(env!("CARGO_BIN_EXE_web-admin"))
        .args(["move", "--from", &url_of(folder.path()), "--from-data-dir", folder.path().to_str().unwrap(), "--to"])
        .arg(place.path().join("stylet.db"))
        .arg("--to-data-dir")
        .arg(place.path())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(moving.stdout.take().unwrap()).lines().map(Result::unwrap);
    let waits = lines.find(|line| line.contains("the move waits")).unwrap();
    assert!(waits.contains("web-admin serve"), "{waits}");
    let late = record(&Attempt::default());
    assert!(is_taken(service.upload(&token, &late, late.len())));
    drop(service);
    let rest: Vec<String> = lines.collect();
    assert!(moving.wait().unwrap().success(), "{rest:?}");
    assert!(rest.iter().any(|line| line.starts_with("moved postgres://")), "{rest:?}");
    let mut file =
        SqliteConnection::connect(&format!("sqlite://{}", place.path().join("stylet.db").display())).await.unwrap();
    let kept: i64 = sqlx::query_scalar("SELECT count(*) FROM sessions").fetch_one(&mut file).await.unwrap();
    let files = std::fs::read_dir(place.path().join("recordings")).unwrap().count();
    assert_eq!((kept, files), (2, 1), "two attempts of one school");
}

#[tokio::test]
async fn wrong_ends_are_named() {
    only_on!(Postgres, "about a server");
    let folder = tempfile::tempdir().unwrap();
    let refused = |from: &str, to: &str| {
        let output = web_admin(folder.path(), &["move", "--from", from, "--to", to]);
        assert!(!output.status.success());
        let words = said(&output);
        assert!(!words.contains("secret"), "{words}");
        words
    };
    let server = url_of(folder.path());
    assert!(refused("a.db", "b.db").contains("allowed: one SQLite database"));
    assert!(refused(&server, "mysql://ada:secret@host/db").contains("mysql://ada@host/db"));
    assert!(refused("nowhere/stylet.db", &server).contains("nowhere/stylet.db: "));
    assert!(
        refused("postgres://ada:secret@127.0.0.1:1/x", folder.path().join("s.db").to_str().unwrap())
            .contains("127.0.0.1")
    );
    let other = folder.path().join("other.db");
    SqliteConnection::connect(&format!("sqlite://{}?mode=rwc", other.display())).await.unwrap().close().await.unwrap();
    assert!(refused(other.to_str().unwrap(), &server).contains("it contains no database of the service"));
}
