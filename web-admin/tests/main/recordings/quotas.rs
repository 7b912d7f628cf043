//! What recordings may take of a disk. Fails when one trainee can bring more than a share, when room is promised twice, or when a recording
//! carries what no document of its attempt names.

use acts::recordings::uploads;
use axum::body::Body;
use axum::http::Request;
use model::{Moment, Role};
use platform::clock::Clock;
use platform::config::UploadQuota;

use crate::support::App;
use crate::support::client::Client;
use crate::support::recordings::{Attempt, EXERCISE, record, with_attachment};

const NOON: Moment = Moment::from_micros(1_790_000_000_000_000);
const DAY_S: i64 = 24 * 3600;

async fn trainee(app: &App, name: &str) -> (Client, String) {
    let school = app.school(name).await;
    let member = app.member(school, Role::Trainee, &format!("{name}@example.org")).await;
    (app.with_token(&member.token), member.person.pseudonym)
}

fn begin(length: u64) -> Request<Body> {
    let head = Request::post("/api/v1/uploads").header("tus-resumable", "1.0.0").header("upload-length", length);
    head.body(Body::empty()).unwrap()
}

#[tokio::test]
async fn a_trainee_brings_so_many_attempts_a_day_by_any_door() {
    let app = App::with(Clock::fixed(NOON), |config| {
        config.person_quota = UploadQuota { uploads: 2, ..config.person_quota };
    });
    let app = app.await;
    let school = app.school("North").await;
    let ada = app.member(school, Role::Trainee, "ada@example.org").await;
    let (mut hers, mut station) = (app.with_token(&ada.token), app.with_token(&app.station(school).await));
    let named = || record(&Attempt { trainee: ada.person.pseudonym.clone(), ..Attempt::default() });
    let first = named();
    assert_eq!(hers.upload(&first).await.status, 201);
    assert_eq!(station.upload(&named()).await.status, 201);
    let third = named();
    station.upload(&third).await.is_problem(429, "2 are allowed");
    hers.upload(&third).await.is_problem(429, "2 are allowed");
    hers.send(begin(1000)).await.is_problem(429, "2 are allowed");
    assert_eq!(station.upload(&first).await.status, 200, "what is kept is acknowledged again");
    let later = App::in_folder(app.folder, Clock::fixed(NOON.plus_s(DAY_S + 1)), |config| {
        config.person_quota = UploadQuota { uploads: 2, ..config.person_quota };
    });
    let later = later.await;
    assert_eq!(later.with_token(&ada.token).upload(&third).await.status, 201, "the next day it is taken");
}

#[tokio::test]
async fn a_trainees_recordings_come_to_so_many_bytes() {
    let size = record(&Attempt::default()).len() as u64;
    let app = App::with(Clock::fixed(NOON), |config| {
        config.person_quota = UploadQuota { bytes: size * 3 / 2, ..config.person_quota };
    });
    let app = app.await;
    let (mut ada, _) = trainee(&app, "ada").await;
    assert_eq!(ada.upload(&record(&Attempt::default())).await.status, 201);
    ada.upload(&record(&Attempt::default())).await.is_problem(429, "this trainee's recordings have");
    let (mut ben, _) = trainee(&app, "ben").await;
    assert_eq!(ben.upload(&record(&Attempt::default())).await.status, 201, "another one has a share of their own");
}

#[tokio::test]
async fn room_is_promised_once() {
    let app = App::with(Clock::system(), |config| {
        let disk = rustix::fs::statvfs(std::env::temp_dir()).unwrap();
        let free = disk.f_bavail * disk.f_frsize;
        // Tests beside this one take room meanwhile: a tenth of the disk is left to them.
        (config.reserve_bytes, config.max_upload_bytes) = (free / 2, free);
        config.owner_quota = UploadQuota { uploads: 10, bytes: u64::MAX };
        config.school_quota = config.owner_quota;
        config.person_quota = config.owner_quota;
    });
    let app = app.await;
    let third = app.state.config.reserve_bytes * 6 / 10;
    let (mut ada, _) = trainee(&app, "ada").await;
    let (mut ben, _) = trainee(&app, "ben").await;
    let begun = ada.send(begin(third)).await;
    assert_eq!(begun.status, 201, "{}", begun.text());
    ben.send(begin(third)).await.is_problem(507, "");
    assert_eq!(ben.send(begin(1000)).await.status, 201, "there is room for a small one");
    let end = Request::delete(begun.header("location")).header("tus-resumable", "1.0.0").body(Body::empty()).unwrap();
    assert_eq!(ada.send(end).await.status, 204);
    assert_eq!(ben.send(begin(third)).await.status, 201, "who ends an upload gives its room back");
}

#[tokio::test]
async fn full_database_rejects_large_uploads_and_people_still_sign_in() {
    let app = App::with(Clock::system(), |config| config.database_reserve_bytes = u64::MAX).await;
    let (mut ada, _) = trainee(&app, "ada").await;
    ada.upload(&record(&Attempt::default())).await.is_problem(507, "");
    ada.send(begin(1000)).await.is_problem(507, "");
    assert_eq!(app.signed_in("ada@example.org").await.get("/").await.status, 200);
    assert!(app.files().is_empty(), "what was refused leaves nothing");
}

#[tokio::test]
async fn an_attachment_that_no_document_names_is_refused() {
    let app = App::new().await;
    let (mut ada, _) = trainee(&app, "ada").await;
    let refused =
        [("mesh/ballast.stl", 5000, "no document refers to it"), ("notes.txt", 1, "no document refers to it")];
    for (name, length, why) in refused {
        let answer = ada.upload(&with_attachment(&Attempt::default(), name, &vec![7; length])).await;
        answer.is_problem(422, why);
        answer.is_problem(422, name);
    }
    assert_eq!(EXERCISE.meshes, [], "the exercise that is attempted has no mesh");
    assert_eq!(ada.upload(&record(&Attempt::default())).await.status, 201);
}

#[tokio::test]
async fn an_upload_that_has_lost_its_bytes_takes_nobodys_share() {
    let app = App::with(Clock::fixed(NOON), |config| {
        config.owner_quota = UploadQuota { uploads: 1, ..config.owner_quota };
    });
    let app = app.await;
    let (mut ada, _) = trainee(&app, "ada").await;
    assert_eq!(ada.send(begin(1000)).await.status, 201);
    ada.send(begin(1000)).await.is_problem(429, "1 unfinished");
    let root = &app.state.config.recordings_dir;
    app.files().iter().for_each(|file| std::fs::remove_file(root.join(file)).unwrap());
    uploads::tidy(&app.state).await.unwrap();
    assert_eq!(ada.send(begin(1000)).await.status, 201);
}
