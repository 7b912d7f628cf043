//! Who is asking is settled first, and nobody sees another school. Fails when a stranger can tell a page that exists
//! from one that does not, or an id of another school from no id at all.

use axum::http::Method;
use model::Role;
use store::audit::Actor;
use store::auth::tokens;
use store::people;
use store::training::cohorts;
use uuid::Uuid;

use crate::support::App;
use crate::support::recordings::{Attempt, record};

#[tokio::test]
async fn a_stranger_is_asked_to_sign_in_wherever_they_go() {
    let app = App::new().await;
    let somewhere = Uuid::new_v4();
    for path in ["/", "/curricula", "/cohorts", "/admin", "/sessions/not-an-id", "/trainees/0", "/nothing", "/%ff"]
        .map(str::to_owned)
        .into_iter()
        .chain(["sessions", "trainees", "exercises", "cohorts"].map(|noun| format!("/{noun}/{somewhere}")))
    {
        for method in [Method::GET, Method::POST, Method::DELETE] {
            let answer = app.stranger().request(method.clone(), &path).await;
            assert_eq!(answer.status, 303, "{method} {path}");
            assert!(answer.header("location").starts_with("/login"), "{method} {path}");
        }
    }
}

#[tokio::test]
async fn a_stranger_to_the_api_is_told_so_and_nothing_else() {
    let app = App::new().await;
    for token in [None, Some("wrong"), Some("")] {
        let mut client = app.stranger();
        client.token = token.map(str::to_owned);
        for path in ["/sessions", "/sessions/x", "/sessions/x/score", "/me/assignments", "/exercises/x", "/nothing"] {
            for method in [Method::GET, Method::POST, Method::PATCH] {
                let answer = client.request(method.clone(), &format!("/api/v1{path}")).await;
                answer.is_problem(401, "token");
                assert_eq!(answer.header("www-authenticate"), "Bearer", "{method} {path}");
            }
        }
    }
    assert_eq!(app.stranger().get("/api/v1/openapi.json").await.status, 200);
}

#[tokio::test]
async fn only_trainee_teacher_and_administrator_see_an_attempt() {
    let app = App::new().await;
    let (north, south) = (app.school("North").await, app.school("South").await);
    let ada = app.member(north, Role::Trainee, "ada@example.org").await;
    let bob = app.member(north, Role::Trainee, "bob@example.org").await;
    let teacher = app.member(north, Role::Instructor, "teacher@example.org").await;
    let other_teacher = app.member(north, Role::Instructor, "other@example.org").await;
    let head = app.member(north, Role::Administrator, "head@example.org").await;
    let abroad = app.member(south, Role::Administrator, "head@south.example").await;
    app.cohort(north, "A", &[&ada.person, &teacher.person]).await;
    app.cohort(north, "B", &[&bob.person, &other_teacher.person]).await;
    let attempt = Attempt::default();
    assert_eq!(app.with_token(&ada.token).upload(&record(&attempt)).await.status, 201);
    for (member, sees) in
        [(&ada, true), (&teacher, true), (&head, true), (&bob, false), (&other_teacher, false), (&abroad, false)]
    {
        let mut client = app.with_token(&member.token);
        for part in ["", "/score", "/recording", "/series"] {
            let answer = client.get(&format!("/api/v1/sessions/{}{part}", attempt.session_id)).await;
            assert_eq!(answer.status != 404, sees, "{} {part}: {}", member.person.email, answer.status);
        }
        let listed = client.get("/api/v1/sessions").await.json()["sessions"].as_array().unwrap().len();
        assert_eq!(listed, usize::from(sees), "{}", member.person.email);
    }
    let taught = cohorts::list_cohorts_of_person(app.state.db.reader(), north, teacher.person.id, Role::Instructor)
        .await
        .unwrap();
    assert_eq!(taught.iter().map(|cohort| cohort.name.as_str()).collect::<Vec<_>>(), ["A"]);
}

#[tokio::test]
async fn nobody_joins_a_cohort_of_another_school() {
    let app = App::new().await;
    let (north, south) = (app.school("North").await, app.school("South").await);
    let ada = app.member(south, Role::Trainee, "ada@example.org").await.person;
    let now = app.state.clock.now();
    let mut tx = app.state.db.write().await.unwrap();
    let cohort = cohorts::find_or_create(&mut tx, north, "A", now).await.unwrap();
    let deed = cohorts::Attribution { by: None, at: now };
    for school_id in [north, south] {
        let join = cohorts::Membership { school_id, cohort_id: cohort.id, person_id: ada.id, role: Role::Trainee };
        assert!(cohorts::join_cohort(&mut tx, join, deed).await.is_err(), "the database itself refuses");
    }
}

#[tokio::test]
async fn a_cookie_reads_and_never_writes_through_the_api() {
    let app = App::new().await;
    let school = app.school("North").await;
    app.member(school, Role::Trainee, "ada@example.org").await;
    let mut browser = app.signed_in("ada@example.org").await;
    assert_eq!(browser.get("/api/v1/sessions").await.status, 200);
    browser.upload(&record(&Attempt::default())).await.is_problem(401, "token");
}

#[tokio::test]
async fn revoked_and_disabled_means_out() {
    let app = App::new().await;
    let school = app.school("North").await;
    let ada = app.member(school, Role::Trainee, "ada@example.org").await;
    let bob = app.member(school, Role::Trainee, "bob@example.org").await;
    let now = app.state.clock.now();
    let revoked = app.write(async |tx| tokens::revoke_all_tokens(tx, ada.person.id, now).await.unwrap()).await;
    assert_eq!(revoked, 1);
    app.write(async |tx| people::disable_person(tx, bob.person.id, now).await.unwrap()).await;
    for member in [ada, bob] {
        app.with_token(&member.token).get("/api/v1/sessions").await.is_problem(401, "token");
    }
}

#[tokio::test]
async fn every_answer_carries_the_strict_headers() {
    let app = App::new().await;
    for path in ["/login", "/", "/nothing", "/api/v1/sessions", "/healthz"] {
        let answer = app.stranger().get(path).await;
        let policy = answer.header("content-security-policy");
        for rule in ["default-src 'none'", "form-action 'self'", "frame-ancestors 'none'", "base-uri 'none'"] {
            assert!(policy.contains(rule), "{path}: {policy}");
        }
        assert!(!policy.contains("unsafe"), "{path}: {policy}");
        assert_eq!(answer.header("x-content-type-options"), "nosniff", "{path}");
        assert_eq!(answer.header("cross-origin-opener-policy"), "same-origin", "{path}");
        assert_eq!(answer.header("cross-origin-resource-policy"), "same-origin", "{path}");
        assert!(answer.header("permissions-policy").contains("camera=()"), "{path}");
        assert_eq!(answer.header("referrer-policy"), "same-origin", "{path}");
        assert_eq!(answer.header("access-control-allow-origin"), "", "{path}");
    }
}

#[test]
fn an_actor_is_named_by_id_or_kind() {
    assert_eq!(Actor::Station("room 2".to_owned()).to_string(), "station room 2");
    assert_eq!(Actor::Worker.to_string(), "worker");
}
