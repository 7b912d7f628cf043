//! What an attempt proves, and what it does not. Fails when a forged exercise, somebody else's recording, a copy under
//! another id or a date that cannot be is counted, or when a certificate asks for less than the school does.

use data_encoding::HEXLOWER;
use ed25519_dalek::SigningKey;
use model::ids::{SchoolId, SessionId, StationId};
use model::{CurrentPerson, Moment, Role, SessionKey};
use platform::clock::Clock;
use serde_json::json;
use store::recordings::{proofs, sessions};
use store::training::{practice, tallies};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;
use time::macros::datetime;
use web_admin::worker;

use crate::support::client::{Answer, csrf_in};
use crate::support::database::connect;
use crate::support::recordings::{Attempt, FORGED, Station, record, tampered};
use crate::support::{App, Member};

const NOW: OffsetDateTime = datetime!(2026-03-04 12:00 UTC);

/// A school that teaches the shipped course, with a trainee; the clock stands at [`NOW`].
struct World {
    app: App,
    school: SchoolId,
    ada: Member,
}

impl World {
    async fn new() -> Self {
        let app = App::with(Clock::fixed(Moment::from(NOW)), |_| {}).await;
        let school = app.school("North").await;
        app.publish(school).await;
        let ada = app.member(school, Role::Trainee, "ada@example.org").await;
        Self { app, school, ada }
    }

    /// Somebody who sees the whole school.
    fn administrator(&self) -> CurrentPerson {
        CurrentPerson { role: Role::Administrator, ..self.ada.person.clone().into_current().unwrap() }
    }

    async fn upload(&self, member: &Member, attempt: &Attempt) -> Answer {
        self.app.with_token(&member.token).upload(&record(attempt)).await
    }

    async fn counted(&self, member: &Member) -> usize {
        worker::work_off_jobs(&self.app.state).await.unwrap();
        practice::list_trainee_practice(self.app.state.db.reader(), self.school, member.person.id).await.unwrap().len()
    }

    /// What the session of an attempt says of when it began, and what its recording claims.
    async fn began(&self, attempt: &Attempt) -> (OffsetDateTime, Option<OffsetDateTime>) {
        let found =
            sessions::find_session(self.app.state.db.reader(), self.school, attempt.session_id).await.unwrap().unwrap();
        (found.started_at.to_utc(), found.claimed_started_at.map(Moment::to_utc))
    }

    /// Pairs a station through the front door.
    async fn pair(&self) -> Station {
        let key = SigningKey::from_bytes(&[7; 32]);
        let mut head = self.app.signed_in("head@example.org").await;
        let csrf = csrf_in(&head.get("/admin").await.text());
        let page = head.form("/admin/pairing-codes", &[("csrf", &csrf)]).await.text();
        let code = page.split("code-to-type\">").nth(1).unwrap().split('<').next().unwrap().to_owned();
        let body =
            json!({ "code": code, "name": "lab", "public_key": HEXLOWER.encode(key.verifying_key().as_bytes()) });
        let request = axum::http::Request::post("/api/v1/stations/pair").header("content-type", "application/json");
        let answer = self.app.stranger().send(request.body(axum::body::Body::from(body.to_string())).unwrap()).await;
        assert_eq!(answer.status, 201, "{}", answer.text());
        Station { id: answer.json()["station_id"].as_str().unwrap().parse().unwrap(), key }
    }
}

fn attempt_at(started_at: OffsetDateTime) -> Attempt {
    Attempt { started_at, ..Attempt::default() }
}

