//! Surveys through the front door. Fails when an answer is lost or counted twice, when an anonymous one leads to who gave
//! it, when a link opens what it should not, or when somebody sees a group that is too small.

pub(crate) mod exports;
pub(crate) mod letters;
pub(crate) mod station_surveys;

use acts::authoring::instruments;
use axum::body::Body;
use axum::http::{Request, header};
use model::ids::{CohortId, SchoolId, SessionId, SurveyId};
use model::{Moment, Role};
use platform::clock::Clock;
use time::macros::datetime;
use web_admin::worker;

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::recordings::{Attempt, record};
use crate::support::{App, Member, course_folder};

/// A form as a browser sends it, whatever stands in it.
pub(crate) async fn send(client: &mut Client, path: &str, fields: &[(&str, &str)]) -> Answer {
    let escape = |text: &str| text.bytes().map(|b| format!("%{b:02X}")).collect::<String>();
    let pairs: Vec<_> = fields.iter().map(|(name, value)| format!("{}={}", escape(name), escape(value))).collect();
    let request = Request::post(path)
        .header(header::CONTENT_TYPE, "application/x-www-form-urlencoded")
        .body(Body::from(pairs.join("&")))
        .unwrap();
    client.send(request).await
}

/// The address that an answer leads to.
fn led_to(answer: &Answer) -> String {
    assert_eq!(answer.status, 303, "{}", answer.text());
    answer.header("location").to_owned()
}

pub(crate) struct School {
    pub(crate) app: App,
    pub(crate) id: SchoolId,
    pub(crate) ada: Member,
}

impl School {
    /// A school with the shipped instruments, a trainee in a cohort, her teacher, another teacher and a head.
    pub(crate) async fn new() -> Self {
        let app = App::with(Clock::fixed(Moment::from(datetime!(2026-05-20 09:30 UTC))), |_| {}).await;
        let id = app.school("North").await;
        let now = app.state.clock.now();
        app.publish(id).await;
        app.write(async |tx| {
            for path in instruments::documents_in(course_folder().parent().unwrap()).unwrap() {
                instruments::publish(tx, id, &path, now).await.unwrap();
            }
        })
        .await;
        let ada = app.member(id, Role::Trainee, "ada@example.org").await;
        let teacher = app.member(id, Role::Instructor, "teacher@example.org").await;
        app.member(id, Role::Instructor, "other@example.org").await;
        app.member(id, Role::Administrator, "head@example.org").await;
        app.cohort(id, "Spring", &[&ada.person, &teacher.person]).await;
        Self { app, id, ada }
    }

    /// Makes a survey in the browser, and returns its path.
    pub(crate) async fn survey(&self, teacher: &mut Client, instrument: &str, fields: &[(&str, &str)]) -> String {
        let csrf = csrf_in(&teacher.get("/surveys/new").await.text());
        let common = [("csrf", csrf.as_str()), ("instrument", instrument), ("title", "What do you think?")];
        let made = send(teacher, "/surveys/new", &[&common[..], fields].concat()).await;
        led_to(&made)
    }

    /// Makes links, and returns their paths.
    pub(crate) async fn links(&self, teacher: &mut Client, survey: &str, labels: &str) -> Vec<String> {
        let csrf = csrf_in(&teacher.get(survey).await.text());
        let page = send(teacher, &format!("{survey}/links"), &[("csrf", &csrf), ("labels", labels)]).await.text();
        page.split("href=\"http://localhost/survey/")
            .skip(1)
            .map(|rest| format!("/survey/{}", rest.split('"').next().unwrap()))
            .collect()
    }

    /// The cohort's id, as the form of a new survey has it.
    pub(crate) async fn cohort(&self, teacher: &mut Client) -> String {
        let page = teacher.get("/surveys/new").await.text();
        page.split("name=\"cohort\" value=\"").nth(1).unwrap().split('"').next().unwrap().to_owned()
    }

