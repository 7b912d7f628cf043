//! Uploads in pieces. Fails when a byte that was acknowledged is lost, when one that was not is counted, when an upload
//! becomes two attempts or none, or when the protocol's words are not tus 1.0.0's.

use acts::recordings::uploads;
use axum::body::Body;
use axum::http::request::Builder;
use axum::http::{Method, Request};
use data_encoding::BASE64;
use model::{Moment, Role};
use platform::clock::Clock;
use platform::config::UploadQuota;
use sha1::Sha1;
use sha2::{Digest, Sha256};
use store::recordings::uploads as rows;
use store::scoring::jobs;

use crate::support::App;
use crate::support::client::{Answer, Client};
use crate::support::recordings::{Attempt, record};

const UPLOADS: &str = "/api/v1/uploads";

async fn trainee(app: &App) -> Client {
    let school = app.school("North").await;
    app.with_token(&app.member(school, Role::Trainee, "ada@example.org").await.token)
}

fn tus(method: &str, path: &str) -> Builder {
    Request::builder().method(method).uri(path).header("tus-resumable", "1.0.0")
}

async fn begin(client: &mut Client, length: usize) -> String {
    let answer = client.send(tus("POST", UPLOADS).header("upload-length", length).body(Body::empty()).unwrap()).await;
    assert_eq!(answer.status, 201, "{}", answer.text());
    answer.header("location").to_owned()
}

fn patch(path: &str, offset: usize) -> Builder {
    tus("PATCH", path).header("upload-offset", offset).header("content-type", "application/offset+octet-stream")
}

async fn send(client: &mut Client, path: &str, offset: usize, bytes: &[u8]) -> Answer {
    client.send(patch(path, offset).body(Body::from(bytes.to_vec())).unwrap()).await
}

async fn head(client: &mut Client, path: &str) -> Answer {
    client.send(tus("HEAD", path).body(Body::empty()).unwrap()).await
}

async fn offset(client: &mut Client, path: &str) -> usize {
    let answer = head(client, path).await;
    assert_eq!(answer.status, 200);
    answer.header("upload-offset").parse().unwrap()
}

/// A body that breaks off after `bytes`.
fn broken(bytes: &[u8]) -> Body {
    let arrived = bytes.chunks(1000).map(|chunk| Ok(chunk.to_vec())).collect::<Vec<_>>();
    Body::from_stream(futures::stream::iter(arrived.into_iter().chain([Err(std::io::Error::other("cut"))])))
}

async fn listed(client: &mut Client) -> usize {
    client.get("/api/v1/sessions").await.json()["sessions"].as_array().unwrap().len()
}

#[tokio::test]
async fn a_recording_in_two_pieces_becomes_one_attempt() {
    let app = App::new().await;
    let mut ada = trainee(&app).await;
    let attempt = Attempt::default();
    let bytes = record(&attempt);
    let metadata = format!("filename {},empty", BASE64.encode(b"attempt.mcap"));
    let request = tus("POST", UPLOADS).header("upload-length", bytes.len()).header("upload-metadata", &metadata);
    let begun = ada.send(request.body(Body::empty()).unwrap()).await;
    assert_eq!((begun.status.as_u16(), begun.header("tus-resumable")), (201, "1.0.0"));
    assert!(begun.header("upload-expires").ends_with(" GMT"), "{}", begun.header("upload-expires"));
    let path = begun.header("location").to_owned();

    let half = bytes.len() / 2;
    let first = send(&mut ada, &path, 0, &bytes[..half]).await;
    assert_eq!((first.status.as_u16(), first.header("upload-offset")), (204, half.to_string().as_str()));
    assert_eq!(first.header("stylet-session"), "", "half a recording is no attempt");
    let standing = head(&mut ada, &path).await;
    assert_eq!(standing.header("upload-offset"), half.to_string());
    assert_eq!(standing.header("upload-length"), bytes.len().to_string());
    assert_eq!(standing.header("upload-metadata"), metadata);
    assert_eq!(standing.header("cache-control"), "no-store");
    assert_eq!(listed(&mut ada).await, 0);

    let last = send(&mut ada, &path, half, &bytes[half..]).await;
    assert_eq!(last.status, 204, "{}", last.text());
    let session = attempt.session_id.to_string();
    assert_eq!(last.header("stylet-session"), session);
    assert_eq!(head(&mut ada, &path).await.header("stylet-session"), session, "who missed the answer asks again");
    let again = send(&mut ada, &path, bytes.len(), &[]).await;
    assert_eq!((again.status.as_u16(), again.header("stylet-session")), (204, session.as_str()));
    assert_eq!(listed(&mut ada).await, 1);
    assert_eq!(ada.get(&format!("/api/v1/sessions/{session}/recording")).await.body, bytes);
    assert_eq!(jobs::count_jobs(app.state.db.reader()).await.unwrap(), 1, "it is scored once");
    assert_eq!(app.files().len(), 1, "nothing stays behind: {:?}", app.files());
}

