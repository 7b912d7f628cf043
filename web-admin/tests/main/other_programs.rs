//! What programs rely on that nobody here wrote: answers as the API's description says, lists with a way on, uploads from a browser of
//! an allowed origin, files in which namesakes stay two. Fails when an answer holds what is not described or lacks what is, when an
//! attempt is missing between two pages of a list or stands in both, and when a page of any other origin is let in.

use axum::body::Body;
use axum::http::{Request, header};
use model::{Moment, Role};
use platform::clock::Clock;
use serde_json::{Value, json};
use time::macros::datetime;
use web_admin::worker;

use crate::support::App;
use crate::support::client::{Answer, Client, csrf_in};
use crate::support::recordings::{Attempt, record};

/// A trainee's attempt, scored.
async fn practised(app: &App) -> (Client, Attempt) {
    let school = app.school("North").await;
    app.publish(school).await;
    let mut ada = app.with_token(&app.member(school, Role::Trainee, "ada@example.org").await.token);
    let attempt = Attempt::default();
    assert_eq!(ada.upload(&record(&attempt)).await.status, 201);
    worker::work_off_jobs(&app.state).await.unwrap();
    (ada, attempt)
}

/// The description with nothing allowed that it does not name, so that what is missing in it shows.
struct Described(Value);

impl Described {
    async fn new(app: &App) -> Self {
        let mut document = app.stranger().get("/api/v1/openapi.json").await.json();
        for schema in document["components"]["schemas"].as_object_mut().unwrap().values_mut() {
            let closes = if schema.get("allOf").is_some() { "unevaluatedProperties" } else { "additionalProperties" };
            if schema.get("allOf").is_some() || schema.get("properties").is_some() {
                schema[closes] = json!(false);
            }
        }
        // What another schema is made of leaves it to that one.
        let schemas = document["components"]["schemas"].as_object_mut().unwrap();
        let parts: Vec<String> = schemas
            .values()
            .flat_map(|schema| schema["allOf"].as_array().into_iter().flatten())
            .filter_map(|part| Some(part["$ref"].as_str()?.rsplit('/').next()?.to_owned()))
            .collect();
        for part in parts {
            schemas[&part].as_object_mut().unwrap().remove("additionalProperties");
        }
        Self(document)
    }

    /// Holds an answer against what is said of its operation, status and media type.
    fn holds(&self, (method, path): (&str, &str), answer: &Answer) {
        let status = answer.status.as_str();
        let media_type = answer.header("content-type");
        let said = &self.0["paths"][path][method]["responses"][status];
        let schema = &said["content"][media_type]["schema"];
        assert!(schema.is_object(), "{method} {path}: {status} as {media_type} is not described: {said}");
        let whole = json!({ "components": self.0["components"], "allOf": [schema] });
        let wrong: Vec<String> = jsonschema::draft202012::new(&whole)
            .unwrap()
            .iter_errors(&answer.json())
            .map(|error| format!("{}: {error}", error.instance_path()))
            .collect();
        assert!(wrong.is_empty(), "{method} {path}: {wrong:#?} in {}", answer.text());
    }
}

#[tokio::test]
async fn answers_are_as_they_are_described() {
    let app = App::new().await;
    let (mut ada, attempt) = practised(&app).await;
    let described = Described::new(&app).await;
    let session = attempt.session_id.to_string();
    let comment = Request::post(format!("/api/v1/sessions/{session}/comments"))
        .header(header::CONTENT_TYPE, "application/json")
        .body(Body::from(json!({ "kind": "question", "from_s": 0.5, "body": "Why?" }).to_string()))
        .unwrap();
    described.holds(("post", "/sessions/{id}/comments"), &ada.send(comment).await);
    for path in [
        "/sessions",
        "/sessions/{id}",
        "/sessions/{id}/score",
        "/sessions/{id}/comments",
        "/sessions/{id}/series",
        "/sessions/{id}/replay",
        "/sessions/{id}/survey",
        "/me/assignments",
        "/exercises",
        "/exercises/feel-the-layers",
    ] {
        let answer = ada.get(&format!("/api/v1{}", path.replace("{id}", &session))).await;
        assert_eq!(answer.status, 200, "{path}: {}", answer.text());
        described.holds(("get", &path.replace("feel-the-layers", "{id}")), &answer);
    }
    described.holds(("post", "/sessions"), &ada.upload(&record(&attempt)).await);
    described.holds(("post", "/sessions"), &ada.upload(b"no recording").await);
    described.holds(("get", "/sessions"), &ada.get("/api/v1/sessions?limit=0").await);
    described.holds(("get", "/sessions/{id}/score"), &ada.get("/api/v1/sessions/0/score").await);
    described.holds(("get", "/sessions"), &app.stranger().get("/api/v1/sessions").await);
}