#[tokio::test]
async fn an_exercise_that_the_school_never_published_masters_nothing() {
    let world = World::new().await;
    for _ in 0..7 {
        let forged = world.upload(&world.ada, &Attempt { bundle: &FORGED, ..attempt_at(NOW) }).await;
        assert_eq!((forged.status.as_u16(), &forged.json()["uncounted"]), (201, &json!("unpublished")));
    }
    assert_eq!(world.counted(&world.ada).await, 0);
    let months = tallies::list_tallies_by_month(world.app.state.db.reader(), &world.administrator()).await.unwrap();
    assert_eq!(months.iter().map(|(_, sums)| sums.attempts).sum::<i64>(), 0);
    let token = &mut world.app.with_token(&world.ada.token);
    let due = token.get("/api/v1/me/assignments").await.json();
    assert_eq!(
        (&due["assignments"][0]["exercise_id"], &due["assignments"][0]["passes"]),
        (&json!("feel-the-layers"), &json!(0))
    );
    let listed = token.get("/api/v1/sessions").await.json()["sessions"][0].clone();
    assert_eq!((&listed["state"], &listed["uncounted"]), (&json!("scored"), &json!("unpublished")), "it is kept");
    let id = listed["session_id"].as_str().unwrap();
    assert_eq!(token.get(&format!("/api/v1/sessions/{id}/score")).await.json()["uncounted"], "unpublished");
    let mut ada = world.app.signed_in("ada@example.org").await;
    assert!(ada.get(&format!("/sessions/{id}")).await.text().contains("This attempt does not count."));
    let home = ada.get("/").await.text();
    assert!(
        home.contains("Exercise not published") && !home.contains("Main point losses"),
        "it is nobody's habit: {home}"
    );
}

#[tokio::test]
async fn exercise_documents_prove_no_attempt_at_another_exercise() {
    let world = World::new().await;
    let honest = attempt_at(NOW);
    let mut session: recording::Session = recording::Recording::read(&record(&honest)[..]).unwrap().session;
    session.exercise_id = "reach-the-muscle".to_owned();
    let found = store::authoring::exercises::by_documents(world.app.state.db.reader(), world.school, &session);
    assert_eq!(found.await.unwrap(), None);
}

#[tokio::test]
async fn attempt_of_another_person_is_refused_and_a_copy_uncounted() {
    let world = World::new().await;
    let eve = world.app.member(world.school, Role::Trainee, "eve@example.org").await;
    let named = Attempt { trainee: world.ada.person.pseudonym.clone(), ..attempt_at(NOW) };
    let stolen = Attempt { session_id: SessionId::random(), hand: Some(named.session_id), ..named.clone() };
    assert_eq!(world.upload(&world.ada, &named).await.status, 201);
    world.upload(&eve, &stolen).await.is_problem(409, "another person");
    let copy = Attempt { trainee: String::new(), started_at: NOW - time::Duration::hours(3), ..stolen };
    for (member, copy) in [(&eve, copy.clone()), (&world.ada, Attempt { session_id: SessionId::random(), ..copy })] {
        let told = world.upload(member, &copy).await;
        assert_eq!((told.status.as_u16(), &told.json()["uncounted"]), (201, &json!("duplicate")), "{}", told.text());
    }
    assert_eq!((world.counted(&world.ada).await, world.counted(&eve).await), (1, 0));
    let noted: i64 =
        sqlx::query_scalar("SELECT count(*) FROM audit_log WHERE details LIKE '%\"repeats\":\"' || $1 || '%'")
            .bind(named.session_id.to_string())
            .fetch_one(world.app.state.db.reader())
            .await
            .unwrap();
    assert_eq!(noted, 2, "the log names the attempt that was copied");
}

#[tokio::test]
async fn uncounted_copy_does_not_stop_the_original_from_counting() {
    let world = World::new().await;
    let honest = attempt_at(NOW);
    let forged =
        Attempt { session_id: SessionId::random(), hand: Some(honest.session_id), bundle: &FORGED, ..honest.clone() };
    assert_eq!(world.upload(&world.ada, &forged).await.json()["uncounted"], "unpublished");
    assert_eq!(world.upload(&world.ada, &honest).await.json().get("uncounted"), None);
    assert_eq!(world.counted(&world.ada).await, 1);
}