    pub(crate) async fn upload(&self) -> SessionId {
        let attempt = Attempt { session_id: SessionId::random(), ..Attempt::default() };
        let answer = self.app.with_token(&self.ada.token).upload(&record(&attempt)).await;
        assert_eq!(answer.status, 201, "{}", answer.text());
        worker::work_off_jobs(&self.app.state).await.unwrap();
        attempt.session_id
    }
}

/// Consents, answers every question of the usability scale with one point, and sends.
async fn answer_sus(client: &mut Client, path: &str, point: &str) -> Answer {
    assert_eq!(send(client, path, &[("do", "begin"), ("consent", "yes"), ("lang", "en")]).await.status, 303);
    let page = client.get(path).await.text();
    let names: Vec<String> =
        page.split("name=\"q.").skip(1).map(|rest| format!("q.{}", rest.split('"').next().unwrap())).collect();
    let mut fields: Vec<(&str, &str)> = vec![("do", "send"), ("page", "0")];
    fields.extend(names.iter().map(|name| (name.as_str(), point)));
    fields.dedup();
    send(client, path, &fields).await
}

#[tokio::test]
async fn a_professional_answers_by_link_once_and_can_take_it_back() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let survey = school.survey(&mut teacher, "sus", &[("identity", "anonymous")]).await;
    let links = school.links(&mut teacher, &survey, "Dr A\nDr B\n").await;
    assert_eq!(links.len(), 2);
    let mut stranger = school.app.stranger();
    let first = stranger.get(&links[0]).await;
    assert!(first.text().contains("are anonymous") && first.text().contains("voluntary"), "{}", first.text());
    assert_eq!(first.header("set-cookie"), "", "an anonymous answer needs no cookie");
    let refused = send(&mut stranger, &links[0], &[("do", "begin"), ("lang", "en")]).await;
    assert_eq!(refused.status, 422, "without consent nothing begins");
    assert_eq!(led_to(&answer_sus(&mut stranger, &links[0], "3").await), links[0]);
    assert!(stranger.get(&links[0]).await.text().contains("have been sent"));
    let again = send(&mut stranger, &links[0], &[("do", "send"), ("page", "0")]).await;
    assert_eq!(again.status, 409, "{}", again.text());
    let results = teacher.get(&format!("{survey}/results")).await.text();
    assert!(results.contains("50.0") && results.contains("50\u{a0}%"), "{results}");
    assert_eq!(send(&mut stranger, &links[0], &[("do", "withdraw")]).await.status, 303);
    assert!(stranger.get(&links[0]).await.text().contains("are deleted"));
    assert!(teacher.get(&format!("{survey}/results")).await.text().contains("There are no answers yet"));
}

#[tokio::test]
async fn a_guessed_an_expired_and_a_closed_link_open_nothing() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let survey = school.survey(&mut teacher, "sus", &[("identity", "named")]).await;
    let links = school.links(&mut teacher, &survey, "Dr A").await;
    let mut stranger = school.app.stranger();
    for guess in ["/survey/0", "/survey/", &format!("{}0", links[0])] {
        assert!([404, 303].contains(&stranger.get(guess).await.status.as_u16()), "{guess}");
    }
    school.app.state.clock.advance(61 * 24 * 3600);
    let late = stranger.get(&links[0]).await;
    assert_eq!(late.status, 410);
    assert!(late.text().contains("expired"), "{}", late.text());
    let begun = send(&mut stranger, &links[0], &[("do", "begin"), ("consent", "yes")]).await;
    assert_eq!(begun.status, 410);
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let link = &school.links(&mut teacher, &survey, "Dr B").await[0];
    let csrf = csrf_in(&teacher.get(&survey).await.text());
    send(&mut teacher, &format!("{survey}/close"), &[("csrf", &csrf), ("closed", "true")]).await;
    assert_eq!(stranger.get(link).await.status, 410, "a closed survey takes no answers");
}

