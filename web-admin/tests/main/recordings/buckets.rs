//! Recordings in a bucket of a real store that speaks S3. Fails when something acknowledged is not there whole, when something is
//! half acknowledged, when an upload does not go on at another service, when a file stays on this machine, or when a store that does
//! not answer costs a recording; when services on one database do not know whom another has erased, or what it has stated.

use std::process::Output;
use std::time::Duration;

use acts::audit::audit_checkpoints;
use acts::audit::checkpoint_store::StatementStore;
use acts::operations::verification;
use acts::privacy::erasing;
use acts::privacy::erasing::Eraser;
use acts::privacy::erasure_store::ErasureStore;
use acts::privacy::erasures::{ERASURES_FILE, Erasure, ErasureList, ErasureScope};
use acts::recordings::uploads;
use acts::replicas;
use axum::body::Body;
use axum::http::{Method, Request};
use model::Role;
use model::people::directory::AccountState;
use platform::clock::Clock;
use store::audit::Actor;
use store::people::directory;
use store::recordings::parse_attempts;
use web_admin::worker;

use crate::support::bucket::{Refusal, TestBucket};
use crate::support::client::{Answer, Client};
use crate::support::database::{copy_database, program};
use crate::support::recordings::{Attempt, record};
use crate::support::{App, Member};

/// A service with a trainee, who can be scored.
async fn begun(bucket: &TestBucket) -> (App, Member) {
    let app = bucket.app().await;
    let north = app.school("North").await;
    app.publish(north).await;
    let ada = app.member(north, Role::Trainee, "ada@example.org").await;
    (app, ada)
}

async fn findings(app: &App) -> Vec<String> {
    verification::everything(&app.state.db, &app.state.recordings).await.unwrap().findings
}

async fn download(client: &mut Client, attempt: &Attempt) -> Answer {
    client.get(&format!("/api/v1/sessions/{}/recording", attempt.session_id)).await
}

async fn ask_range(client: &mut Client, path: &str, range: &str) -> Answer {
    client.send(Request::get(path).header("range", range).body(Body::empty()).unwrap()).await
}

fn tus(method: &str, path: &str) -> axum::http::request::Builder {
    Request::builder().method(method).uri(path).header("tus-resumable", "1.0.0")
}

async fn begin(client: &mut Client, length: usize) -> String {
    let request = tus("POST", "/api/v1/uploads").header("upload-length", length).body(Body::empty()).unwrap();
    let answer = client.send(request).await;
    assert_eq!(answer.status, 201, "{}", answer.text());
    answer.header("location").to_owned()
}

async fn send(client: &mut Client, path: &str, offset: usize, bytes: &[u8]) -> Answer {
    let request =
        tus("PATCH", path).header("upload-offset", offset).header("content-type", "application/offset+octet-stream");
    client.send(request.body(Body::from(bytes.to_vec())).unwrap()).await
}

async fn head(client: &mut Client, path: &str) -> Answer {
    client.send(tus("HEAD", path).body(Body::empty()).unwrap()).await
}

/// Sends pieces of a third each from where an upload has come to, until somebody refuses; the session that was acknowledged.
async fn go_on(client: &mut Client, path: &str, bytes: &[u8]) -> Option<String> {
    let standing = head(client, path).await;
    assert_eq!(standing.status, 200, "{}", standing.text());
    let mut at: usize = standing.header("upload-offset").parse().unwrap();
    let mut session = standing.header("stylet-session").to_owned();
    while session.is_empty() {
        let end = (at + bytes.len() / 3 + 1).min(bytes.len());
        let answer = send(client, path, at, &bytes[at..end]).await;
        if answer.status != 204 {
            answer.is_problem(503, "the recording store is unavailable");
            return None;
        }
        at = end;
        session = answer.header("stylet-session").to_owned();
    }
    Some(session)
}

