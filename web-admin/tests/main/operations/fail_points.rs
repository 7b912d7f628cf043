//! The service, a backup and a restore are ended at every place where something is half done, with recordings in a folder and in a
//! bucket. Fails when an acknowledged attempt is lost,
//! is there twice, is scored twice or not at all, when a backup or a restore wants a hand, or when `verify` finds anything.

use std::collections::BTreeMap;
use std::io::Read;
use std::net::TcpStream;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::Output;
use std::time::Duration;

use model::SessionKey;
use platform::fail_points::{FailPoint, VARIABLE};
use store::Database;
use store::recordings::sessions;
use store::scoring::scores;

#[cfg(feature = "replicas")]
use crate::support::bucket::TestBucket;
use crate::support::database::{address_of, program};
use crate::support::recordings::{Attempt, record};
use crate::support::service::{Service, founded, header};

/// What kills which point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    Arriving,
    InPieces,
    Scoring,
    Backup,
    Restore,
    Moving,
}

const fn way(point: FailPoint) -> Way {
    use FailPoint as P;
    match point {
        P::ReadingBegun | P::RecordingRead | P::RecordingLinked | P::RecordingCommitting | P::RecordingCommitted => {
            Way::Arriving
        }
        P::UploadMade | P::PieceWritten | P::PieceSynced | P::PieceCounted | P::UploadMarked | P::UploadUnlinking => {
            Way::InPieces
        }
        P::JobBegun | P::JobJudged | P::ScoreAdded | P::ScoreCommitting | P::ScoreCommitted => Way::Scoring,
        P::BackupCopied | P::BackupWritten | P::BackupNamed => Way::Backup,
        P::RestoreUnpacked | P::RestoreMoving | P::RestoreMoved => Way::Restore,
        P::MoveCopied | P::MoveCarried | P::MoveKept => Way::Moving,
    }
}

fn points(wanted: Way) -> impl Iterator<Item = FailPoint> {
    FailPoint::ALL.iter().copied().filter(move |point| way(*point) == wanted)
}

/// What the environment of every program says.
type Surroundings = BTreeMap<String, String>;

/// Recordings lie in a folder.
const FOLDER: Surroundings = BTreeMap::new();

/// Recordings lie in a bucket that is new.
#[cfg(feature = "replicas")]
fn in_bucket() -> Surroundings {
    let bucket = TestBucket::new();
    let mut around = bucket.environment();
    around.insert("STYLET_RECORDINGS".to_owned(), bucket.url());
    around
}

/// Every kind of place that recordings lie in.
const PLACES: &[fn() -> Surroundings] = &[
    || FOLDER,
    #[cfg(feature = "replicas")]
    in_bucket,
];

/// Starts a service, which dies where it is told to.
fn serve(folder: &Path, around: &Surroundings, kill_at: Option<FailPoint>) -> Service {
    let around = around.iter().map(|(name, value)| (name.as_str(), Path::new(value)));
    let kill_at = kill_at.map(|point| (VARIABLE, Path::new(point.name())));
    Service::start_with(folder, &around.chain(kill_at).collect::<Vec<_>>())
}

fn web_admin(folder: &Path, around: &Surroundings, arguments: &[&str], kill_at: Option<FailPoint>) -> Output {
    let mut command = program(folder);
    command.args(arguments).envs(around);
    if let Some(point) = kill_at {
        command.env(VARIABLE, point.name());
    }
    command.output().unwrap()
}

fn killed(output: &Output) -> bool {
    output.status.signal() == Some(9)
}

/// Status and head of an answer; nothing where the service died before.
fn heard(mut stream: TcpStream) -> Option<(u16, String)> {
    let mut text = String::new();
    let _ = stream.read_to_string(&mut text);
    let (head, _) = text.split_once("\r\n\r\n")?;
    Some((head.split(' ').nth(1)?.parse().ok()?, head.to_lowercase()))
}

/// Sends a recording at once; whether it was acknowledged.
fn at_once(service: &Service, token: &str, bytes: &[u8]) -> bool {
    heard(service.upload(token, bytes, bytes.len())).is_some_and(|(status, _)| matches!(status, 200 | 201))
}

/// Sends a recording in two pieces, from where an upload has come to; the session that was acknowledged.
fn in_pieces(service: &Service, token: &str, bytes: &[u8], path: &mut Option<String>) -> Option<String> {
    let ask = |path: &str| {
        let ask = format!("HEAD {path} HTTP/1.1\r\nTus-Resumable: 1.0.0");
        heard(service.begin(&ask, token, &[])).filter(|(status, _)| *status == 200)
    };
    let known = path.clone().and_then(|path| Some((ask(&path)?.1, path)));
    let mut at = match known {
        Some((head, _)) if !header(&head, "stylet-session").is_empty() => {
            return Some(header(&head, "stylet-session").to_owned());
        }
        Some((head, _)) => header(&head, "upload-offset").parse().unwrap(),
        None => {
            let create =
                format!("POST /api/v1/uploads HTTP/1.1\r\nTus-Resumable: 1.0.0\r\nUpload-Length: {}", bytes.len());
            *path = Some(header(&heard(service.begin(&create, token, &[]))?.1, "location").to_owned());
            0
        }
    };
    let path = path.clone()?;
    loop {
        let end = if at < bytes.len() / 2 { bytes.len() / 2 } else { bytes.len() };
        let (status, head) = heard(service.piece(token, (&path, at), &bytes[at..end], end - at))?;
        assert_eq!(status, 204, "{head}");
        let session = header(&head, "stylet-session");
        if !session.is_empty() {
            return Some(session.to_owned());
        }
        at = end;
    }
}