#[tokio::test]
async fn what_is_typed_survives_a_closed_tab_and_a_refusal() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let survey = school.survey(&mut teacher, "simulator-validity", &[("identity", "pseudonymous")]).await;
    let link = school.links(&mut teacher, &survey, "Dr A").await.remove(0);
    let mut stranger = school.app.stranger();
    send(&mut stranger, &link, &[("do", "begin"), ("consent", "yes"), ("lang", "de")]).await;
    let saved = send(&mut stranger, &link, &[("do", "save"), ("page", "0"), ("q.punctures", "more")]).await;
    assert_eq!(saved.status, 204);
    // Another browser, the same address: the answer is there, in the language of before.
    let again = school.app.stranger().get(&link).await.text();
    assert!(again.contains("value=\"more\" checked") && again.contains("<html lang=\"de\">"), "{again}");
    let next = led_to(&send(&mut stranger, &link, &[("do", "next"), ("page", "0"), ("q.punctures", "more")]).await);
    assert_eq!(next, format!("{link}?page=1"));
    let refused = send(&mut stranger, &link, &[("do", "next"), ("page", "1"), ("q.years", "<61>")]).await;
    assert_eq!(refused.status, 422);
    let page = refused.text();
    assert!(page.contains("&#60;61&#62;") && page.contains("eine Zahl von 0 bis 60\u{a0}years"), "{page}");
    assert!(!page.contains("<61>"));
    // Somebody without practice is not asked for years: the page is passed over, and what was said there is dropped.
    send(&mut stranger, &link, &[("do", "next"), ("page", "1"), ("q.years", "12,5")]).await;
    let next = led_to(&send(&mut stranger, &link, &[("do", "next"), ("page", "0"), ("q.punctures", "none")]).await);
    assert_eq!(next, format!("{link}?page=2"));
    let wrong = send(&mut stranger, &link, &[("do", "next"), ("page", "2"), ("q.pops", "6")]).await;
    assert_eq!(wrong.status, 422, "an answer out of range");
    let sent = send(&mut stranger, &link, &[("do", "send"), ("page", "5"), ("q.comment", "fine")]).await;
    assert_eq!(sent.status, 303);
    let csv = teacher.get(&format!("{survey}/results/answers-wide.csv")).await.text();
    assert!(csv.contains(",none,,") && !csv.contains("12.5"), "{csv}");
    // Four of six are needed for the realism: there is no score, and the page says so.
    let results = teacher.get(&format!("{survey}/results")).await.text();
    assert!(results.contains("data-label=\"Without\" class=\"num\">1"), "{results}");
}

#[tokio::test]
async fn overlong_comment_is_rejected_and_a_short_one_kept_verbatim() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let survey = school.survey(&mut teacher, "free-comment", &[("identity", "anonymous")]).await;
    let link = school.links(&mut teacher, &survey, "Dr A").await.remove(0);
    let mut stranger = school.app.stranger();
    send(&mut stranger, &link, &[("do", "begin"), ("consent", "yes")]).await;
    let long = "<i>ä</i>".repeat(1250);
    let refused = send(&mut stranger, &link, &[("do", "send"), ("page", "0"), ("q.good", &long)]).await;
    assert_eq!(refused.status, 422);
    let page = refused.text();
    assert!(
        page.contains("10000 characters; allowed: at most 4000 characters") && !page.contains("<i>"),
        "limit and markup"
    );
    assert!(page.contains("&#60;i&#62;ä"), "what was typed is still there");
    let formula = "=1+1 <script>alert(1)</script>";
    assert_eq!(send(&mut stranger, &link, &[("do", "send"), ("page", "0"), ("q.good", formula)]).await.status, 303);
    let results = teacher.get(&format!("{survey}/results")).await.text();
    assert!(results.contains("=1+1 &#60;script&#62;") && !results.contains("<script>alert"), "{results}");
    let csv = teacher.get(&format!("{survey}/results/answers-long.csv")).await.text();
    assert!(csv.contains("'=1+1 <script>"), "{csv}");
    let csrf = csrf_in(&results);
    let response = results.split("name=\"response\" value=\"").nth(1).unwrap().split('"').next().unwrap().to_owned();
    let fields = [("csrf", csrf.as_str()), ("response", &response), ("item", "good"), ("tag", "Praise"), ("do", "add")];
    assert_eq!(send(&mut teacher, &format!("{survey}/tags"), &fields).await.status, 303);
    assert!(teacher.get(&format!("{survey}/results")).await.text().contains("praise 1"));
}