#[tokio::test]
async fn attempt_in_a_bucket_leaves_no_file_on_this_machine() {
    let bucket = TestBucket::new();
    let (app, ada) = begun(&bucket).await;
    let mut ada = app.with_token(&ada.token);
    let attempt = Attempt::default();
    let bytes = record(&attempt);
    assert_eq!(ada.upload(&bytes).await.status, 201);
    assert_eq!(ada.upload(&bytes).await.status, 200, "the same again is the same");
    worker::work_off_jobs(&app.state).await.unwrap();
    let api = format!("/api/v1/sessions/{}", attempt.session_id);
    assert_eq!(ada.get(&format!("{api}/score")).await.status, 200);
    assert_eq!(bucket.names().len(), 4, "a recording and three files of its replay: {:?}", bucket.names());
    assert_eq!(download(&mut ada, &attempt).await.body, bytes);
    let path = format!("{api}/recording");
    let middle = ask_range(&mut ada, &path, "bytes=100-199").await;
    assert_eq!((middle.status.as_u16(), middle.body.as_slice()), (206, &bytes[100..200]));
    assert_eq!(middle.header("content-range"), format!("bytes 100-199/{}", bytes.len()));
    assert_eq!(ask_range(&mut ada, &path, "bytes=-8").await.body, bytes[bytes.len() - 8..]);
    assert_eq!(ask_range(&mut ada, &path, &format!("bytes={}-", bytes.len())).await.status, 416);
    let told = ada.request(Method::HEAD, &path).await;
    assert_eq!((told.status.as_u16(), told.header("content-length")), (200, bytes.len().to_string().as_str()));
    assert_eq!(ada.get(&format!("{path}?with=comments")).await.status, 200);
    let replay = |name: &str| format!("{api}/{name}");
    let frames = ada.get(&replay("replay/frames")).await;
    assert_eq!(ask_range(&mut ada, &replay("replay/frames"), "bytes=4-7").await.body, frames.body[4..8]);
    // What was made of a recording may go at any time, and another service makes it, too.
    bucket.names().iter().filter(|name| name.starts_with("replays/")).for_each(|name| bucket.delete(name));
    let other = bucket.replica(&app).await;
    let mut elsewhere = other.with_token(ada.token.as_ref().unwrap());
    assert_eq!(elsewhere.get(&replay("replay/frames")).await.body, frames.body);
    assert_eq!(elsewhere.get(&replay("series")).await.status, 200);
    assert_eq!(bucket.names().len(), 4, "{:?}", bucket.names());
    for app in [&app, &other] {
        assert_eq!(app.files(), Vec::<std::path::PathBuf>::new());
        assert_eq!(std::fs::read_dir(app.state.config.replays_dir()).unwrap().count(), 0);
    }
}

#[tokio::test]
async fn a_large_recording_is_sent_in_parts_and_arrives_byte_for_byte() {
    let bucket = TestBucket::new();
    let app = bucket.app().await;
    let file = app.folder.path().join("large");
    let bytes: Vec<u8> = (0..40_000_000_u32).map(|n| (n ^ (n >> 9)) as u8).collect();
    std::fs::write(&file, &bytes).unwrap();
    let platform::recording_store::RecordingStore::Bucket(kept) = &app.state.recordings else { panic!("a bucket") };
    let (sha256, _) = platform::files::hash_file(&file).unwrap();
    kept.keep_recording(&file, "a/b.mcap", &sha256).await.unwrap();
    let copy = app.state.recordings.fetch("a/b.mcap").await.unwrap();
    assert!(std::fs::read(copy.path()).unwrap() == bytes);
    assert!(kept.keep_recording(&file, "a/c.mcap", "another hash").await.is_err(), "what is there is read back");
}

#[tokio::test]
async fn an_upload_goes_on_at_another_service_and_becomes_one_attempt() {
    let bucket = TestBucket::new();
    let (app, ada) = begun(&bucket).await;
    let mut here = app.with_token(&ada.token);
    let attempt = Attempt::default();
    let bytes = record(&attempt);
    let half = bytes.len() / 2;
    let path = begin(&mut here, bytes.len()).await;
    assert_eq!(send(&mut here, &path, 0, &bytes[..half]).await.status, 204);
    let other = bucket.replica(&app).await;
    let mut there = other.with_token(&ada.token);
    assert_eq!(head(&mut there, &path).await.header("upload-offset"), half.to_string());
    assert_eq!(send(&mut there, &path, half, &bytes[half..half + 100]).await.status, 204);
    send(&mut here, &path, half, &bytes[half..]).await.is_problem(409, "this upload has");
    let last = send(&mut here, &path, half + 100, &bytes[half + 100..]).await;
    assert_eq!(last.header("stylet-session"), attempt.session_id.to_string(), "{}", last.text());
    assert_eq!(download(&mut there, &attempt).await.body, bytes);
    assert!(bucket.names().iter().all(|name| name.starts_with("recordings/")), "{:?}", bucket.names());
    assert_eq!(findings(&app).await, Vec::<String>::new());
}

