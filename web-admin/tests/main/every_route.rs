//! Every route, tried by everybody. The table `every_route.txt` has a line for each method of each path and says what
//! each kind of visitor is answered. Fails when somebody is let in who should not be, or kept out who should not be, and
//! when a route has no line: the list of routes is the router's own.
//!
//! # How to add a line
//!
//! `METHOD /path/{object} | out own same other teacher colleague admin abroad station | what is sent`
//!
//! The columns, all of the school North but one:
//! - `out`: nobody, and somebody disabled with a session and a token of better days (both are tried)
//! - `own`: the trainee whose attempt, page and upload are meant; in cohort A
//! - `same`: another trainee of cohort A; `other`: a trainee of cohort B
//! - `teacher`: teaches cohort A; `colleague`: teaches cohort B
//! - `admin`: administrator; `abroad`: administrator of the school South
//! - `station`: a training station; only on the API, `-` elsewhere
//!
//! Each is a status, several separated by `/`, or `-` for "not tried". The objects that a path or what is sent may name are made in
//! [`World::new`]: `{session}`, `{trainee}`, `{cohort}`, …; add yours there. What is sent is a form (its CSRF token is
//! added) or, beginning with `{`, JSON. Every line is tried on a copy of the database that nobody has changed: where a try has, the next gets a new one.
//! To see what the service answers now: leave the columns at `-`, run, and read the message; then judge whether it is right.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use acts::authoring::drafting;
use acts::authoring::instruments::publish;
use acts::people::roster_import;
use acts::recordings::uploads;
use acts::recordings::uploads::Announced;
use acts::scoring::exam_files;
use acts::scoring::exam_files::ExamWords;
use acts::scoring::regrading::exercise as regrading;
use acts::surveys;
use acts::training::{assignments, outcomes};
use axum::body::Body;
use axum::http::{Method, Request, header};
use documents::ExerciseBundle;
use model::ids::{CohortId, SessionId};
use model::people::roster::RosterRequest;
use model::surveys::Identity;
use model::training::assignment::AssignmentTask;
use model::training::comment::{Comment, CommentKind};
use model::training::outcome::OutcomeText;
use model::{Role, SessionKey};
use platform::clock::Clock;
use sqlx::pool::PoolConnection;
use store::authoring::{exercises, pictures};
use store::recordings::sessions;
use store::recordings::uploads::UploadOwner;
use store::scoring::{exams, ratings, segments};
use store::surveys::instruments;
use store::training::assignments::NewAssignment;
use store::training::cohorts::MembershipKey;
use store::training::{cohorts, comments, reports};
use store::{people, stations, surveys as stored};
use tempfile::TempDir;
use web_admin::{routes, worker};

use crate::support::client::{Client, csrf_in};
use crate::support::database::{copy_database, version};
use crate::support::recordings::{Attempt, record};
use crate::support::university::{DIRECTORY, add_systems};
use crate::support::{App, Member, course_folder};

const TABLE: &str = include_str!("every_route.txt");
const COLUMNS: [&str; 9] = ["out", "own", "same", "other", "teacher", "colleague", "admin", "abroad", "station"];

/// A line of the table.
pub(super) struct Row {
    pub method: Method,
    pub path: &'static str,
    pub expected: Vec<(&'static str, &'static str)>,
    pub sent: &'static str,
}

pub(super) fn rows() -> Vec<Row> {
    let lines = TABLE.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
    lines.map(|line| row(line).unwrap_or_else(|| panic!("not a line of the table: {line}"))).collect()
}

fn row(line: &'static str) -> Option<Row> {
    let mut parts = line.splitn(3, '|').map(str::trim);
    let (method, path) = parts.next()?.split_once(char::is_whitespace)?;
    let statuses: Vec<_> = parts.next()?.split_whitespace().collect();
    (statuses.len() == COLUMNS.len()).then(|| Row {
        method: method.parse().unwrap(),
        path: path.trim(),
        expected: COLUMNS.into_iter().zip(statuses).filter(|(_, status)| *status != "-").collect(),
        sent: parts.next().unwrap_or_default(),
    })
}

/// A path without the names of its parameters.
fn shape(path: &str) -> String {
    let part = |part: &str| if part.starts_with('{') { "{}".to_owned() } else { part.to_owned() };
    path.split('/').map(part).collect::<Vec<_>>().join("/")
}

/// A visitor: what their requests carry.
#[derive(Clone)]
pub(super) struct Visitor {
    pub column: &'static str,
    pub cookie: Option<String>,
    pub csrf: String,
    pub token: Option<String>,
}