#[tokio::test]
async fn what_is_asked_after_an_attempt_is_asked_while_it_is_fresh() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let fields = [("identity", "pseudonymous"), ("after_attempts", "true"), ("fresh", "24")];
    school.survey(&mut teacher, "nasa-tlx", &fields).await;
    let began = datetime!(2026-05-20 09:00 UTC);
    let attempt = Attempt { session_id: SessionId::random(), started_at: began, ..Attempt::default() };
    let token = school.ada.token.clone();
    assert_eq!(school.app.with_token(&token).upload(&record(&attempt)).await.status, 201);
    worker::work_off_jobs(&school.app.state).await.unwrap();
    let page = format!("/sessions/{}", attempt.session_id);
    let api = format!("/api/v1{page}/survey");
    let asked = school.app.signed_in("ada@example.org").await.get(&page).await.link("/surveys/");
    assert_eq!(school.app.with_token(&token).get(&api).await.json()["surveys"].as_array().unwrap().len(), 1);
    school.app.state.clock.advance(25 * 3600);
    let mut ada = school.app.signed_in("ada@example.org").await;
    assert!(!ada.get(&page).await.text().contains("/surveys/"), "nobody remembers a workload for weeks");
    assert_eq!(school.app.with_token(&token).get(&api).await.json()["surveys"], serde_json::json!([]));
    assert_eq!(ada.get(&asked).await.status, 404);
}

#[tokio::test]
async fn only_attempts_of_whoever_is_asked_are_counted() {
    let school = School::new().await;
    let bo = school.app.member(school.id, Role::Trainee, "bo@example.org").await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let cohort = school.cohort(&mut teacher).await;
    let fields = [("identity", "pseudonymous"), ("after_attempts", "true"), ("cohort", cohort.as_str())];
    let path = school.survey(&mut teacher, "sus", &fields).await;
    let id: SurveyId = path.rsplit('/').next().unwrap().parse().unwrap();
    let reader = school.app.state.db.reader();
    let survey = store::surveys::find(reader, school.id, id).await.unwrap().unwrap();
    let exercise = Attempt::default().bundle.exercise.id.clone();
    school
        .app
        .write(async |tx| {
            let asked =
                sqlx::query("INSERT INTO survey_exercises (school_id, survey_id, exercise_id) VALUES ($1, $2, $3)");
            asked.bind(school.id).bind(id).bind(exercise).execute(tx).await.unwrap();
        })
        .await;
    school.app.state.clock.advance(3600);
    for token in [&school.ada.token, &bo.token] {
        let started_at = datetime!(2026-05-20 09:40 UTC);
        let attempt = Attempt { session_id: SessionId::random(), started_at, ..Attempt::default() };
        assert_eq!(school.app.with_token(token).upload(&record(&attempt)).await.status, 201);
    }
    let counted = store::surveys::counts(reader, &survey, school.app.state.clock.now()).await.unwrap();
    assert_eq!(counted.attempts, 1, "Bo is in no cohort that is asked");
}