#[tokio::test]
async fn signed_attempt_counts_after_an_earlier_unsigned_copy() {
    let world = World::new().await;
    world.app.member(world.school, Role::Administrator, "head@example.org").await;
    let eve = world.app.member(world.school, Role::Trainee, "eve@example.org").await;
    let trainee = world.ada.person.pseudonym.clone();
    let original = Attempt { station: Some(world.pair().await), trainee, ..attempt_at(NOW) };
    let copy = Attempt { session_id: SessionId::random(), hand: Some(original.session_id), ..attempt_at(NOW) };
    assert_eq!(world.upload(&eve, &copy).await.status, 201);
    assert_eq!(world.counted(&eve).await, 1);
    let told = world.upload(&world.ada, &original).await.json();
    assert_eq!((told.get("uncounted"), &told["signed_by_station"]), (None, &json!(true)), "{told}");
    assert_eq!((world.counted(&world.ada).await, world.counted(&eve).await), (1, 0));
    let listed = world.app.with_token(&eve.token).get("/api/v1/sessions").await.json()["sessions"][0].clone();
    assert_eq!(listed["uncounted"], "duplicate");
    let again = Attempt { session_id: SessionId::random(), hand: Some(original.session_id), ..original };
    assert_eq!(
        world.upload(&world.ada, &again).await.json()["uncounted"],
        "duplicate",
        "of two signed ones the first counts"
    );
}

#[tokio::test]
async fn an_attempt_is_believed_within_bounds_and_its_claim_is_kept() {
    let world = World::new().await;
    let long_ago = attempt_at(datetime!(2026-01-01 0:00 UTC));
    let far = attempt_at(datetime!(2104-12-31 0:00 UTC));
    let honest = attempt_at(datetime!(2026-03-04 11:00 UTC));
    for attempt in [&long_ago, &far, &honest] {
        assert_eq!(world.upload(&world.ada, attempt).await.status, 201);
    }
    assert_eq!(world.began(&long_ago).await, (NOW - time::Duration::days(1), Some(long_ago.started_at)));
    let (began, claimed) = world.began(&far).await;
    assert!(began < NOW && began > NOW - time::Duration::minutes(1) && claimed == Some(far.started_at), "{began}");
    assert_eq!(world.began(&honest).await, (honest.started_at, None));
    let mut ada = world.app.signed_in("ada@example.org").await;
    let page = ada.get(&format!("/sessions/{}", far.session_id)).await.text();
    assert!(page.contains("Started, according to the recording") && page.contains("2104"), "{page}");
    assert!(!ada.get("/").await.text().contains("2104"), "no list and no curve runs to the far end");
}

#[tokio::test]
async fn a_station_whose_clock_is_wrong_says_so_and_is_corrected() {
    let world = World::new().await;
    let fast = attempt_at(NOW + time::Duration::hours(5) - time::Duration::minutes(2));
    let mut client = world.app.with_token(&world.ada.token);
    let request = |clock: &str| {
        axum::http::Request::post("/api/v1/sessions")
            .header("content-type", "application/octet-stream")
            .header("stylet-clock", clock)
            .body(axum::body::Body::from(record(&fast)))
            .unwrap()
    };
    client.send(request("yesterday")).await.is_problem(400, "RFC 3339");
    assert_eq!(client.send(request("2026-03-04T17:00:00Z")).await.status, 201);
    assert_eq!(world.began(&fast).await, (NOW - time::Duration::minutes(2), Some(fast.started_at)));
}

