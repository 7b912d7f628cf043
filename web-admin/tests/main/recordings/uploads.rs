//! An upload is acknowledged once it is kept, once only, and whatever is refused leaves nothing behind. Fails when a
//! second upload overwrites the first, when a refused one stays on the disk, or when a cut recording is turned away.

use axum::body::Body;
use axum::http::{Request, header};
use data_encoding::BASE64;
use futures::StreamExt;
use model::Role;
use model::ids::SessionId;
use sha2::{Digest, Sha256};
use store::scoring::jobs;

use crate::support::recordings::{Attempt, record};
use crate::support::{App, Member};

async fn trainee(app: &App) -> Member {
    let school = app.school("North").await;
    app.member(school, Role::Trainee, "ada@example.org").await
}

#[tokio::test]
async fn a_recording_is_kept_byte_for_byte() {
    let app = App::new().await;
    let mut ada = app.with_token(&trainee(&app).await.token);
    let (id, bytes) = (SessionId::random(), record(&Attempt { session_id: SessionId::nil(), ..Attempt::default() }));
    assert_ne!(id, SessionId::nil());
    let answer = ada.upload(&bytes).await;
    assert_eq!(answer.status, 201, "{}", answer.text());
    let session = answer.json();
    assert_eq!(session["session_id"], SessionId::nil().to_string());
    assert_eq!((&session["state"], &session["complete"]), (&"pending".into(), &true.into()));
    assert_eq!(session["unknown_exercise"], true, "this school has published nothing");
    let kept = ada.get(&format!("/api/v1/sessions/{}/recording", SessionId::nil())).await;
    assert_eq!(kept.body, bytes);
    assert_eq!(jobs::count_jobs(app.state.db.reader()).await.unwrap(), 1);
}

#[tokio::test]
async fn repeated_upload_is_acknowledged_and_different_bytes_rejected() {
    let app = App::new().await;
    let school = app.school("North").await;
    let ada = app.member(school, Role::Trainee, "ada@example.org").await;
    let bob = app.member(school, Role::Trainee, "bob@example.org").await;
    let attempt = Attempt::default();
    let (first, other) = (record(&attempt), record(&Attempt { depth_mm: 12.0, ..attempt.clone() }));
    let mut client = app.with_token(&ada.token);
    assert_eq!(client.upload(&first).await.status, 201);
    let again = client.upload(&first).await;
    assert_eq!(again.status, 200);
    assert_eq!(again.json()["session_id"], attempt.session_id.to_string());
    client.upload(&other).await.is_problem(409, "different bytes");
    app.with_token(&bob.token).upload(&first).await.is_problem(409, "another trainee");
    let kept = client.get(&format!("/api/v1/sessions/{}/recording", attempt.session_id)).await;
    assert_eq!(kept.body, first, "the first one stands");
    assert_eq!(app.files().len(), 1, "nothing else stays: {:?}", app.files());
    assert_eq!(jobs::count_jobs(app.state.db.reader()).await.unwrap(), 1, "it is scored once");
}

#[tokio::test]
async fn of_two_at_once_under_one_id_one_wins_whole() {
    let app = App::new().await;
    let token = trainee(&app).await.token;
    let attempt = Attempt::default();
    let (a, b) = (record(&attempt), record(&Attempt { depth_mm: 12.0, ..attempt.clone() }));
    let (mut one, mut two) = (app.with_token(&token), app.with_token(&token));
    let (first, second) = tokio::join!(one.upload(&a), two.upload(&b));
    let mut statuses = [first.status.as_u16(), second.status.as_u16()];
    statuses.sort_unstable();
    assert_eq!(statuses, [201, 409]);
    let winner = if first.status == 201 { a } else { b };
    let kept = one.get(&format!("/api/v1/sessions/{}/recording", attempt.session_id)).await;
    assert_eq!(kept.body, winner);
}

#[tokio::test]
async fn one_school_neither_sees_nor_blocks_an_id_of_another() {
    let app = App::new().await;
    let bytes = record(&Attempt::default());
    for name in ["North", "South"] {
        let school = app.school(name).await;
        let member = app.member(school, Role::Trainee, &format!("ada@{name}.example")).await;
        assert_eq!(app.with_token(&member.token).upload(&bytes).await.status, 201, "{name}");
    }
}

#[tokio::test]
async fn too_large_a_body_is_refused_announced_or_not() {
    let app = App::with(platform::clock::Clock::system(), |config| config.max_upload_bytes = 1000).await;
    let mut ada = app.with_token(&trainee(&app).await.token);
    let announced = Request::post("/api/v1/sessions")
        .header(header::CONTENT_TYPE, "application/octet-stream")
        .header(header::CONTENT_LENGTH, "1001")
        .body(Body::from(vec![0; 1001]))
        .unwrap();
    ada.send(announced).await.is_problem(413, "1000 bytes");
    let pieces = futures::stream::iter((0..20).map(|_| Ok::<_, std::io::Error>(vec![0_u8; 100])));
    let unannounced = Request::post("/api/v1/sessions")
        .header(header::CONTENT_TYPE, "application/octet-stream")
        .body(Body::from_stream(pieces))
        .unwrap();
    ada.send(unannounced).await.is_problem(413, "1000 bytes");
    assert!(app.files().is_empty(), "{:?}", app.files());
}