#[tokio::test]
async fn what_two_services_write_at_once_is_counted_once() {
    let bucket = TestBucket::new();
    let (app, ada) = begun(&bucket).await;
    let other = bucket.replica(&app).await;
    let (mut here, mut there) = (app.with_token(&ada.token), other.with_token(&ada.token));
    let attempt = Attempt::default();
    let bytes = record(&attempt);
    let path = begin(&mut here, bytes.len()).await;
    let most = bytes.len() - 1;
    let (one, two) =
        tokio::join!(send(&mut here, &path, 0, &bytes[..most]), send(&mut there, &path, 0, &bytes[..1000]));
    let mut told = [one.status.as_u16(), two.status.as_u16()];
    told.sort_unstable();
    assert_eq!(told, [204, 409], "{} {}", one.text(), two.text());
    assert_eq!(go_on(&mut here, &path, &bytes).await, Some(attempt.session_id.to_string()));
    assert_eq!(download(&mut here, &attempt).await.body, bytes);
}

#[tokio::test]
async fn last_piece_waits_while_another_service_reads_the_upload() {
    let bucket = TestBucket::new();
    let (app, ada) = begun(&bucket).await;
    let other = bucket.replica(&app).await;
    let (mut here, attempt) = (app.with_token(&ada.token), Attempt::default());
    let bytes = record(&attempt);
    let path = begin(&mut here, bytes.len()).await;
    let id = path.rsplit('/').next().unwrap().parse().unwrap();
    other.write(async |tx| assert!(parse_attempts::hold_upload(tx, id, other.state.replica).await.unwrap())).await;
    let buried = async {
        tokio::time::sleep(Duration::from_millis(500)).await;
        // It has died over it.
        replicas::mark_others_dead(&app.state).await.unwrap();
    };
    let (sent, ()) = tokio::join!(send(&mut here, &path, 0, &bytes), buried);
    assert_eq!(sent.header("stylet-session"), attempt.session_id.to_string(), "{} {}", sent.status, sent.text());
}

#[tokio::test]
async fn what_was_ended_or_is_no_recording_leaves_no_piece() {
    let bucket = TestBucket::new();
    let (app, ada) = begun(&bucket).await;
    let mut ada = app.with_token(&ada.token);
    let path = begin(&mut ada, 10).await;
    assert_eq!(send(&mut ada, &path, 0, b"abc").await.status, 204);
    assert_eq!(bucket.names().len(), 1);
    assert_eq!(ada.send(tus("DELETE", &path).body(Body::empty()).unwrap()).await.status, 204);
    assert_eq!(head(&mut ada, &path).await.status, 404);
    let path = begin(&mut ada, 9).await;
    send(&mut ada, &path, 0, b"not a rec").await.is_problem(422, "not a recording");
    assert_eq!(bucket.names(), Vec::<String>::new());
    bucket.put("uploads/00000000-0000-0000-0000-000000000000/x", b"a piece whose upload is gone");
    uploads::tidy(&app.state).await.unwrap();
    assert_eq!(bucket.names(), Vec::<String>::new());
}