/// Two schools, closed: every try opens a copy.
pub(super) struct World {
    folder: TempDir,
    pub visitors: Vec<Visitor>,
    objects: BTreeMap<&'static str, String>,
}

impl World {
    pub(super) async fn new() -> Self {
        let app = App::new().await;
        let (north, south) = (app.school("North").await, app.school("South").await);
        let member = async |role, name: &str| app.member(north, role, &format!("{name}@north.example")).await;
        let own = member(Role::Trainee, "own").await;
        let same = member(Role::Trainee, "same").await;
        let other = member(Role::Trainee, "other").await;
        let gone = member(Role::Trainee, "gone").await;
        let teacher = member(Role::Instructor, "teacher").await;
        let colleague = member(Role::Instructor, "colleague").await;
        let admin = member(Role::Administrator, "admin").await;
        let abroad = app.member(south, Role::Administrator, "abroad@south.example").await;
        app.cohort(north, "A", &[&own.person, &same.person, &gone.person, &teacher.person]).await;
        app.cohort(north, "B", &[&other.person, &colleague.person]).await;
        app.publish(north).await;
        let attempt = Attempt::default();
        assert_eq!(app.with_token(&own.token).upload(&record(&attempt)).await.status, 201);
        worker::work_off_jobs(&app.state).await.unwrap();

        let station = app.station(north).await;
        let now = app.state.clock.now();
        let members = [
            ("out", &gone),
            ("own", &own),
            ("same", &same),
            ("other", &other),
            ("teacher", &teacher),
            ("admin", &admin),
        ];
        let mut visitors = vec![stranger("out")];
        for (column, member) in members.into_iter().chain([("colleague", &colleague), ("abroad", &abroad)]) {
            visitors.push(signed_in(&app, column, member).await);
        }
        visitors.push(Visitor { token: Some(station), ..stranger("station") });
        app.write(async |tx| people::disable_person(tx, gone.person.id, now).await.unwrap()).await;

        let objects = objects(&app, [&own, &other, &teacher, &colleague, &admin], attempt.session_id).await;
        app.state.db.close().await;
        Self { folder: app.folder, visitors, objects }
    }

    /// The service on a copy.
    pub(super) async fn open(&self) -> App {
        let folder = tempfile::tempdir().unwrap();
        copy(self.folder.path(), folder.path());
        copy_database(self.folder.path(), folder.path());
        App::in_folder(folder, Clock::system(), |_| {}).await
    }

    pub(super) fn filled(&self, text: &str) -> String {
        self.objects.iter().fold(text.to_owned(), |text, (name, value)| text.replace(&format!("{{{name}}}"), value))
    }

    async fn answer(&self, app: &App, visitor: &Visitor, row: &Row) -> u16 {
        let mut client = Client::new(app.router.clone());
        let api = row.path.starts_with("/api/");
        client.cookie = visitor.cookie.clone().filter(|_| !api);
        client.token = visitor.token.clone().filter(|_| api);
        let sent = self.filled(row.sent);
        let (kind, sent) = match sent.starts_with('{') || api {
            true => ("application/json", sent),
            false => ("application/x-www-form-urlencoded", format!("csrf={}&{sent}", visitor.csrf)),
        };
        let request = Request::builder().method(row.method.clone()).uri(self.filled(row.path));
        let request = request.header(header::CONTENT_TYPE, kind).header("tus-resumable", "1.0.0");
        let body = if row.method == Method::GET { Body::empty() } else { Body::from(sent) };
        client.send(request.body(body).unwrap()).await.status.as_u16()
    }
}

/// The service on a copy, and a connection that notices when the copy is changed.
struct Copy {
    app: App,
    watch: PoolConnection<store::Engine>,
    version: String,
}

impl Copy {
    async fn of(world: &World) -> Self {
        let app = world.open().await;
        let mut watch = app.state.db.reader().acquire().await.unwrap();
        let version = version(&mut watch).await;
        Self { app, watch, version }
    }

    async fn is_changed(&mut self) -> bool {
        version(&mut self.watch).await != self.version
    }
}