#[tokio::test]
async fn trainee_is_surveyed_once_per_attempt_and_skips_untraced() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let survey = school.survey(&mut teacher, "sus", &[("identity", "pseudonymous"), ("after_attempts", "true")]).await;
    let attempt = school.upload().await;
    let mut ada = school.app.signed_in("ada@example.org").await;
    let asked = ada.get(&format!("/sessions/{attempt}")).await.link("/surveys/");
    assert_eq!(asked, format!("{survey}?session={attempt}"));
    let api = format!("/api/v1/sessions/{attempt}/survey");
    let station = school.app.station(school.id).await;
    for token in [&school.ada.token, &station] {
        assert_eq!(school.app.with_token(token).get(&api).await.json()["surveys"][0]["path"], asked.as_str());
    }
    assert!(!teacher.get(&format!("/sessions/{attempt}")).await.text().contains("How was it?"), "only their own");
    let audit = async || {
        let sql = "SELECT count(*) FROM audit_log WHERE action LIKE 'survey.%'";
        sqlx::query_scalar::<_, i64>(sql).fetch_one(school.app.state.db.reader()).await.unwrap()
    };
    let before = audit().await;
    let session = attempt.to_string();
    let begin = async |ada: &mut Client| {
        let csrf = csrf_in(&ada.get(&asked).await.text());
        let fields = [("csrf", csrf.as_str()), ("session", &session), ("consent", "yes"), ("lang", "en")];
        led_to(&send(ada, &format!("{survey}/answer"), &fields).await)
    };
    let skipped = begin(&mut ada).await;
    assert!(send(&mut ada, &skipped, &[("do", "discard")]).await.text().contains("No answers were sent"));
    let left: i64 = sqlx::query_scalar("SELECT count(*) FROM survey_responses")
        .fetch_one(school.app.state.db.reader())
        .await
        .unwrap();
    assert_eq!((left, audit().await), (0, before), "skipping leaves no trace");
    let path = begin(&mut ada).await;
    let page = ada.get(&path).await.text();
    let names: Vec<String> =
        page.split("name=\"q.").skip(1).map(|r| format!("q.{}", r.split('"').next().unwrap())).collect();
    let mut fields: Vec<(&str, &str)> = vec![("do", "send"), ("page", "0")];
    fields.extend(names.iter().map(|name| (name.as_str(), "3")));
    assert_eq!(send(&mut ada, &path, &fields).await.status, 303);
    assert_eq!(audit().await, before + 1);
    assert!(!ada.get(&format!("/sessions/{attempt}")).await.text().contains("How was it?"), "once for an attempt");
    assert_eq!(school.app.with_token(&school.ada.token).get(&api).await.json()["surveys"], serde_json::json!([]));
    let csv = teacher.get(&format!("{survey}/results/answers-wide.csv")).await.text();
    assert!(csv.contains(&school.ada.person.pseudonym) && csv.contains("50"), "{csv}");
    assert!(!csv.contains("Somebody"), "a pseudonymous answer carries no name");
}

#[tokio::test]
async fn an_anonymous_answer_of_a_signed_in_person_leads_to_nobody() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let cohort = school.cohort(&mut teacher).await;
    let survey = school.survey(&mut teacher, "sus", &[("identity", "anonymous"), ("cohort", &cohort)]).await;
    let mut ada = school.app.signed_in("ada@example.org").await;
    assert_eq!(ada.get("/surveys").await.link("/surveys/"), survey);
    let csrf = csrf_in(&ada.get(&survey).await.text());
    let begun =
        send(&mut ada, &format!("{survey}/answer"), &[("csrf", &csrf), ("consent", "yes"), ("lang", "en")]).await;
    let path = led_to(&begun);
    assert_eq!(send(&mut ada, &path, &[("do", "send"), ("page", "0"), ("q.easy", "4")]).await.status, 303);
    let row: (Option<Vec<u8>>, Option<Vec<u8>>, i64) =
        sqlx::query_as("SELECT person_id, session_id, submitted_at % 86400000000 FROM survey_responses")
            .fetch_one(school.app.state.db.reader())
            .await
            .unwrap();
    assert_eq!(row, (None, None, 0), "neither person nor attempt nor hour");
    let told: String = sqlx::query_scalar("SELECT actor FROM audit_log WHERE action = 'survey.answered'")
        .fetch_one(school.app.state.db.reader())
        .await
        .unwrap();
    assert_eq!(told, "respondent");
    let second = send(&mut ada, &format!("{survey}/answer"), &[("csrf", &csrf), ("consent", "yes")]).await;
    assert_eq!(second.status, 409, "once");
    assert_eq!(send(&mut ada, &path, &[("do", "withdraw")]).await.status, 303, "by the address of the last page");
}