#[tokio::test]
async fn what_is_no_recording_is_refused_with_the_reason() {
    let app = App::new().await;
    let mut ada = app.with_token(&trainee(&app).await.token);
    ada.upload(b"").await.is_problem(422, "");
    ada.upload(b"not a recording").await.is_problem(422, "not a recording");
    let whole = record(&Attempt::default());
    ada.upload(&whole[..100]).await.is_problem(422, "");
    let typed =
        Request::post("/api/v1/sessions").header(header::CONTENT_TYPE, "text/plain").body(Body::from(whole)).unwrap();
    ada.send(typed).await.is_problem(415, "application/octet-stream");
    assert!(app.files().is_empty(), "{:?}", app.files());
}

#[tokio::test]
async fn a_body_that_breaks_off_or_falls_silent_leaves_nothing() {
    let silence = std::time::Duration::from_millis(50);
    let app = App::with(platform::clock::Clock::system(), |config| config.upload_silence = silence).await;
    let mut ada = app.with_token(&trainee(&app).await.token);
    let start = vec![Ok(record(&Attempt::default())[..1000].to_vec())];
    let broken = start.into_iter().chain([Err(std::io::Error::other("gone"))]);
    let request = |body| {
        Request::post("/api/v1/sessions").header(header::CONTENT_TYPE, "application/octet-stream").body(body).unwrap()
    };
    ada.send(request(Body::from_stream(futures::stream::iter(broken)))).await.is_problem(400, "is incomplete");
    let silent = futures::stream::pending::<Result<Vec<u8>, std::io::Error>>();
    ada.send(request(Body::from_stream(silent))).await.is_problem(408, "was interrupted");
    assert!(app.files().is_empty(), "{:?}", app.files());
}

#[tokio::test]
async fn half_a_body_is_waited_for_nowhere() {
    let silence = std::time::Duration::from_millis(20);
    let app = App::with(platform::clock::Clock::system(), |config| config.upload_silence = silence).await;
    let half = futures::stream::iter([Ok::<_, std::io::Error>("{\"code\":")]).chain(futures::stream::pending());
    let body = Body::from_stream(half);
    let request = Request::post("/api/v1/stations/pair").header(header::CONTENT_TYPE, "application/json").body(body);
    let answer = app.stranger().send(request.unwrap()).await;
    assert!(answer.status.is_client_error(), "{}", answer.status);
}

#[tokio::test]
async fn a_station_uploads_for_whoever_the_recording_names() {
    let app = App::new().await;
    let ada = trainee(&app).await;
    let mut station = app.with_token(&app.station(ada.person.school_id).await);
    let attempt = Attempt { trainee: ada.person.pseudonym.clone(), ..Attempt::default() };
    let answer = station.upload(&record(&attempt)).await;
    assert_eq!(answer.status, 201, "{}", answer.text());
    assert_eq!(answer.json()["trainee_id"], ada.person.id.to_string());
    let unknown = Attempt { trainee: "p-nobody".to_owned(), ..Attempt::default() };
    station.upload(&record(&unknown)).await.is_problem(422, "p-nobody");
    station.get(&format!("/api/v1/sessions/{}", attempt.session_id)).await.is_problem(403, "station");
}

#[tokio::test]
async fn body_that_contradicts_its_digest_is_rejected_and_removed() {
    let app = App::new().await;
    let mut ada = app.with_token(&trainee(&app).await.token);
    let bytes = record(&Attempt::default());
    let digest = format!("sha-256=:{}:", BASE64.encode(&Sha256::digest(&bytes)));
    let send = |digest: &str, body: &[u8]| {
        let request = Request::post("/api/v1/sessions").header(header::CONTENT_TYPE, "application/octet-stream");
        request.header("content-digest", digest).body(Body::from(body.to_vec())).unwrap()
    };
    for at in [0, bytes.len() / 2, bytes.len() - 1] {
        let mut flipped = bytes.clone();
        flipped[at] ^= 4;
        ada.send(send(&digest, &flipped)).await.is_problem(422, "Content-Digest");
    }
    for nonsense in ["sha-256=AAAA", "sha-256=:AAAA:", "sha-512=:AAAA:, sha-256=::"] {
        ada.send(send(nonsense, &bytes)).await.is_problem(400, "Content-Digest");
    }
    assert_eq!(app.files().len(), 0, "{:?}", app.files());
    assert_eq!(ada.send(send(&format!("sha-512=:AAAA:, {digest}"), &bytes)).await.status, 201);
}