/// Has the store fail at each of its requests in turn: nothing acknowledged is lost, and nothing else is acknowledged.
async fn fail_everywhere(how: Refusal) {
    let bucket = TestBucket::new();
    let (app, ada) = begun(&bucket).await;
    let mut ada = app.with_token(&ada.token);
    for nth in 1.. {
        let (at_once, in_pieces) = (Attempt::default(), Attempt::default());
        let (first, second) = (record(&at_once), record(&in_pieces));
        let path = begin(&mut ada, second.len()).await;
        bucket.refuse(how, nth);
        let answer = ada.upload(&first).await;
        if answer.status != 201 {
            answer.is_problem(503, "the recording store is unavailable");
            assert_eq!(answer.header("retry-after"), "10");
        }
        let acknowledged = go_on(&mut ada, &path, &second).await;
        let asked = bucket.mend();
        if answer.status == 201 {
            assert_eq!(download(&mut ada, &at_once).await.body, first, "{how:?} {nth}");
        }
        assert!(matches!(ada.upload(&first).await.status.as_u16(), 200 | 201), "{how:?} {nth}");
        let session = Some(in_pieces.session_id.to_string());
        assert!(acknowledged.is_none() || acknowledged == session, "{how:?} {nth}");
        assert_eq!(go_on(&mut ada, &path, &second).await, session, "{how:?} {nth}");
        assert_eq!(download(&mut ada, &in_pieces).await.body, second, "{how:?} {nth}");
        assert_eq!(findings(&app).await, Vec::<String>::new(), "{how:?} {nth}");
        if asked < nth {
            break;
        }
    }
    assert_eq!(app.files(), Vec::<std::path::PathBuf>::new());
}

#[tokio::test]
async fn bucket_that_ignores_requests_loses_no_acknowledged_upload() {
    fail_everywhere(Refusal::Lost).await;
}

#[tokio::test]
async fn bucket_that_answers_wrongly_loses_no_acknowledged_upload() {
    fail_everywhere(Refusal::Unheard).await;
}

#[tokio::test]
async fn a_full_store_is_said_and_a_silent_one_costs_no_score() {
    let bucket = TestBucket::new();
    let (app, ada) = begun(&bucket).await;
    let mut ada = app.with_token(&ada.token);
    let attempt = Attempt::default();
    let bytes = record(&attempt);
    bucket.refuse(Refusal::Full, 1);
    ada.upload(&bytes).await.is_problem(507, "disk space");
    bucket.mend();
    assert_eq!(ada.upload(&bytes).await.status, 201);
    bucket.refuse(Refusal::Lost, 1);
    download(&mut ada, &attempt).await.is_problem(503, "the recording store is unavailable");
    // More often than a job may fail.
    for minute in 0..10 {
        let later = app.state.at(app.state.clock.now().plus_s(60 * minute));
        worker::work_off_jobs(&later).await.unwrap();
    }
    bucket.mend();
    let score = format!("/api/v1/sessions/{}/score", attempt.session_id);
    worker::work_off_jobs(&app.state.at(app.state.clock.now().plus_s(3600))).await.unwrap();
    assert_eq!(ada.get(&score).await.status, 200);
}

#[tokio::test]
async fn what_is_missing_damaged_or_unknown_in_a_bucket_is_found() {
    let bucket = TestBucket::new();
    let (app, ada) = begun(&bucket).await;
    let mut ada = app.with_token(&ada.token);
    for _ in 0..2 {
        assert_eq!(ada.upload(&record(&Attempt::default())).await.status, 201);
    }
    assert_eq!(findings(&app).await, Vec::<String>::new());
    let names = bucket.names();
    let stray = names[0].replace(".mcap", "0.mcap");
    bucket.put(&names[0], b"other bytes");
    bucket.delete(&names[1]);
    bucket.put(&stray, b"a stray");
    let found = findings(&app).await.join("\n");
    for (word, name) in [("11 bytes;", &names[0]), ("no such object", &names[1]), ("no attempt refers to", &stray)] {
        let name = name.strip_prefix("recordings/").unwrap();
        assert!(found.lines().any(|line| line.contains(word) && line.contains(name)), "{word}: {found}");
    }
}

#[tokio::test]
async fn erased_recordings_are_deleted_after_the_bucket_returns() {
    let bucket = TestBucket::new();
    let (app, ada) = begun(&bucket).await;
    let attempt = Attempt::default();
    let mut client = app.with_token(&ada.token);
    assert_eq!(client.upload(&record(&attempt)).await.status, 201);
    worker::work_off_jobs(&app.state).await.unwrap();
    assert_eq!(bucket.names().len(), 4);
    // It answers whether it is there, and takes a line of the list.
    bucket.refuse(Refusal::Lost, 3);
    let wish = ErasureScope { recordings: true, ..ErasureScope::default() };
    assert!(erase(&app, &ada, wish).await.is_err(), "what is left is said");
    assert!(is_erased(&app, &ada).await);
    assert!(erasing::remove_left(&app.state).await.is_err());
    bucket.mend();
    erasing::remove_left(&app.state).await.unwrap();
    assert!(bucket.names().iter().all(|name| name.starts_with("erasures/")), "{:?}", bucket.names());
    assert_eq!(findings(&app).await, Vec::<String>::new());
}