#[tokio::test]
async fn upload_cut_at_twenty_offsets_arrives_once_and_unchanged() {
    let app = App::new().await;
    let mut ada = trainee(&app).await;
    let attempt = Attempt::default();
    let bytes = record(&attempt);
    let path = begin(&mut ada, bytes.len()).await;
    // A generator of Numerical Recipes; the seed is of no importance.
    let mut word = 12_345_u32;
    for _ in 0..20 {
        let at = offset(&mut ada, &path).await;
        word = word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let more = (word >> 8) as usize % ((bytes.len() - at) / 8);
        let cut = ada.send(patch(&path, at).body(broken(&bytes[at..at + more])).unwrap()).await;
        cut.is_problem(400, "is incomplete");
        assert_eq!(offset(&mut ada, &path).await, at + more, "what arrived is kept");
    }
    let at = offset(&mut ada, &path).await;
    assert_eq!(send(&mut ada, &path, at, &bytes[at..]).await.status, 204);
    assert_eq!(listed(&mut ada).await, 1);
    let kept = ada.get(&format!("/api/v1/sessions/{}/recording", attempt.session_id)).await;
    assert_eq!(kept.body, bytes);
}

#[tokio::test]
async fn a_piece_that_is_not_what_its_checksum_says_has_not_arrived() {
    let app = App::new().await;
    let mut ada = trainee(&app).await;
    let bytes = record(&Attempt::default());
    let path = begin(&mut ada, bytes.len()).await;
    let sha256 = format!("sha256 {}", BASE64.encode(&Sha256::digest(&bytes[..1000])));
    let with = |sum: &str, body| patch(&path, 0).header("upload-checksum", sum).body(body).unwrap();
    let wrong = ada.send(with(&sha256, Body::from(bytes[..999].to_vec()))).await;
    wrong.is_problem(460, "Upload-Checksum");
    assert_eq!((wrong.json()["title"].as_str(), offset(&mut ada, &path).await), (Some("Checksum Mismatch"), 0));
    ada.send(with(&sha256, broken(&bytes[..500]))).await.is_problem(400, "is incomplete");
    assert_eq!(offset(&mut ada, &path).await, 0, "half a piece cannot be checked");
    for nonsense in ["md5 AAAA", "sha256", "sha256 !", "sha256 AAAA", ""] {
        ada.send(with(nonsense, Body::empty())).await.is_problem(400, "sha256 or sha1");
    }
    assert_eq!(ada.send(with(&sha256, Body::from(bytes[..1000].to_vec()))).await.status, 204);
    let sha1 = format!("sha1 {}", BASE64.encode(&Sha1::digest(&bytes[1000..])));
    let last = patch(&path, 1000).header("upload-checksum", sha1).body(Body::from(bytes[1000..].to_vec())).unwrap();
    assert_eq!(ada.send(last).await.status, 204);
    assert_eq!(listed(&mut ada).await, 1);
}

#[tokio::test]
async fn an_upload_may_begin_with_its_first_piece() {
    let app = App::new().await;
    let mut ada = trainee(&app).await;
    let attempt = Attempt::default();
    let bytes = record(&attempt);
    let request = tus("POST", UPLOADS)
        .header("upload-length", bytes.len())
        .header("content-type", "application/offset+octet-stream")
        .body(Body::from(bytes.clone()))
        .unwrap();
    let answer = ada.send(request).await;
    assert_eq!((answer.status.as_u16(), answer.header("upload-offset")), (201, bytes.len().to_string().as_str()));
    assert_eq!(answer.header("stylet-session"), attempt.session_id.to_string());
}