#[tokio::test]
async fn groups_under_five_are_for_the_owner_only() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let survey = school.survey(&mut teacher, "sus", &[("identity", "anonymous")]).await;
    let labels: String = (0..5).map(|n| format!("Dr {n}\n")).collect();
    let links = school.links(&mut teacher, &survey, &labels).await;
    for link in &links[..4] {
        answer_sus(&mut school.app.stranger(), link, "3").await;
    }
    let mut other = school.app.signed_in("other@example.org").await;
    let results = format!("{survey}/results");
    assert!(teacher.get(&results).await.text().contains("50.0"));
    let hidden = other.get(&results).await.text();
    assert!(hidden.contains("4 answers in groups of fewer than five") && !hidden.contains("50.0"), "{hidden}");
    let json = other.get(&format!("{results}/results.json")).await.json();
    assert_eq!(
        (&json["results"]["hidden"], &json["results"]["scores"][0]["groups"]),
        (&4.into(), &serde_json::json!([]))
    );
    assert_eq!(other.get(&format!("{results}/answers-wide.csv")).await.status, 403);
    assert_eq!(other.get(&format!("{results}/codebook.csv")).await.status, 200);
    answer_sus(&mut school.app.stranger(), &links[4], "3").await;
    assert!(other.get(&results).await.text().contains("50.0"), "five may be shown");
    let csrf = csrf_in(&other.get(&survey).await.text());
    assert_eq!(send(&mut other, &format!("{survey}/links"), &[("csrf", &csrf), ("labels", "x")]).await.status, 403);
    assert_eq!(send(&mut other, &format!("{survey}/close"), &[("csrf", &csrf), ("closed", "true")]).await.status, 403);
}

#[tokio::test]
async fn surveys_of_another_school_and_of_nobody_are_not_there() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let survey = school.survey(&mut teacher, "sus", &[("identity", "named")]).await;
    let south = school.app.school("South").await;
    school.app.member(south, Role::Administrator, "head@south.example").await;
    let mut abroad = school.app.signed_in("head@south.example").await;
    let mut ada = school.app.signed_in("ada@example.org").await;
    for client in [&mut abroad, &mut ada] {
        for path in [survey.clone(), format!("{survey}/results"), format!("{survey}/results/results.json")] {
            assert_eq!(client.get(&path).await.status, 404, "{path}");
        }
    }
    assert_eq!(abroad.get("/surveys/instruments/sus").await.status, 404);
    assert_eq!(ada.get("/surveys/new").await.status, 403);
    assert_eq!(teacher.get("/surveys/x").await.status, 404);
}

#[tokio::test]
async fn edited_instrument_is_a_revision_and_old_answers_keep_theirs() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let survey = school.survey(&mut teacher, "sus", &[("identity", "anonymous")]).await;
    let link = school.links(&mut teacher, &survey, "Dr A").await.remove(0);
    answer_sus(&mut school.app.stranger(), &link, "3").await;
    let edit = "/surveys/instruments/sus/edit";
    let csrf = csrf_in(&teacher.get(edit).await.text());
    let old = teacher.get("/surveys/instruments/sus/document.toml").await.text();
    let wrong = old.replace("points = 5", "points = 50");
    let refused = send(&mut teacher, edit, &[("csrf", &csrf), ("text", &wrong), ("do", "publish")]).await;
    assert_eq!(refused.status, 422);
    assert!(refused.text().contains("scale[0].points: 50; allowed: a whole number from 2 to 11"), "{}", refused.text());
    let new = old.replace("points = 5", "points = 7");
    let preview = send(&mut teacher, edit, &[("csrf", &csrf), ("text", &new), ("do", "preview")]).await;
    assert!(preview.text().contains("1 – 7"), "{}", preview.text());
    assert_eq!(teacher.get("/surveys/instruments/sus/document.toml").await.text(), old, "a preview publishes nothing");
    let other = old.replace("id = \"sus\"\ntitle", "id = \"other\"\ntitle");
    let moved = send(&mut teacher, edit, &[("csrf", &csrf), ("text", &other), ("do", "publish")]).await;
    assert!(moved.status == 422 && moved.text().contains("keeps its id"), "{}", moved.text());
    assert_eq!(send(&mut teacher, edit, &[("csrf", &csrf), ("text", &new), ("do", "publish")]).await.status, 303);
    assert_eq!(teacher.get("/surveys/instruments/sus/document.toml").await.text(), new);
    assert!(
        teacher.get(&format!("{survey}/results")).await.text().contains("50.0"),
        "scored by the key it was given to"
    );
}