async fn erase(app: &App, who: &Member, wish: ErasureScope) -> Result<(), acts::Error> {
    let school = who.person.school_id;
    let entry = directory::find_anybody(app.state.db.reader(), school, who.person.id).await.unwrap().unwrap();
    erasing::erase(&app.state, Eraser { actor: Actor::CommandLine, why: None }, &entry, school, wish).await
}

async fn is_erased(app: &App, who: &Member) -> bool {
    let found = directory::find_anybody(app.state.db.reader(), who.person.school_id, who.person.id).await;
    found.unwrap().unwrap().state == AccountState::Erased
}

async fn list(app: &App) -> Vec<Erasure> {
    ErasureStore::of(&app.state.config, &app.state.recordings).read().await.unwrap()
}

#[tokio::test]
async fn another_service_repeats_erasures_on_an_older_database() {
    let bucket = TestBucket::new();
    let (app, ada) = begun(&bucket).await;
    let before = tempfile::tempdir().unwrap();
    app.state.db.close().await;
    copy_database(app.folder.path(), before.path());
    let app = App::in_folder(app.folder, Clock::system(), |config| bucket.keep(config)).await;
    erase(&app, &ada, ErasureScope::default()).await.unwrap();
    assert!(!app.folder.path().join(ERASURES_FILE).exists(), "no colleague would see that");
    let restored = App::in_folder(before, Clock::system(), |config| bucket.keep(config)).await;
    assert!(!is_erased(&restored, &ada).await);
    let store = ErasureStore::of(&restored.state.config, &restored.state.recordings);
    assert_eq!(verification::unerased(&restored.state.db, &store).await.unwrap().len(), 1);
    assert_eq!(erasing::catch_up(&restored.state).await.unwrap(), 1);
    assert!(is_erased(&restored, &ada).await);
    assert_eq!(erasing::catch_up(&restored.state).await.unwrap(), 0);
    bucket.put("erasures/0.json", b"Ana Ek, 3 March");
    let refused = format!("{:#}", erasing::catch_up(&restored.state).await.unwrap_err());
    assert!(refused.contains("erasures/0.json: not an erasure"), "{refused}");
}

#[tokio::test]
async fn bucket_that_fails_keeps_the_list_equal_to_the_erased_people() {
    let bucket = TestBucket::new();
    let (app, _) = begun(&bucket).await;
    let school = app.school("South").await;
    let mut erased = 0;
    for how in [Refusal::Lost, Refusal::Unheard] {
        for nth in 1..5 {
            let who = app.member(school, Role::Trainee, &format!("{how:?}{nth}@example.org")).await;
            bucket.refuse(how, nth);
            let done = erase(&app, &who, ErasureScope::default()).await;
            bucket.mend();
            erased += usize::from(done.is_ok());
            assert_eq!(is_erased(&app, &who).await, done.is_ok(), "{how:?} {nth}");
            assert_eq!(list(&app).await.len(), erased, "{how:?} {nth}");
        }
    }
    assert!((1..8).contains(&erased), "{erased}");
}

#[tokio::test]
async fn erasures_and_statements_move_from_the_folder_to_the_bucket() {
    let bucket = TestBucket::new();
    let (app, ada) = begun(&bucket).await;
    let (config, folder) = (&app.state.config, app.folder.path());
    let erasure = Erasure {
        at: app.state.clock.now(),
        school_id: ada.person.school_id,
        person_id: ada.person.id,
        pseudonym: "p-1".to_owned(),
        wish: ErasureScope::default(),
    };
    ErasureList::of(config).add(&erasure).unwrap();
    std::fs::create_dir(folder.join("statements")).unwrap();
    std::fs::write(folder.join("statements/2026-11-20.json"), b"stated").unwrap();
    let statements = StatementStore::of(config, &app.state.recordings);
    for _ in 0..2 {
        ErasureStore::of(config, &app.state.recordings).carry_over(config).await.unwrap();
        statements.carry_over(config).await.unwrap();
        assert_eq!(list(&app).await, std::slice::from_ref(&erasure));
        assert_eq!(bucket.names().len(), 2, "{:?}", bucket.names());
    }
    assert_eq!(statements.read("2026-11-20.json").await.unwrap(), Some(b"stated".to_vec()));
}