#[tokio::test]
async fn the_service_says_what_it_speaks() {
    let app = App::new().await;
    let answer = app.stranger().request(Method::OPTIONS, UPLOADS).await;
    assert_eq!(answer.status, 204);
    for (name, value) in [
        ("tus-resumable", "1.0.0"),
        ("tus-version", "1.0.0"),
        ("tus-extension", "creation,creation-with-upload,checksum,expiration,termination"),
        ("tus-max-size", "536870912"),
        ("tus-checksum-algorithm", "sha256,sha1"),
    ] {
        assert_eq!(answer.header(name), value, "{name}");
    }
    for (method, path) in [("POST", UPLOADS), ("PATCH", "/api/v1/uploads/x"), ("DELETE", "/api/v1/uploads/x")] {
        let answer = app.stranger().send(tus(method, path).body(Body::empty()).unwrap()).await;
        answer.is_problem(401, "token");
        assert_eq!(answer.header("tus-resumable"), "1.0.0", "{method}");
    }
    let mut ada = trainee(&app).await;
    for version in ["0.2.2", "1.0", "2.0.0"] {
        let request = Request::post(UPLOADS).header("tus-resumable", version).header("upload-length", 1);
        let answer = ada.send(request.body(Body::empty()).unwrap()).await;
        answer.is_problem(412, "1.0.0");
        assert_eq!(answer.header("tus-version"), "1.0.0");
    }
    let unversioned = Request::post(UPLOADS).header("upload-length", 1).body(Body::empty()).unwrap();
    assert_eq!(ada.send(unversioned).await.status, 412);
}

#[tokio::test]
async fn wrong_words_are_refused_with_what_is_allowed() {
    let app = App::with(Clock::system(), |config| config.max_upload_bytes = 1000).await;
    let mut ada = trainee(&app).await;
    let create =
        |name: &'static str, value: &'static str| tus("POST", UPLOADS).header(name, value).body(Body::empty()).unwrap();
    for length in ["", "-1", "+1", "many", "1e3", "99999999999999999999"] {
        ada.send(create("upload-length", length)).await.is_problem(400, "upload-length");
    }
    ada.send(create("upload-defer-length", "1")).await.is_problem(400, "upload-length");
    ada.send(create("upload-length", "0")).await.is_problem(422, "a recording was expected");
    ada.send(create("upload-length", "1001")).await.is_problem(413, "1000 bytes");
    for metadata in ["name !", "name YQ==,name YQ==", ","] {
        let request = tus("POST", UPLOADS).header("upload-length", 9).header("upload-metadata", metadata);
        ada.send(request.body(Body::empty()).unwrap()).await.is_problem(400, "base64");
    }
    let long = format!("name {}", "QUFB".repeat(1024));
    let request = tus("POST", UPLOADS).header("upload-length", 9).header("upload-metadata", long);
    ada.send(request.body(Body::empty()).unwrap()).await.is_problem(400, "at most 4096");
    let request = tus("POST", UPLOADS).header("upload-length", 9).header("upload-concat", "partial");
    ada.send(request.body(Body::empty()).unwrap()).await.is_problem(400, "upload-concat");
    let path = begin(&mut ada, 9).await;
    let typed = tus("PATCH", &path).header("upload-offset", 0).header("content-type", "application/octet-stream");
    ada.send(typed.body(Body::from("a")).unwrap()).await.is_problem(415, "offset+octet-stream");
    send(&mut ada, &path, 1, b"a").await.is_problem(409, "has 0 bytes");
    send(&mut ada, &path, 0, &[0; 10]).await.is_problem(413, "9 bytes");
    let announced = patch(&path, 0).header("content-length", 10).body(Body::from(vec![0; 10])).unwrap();
    ada.send(announced).await.is_problem(413, "9 bytes");
    let unplaced = tus("PATCH", &path).header("content-type", "application/offset+octet-stream");
    ada.send(unplaced.body(Body::from("a")).unwrap()).await.is_problem(400, "upload-offset");
    assert_eq!(offset(&mut ada, &path).await, 0, "nothing of it was counted");
    for path in ["/api/v1/uploads/x", "/api/v1/uploads/00000000-0000-0000-0000-000000000000"] {
        send(&mut ada, path, 0, b"a").await.is_problem(404, "nothing was found");
    }
}