#[tokio::test]
async fn an_instrument_leaves_as_json_and_comes_back() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let json = teacher.get("/surveys/instruments/nasa-tlx/document.json").await.text();
    let csrf = csrf_in(&teacher.get("/surveys/instruments/new").await.text());
    let again = [("csrf", csrf.as_str()), ("text", &json), ("do", "publish")];
    let refused = send(&mut teacher, "/surveys/instruments/new", &again).await;
    assert!(refused.status == 422 && refused.text().contains("edit that questionnaire"), "{}", refused.text());
    let renamed = json.replace("\"nasa-tlx\"", "\"my-tlx\"");
    let fields = [("csrf", csrf.as_str()), ("text", &renamed), ("do", "publish")];
    assert_eq!(led_to(&send(&mut teacher, "/surveys/instruments/new", &fields).await), "/surveys/instruments/my-tlx");
    let back = teacher.get("/surveys/instruments/my-tlx/document.json").await.json();
    assert_eq!(back["item"], serde_json::from_str::<serde_json::Value>(&json).unwrap()["item"]);
    let broken =
        send(&mut teacher, "/surveys/instruments/new", &[("csrf", &csrf), ("text", "{\"id\": }"), ("do", "publish")])
            .await;
    assert!(broken.status == 422 && broken.text().contains("line 1, column 8"), "{}", broken.text());
}

#[tokio::test]
async fn invalid_survey_is_rejected_and_keeps_the_input() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let csrf = csrf_in(&teacher.get("/surveys/new").await.text());
    let elsewhere = CohortId::random().to_string();
    for (key, value, says) in [
        ("title", " ", "title: 0 characters; allowed: 1 to 200"),
        ("identity", "secret", "allowed: anonymous, pseudonymous, named"),
        ("instrument", "none", "does not exist"),
        ("closes", "2026-05-19", "allowed: today or later"),
        ("opens", "tomorrow", "allowed: a day like 2026-05-20"),
        ("cohort", &elsewhere, "the cohorts you teach"),
    ] {
        let mut fields =
            vec![("csrf", csrf.as_str()), ("instrument", "sus"), ("title", "Kept title"), ("identity", "named")];
        fields.retain(|(name, _)| *name != key);
        fields.push((key, value));
        let refused = send(&mut teacher, "/surveys/new", &fields).await;
        assert_eq!(refused.status, 422, "{key}");
        assert!(refused.text().contains(says), "{says}: {}", refused.text());
        assert!(key == "title" || refused.text().contains("Kept title"));
    }
}

#[tokio::test]
async fn instruments_are_listed_in_the_readers_language() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    assert!(teacher.get("/surveys/instruments").await.text().contains(">System Usability Scale<"));
    let csrf = csrf_in(&teacher.get("/account").await.text());
    send(&mut teacher, "/account/language", &[("csrf", &csrf), ("language", "de")]).await;
    for page in ["/surveys/instruments", "/surveys/new", "/studies/new"] {
        let page = teacher.get(page).await.text();
        assert!(page.contains("Skala der Gebrauchstauglichkeit (SUS)"), "{page}");
    }
}