fn exists(child: &mut std::process::Child) -> bool {
    child.try_wait().unwrap().is_none()
}

/// Waits for the service to be killed.
fn await_death(service: &mut Service, point: FailPoint) {
    for _ in 0..600 {
        if !exists(&mut service.child) {
            return;
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    panic!("{} was not reached", point.name());
}

/// Whether everything that was acknowledged is there once, scored once, and nothing else; and nothing is found wrong.
async fn check(folder: &Path, around: &Surroundings, expected: &[&Attempt], point: FailPoint) {
    let verified = web_admin(folder, around, &["verify"], None);
    assert!(verified.status.success(), "{}: {}", point.name(), String::from_utf8_lossy(&verified.stdout));
    let db = Database::open_existing(&address_of(folder)).await.unwrap();
    let mut found: Vec<_> = sessions::list_recordings(db.reader()).await.unwrap().iter().map(|file| file.id).collect();
    let mut wanted: Vec<_> = expected.iter().map(|attempt| attempt.session_id).collect();
    found.sort();
    wanted.sort();
    assert_eq!(found, wanted, "{}", point.name());
    let school_id = sqlx::query_scalar("SELECT id FROM schools").fetch_one(db.reader()).await.unwrap();
    for id in found {
        let scores = scores::list_scores(db.reader(), SessionKey { school_id, id }).await.unwrap();
        assert_eq!(scores.len(), 1, "{}", point.name());
    }
    db.close().await;
}

/// Waits until nothing is left to score.
fn settle(service: &Service, token: &str, attempts: &[&Attempt], point: FailPoint) {
    for attempt in attempts {
        let ask = format!("GET /api/v1/sessions/{}/score HTTP/1.1", attempt.session_id);
        let scored = (0..600).any(|_| {
            std::thread::sleep(Duration::from_millis(50));
            heard(service.begin(&ask, token, &[])).is_some_and(|(status, _)| status == 200)
        });
        assert!(scored, "{}: an attempt is not scored", point.name());
    }
}

/// A service is killed at each point of a way, with an attempt that came at once and one that came in pieces.
async fn kill_on(way: Way, surround: fn() -> Surroundings) {
    for point in points(way) {
        let around = &surround();
        let (folder, token) = founded().await;
        let attempts = [Attempt::default(), Attempt::default()];
        let [first, second] = attempts.each_ref().map(record);
        let mut service = serve(folder.path(), around, Some(point));
        let mut path = None;
        if at_once(&service, &token, &first) && exists(&mut service.child) && way != Way::Scoring {
            in_pieces(&service, &token, &second, &mut path);
        }
        await_death(&mut service, point);
        drop(service);
        let service = serve(folder.path(), around, None);
        assert!(at_once(&service, &token, &first), "{}", point.name());
        let session = in_pieces(&service, &token, &second, &mut path);
        assert_eq!(session, Some(attempts[1].session_id.to_string()), "{}", point.name());
        settle(&service, &token, &attempts.each_ref(), point);
        drop(service);
        check(folder.path(), around, &attempts.each_ref(), point).await;
    }
}

#[tokio::test]
async fn what_arrives_at_once_outlives_a_death_at_every_point() {
    kill_on(Way::Arriving, || FOLDER).await;
}

#[cfg(feature = "replicas")]
#[tokio::test]
async fn what_arrives_in_a_bucket_outlives_a_death_at_every_point() {
    for way in [Way::Arriving, Way::InPieces] {
        kill_on(way, in_bucket).await;
    }
}

#[tokio::test]
async fn what_arrives_in_pieces_outlives_a_death_at_every_point() {
    kill_on(Way::InPieces, || FOLDER).await;
}

#[tokio::test]
async fn what_is_scored_is_scored_once_whenever_the_service_dies() {
    kill_on(Way::Scoring, || FOLDER).await;
}

#[tokio::test]
async fn backups_and_restores_that_were_killed_are_done_over() {
    only_on!(Sqlite, "a backup holds a file of SQLite");
    let (folder, token) = founded().await;
    let attempts = [Attempt::default(), Attempt::default()];
    let service = Service::start(folder.path());
    assert!(attempts.iter().all(|attempt| at_once(&service, &token, &record(attempt))));
    settle(&service, &token, &attempts.each_ref(), FailPoint::BackupCopied);
    drop(service);
    let backup = folder.path().join("backup.tar");
    let to = backup.to_str().unwrap();
    for point in points(Way::Backup) {
        let _ = std::fs::remove_file(&backup);
        assert!(killed(&web_admin(folder.path(), &FOLDER, &["backup", "--to", to], Some(point))), "{}", point.name());
        if !backup.exists() {
            let again = web_admin(folder.path(), &FOLDER, &["backup", "--to", to], None);
            assert!(again.status.success(), "{}: {}", point.name(), String::from_utf8_lossy(&again.stderr));
        }
        let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        assert!(!left.iter().any(|name| name.to_string_lossy().starts_with("backup.tar.")), "{left:?}");
    }
    for (point, around) in points(Way::Restore).flat_map(|point| PLACES.iter().map(move |place| (point, place()))) {
        let place = tempfile::tempdir().unwrap();
        assert!(killed(&web_admin(place.path(), &around, &["restore", to], Some(point))), "{}", point.name());
        let served = web_admin(place.path(), &around, &["serve", "--listen", "127.0.0.1:0"], None);
        assert!(!served.status.success(), "{}: half a school is served", point.name());
        let again = web_admin(place.path(), &around, &["restore", to], None);
        assert!(again.status.success(), "{}: {}", point.name(), String::from_utf8_lossy(&again.stderr));
        drop(serve(place.path(), &around, None));
        check(place.path(), &around, &attempts.each_ref(), point).await;
    }
}