#[tokio::test]
async fn nobody_else_sees_or_feeds_an_upload() {
    let app = App::new().await;
    let (north, south) = (app.school("North").await, app.school("South").await);
    let mut ada = trainee(&app).await;
    let bob = app.member(north, Role::Administrator, "bob@example.org").await.token;
    let eve = app.member(south, Role::Trainee, "eve@example.org").await.token;
    let path = begin(&mut ada, 10).await;
    for token in [bob, eve, app.station(north).await] {
        let mut other = app.with_token(&token);
        assert_eq!(head(&mut other, &path).await.status, 404);
        send(&mut other, &path, 0, b"x").await.is_problem(404, "nothing was found");
        other.send(tus("DELETE", &path).body(Body::empty()).unwrap()).await.is_problem(404, "nothing was found");
    }
    assert_eq!(offset(&mut ada, &path).await, 0);
}

/// A body that goes on for as long as its sender is there.
type Feed = futures::channel::mpsc::UnboundedSender<Result<Vec<u8>, std::io::Error>>;

/// Somebody who has begun to write to an upload and has sent three bytes, which are written.
async fn writing(app: &App, client: &Client, path: &str) -> (Feed, tokio::task::JoinHandle<Answer>) {
    let (feed, fed) = futures::channel::mpsc::unbounded::<Result<Vec<u8>, std::io::Error>>();
    let (mut client, slow) = (client.clone(), patch(path, 0).body(Body::from_stream(fed)).unwrap());
    let writing = tokio::spawn(async move { client.send(slow).await });
    feed.unbounded_send(Ok(b"abc".to_vec())).unwrap();
    let id = path.rsplit('/').next().unwrap();
    let file = app.state.config.uploads_dir().join(format!("{id}.tus"));
    while std::fs::metadata(&file).unwrap().len() < 3 {
        tokio::time::sleep(std::time::Duration::from_millis(5)).await;
    }
    (feed, writing)
}

#[tokio::test]
async fn new_connection_takes_over_a_silent_one_and_keeps_its_bytes() {
    let app = App::new().await;
    let mut ada = trainee(&app).await;
    for ask_first in [true, false] {
        let path = begin(&mut ada, 10).await;
        let (_silent, first) = writing(&app, &ada, &path).await;
        if ask_first {
            assert_eq!(offset(&mut ada, &path).await, 3, "what has arrived is kept");
        }
        // Who does not ask does not know that three bytes have arrived.
        let at = if ask_first { 3 } else { 0 };
        let went_on = tokio::time::timeout(std::time::Duration::from_secs(10), send(&mut ada, &path, at, b"defg"));
        let went_on = went_on.await.expect("nobody waits for a silence to end");
        assert_eq!(went_on.status, if ask_first { 204 } else { 409 }, "{}", went_on.text());
        first.await.unwrap().is_problem(409, "taken over this upload");
        assert_eq!(offset(&mut ada, &path).await, if ask_first { 7 } else { 3 });
    }
    let path = begin(&mut ada, 10).await;
    let (_silent, first) = writing(&app, &ada, &path).await;
    assert_eq!(ada.send(tus("DELETE", &path).body(Body::empty()).unwrap()).await.status, 204);
    first.await.unwrap().is_problem(409, "taken over this upload");
    assert_eq!(head(&mut ada, &path).await.status, 404);
}

