//! A scanner for malware looks at what arrives before anything else does. Fails when what it finds is kept, when a recording is taken in of which it
//! has said nothing, when one is lost because it says nothing, and when what is sent to it is not what clamd's protocol asks for.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use acts::recordings::uploads;
use axum::body::Body;
use axum::http::Request;
use data_encoding::HEXLOWER;
use model::Role;
use platform::clock::Clock;
use platform::scanning::{ScanVerdict, Scanner};
use tempfile::TempDir;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{UnixListener, UnixStream};

use crate::support::App;
use crate::support::client::{Answer, Client};
use crate::support::recordings::{Attempt, record};

/// What every scanner calls malware, and harms nobody. Written backwards here, that none takes this file for it.
fn eicar() -> Vec<u8> {
    r"*H+H$!ELIF-TSET-SURIVITNA-DRADNATS-RACIE$}7)CC7)^P(45XZP\4[PA@%P!O5X".bytes().rev().collect()
}

/// What the stand-in does.
const HONEST: u8 = 0;
const SILENT: u8 = 1;
const SMALL: u8 = 2;
const GONE: u8 = 3;

/// A stand-in for clamd: it takes `zINSTREAM` alone, and answers as clamd does.
#[derive(Clone)]
struct StandIn {
    mood: Arc<AtomicU8>,
    seen: Arc<Mutex<Vec<Vec<u8>>>>,
    socket: PathBuf,
}

/// What the stand-in called SMALL takes, in bytes.
const LIMIT: usize = 10_000;

impl StandIn {
    fn start(folder: &Path) -> Self {
        let socket = folder.join("clamd");
        let (mood, seen) = (Arc::default(), Arc::default());
        let it = Self { mood, seen, socket };
        let (listener, running) = (UnixListener::bind(&it.socket).unwrap(), it.clone());
        tokio::spawn(async move {
            while let Ok((stream, _)) = listener.accept().await {
                let one = running.clone();
                tokio::spawn(async move { one.answer(stream).await });
            }
        });
        it
    }

    fn is(&self, mood: u8) {
        self.mood.store(mood, Ordering::SeqCst);
    }

    async fn answer(&self, mut stream: UnixStream) {
        let mood = self.mood.load(Ordering::SeqCst);
        let mut command = [0; 10];
        if mood == GONE || stream.read_exact(&mut command).await.is_err() {
            return;
        }
        if &command != b"zINSTREAM\0" {
            stream.write_all(b"UNKNOWN COMMAND\0").await.unwrap();
            return;
        }
        let mut whole = Vec::new();
        loop {
            let length = stream.read_u32().await.unwrap() as usize;
            if length == 0 {
                break;
            }
            let mut piece = vec![0; length];
            stream.read_exact(&mut piece).await.unwrap();
            whole.extend(piece);
            if mood == SMALL && whole.len() > LIMIT {
                stream.write_all(b"INSTREAM size limit exceeded. ERROR\0").await.unwrap();
                return;
            }
        }
        if mood == SILENT {
            tokio::time::sleep(Duration::from_secs(60)).await;
        }
        let found = whole == eicar();
        self.seen.lock().unwrap().push(whole);
        let answer: &[u8] = if found { b"stream: Eicar-Signature FOUND\0" } else { b"stream: OK\0" };
        stream.write_all(answer).await.unwrap();
    }
}

struct World {
    app: App,
    ada: Client,
    clamd: StandIn,
    _folder: TempDir,
}

impl World {
    async fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let clamd = StandIn::start(folder.path());
        let scanner = Scanner { socket: clamd.socket.clone(), time: Duration::from_secs(2) };
        let app = App::with(Clock::system(), |config| config.scanner = Some(scanner)).await;
        let school = app.school("North").await;
        let ada = app.with_token(&app.member(school, Role::Trainee, "ada@example.org").await.token);
        Self { app, ada, clamd, _folder: folder }
    }

    async fn listed(&mut self) -> usize {
        self.ada.get("/api/v1/sessions").await.json()["sessions"].as_array().unwrap().len()
    }

    async fn begin(&mut self, length: usize) -> String {
        let begin = Request::post("/api/v1/uploads").header("tus-resumable", "1.0.0").header("upload-length", length);
        let begun = self.ada.send(begin.body(Body::empty()).unwrap()).await;
        assert_eq!(begun.status, 201, "{}", begun.text());
        begun.header("location").to_owned()
    }

    async fn send(&mut self, path: &str, offset: usize, bytes: &[u8]) -> Answer {
        let piece = Request::patch(path).header("tus-resumable", "1.0.0").header("upload-offset", offset);
        let piece = piece.header("content-type", "application/offset+octet-stream");
        self.ada.send(piece.body(Body::from(bytes.to_vec())).unwrap()).await
    }
}

#[tokio::test]
async fn what_is_clean_is_taken_in_and_was_shown_whole() {
    let mut world = World::new().await;
    let bytes = record(&Attempt::default());
    assert!(bytes.len() > 100_000, "of several pieces");
    assert_eq!(world.ada.upload(&bytes).await.status, 201);
    assert_eq!(world.clamd.seen.lock().unwrap().as_slice(), &[bytes], "byte for byte");
}