#[tokio::test]
async fn a_list_goes_on_where_it_ended() {
    let app = App::with(Clock::fixed(Moment::from(datetime!(2026-03-04 12:00 UTC))), |_| {}).await;
    let school = app.school("North").await;
    let mut ada = app.with_token(&app.member(school, Role::Trainee, "ada@example.org").await.token);
    let mut ids = Vec::new();
    for _ in 0..3 {
        let attempt = Attempt { depth_mm: 2.0, ..Attempt::default() };
        assert_eq!(ada.upload(&record(&attempt)).await.status, 201);
        ids.push(attempt.session_id.to_string());
    }
    // All three began at the same moment: their ids decide.
    ids.sort_by(|a, b| b.cmp(a));
    let first = ada.get("/api/v1/sessions?limit=2").await;
    let (list, next) = (first.json(), first.json()["next"].as_str().unwrap().to_owned());
    assert_eq!(first.header("link"), format!("</api/v1/sessions?after={next}&limit=2>; rel=\"next\""));
    let address = first.header("link").trim_start_matches('<').split('>').next().unwrap().to_owned();
    let rest = ada.get(&address).await;
    assert_eq!((rest.json()["next"].as_str(), rest.header("link")), (None, ""), "{}", rest.text());
    let (front, back) =
        (list["sessions"].as_array().unwrap().clone(), rest.json()["sessions"].as_array().unwrap().clone());
    let listed: Vec<_> = front.iter().chain(&back).map(|session| session["session_id"].as_str().unwrap()).collect();
    assert_eq!(listed, ids);
    assert_eq!(ada.get("/api/v1/sessions").await.json()["next"], Value::Null);
    for (query, word) in
        [("limit=0", "from 1 to 100"), ("limit=101", "limit"), ("after=x", "after"), ("limit=ten", "ten")]
    {
        ada.get(&format!("/api/v1/sessions?{query}")).await.is_problem(400, word);
    }
}

#[tokio::test]
async fn a_browser_uploads_from_an_allowed_origin_and_from_no_other() {
    const LAB: &str = "https://lab.example.org";
    let app = App::with(Clock::system(), |config| config.allowed_origins = vec![LAB.to_owned()]).await;
    let school = app.school("North").await;
    let token = app.member(school, Role::Trainee, "ada@example.org").await.token;
    let ask = |method: &str, origin: &str| {
        Request::builder().method(method).uri("/api/v1/uploads").header(header::ORIGIN, origin)
    };
    let preflight = |origin| {
        let asked = ask("OPTIONS", origin).header("access-control-request-method", "POST");
        asked
            .header("access-control-request-headers", "authorization,tus-resumable,upload-length")
            .body(Body::empty())
            .unwrap()
    };
    let asked = app.stranger().send(preflight(LAB)).await;
    assert_eq!((asked.status.as_u16(), asked.header("access-control-allow-origin")), (204, LAB));
    for needed in
        ["authorization", "tus-resumable", "upload-length", "upload-offset", "upload-metadata", "content-type"]
    {
        assert!(asked.header("access-control-allow-headers").contains(needed), "{needed}");
    }
    assert!(
        ["POST", "PATCH", "HEAD"].iter().all(|method| asked.header("access-control-allow-methods").contains(method))
    );
    let begin = |origin| {
        // tuspy sends it empty where it has nothing to say.
        let begun = ask("POST", origin)
            .header("tus-resumable", "1.0.0")
            .header("upload-length", 5)
            .header("upload-metadata", "");
        begun.body(Body::empty()).unwrap()
    };
    let begun = app.with_token(&token).send(begin(LAB)).await;
    assert_eq!((begun.status.as_u16(), begun.header("access-control-allow-origin")), (201, LAB), "{}", begun.text());
    assert!(
        ["location", "upload-offset", "stylet-session"]
            .iter()
            .all(|name| begun.header("access-control-expose-headers").contains(name))
    );
    let refused = app.stranger().send(begin(LAB)).await;
    assert_eq!(
        (refused.status.as_u16(), refused.header("access-control-allow-origin")),
        (401, LAB),
        "a page may read why"
    );
    for elsewhere in ["https://lab.example.org.evil.example", "http://lab.example.org", "null", "https://evil.example"]
    {
        for answer in
            [app.stranger().send(preflight(elsewhere)).await, app.with_token(&token).send(begin(elsewhere)).await]
        {
            assert_eq!(
                (answer.header("access-control-allow-origin"), answer.header("vary")),
                ("", "origin"),
                "{elsewhere}"
            );
        }
    }
    for answer in [asked, begun] {
        assert_eq!(answer.header("access-control-allow-credentials"), "", "never with cookies");
    }
    let shut = App::new().await;
    assert_eq!(
        shut.stranger().send(preflight(LAB)).await.header("access-control-allow-origin"),
        "",
        "nobody was allowed"
    );
}