#[tokio::test]
async fn a_stranger_takes_nothing_over() {
    let app = App::new().await;
    let mut ada = trainee(&app).await;
    let path = begin(&mut ada, 10).await;
    let (feed, first) = writing(&app, &ada, &path).await;
    let bob = app.member(app.school("North").await, Role::Trainee, "bob@example.org").await.token;
    let mut bob = app.with_token(&bob);
    assert_eq!(head(&mut bob, &path).await.status, 404);
    send(&mut bob, &path, 3, b"x").await.is_problem(404, "nothing was found");
    drop(feed);
    assert_eq!(first.await.unwrap().header("upload-offset"), "3");
}

#[tokio::test]
async fn who_is_taken_in_gives_way_to_nobody() {
    let app = App::new().await;
    let mut ada = trainee(&app).await;
    let path = begin(&mut ada, 10).await;
    let turn = app.state.turns.take(path.rsplit('/').next().unwrap().parse().unwrap()).unwrap();
    send(&mut ada, &path, 0, b"x").await.is_problem(423, "another request");
    assert_eq!(offset(&mut ada, &path).await, 0, "how far it has come can be asked");
    drop(turn);
    assert_eq!(send(&mut ada, &path, 0, b"x").await.status, 204);
}

#[tokio::test]
async fn invalid_recording_is_rejected_when_whole_and_leaves_no_file() {
    let app = App::new().await;
    let mut ada = trainee(&app).await;
    let path = begin(&mut ada, 9).await;
    send(&mut ada, &path, 0, b"not a rec").await.is_problem(422, "not a recording");
    assert_eq!(head(&mut ada, &path).await.status, 404);
    assert!(app.files().is_empty(), "{:?}", app.files());
}

#[tokio::test]
async fn recording_sent_both_ways_is_one_attempt_and_a_clash_rejected() {
    let app = App::new().await;
    let mut ada = trainee(&app).await;
    let attempt = Attempt::default();
    let (bytes, other) = (record(&attempt), record(&Attempt { depth_mm: 12.0, ..attempt.clone() }));
    assert_eq!(ada.upload(&bytes).await.status, 201);
    let path = begin(&mut ada, bytes.len()).await;
    let again = send(&mut ada, &path, 0, &bytes).await;
    assert_eq!((again.status.as_u16(), again.header("stylet-session")), (204, attempt.session_id.to_string().as_str()));
    let path = begin(&mut ada, other.len()).await;
    send(&mut ada, &path, 0, &other).await.is_problem(409, "different bytes");
    assert_eq!((listed(&mut ada).await, app.files().len()), (1, 1), "{:?}", app.files());
}

#[tokio::test]
async fn what_was_ended_is_gone_and_what_has_expired_goes() {
    let clock = Clock::fixed(Moment::from_micros(1_767_268_800_000_000));
    let app = App::with(clock.clone(), |config| config.upload_lifetime_s = 3600).await;
    let mut ada = trainee(&app).await;
    let ended = begin(&mut ada, 10).await;
    assert_eq!(ada.send(tus("DELETE", &ended).body(Body::empty()).unwrap()).await.status, 204);
    assert_eq!(head(&mut ada, &ended).await.status, 404);
    assert!(app.files().is_empty(), "{:?}", app.files());

    let (fed, left) = (begin(&mut ada, 10).await, begin(&mut ada, 10).await);
    clock.advance(3000);
    let answer = send(&mut ada, &fed, 0, b"abc").await;
    assert_eq!(answer.header("upload-expires"), "Thu, 01 Jan 2026 13:50:00 GMT", "a piece prolongs it");
    clock.advance(600);
    uploads::tidy(&app.state).await.unwrap();
    assert_eq!(offset(&mut ada, &fed).await, 3);
    assert_eq!(head(&mut ada, &left).await.status, 404, "thrown away");
    clock.advance(3000);
    send(&mut ada, &fed, 3, b"d").await.is_problem(410, "expired");
    uploads::tidy(&app.state).await.unwrap();
    assert!(app.files().is_empty(), "{:?}", app.files());
}