#[tokio::test]
async fn what_is_found_is_named_and_kept_nowhere() {
    let mut world = World::new().await;
    let malware = eicar();
    assert_eq!(malware.len(), 68);
    world.ada.upload(&malware).await.is_problem(422, "found Eicar-Signature");
    let path = world.begin(malware.len()).await;
    world.send(&path, 0, &malware).await.is_problem(422, "found Eicar-Signature");
    assert_eq!(world.send(&path, 0, &malware).await.status, 404, "the upload is gone");
    assert_eq!(world.app.files(), Vec::<PathBuf>::new(), "nothing is kept");
    assert_eq!(world.listed().await, 0);
    let told: Vec<String> = sqlx::query_scalar("SELECT details FROM audit_log WHERE action = 'recording.infected'")
        .fetch_all(world.app.state.db.reader())
        .await
        .unwrap();
    assert_eq!(told.len(), 2);
    assert!(told[0].contains("Eicar-Signature"), "{told:?}");
}

#[tokio::test]
async fn silent_scanner_admits_no_upload_and_loses_none() {
    let mut world = World::new().await;
    let bytes = record(&Attempt::default());
    for mood in [GONE, SILENT, SMALL] {
        world.clamd.is(mood);
        let refused = world.ada.upload(&bytes).await;
        refused.is_problem(503, "scanner");
        assert_eq!(refused.header("retry-after"), "60", "{mood}");
    }
    let path = world.begin(bytes.len()).await;
    let refused = world.send(&path, 0, &bytes).await;
    refused.is_problem(503, "scanner");
    assert_eq!(refused.header("retry-after"), "60");
    assert_eq!(world.listed().await, 0);

    world.clamd.is(HONEST);
    let sent = world.send(&path, bytes.len(), &[]).await;
    assert_eq!(sent.status, 204, "{}", sent.text());
    assert!(!sent.header("stylet-session").is_empty(), "what was sent is still there");
    assert_eq!(world.listed().await, 1);
}

#[tokio::test]
async fn upload_waiting_for_the_scanner_is_accepted_without_a_request() {
    let mut world = World::new().await;
    let bytes = record(&Attempt::default());
    world.clamd.is(GONE);
    let path = world.begin(bytes.len()).await;
    assert_eq!(world.send(&path, 0, &bytes).await.status, 503);
    uploads::tidy(&world.app.state).await.unwrap();
    assert_eq!(world.listed().await, 0);
    world.clamd.is(HONEST);
    uploads::tidy(&world.app.state).await.unwrap();
    assert_eq!(world.listed().await, 1);
}

/// A real clamd with one signature, killed when dropped.
struct Clamd(Child);

impl Clamd {
    fn start(folder: &Path) -> Option<Self> {
        let signatures = folder.join("signatures");
        std::fs::create_dir(&signatures).unwrap();
        std::fs::write(signatures.join("own.ndb"), format!("Eicar-Own:0:0:{}\n", HEXLOWER.encode(&eicar()))).unwrap();
        let configuration = folder.join("clamd.conf");
        let (socket, at) = (folder.join("real"), signatures.display());
        let text =
            format!("Foreground yes\nLocalSocket {}\nDatabaseDirectory {at}\nStreamMaxLength 1M\n", socket.display());
        std::fs::write(&configuration, text).unwrap();
        let mut command = Command::new("clamd");
        command.arg("--config-file").arg(&configuration).stdout(Stdio::null()).stderr(Stdio::null());
        let clamd = Self(command.spawn().ok()?);
        (0..600)
            .any(|_| {
                socket.exists() || {
                    std::thread::sleep(Duration::from_millis(50));
                    false
                }
            })
            .then_some(clamd)
    }
}

impl Drop for Clamd {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[tokio::test]
async fn the_real_scanner_understands_it() {
    let folder = tempfile::tempdir().unwrap();
    let Some(_clamd) = Clamd::start(folder.path()) else {
        eprintln!("not tried: clamd is not installed; deploy/test installs it");
        return;
    };
    let scanner = Scanner { socket: folder.path().join("real"), time: Duration::from_secs(30) };
    let file = folder.path().join("file");
    let scan = async |bytes: &[u8]| {
        std::fs::write(&file, bytes).unwrap();
        scanner.scan(&file).await
    };
    let recording = record(&Attempt::default());
    assert_eq!(scan(&recording[..recording.len().min(900_000)]).await.unwrap(), ScanVerdict::Clean);
    assert_eq!(scan(b"").await.unwrap(), ScanVerdict::Clean);
    let ScanVerdict::Found(name) = scan(&eicar()).await.unwrap() else { panic!("it finds what it is for") };
    assert!(name.starts_with("Eicar-Own"), "{name}");
    let refused = scan(&vec![7; 5_000_000]).await.unwrap_err();
    assert!(format!("{refused:#}").contains("StreamMaxLength"), "{refused:#}");
}
