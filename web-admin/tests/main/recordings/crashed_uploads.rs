//! The service dies at the worst moment. Fails when an acknowledged upload is lost, when one that was not is listed, or when somebody is
//! written to twice.

use std::path::Path;
use std::time::Duration;

use model::Role;
use model::letters::mail::MailKind;
use store::letters::mails;
use store::letters::mails::NewMail;

use crate::support::mail::MailServer;
use crate::support::recordings::{Attempt, record};
use crate::support::service::{Service, answer, founded, header, whole_answer};
use crate::support::{App, web_admin};

/// Longest until a service that has started sends a letter.
const PATIENCE: Duration = Duration::from_secs(60);

fn parts(folder: &Path) -> usize {
    std::fs::read_dir(folder.join("recordings/.uploads")).unwrap().count()
}

#[tokio::test]
async fn killed_upload_keeps_exactly_the_acknowledged_recordings() {
    let (folder, token) = founded().await;
    let (kept, lost) = (Attempt::default(), Attempt::default());
    let (kept_bytes, lost_bytes) = (record(&kept), record(&lost));
    let service = Service::start(folder.path());
    let (status, body) = answer(service.upload(&token, &kept_bytes, kept_bytes.len()));
    assert_eq!(status, 201, "{body}");
    let half_way = service.upload(&token, &lost_bytes, lost_bytes.len() / 2);
    for _ in 0..200 {
        if parts(folder.path()) > 0 {
            break;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    assert_eq!(parts(folder.path()), 1, "the upload has begun");
    service.signal("-KILL");
    drop((half_way, service));

    let service = Service::start(folder.path());
    assert_eq!(service.listed(&token), [kept.session_id.to_string()]);
    assert_eq!(parts(folder.path()), 0, "what was left over is gone");
    let path = format!("GET /api/v1/sessions/{}/score HTTP/1.1", kept.session_id);
    let scored = (0..200).any(|_| {
        std::thread::sleep(Duration::from_millis(20));
        answer(service.begin(&path, &token, &[])).0 == 200
    });
    assert!(scored, "what waited to be scored is scored after the restart");
    assert_eq!(answer(service.upload(&token, &kept_bytes, kept_bytes.len())).0, 200);
    assert_eq!(answer(service.upload(&token, &lost_bytes, lost_bytes.len())).0, 201, "it can be sent again");
    drop(service);
    let verified = web_admin(folder.path(), &["verify"]);
    assert!(verified.status.success(), "{}", String::from_utf8_lossy(&verified.stdout));
}

#[tokio::test]
async fn killed_resumable_upload_continues_from_acknowledged_pieces() {
    let (folder, token) = founded().await;
    let attempt = Attempt::default();
    let bytes = record(&attempt);
    let (third, half) = (bytes.len() / 3, bytes.len() / 2);
    let service = Service::start(folder.path());
    let create = format!("POST /api/v1/uploads HTTP/1.1\r\nTus-Resumable: 1.0.0\r\nUpload-Length: {}", bytes.len());
    let (status, head, body) = whole_answer(service.begin(&create, &token, &[]));
    assert_eq!(status, 201, "{body}");
    let path = header(&head, "location").to_owned();
    assert_eq!(answer(service.piece(&token, (&path, 0), &bytes[..third], third)).0, 204);
    let on_its_way = service.piece(&token, (&path, third), &bytes[third..], half - third);
    let part = folder.path().join("recordings/.uploads").join(format!("{}.tus", path.rsplit('/').next().unwrap()));
    let written = (0..200).any(|_| {
        std::thread::sleep(Duration::from_millis(10));
        std::fs::metadata(&part).unwrap().len() > third as u64
    });
    assert!(written, "the second piece is being written");
    service.signal("-KILL");
    drop((on_its_way, service));

    let service = Service::start(folder.path());
    let ask = format!("HEAD {path} HTTP/1.1\r\nTus-Resumable: 1.0.0");
    let (status, head, _) = whole_answer(service.begin(&ask, &token, &[]));
    assert_eq!((status, header(&head, "upload-offset")), (200, third.to_string().as_str()), "what was acknowledged");
    assert!(service.listed(&token).is_empty());
    let rest = &bytes[third..];
    let (status, head, body) = whole_answer(service.piece(&token, (&path, third), rest, rest.len()));
    assert_eq!((status, header(&head, "stylet-session")), (204, attempt.session_id.to_string().as_str()), "{body}");
    service.signal("-KILL");
    drop(service);

    let service = Service::start(folder.path());
    assert_eq!(service.listed(&token), [attempt.session_id.to_string()]);
    let (_, head, _) = whole_answer(service.begin(&ask, &token, &[]));
    assert_eq!(header(&head, "stylet-session"), attempt.session_id.to_string(), "also after a restart");
    let recordings = folder.path().join("recordings");
    let school = std::fs::read_dir(&recordings).unwrap().map(|e| e.unwrap().path()).find(|p| !p.ends_with(".uploads"));
    let kept = std::fs::read(school.unwrap().join(format!("{}.mcap", attempt.session_id))).unwrap();
    assert!(kept == bytes, "the file is another");
}

#[tokio::test]
async fn told_to_stop_it_stops_at_once_and_well() {
    let folder = tempfile::tempdir().unwrap();
    let mut service = Service::start(&folder.path().join("new"));
    assert!(service.greeting.contains("web-admin user add"), "{}", service.greeting);
    service.signal("-TERM");
    assert!(service.child.wait().unwrap().success());
}

/// A school with a letter for each of two people, and the service that has handed the first one's over and waits for the answer.
async fn handing_over(server: &MailServer) -> (App, Service) {
    let app = App::new().await;
    let school = app.school("North").await;
    for email in ["ada@example.org", "bo@example.org"] {
        let person_id = app.member(school, Role::Trainee, email).await.person.id;
        let mail = NewMail { school_id: school, person_id, kind: MailKind::Reset, assignment_id: None };
        app.write(async |tx| mails::queue_mail(tx, mail, app.state.clock.now()).await.unwrap()).await;
    }
    let service = Service::start_with(app.folder.path(), &[("STYLET_MAIL", Path::new(&server.url))]);
    assert!(server.letters.recv_timeout(PATIENCE).unwrap().contains("ada@example.org"));
    (app, service)
}

#[tokio::test]
async fn killed_while_a_letter_goes_it_does_not_send_it_again() {
    let server = MailServer::start();
    let (app, service) = handing_over(&server).await;
    service.signal("-KILL");
    drop(service);
    for answer in ["250 taken", "250 taken"] {
        server.answers.send(answer).unwrap();
    }
    let _service = Service::start_with(app.folder.path(), &[("STYLET_MAIL", Path::new(&server.url))]);
    let next = server.letters.recv_timeout(PATIENCE).unwrap();
    assert!(next.contains("bo@example.org"), "it goes on with the next: {next}");
}

#[tokio::test]
async fn stopped_while_a_letter_goes_it_waits_for_the_answer() {
    let server = MailServer::start();
    let (app, mut service) = handing_over(&server).await;
    service.signal("-TERM");
    std::thread::sleep(Duration::from_millis(300));
    server.answers.send("250 taken").unwrap();
    assert!(service.child.wait().unwrap().success());
    let sent = "SELECT count(*) FROM mails WHERE sent_at IS NOT NULL";
    let sent: i64 = sqlx::query_scalar(sent).fetch_one(app.state.db.reader()).await.unwrap();
    assert_eq!(sent, 1, "it is known that it went, and none went after it");
}