#[tokio::test]
async fn complete_upload_is_accepted_at_restart_and_strays_deleted() {
    let app = App::new().await;
    let mut ada = trainee(&app).await;
    let bytes = record(&Attempt::default());
    let path = begin(&mut ada, bytes.len()).await;
    // As a service leaves it that is killed between the last byte and the session.
    let folder = app.state.config.uploads_dir();
    let id = path.rsplit('/').next().unwrap();
    std::fs::write(folder.join(format!("{id}.tus")), &bytes).unwrap();
    std::fs::write(folder.join("00000000-0000-0000-0000-000000000000.tus"), "a file whose row was never written")
        .unwrap();
    let mut upload = rows::find_upload_by_id(app.state.db.reader(), id.parse().unwrap()).await.unwrap().unwrap();
    upload.received = upload.length;
    app.write(async |tx| rows::advance_upload(tx, &upload).await.unwrap()).await;
    assert_eq!((offset(&mut ada, &path).await, listed(&mut ada).await), (bytes.len(), 0));
    uploads::tidy(&app.state).await.unwrap();
    assert_eq!((listed(&mut ada).await, app.files().len()), (1, 1), "{:?}", app.files());
}

#[tokio::test]
async fn a_network_that_only_lets_post_pass_is_no_hindrance() {
    let app = App::new().await;
    let mut ada = trainee(&app).await;
    let path = begin(&mut ada, 10).await;
    let posted = |method: &str| {
        tus("POST", &path)
            .header("x-http-method-override", method)
            .header("upload-offset", 0)
            .header("content-type", "application/offset+octet-stream")
            .body(Body::from("abc"))
            .unwrap()
    };
    assert_eq!(ada.send(posted("PATCH")).await.header("upload-offset"), "3");
    assert_eq!(ada.send(posted("HEAD")).await.header("upload-offset"), "3");
    ada.send(posted("PUT")).await.is_problem(400, "X-HTTP-Method-Override");
    assert_eq!(ada.send(posted("DELETE")).await.status, 204);
}

#[tokio::test]
async fn a_stations_upload_belongs_to_whoever_the_recording_names() {
    let app = App::new().await;
    let north = app.school("North").await;
    let ada = app.member(north, Role::Trainee, "ada@example.org").await.person;
    let mut station = app.with_token(&app.station(north).await);
    let bytes = record(&Attempt { trainee: ada.pseudonym.clone(), ..Attempt::default() });
    let path = begin(&mut station, bytes.len()).await;
    assert_eq!(send(&mut station, &path, 0, &bytes).await.status, 204);
    assert_eq!(
        listed(&mut app.with_token(&app.member(north, Role::Administrator, "h@example.org").await.token)).await,
        1
    );
    let bytes = record(&Attempt { trainee: "p-nobody".to_owned(), ..Attempt::default() });
    let path = begin(&mut station, bytes.len()).await;
    send(&mut station, &path, 0, &bytes).await.is_problem(422, "p-nobody");
}

#[tokio::test]
async fn quota_limits_open_uploads_per_owner_and_per_school() {
    let quota = |uploads, bytes| UploadQuota { uploads, bytes };
    let app = App::with(Clock::system(), |config| {
        config.owner_quota = quota(3, 1000);
        config.school_quota = quota(4, 10_000);
    });
    let app = app.await;
    let school = app.school("North").await;
    let mut people = Vec::new();
    for name in ["ada", "ben", "eve"] {
        let member = app.member(school, Role::Trainee, &format!("{name}@example.org")).await;
        people.push(app.with_token(&member.token));
    }
    let [ada, ben, eve] = &mut people[..] else { unreachable!() };
    let ask = |length: usize| tus("POST", UPLOADS).header("upload-length", length).body(Body::empty()).unwrap();
    ada.send(ask(1001)).await.is_problem(429, "1000 bytes");
    let first = begin(ada, 100).await;
    begin(ada, 100).await;
    ada.send(ask(801)).await.is_problem(429, "1000 bytes");
    begin(ada, 800).await;
    ada.send(ask(1)).await.is_problem(429, "3 uploads");
    begin(ben, 1000).await;
    eve.send(ask(1)).await.is_problem(429, "this school has 4");
    assert_eq!(ada.send(tus("DELETE", &first).body(Body::empty()).unwrap()).await.status, 204);
    begin(eve, 1).await;
    assert_eq!(app.files().len(), 4, "what was refused leaves nothing");
}