#[tokio::test]
async fn services_sharing_keys_sign_alike_and_write_one_checkpoint() {
    let bucket = TestBucket::new();
    let (app, _) = begun(&bucket).await;
    let keys = app.folder.path().to_owned();
    let database = app.state.config.database.clone();
    let other = App::in_folder(tempfile::tempdir().unwrap(), Clock::system(), |config| {
        bucket.keep(config);
        (config.database, config.keys_dir) = (database, keys);
    })
    .await;
    let place = audit_checkpoints::anchor(&app.state).await.unwrap().unwrap();
    assert_eq!(audit_checkpoints::anchor(&other.state).await.unwrap(), None, "it is stated");
    let name = place.rsplit('/').next().unwrap();
    let statement = StatementStore::of(&other.state.config, &other.state.recordings).read(name).await.unwrap().unwrap();
    let published = "/.well-known/stylet-certificate-key";
    let key = other.stranger().get(published).await.text();
    assert_eq!(app.stranger().get(published).await.text(), key);
    audit_checkpoints::check(&statement, key.trim()).unwrap();
    let stranger = bucket.replica(&app).await;
    let key = stranger.stranger().get(published).await.text();
    assert!(audit_checkpoints::check(&statement, key.trim()).is_err(), "of keys of its own");
}

/// Runs the program on a data folder, with recordings in a bucket where one is named.
fn web_admin(folder: &std::path::Path, bucket: Option<&TestBucket>, arguments: &[&str]) -> Output {
    let mut command = program(folder);
    command.args(arguments);
    if let Some(bucket) = bucket {
        command.envs(bucket.environment()).env("STYLET_RECORDINGS", bucket.url());
    }
    command.output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

#[tokio::test]
async fn a_backup_moves_a_school_from_a_folder_into_a_bucket_and_back() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let app = App::new().await;
    let north = app.school("North").await;
    let mut ada = app.with_token(&app.member(north, Role::Trainee, "ada@example.org").await.token);
    assert_eq!(ada.upload(&record(&Attempt::default())).await.status, 201);
    app.state.db.close().await;
    let bucket = TestBucket::new();
    let places = [(tempfile::tempdir().unwrap(), Some(&bucket)), (tempfile::tempdir().unwrap(), None)];
    let mut from = (&app.folder, None);
    for (place, bucket) in &places {
        let backup = place.path().with_extension("tar");
        let backup = backup.to_str().unwrap();
        let made = web_admin(from.0.path(), from.1, &["backup", "--to", backup]);
        assert!(made.status.success(), "{}", said(&made));
        let restored = web_admin(place.path(), *bucket, &["restore", backup]);
        std::fs::remove_file(backup).unwrap();
        assert!(restored.status.success(), "{}", said(&restored));
        let verified = web_admin(place.path(), *bucket, &["verify"]);
        assert!(said(&verified).contains("1 recordings") && verified.status.success(), "{}", said(&verified));
        from = (place, *bucket);
    }
    let place = tempfile::tempdir().unwrap();
    let served = web_admin(place.path(), Some(&bucket), &["serve", "--listen", "127.0.0.1:0"]);
    assert!(!served.status.success() && said(&served).contains("contains recordings"), "{}", said(&served));
}

#[test]
fn a_bucket_that_is_not_there_is_said_before_anybody_is_served() {
    let bucket = TestBucket::new();
    let place = tempfile::tempdir().unwrap();
    let serve =
        |url: &str| web_admin(place.path(), Some(&bucket), &["serve", "--listen", "127.0.0.1:0", "--recordings", url]);
    let missing = serve("s3://nobody-has-this");
    assert_eq!(missing.status.code(), Some(1), "{}", said(&missing));
    assert!(said(&missing).contains("s3://nobody-has-this"), "{}", said(&missing));
    let wrong = serve("s3://a b");
    assert_eq!(wrong.status.code(), Some(2), "{}", said(&wrong));
    assert!(said(&wrong).contains("--recordings"), "{}", said(&wrong));
}