#[tokio::test]
async fn namesakes_stay_two_people_in_every_file() {
    let app = App::new().await;
    let school = app.school("North").await;
    app.publish(school).await;
    let people =
        [app.member(school, Role::Trainee, "a@x.org").await, app.member(school, Role::Trainee, "b@x.org").await];
    let teacher = app.member(school, Role::Instructor, "teacher@x.org").await;
    app.cohort(school, "A", &[&people[0].person, &people[1].person, &teacher.person]).await;
    for member in &people {
        assert_eq!(app.with_token(&member.token).upload(&record(&Attempt::default())).await.status, 201);
    }
    worker::work_off_jobs(&app.state).await.unwrap();
    app.member(school, Role::Administrator, "head@x.org").await;
    let mut head = app.signed_in("head@x.org").await;
    let cohort = head.get("/cohorts").await.link("/cohorts/");
    let metrics = format!("{cohort}/exercises/feel-the-layers/metrics.csv");
    for path in [format!("{cohort}/progress.csv"), metrics, "/progress/attempts.csv".to_owned()] {
        let file = head.get(&path).await;
        assert_eq!((file.status.as_u16(), file.header("content-type")), (200, "text/csv; charset=utf-8"), "{path}");
        let mut reader = csv::Reader::from_reader(file.body.as_slice());
        let names = reader.headers().unwrap().clone();
        let column =
            |name: &str| names.iter().position(|known| known == name).unwrap_or_else(|| panic!("{path}: {name}"));
        let (name, id, pseudonym) = (column("trainee"), column("trainee_id"), column("pseudonym"));
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        for member in &people {
            let person = &member.person;
            let own: Vec<_> = rows.iter().filter(|row| row[id] == person.id.to_string()).collect();
            assert!(!own.is_empty() && own.len() * 2 == rows.len(), "{path}: {}", file.text());
            assert!(
                own.iter().all(|row| row[pseudonym] == person.pseudonym && row[name] == person.display_name),
                "{path}"
            );
        }
    }
}

#[tokio::test]
async fn links_to_viewers_begin_where_the_service_is_found() {
    const FOUND: &str = "https://training.example.org/stylet";
    let app = App::with(Clock::system(), |config| config.public_url = Some(FOUND.to_owned())).await;
    let (_, attempt) = practised(&app).await;
    let mut browser = app.signed_in("ada@example.org").await;
    let csrf = csrf_in(&browser.get("/account").await.text());
    let page = browser.form(&format!("/sessions/{}/links", attempt.session_id), &[("csrf", &csrf)]).await.text();
    assert!(page.contains(&format!("{FOUND}/recordings/")), "{page}");
    let encoded = "https%3A%2F%2Ftraining%2Eexample%2Eorg%2Fstylet%2Frecordings";
    assert_eq!(page.matches(encoded).count(), 3, "each viewer is handed it: {page}");
}

#[tokio::test]
async fn a_school_allows_origins_and_takes_them_back() {
    const LAB: &str = "https://lab.example.org";
    let app = App::new().await;
    let school = app.school("North").await;
    app.member(school, Role::Administrator, "head@example.org").await;
    let told = async || {
        let asked = Request::options("/api/v1/uploads").header(header::ORIGIN, LAB);
        let asked = asked.header("access-control-request-method", "POST").body(Body::empty()).unwrap();
        app.stranger().send(asked).await.header("access-control-allow-origin").to_owned()
    };
    assert_eq!(told().await, "");
    let mut head = app.signed_in("head@example.org").await;
    let csrf = csrf_in(&head.get("/admin/origins").await.text());
    let mut set = async |origins| head.form("/admin/origins", &[("csrf", &csrf), ("origins", origins)]).await;
    assert_eq!(set("\n https://LAB.example.org \r\nhttp://localhost:3000\n").await.status, 303);
    assert_eq!(told().await, LAB);
    for (refused, said) in [
        ("https://lab.example.org/upload", "“https://lab.example.org/upload”"),
        ("*", "“*”"),
        ("https://*.example.org", "“https://*.example.org”"),
        ("null", "“null”"),
        ("<b>", "“&#60;b&#62;”"),
    ] {
        let answer = set(refused).await;
        assert!(answer.status == 422 && answer.text().contains(said), "{refused}: {}", answer.text());
    }
    let many: String = (0..21).map(|n| format!("https://lab{n}.example.org\n")).collect();
    assert!(set(&many).await.text().contains("21 origins"));
    assert_eq!(told().await, LAB, "what is refused changes nothing");
    assert_eq!(set("").await.status, 303);
    assert_eq!(told().await, "");
}

#[tokio::test]
async fn the_key_of_certificates_is_published() {
    let app = App::new().await;
    let published = app.stranger().get("/.well-known/stylet-certificate-key").await;
    assert_eq!((published.status.as_u16(), published.header("content-type")), (200, "text/plain; charset=utf-8"));
    let key = acts::training::certificates::public_key(&app.state.config.keys_dir).unwrap();
    assert_eq!(published.text(), format!("{key}\n"));
}