#[tokio::test]
async fn signature_counts_while_paired_and_only_for_its_recording() {
    let world = World::new().await;
    world.app.member(world.school, Role::Administrator, "head@example.org").await;
    let station = world.pair().await;
    let reader = world.app.state.db.reader();
    let proof = async |attempt: &Attempt| {
        worker::work_off_jobs(&world.app.state).await.unwrap();
        proofs::find_proof(reader, SessionKey { school_id: world.school, id: attempt.session_id }).await.unwrap()
    };
    let trainee = world.ada.person.pseudonym.clone();
    let signed =
        |started_at| Attempt { station: Some(station.clone()), trainee: trainee.clone(), ..attempt_at(started_at) };
    let honest = signed(NOW);
    let told = world.upload(&world.ada, &honest).await.json();
    assert_eq!(told["signed_by_station"], true, "{told}");
    let found = proof(&honest).await;
    assert!(found.signed && found.resimulated && !found.supervised, "{found:?}");
    let token = &mut world.app.with_token(&world.ada.token);
    let score = token.get(&format!("/api/v1/sessions/{}/score", honest.session_id)).await.json();
    assert_eq!(score["proof"], json!({ "signed": true, "resimulated": true, "supervised": false }));

    let other_key = Station { key: SigningKey::from_bytes(&[8; 32]), ..station.clone() };
    let stranger = Station { id: StationId::random(), ..station.clone() };
    for forger in [other_key, stranger] {
        let forged = Attempt { station: Some(forger), ..signed(NOW) };
        assert_eq!(world.upload(&world.ada, &forged).await.json()["signed_by_station"], false);
        assert!(!proof(&forged).await.signed);
    }
    let nameless = Attempt { trainee: String::new(), ..signed(NOW) };
    assert_eq!(world.upload(&world.ada, &nameless).await.json()["signed_by_station"], false, "no trainee is named");
    assert!(!proof(&nameless).await.signed);
    // A station vouches for what the hand did; forces that do not follow from it are no proof.
    let spoilt = signed(NOW);
    assert_eq!(world.app.with_token(&world.ada.token).upload(&tampered(&spoilt)).await.status, 201);
    assert!(!proof(&spoilt).await.signed);
    // What is signed is believed back to the pairing, and no further.
    world.app.state.clock.advance(3 * 24 * 3600);
    let (offline, before) = (signed(NOW + time::Duration::hours(1)), signed(NOW - time::Duration::hours(1)));
    world.upload(&world.ada, &offline).await;
    world.upload(&world.ada, &before).await;
    assert_eq!(world.began(&offline).await, (offline.started_at, None));
    assert_eq!(world.began(&before).await, (NOW, Some(before.started_at)));
    // The uploader's clock is not the clock of the station that recorded the attempt.
    let carried = signed(NOW + time::Duration::hours(2));
    let fast = world.app.state.clock.now().to_utc() + time::Duration::days(2);
    let request = axum::http::Request::post("/api/v1/sessions")
        .header("content-type", "application/octet-stream")
        .header("stylet-clock", fast.format(&Rfc3339).unwrap())
        .body(axum::body::Body::from(record(&carried)));
    assert_eq!(world.app.with_token(&world.ada.token).send(request.unwrap()).await.status, 201);
    assert_eq!(world.began(&carried).await, (carried.started_at, None));
    let mut head = world.app.signed_in("head@example.org").await;
    let csrf = csrf_in(&head.get("/admin").await.text());
    head.form(&format!("/admin/stations/{}/revoke", station.id), &[("csrf", &csrf)]).await;
    let late = signed(NOW);
    assert_eq!(world.upload(&world.ada, &late).await.json()["signed_by_station"], false, "revoked");
    assert!(proof(&honest).await.signed, "what was right when it was received stays so");
}