/// A survey of a teacher for a cohort, with a link, and what else its addresses name.
async fn survey(app: &App, teacher: &Member, cohort: CohortId) -> [(&'static str, String); 6] {
    let (school, now) = (teacher.person.school_id, app.state.clock.now());
    let document = course_folder().with_file_name("instruments").join("sus.toml");
    app.write(async |tx| publish(tx, school, &document, now).await.unwrap()).await;
    let revision = instruments::find_current_instrument(app.state.db.reader(), school, "sus").await.unwrap().unwrap();
    let wanted = surveys::SurveyRequest {
        revision_id: revision.id,
        title: "Survey".to_owned(),
        identity: Identity::Named,
        after_attempts: false,
        fresh_hours: None,
        generated: false,
        opens_at: now,
        closes_at: None,
        cohorts: vec![cohort],
    };
    let owner = teacher.person.clone().into_current().unwrap();
    let id = surveys::make(&app.state, &owner, &wanted).await.unwrap();
    let survey = stored::find(app.state.db.reader(), school, id).await.unwrap().unwrap();
    let links = surveys::make_links(&app.state, &owner, &survey, &["Dr A".to_owned()]).await.unwrap();
    let questionnaire = drafting::open_instrument(&app.state, &owner, "sus").await.unwrap();
    [
        ("questionnaire", questionnaire.to_string()),
        ("survey", id.to_string()),
        ("link", links[0].token.clone()),
        ("instrument", "sus".to_owned()),
        ("document", "document.toml".to_owned()),
        ("export", "results.json".to_owned()),
    ]
}

/// A round of ratings that a teacher asks of themselves and of a colleague, and the colleague's rating.
async fn round(app: &App, [teacher, colleague]: [&Member; 2], session: SessionId) -> [(&'static str, String); 2] {
    let (school, reader) = (teacher.person.school_id, app.state.db.reader());
    let revision = instruments::find_current_instrument(reader, school, "sus").await.unwrap().unwrap();
    let new = ratings::NewRound {
        revision_id: revision.id,
        title: "Round".to_owned(),
        generated: false,
        sessions: vec![session],
        raters: vec![teacher.person.id, colleague.person.id],
    };
    let by = teacher.person.clone().into_current().unwrap();
    let round = acts::scoring::ratings::make(&app.state, &by, &new).await.unwrap();
    let rater = colleague.person.clone().into_current().unwrap();
    let own = ratings::own(reader, &rater, round).await.unwrap();
    [("round", round.to_string()), ("rating", own[0].id.to_string())]
}

/// An exam of a teacher's cohort, with the sitting of a trainee.
async fn exam(app: &App, [own, teacher, colleague]: [&Member; 3], cohort_id: CohortId) -> [(&'static str, String); 1] {
    let (school, reader) = (teacher.person.school_id, app.state.db.reader());
    let revision = instruments::find_current_instrument(reader, school, "sus").await.unwrap().unwrap();
    let new = exams::NewExam {
        title: "Station".to_owned(),
        cohort_id,
        exercise_id: "feel-the-layers".to_owned(),
        revision_id: revision.id,
        limit_min: 10,
        second_rater_id: Some(colleague.person.id),
    };
    let by = teacher.person.clone().into_current().unwrap();
    let id = acts::scoring::exams::make(&app.state, &by, &new).await.unwrap();
    let exam = acts::scoring::exams::find(&app.state, &by, id).await.unwrap();
    acts::scoring::exams::begin(&app.state, &by, &exam, own.person.id).await.unwrap();
    [("exam", id.to_string())]
}

/// A task to mark pops for a cohort, and its trace.
async fn task(app: &App, teacher: &Member, cohort_id: CohortId, session: SessionId) -> [(&'static str, String); 2] {
    let by = teacher.person.clone().into_current().unwrap();
    let new = segments::NewTask {
        title: "Pops".to_owned(),
        cohort_id,
        due: None,
        time_zone: "UTC".to_owned(),
        sessions: vec![session],
    };
    let task = acts::scoring::segments::make(&app.state, &by, &new).await.unwrap();
    let traces = segments::list_traces(app.state.db.reader(), by.school_id, task).await.unwrap();
    [("task", task.to_string()), ("trace", traces[0].id.to_string())]
}

/// A teacher's look at what a revision's rubric would change, and the revision.
async fn regraded(app: &App, teacher: &Member) -> [(&'static str, String); 2] {
    let by = teacher.person.clone().into_current().unwrap();
    let revision = exercises::find_current_revision(app.state.db.reader(), by.school_id, "feel-the-layers")
        .await
        .unwrap()
        .unwrap();
    let look = regrading::look(&app.state, &by, "feel-the-layers", revision.id).await.unwrap();
    worker::work_off_jobs(&app.state).await.unwrap();
    [("regrading", look.to_string()), ("revision", revision.id.to_string())]
}

async fn exam_file(app: &App, admin: &Member, key: SessionKey) -> [(&'static str, String); 1] {
    let by = admin.person.clone().into_current().unwrap();
    let attempt = sessions::find_session(app.state.db.reader(), key.school_id, key.id).await.unwrap().unwrap();
    let words = ExamWords { rule: |_| String::new(), needed: |_| "" };
    let made = exam_files::freeze_attempt(&app.state, &by, &attempt, words).await.unwrap();
    [("exam_file", made.to_string())]
}

/// What paths and forms may name, made by a trainee, another who is asked for, their teacher, a colleague and the administrator.
async fn objects(
    app: &App,
    [own, other, teacher, colleague, admin]: [&Member; 5],
    session: SessionId,
) -> BTreeMap<&'static str, String> {
    let (north, now) = (own.person.school_id, app.state.clock.now());
    let reader = app.state.db.reader();
    let known = reports::cohorts(reader, &admin.person.clone().into_current().unwrap()).await.unwrap();
    let asked = MembershipKey { school_id: north, cohort_id: known[0].id, person_id: other.person.id };
    app.write(async |tx| cohorts::ask_for_member(tx, asked, teacher.person.id, now).await.unwrap()).await;
    let owner = UploadOwner { school_id: north, person_id: Some(own.person.id), station_id: None };
    let announced = Announced { length: 10, metadata: String::new(), ahead_us: None };
    let upload = uploads::begin(&app.state, owner, announced).await.unwrap();
    let writer = teacher.person.clone().into_current().unwrap();
    let draft = drafting::open_exercise(&app.state, &writer, "stop-in-the-fat").await.unwrap();
    let shipped = ExerciseBundle::read(&course_folder().join("6-avoid-the-vessel.toml")).unwrap().pictures.remove(0);
    app.write(async |tx| pictures::add_draft_picture(tx, draft, &shipped).await.unwrap()).await;
    let said = Comment { kind: CommentKind::Question, from_s: 0.1, to_s: None, body: "Why?".to_owned() };
    let key = SessionKey { school_id: north, id: session };
    let comment = app.write(async |tx| comments::add_comment(tx, key, own.person.id, &said, now).await.unwrap()).await;
    let file = "email,name\nnew@north.example,New\n".as_bytes();
    let by = admin.person.clone().into_current().unwrap();
    let roster = roster_import::keep(&app.state, &by, "roster.csv", file, &RosterRequest::default()).await.unwrap();
    let new = NewAssignment {
        since_only: false,
        task: AssignmentTask::Exercise("feel-the-layers".to_owned()),
        cohort_id: Some(known[0].id),
        person_id: None,
        supervised: false,
        attempt_limit: None,
        due: Some(("2126-11-30T18:00:00".to_owned(), now.plus_s(86_400))),
        time_zone: "UTC".to_owned(),
    };
    let assignment = assignments::make(&app.state, &by, &new).await.unwrap();
    let text = OutcomeText { code: "EPA 1".to_owned(), title: "Puncture".to_owned(), ..OutcomeText::default() };
    let outcome = outcomes::add_outcome(&app.state, &by, text).await.unwrap();
    acts::training::terms::add_term(&app.state, &by, "Term", "2026-10-12").await.unwrap();
    let term = store::training::terms::list_terms(reader, north).await.unwrap()[0].id;
    let objects = BTreeMap::from([
        ("outcome", outcome.to_string()),
        ("term", term.to_string()),
        ("draft", draft.to_string()),
        ("pictured", "avoid-the-vessel".to_owned()),
        ("picture", shipped.name),
        ("number", "1".to_owned()),
        ("list", "0".to_owned()),
        ("course", "lower-back-basics".to_owned()),
        ("comment", comment.to_string()),
        ("unknown", "nobody-was-given-this".to_owned()),
        ("file", "x.mcap".to_owned()),
        ("session", session.to_string()),
        ("trainee", own.person.id.to_string()),
        ("cohort", known[0].id.to_string()),
        ("asked", other.person.id.to_string()),
        ("exercise", "feel-the-layers".to_owned()),
        ("upload", upload.id.to_string()),
        ("station", stations::list_stations(reader, north).await.unwrap()[0].id.to_string()),
        ("asset", "style.css".to_owned()),
        ("join", "nobodys-token".to_owned()),
        ("roster", roster.to_string()),
        ("assignment", assignment.to_string()),
    ]);
    let exam_file = exam_file(app, admin, key).await;
    let survey = survey(app, teacher, known[0].id).await;
    let rated = round(app, [teacher, colleague], session).await;
    let task = task(app, teacher, known[0].id, session).await;
    let exam = exam(app, [own, teacher, colleague], known[0].id).await;
    let regraded = regraded(app, teacher).await;
    let ways = add_systems(app, own, teacher).await;
    let objects = objects.into_iter().chain(exam_file).chain(survey).chain(rated).chain(task);
    objects.chain(exam).chain(regraded).chain(ways).collect()
}

fn stranger(column: &'static str) -> Visitor {
    Visitor { column, cookie: None, csrf: String::new(), token: None }
}

async fn signed_in(app: &App, column: &'static str, member: &Member) -> Visitor {
    let mut client = app.signed_in(&member.person.email).await;
    let csrf = csrf_in(&client.get("/").await.text());
    Visitor { column, cookie: client.cookie, csrf, token: Some(member.token.clone()) }
}

fn copy(from: &Path, to: &Path) {
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            std::fs::create_dir_all(&target).unwrap();
            copy(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// Tries every row of a kind, and tells all that is answered otherwise than the table says.
async fn every(kind: impl Fn(&Row) -> bool) {
    let world = World::new().await;
    let mut copy = Copy::of(&world).await;
    let mut wrong = Vec::new();
    for row in rows().into_iter().filter(|row| kind(row)) {
        for visitor in &world.visitors {
            let expected = row.expected.iter().find(|(column, _)| *column == visitor.column);
            let Some((_, expected)) = expected else { continue };
            let answer = world.answer(&copy.app, visitor, &row).await;
            if copy.is_changed().await {
                copy = Copy::of(&world).await;
            }
            if !expected.split('/').any(|status| answer.to_string() == status) {
                wrong.push(format!("{} {} {}: {answer}, not {expected}", row.method, row.path, visitor.column));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[tokio::test]
async fn everybody_is_shown_what_is_theirs_and_nothing_else() {
    every(|row| row.method == Method::GET).await;
}

#[tokio::test]
async fn everybody_changes_what_is_theirs_and_nothing_else() {
    every(|row| row.method != Method::GET && !row.path.starts_with("/api/")).await;
}

#[tokio::test]
async fn every_program_changes_what_is_its_own_and_nothing_else() {
    every(|row| row.method != Method::GET && row.path.starts_with("/api/")).await;
}

#[tokio::test]
async fn every_route_has_its_line() {
    let world = World::new().await;
    let app = world.open().await;
    let admin = world.visitors.iter().find(|visitor| visitor.column == "admin").unwrap();
    let listed: BTreeSet<String> = rows().iter().map(|row| format!("{} {}", row.method, shape(row.path))).collect();
    let mut served = BTreeSet::new();
    for path in routes::all_routes(&app.state).paths() {
        // A method that no route has: the answer names those that it has.
        let probe = Row { method: Method::TRACE, path: Box::leak(path.into_boxed_str()), expected: vec![], sent: "" };
        let mut client = Client::new(app.router.clone());
        client.cookie.clone_from(&admin.cookie);
        client.token = match probe.path.starts_with("/scim/") {
            true => Some(DIRECTORY.to_owned()),
            false => admin.token.clone(),
        };
        let concrete = probe.path.replace(['{', '}'], "");
        let request = Request::builder().method(probe.method).uri(concrete).header("tus-resumable", "1.0.0");
        let answer = client.send(request.body(Body::empty()).unwrap()).await;
        assert_eq!(answer.status, 405, "{}", probe.path);
        let allowed = answer.header("allow").split(',').map(|method| method.trim().to_owned());
        served
            .extend(allowed.filter(|method| method != "HEAD").map(|method| format!("{method} {}", shape(probe.path))));
    }
    assert!(served.len() > 20, "{served:?}");
    let missing: Vec<_> = served.difference(&listed).collect();
    assert!(missing.is_empty(), "routes without a line in every_route.txt: {missing:#?}");
    let gone: Vec<_> = listed.difference(&served).filter(|line| !line.starts_with("HEAD")).collect();
    assert!(gone.is_empty(), "lines in every_route.txt without a route: {gone:#?}");
}

#[test]
fn no_route_escapes_the_list() {
    let mut open: Vec<_> =
        ["src/routes", "routes"].map(|folder| Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)).into();
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if !path.ends_with("listed.rs") {
                let source = std::fs::read_to_string(&path).unwrap();
                assert!(!source.contains("Router::new("), "{}: use Routes::new()", path.display());
            }
        }
    }
}