#[tokio::test]
async fn a_database_of_before_counts_again_without_what_was_forged() {
    only_on!(Sqlite, "there was no PostgreSQL before");
    let world = World::new().await;
    let (honest, forged, far) = (attempt_at(NOW), Attempt { bundle: &FORGED, ..attempt_at(NOW) }, attempt_at(NOW));
    for attempt in [&honest, &forged, &far] {
        world.upload(&world.ada, attempt).await;
    }
    assert_eq!(world.counted(&world.ada).await, 2);
    let migration = include_str!("../../../../migrations/0110_prove_attempts.sql");
    // The part that looks at what is there, as it would find a database of before: all counted, one in the far future.
    let looks = migration.split("FROM sessions s;\n").nth(1).expect("behind the view");
    let mut connection = connect(world.app.folder.path()).await;
    let before = "UPDATE sessions SET uncounted = NULL; UPDATE practice SET attempts = 3;
        UPDATE sessions SET started_at = 253370764800000000 WHERE id = $1";
    for statement in before.split(';') {
        sqlx::query(sqlx::AssertSqlSafe(statement)).bind(far.session_id).execute(&mut connection).await.unwrap();
    }
    sqlx::raw_sql(looks).execute(&mut connection).await.unwrap();
    assert_eq!(world.counted(&world.ada).await, 2);
    let (began, claimed) = world.began(&far).await;
    assert!(began < NOW && claimed.is_some_and(|claimed| claimed.year() == 9999), "{began} {claimed:?}");
    let months = tallies::list_tallies_by_month(world.app.state.db.reader(), &world.administrator()).await.unwrap();
    assert_eq!(months.iter().map(|(month, sums)| (*month, sums.attempts)).collect::<Vec<_>>(), [(2026 * 12 + 2, 2)]);
    for attempt in [&honest, &far] {
        let key = SessionKey { school_id: world.school, id: attempt.session_id };
        world.app.write(async |tx| practice::refresh_practice(tx, key).await.unwrap()).await;
    }
    let again = tallies::list_tallies_by_month(world.app.state.db.reader(), &world.administrator()).await.unwrap();
    assert_eq!(again, months, "what the migration sums up is what scoring sums up");
}

#[tokio::test]
async fn motions_of_before_are_compared_when_nothing_else_waits() {
    only_on!(Sqlite, "there was no PostgreSQL before");
    let world = World::new().await;
    let eve = world.app.member(world.school, Role::Trainee, "eve@example.org").await;
    let first = attempt_at(NOW);
    let copy = Attempt { session_id: SessionId::random(), hand: Some(first.session_id), ..first.clone() };
    let other = attempt_at(NOW);
    for (member, attempt) in [(&world.ada, &first), (&world.ada, &other), (&eve, &copy)] {
        world.upload(member, attempt).await;
    }
    assert_eq!((world.counted(&world.ada).await, world.counted(&eve).await), (2, 0));
    let mut connection = connect(world.app.folder.path()).await;
    let fill = include_str!("../../../../migrations/0211_compare_motions_of_before.sql").split(";\n\n").nth(1).unwrap();
    // All three of before; then, of the copies, only the first, so that the later one has its hash when it is looked at.
    for of_before in ["1", "id <> $1"] {
        let undone = format!(
            "UPDATE sessions SET motion_sha256 = NULL WHERE {of_before}; UPDATE sessions SET uncounted = NULL, repeats = NULL"
        );
        for statement in undone.split(';') {
            sqlx::query(sqlx::AssertSqlSafe(statement)).bind(copy.session_id).execute(&mut connection).await.unwrap();
        }
        let key = SessionKey { school_id: world.school, id: copy.session_id };
        world.app.write(async |tx| practice::refresh_practice(tx, key).await.unwrap()).await;
        assert_eq!(world.counted(&eve).await, 1, "as it was counted before");
        sqlx::raw_sql(sqlx::AssertSqlSafe(fill)).execute(&mut connection).await.unwrap();

        worker::work_off_jobs(&world.app.state).await.unwrap();
        assert_eq!((world.counted(&world.ada).await, world.counted(&eve).await), (2, 0), "{of_before}");
        let told = world.app.with_token(&eve.token).get("/api/v1/sessions").await.json()["sessions"][0].clone();
        assert_eq!(told["uncounted"], "duplicate");
        let left: i64 =
            sqlx::query_scalar("SELECT count(*) FROM unhashed_motions").fetch_one(&mut connection).await.unwrap();
        assert_eq!(left, 0);
    }
    let again = Attempt { session_id: SessionId::random(), hand: Some(other.session_id), ..other.clone() };
    assert_eq!(
        world.upload(&eve, &again).await.json()["uncounted"],
        "duplicate",
        "an old one is found when it comes again"
    );
}
