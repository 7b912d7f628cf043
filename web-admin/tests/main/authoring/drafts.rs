//! Documents written in the browser. Fails when a draft reaches trainees before it is published, when publishing changes an
//! attempt already made, when one person's text is lost to another's, when a wrong document is published, or when somebody
//! writes who may not.

use model::Role;
use web_admin::worker;

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::recordings::{Attempt, record};
use crate::support::{App, Member};

const EXERCISE: &str = "feel-the-layers";

/// A school with the shipped course, a trainee and two instructors.
struct School {
    app: App,
    trainee: Member,
}

impl School {
    async fn new() -> Self {
        let app = App::new().await;
        let school = app.school("North").await;
        app.publish(school).await;
        let trainee = app.member(school, Role::Trainee, "ada@example.org").await;
        for email in ["osei@example.org", "bell@example.org"] {
            app.member(school, Role::Instructor, email).await;
        }
        Self { app, trainee }
    }

    /// An instructor who has opened the draft of a document: the draft's page.
    async fn opens(&self, email: &str, document: &str) -> Writer {
        let mut client = self.app.signed_in(email).await;
        let csrf = csrf_in(&client.get("/curricula").await.text());
        let begun = client.form(&format!("{document}/draft"), &[("csrf", &csrf)]).await;
        assert_eq!(begun.status, 303, "{}", begun.text());
        Writer::at(client, begun.header("location").to_owned()).await
    }
}

/// Somebody at a draft's page.
struct Writer {
    client: Client,
    draft: String,
    csrf: String,
    seen: String,
    document: String,
    scene: String,
}

impl Writer {
    async fn at(mut client: Client, draft: String) -> Self {
        let page = client.get(&draft).await;
        assert_eq!(page.status, 200, "{}", page.text());
        let page = page.text();
        let (document, scene) = (area(&page, "document").expect("a document"), area(&page, "scene"));
        Self { client, draft, csrf: csrf_in(&page), seen: seen_in(&page), document, scene: scene.unwrap_or_default() }
    }

    async fn act(&mut self, act: &str) -> Answer {
        let fields = [
            ("csrf", self.csrf.as_str()),
            ("seen", &self.seen),
            ("document", &self.document.replace('\n', "\r\n")),
            ("scene", &self.scene.replace('\n', "\r\n")),
            ("act", act),
        ];
        let answer = self.client.form(&self.draft, &fields).await;
        if answer.status != 303 {
            self.seen = seen_in(&answer.text());
        }
        answer
    }

    fn replace(&mut self, from: &str, to: &str) {
        assert!(self.document.contains(from), "{}", self.document);
        self.document = self.document.replace(from, to);
    }
}

fn seen_in(page: &str) -> String {
    page.split("name=\"seen\" value=\"").nth(1).and_then(|rest| rest.split('"').next()).expect("a version").to_owned()
}

/// What stands in a text area.
fn area(page: &str, name: &str) -> Option<String> {
    let rest = page.split(&format!("name=\"{name}\"")).nth(1)?.split_once('>')?.1;
    let text = rest.split("</textarea>").next()?.strip_prefix('\n')?;
    let unescaped = [("&#34;", "\""), ("&#39;", "'"), ("&lt;", "<"), ("&gt;", ">"), ("&#60;", "<"), ("&#62;", ">")];
    let text = unescaped.iter().fold(text.to_owned(), |text, (code, sign)| text.replace(code, sign));
    Some(text.replace("&#38;", "&").replace("&amp;", "&"))
}

#[tokio::test]
async fn draft_is_private_until_published_and_attempts_keep_revision() {
    let school = School::new().await;
    let attempt = Attempt::default();
    let mut trainee = school.app.with_token(&school.trainee.token);
    assert_eq!(trainee.upload(&record(&attempt)).await.status, 201);
    worker::work_off_jobs(&school.app.state).await.unwrap();
    let score = format!("/api/v1/sessions/{}/score", attempt.session_id);
    let (given, graded) =
        (trainee.get(&format!("/api/v1/exercises/{EXERCISE}")).await.json(), trainee.get(&score).await.json());
    let mut writer = school.opens("osei@example.org", &format!("/exercises/{EXERCISE}")).await;
    let published = std::fs::read_to_string(crate::support::course_folder().join("1-feel-the-layers.toml")).unwrap();
    assert_eq!(writer.document, published, "the draft begins as the revision that is given");
    writer.replace("Feel the layers", "Feel every layer");
    let saved = writer.act("save").await;
    assert_eq!(saved.status, 200, "{}", saved.text());
    assert!(saved.text().contains("<svg") && saved.text().contains("Tissue model error"), "{}", saved.text());
    let typed = [("csrf", writer.csrf.as_str()), ("document", "id = 1"), ("scene", &writer.scene)];
    let preview = writer.client.form(&format!("{}/preview", writer.draft), &typed).await.text();
    assert!(preview.contains("Document, line 1") && !preview.contains("<html"), "{preview}");
    let kept = Writer::at(writer.client.clone(), writer.draft.clone()).await;
    assert_eq!(kept.document, writer.document, "a preview saves nothing");
    let same = trainee.get(&format!("/api/v1/exercises/{EXERCISE}")).await.json();
    assert_eq!(same, given, "a draft is nobody's");

    let done = writer.act("publish").await;
    assert_eq!(done.header("location"), format!("/exercises/{EXERCISE}?published=yes"), "{}", done.text());
    let now = trainee.get(&format!("/api/v1/exercises/{EXERCISE}")).await.json();
    assert_ne!(now, given);
    assert_eq!(trainee.get(&score).await.json(), graded, "an attempt already made keeps its grade");
    let page = writer.client.get(&format!("/exercises/{EXERCISE}/revisions")).await.text();
    assert!(page.contains("en = &#34;Feel every layer&#34;") && page.contains("No difference"), "{page}");
    assert_eq!(writer.client.get(&writer.draft).await.status, 404, "published, it is no draft any more");
}

#[tokio::test]
async fn the_second_of_two_writers_is_told_and_loses_nothing() {
    let school = School::new().await;
    let document = format!("/exercises/{EXERCISE}");
    let mut osei = school.opens("osei@example.org", &document).await;
    let mut bell = school.opens("bell@example.org", &document).await;
    assert_eq!(osei.draft, bell.draft, "one document has one draft");
    osei.replace("Feel the layers", "Feel them all");
    assert_eq!(osei.act("save").await.status, 200);
    bell.replace("Feel the layers", "Feel the skin");
    let refused = bell.act("save").await;
    assert_eq!(refused.status, 409);
    let page = refused.text();
    assert!(area(&page, "document").unwrap().contains("Feel the skin"), "what was typed is still there");
    assert!(page.contains("Feel them all"), "and so is what the other wrote");
    let discarded = bell.client.form(&format!("{}/discard", bell.draft), &[("csrf", &bell.csrf), ("seen", "1")]).await;
    assert_eq!(discarded.status, 409, "an old page does not throw away what it has not seen");
    assert_eq!(bell.act("save").await.status, 200, "having seen it, the second may replace it");
    let reopened = Writer::at(osei.client, osei.draft).await;
    assert_eq!(reopened.document, bell.document);
}

#[tokio::test]
async fn what_is_wrong_is_saved_named_and_not_published() {
    let school = School::new().await;
    let mut writer = school.opens("osei@example.org", &format!("/exercises/{EXERCISE}")).await;
    let whole = writer.document.clone();
    for (from, to, place) in [
        ("difficulty = ", "difficulty = 1", "difficulty"),
        ("pass_mark = ", "pass_mark = -", "pass_mark"),
        ("id = \"feel-the-layers\"", "id = \"stop-in-the-fat\"", "the id of this draft"),
    ] {
        writer.document = whole.replace(from, to);
        assert_ne!(writer.document, whole);
        let refused = writer.act("publish").await;
        assert_eq!(refused.status, 422, "{to}");
        assert!(refused.text().contains(place) && refused.text().contains("line "), "{to}: {}", refused.text());
    }
    writer.document = "<script>alert(1)</script>".to_owned();
    let refused = writer.act("publish").await.text();
    assert!(!refused.contains("<script>alert"), "{refused}");
    writer.document = whole;
    // Skin that gives way to something much stiffer and tougher.
    let tougher = writer.scene.replace("stiffness_n_per_m = 39\n", "stiffness_n_per_m = 1500\n");
    writer.scene = tougher.replace("tip_rupture_n = 0.24", "tip_rupture_n = 6");
    let unsound = writer.act("publish").await;
    assert_eq!(unsound.status, 422, "a scene that would push the hand is not published");
    assert!(unsound.text().contains("unsound"), "{}", unsound.text());
}

/// What `stylet check` finds in a rubric is shown while it is written, holds it back once, and is published when its author insists.
#[tokio::test]
async fn flawed_rubric_holds_publication_until_its_author_insists() {
    let school = School::new().await;
    let mut writer = school.opens("osei@example.org", "/exercises/stop-in-the-fat").await;
    assert!(!writer.act("save").await.text().contains("before you publish"), "nothing is found in what is shipped");
    writer.replace("full = 0.5\nzero = 5", "full = 5\nzero = 0.5");
    writer.replace("withdrawn = true", "withdrawn = false");
    let typed = [("csrf", writer.csrf.as_str()), ("document", &writer.document), ("scene", &writer.scene)];
    let preview = writer.client.form(&format!("{}/preview", writer.draft), &typed).await.text();
    for said in
        ["Document, line ", "rubric[1].full", "lower overshoot_mm is better", "the needle is not withdrawn", "<svg"]
    {
        assert!(preview.contains(said), "{said} is not in\n{preview}");
    }
    let held = writer.act("publish").await;
    assert_eq!(held.status, 422, "{}", held.text());
    assert!(held.text().contains("2 warnings: change them before you publish"), "{}", held.text());
    let done = writer.act("insist").await;
    assert_eq!(done.header("location"), "/exercises/stop-in-the-fat?published=yes", "{}", done.text());
}

#[tokio::test]
async fn a_course_is_written_with_its_exercises_by_file_or_by_id() {
    let school = School::new().await;
    let mut writer = school.opens("osei@example.org", "/curricula/lower-back-basics").await;
    let whole = writer.document.clone();
    let cycle = "file = \"1-feel-the-layers.toml\"\nprerequisites = [\"reach-the-muscle\"]";
    writer.replace("file = \"1-feel-the-layers.toml\"", cycle);
    let refused = writer.act("publish").await;
    assert_eq!(refused.status, 422);
    assert!(refused.text().contains("a cycle: "), "{}", refused.text());
    writer.document =
        whole.replace("file = \"7-thick-fat.toml\"", "file = \"thick-fat\"").replace("passes = 3", "passes = 2");
    let done = writer.act("publish").await;
    assert_eq!(done.status, 303, "{}", done.text());
    assert_eq!(done.header("location"), "/curricula?published=lower-back-basics");
    let page = writer.client.get("/curricula/lower-back-basics/revisions").await.text();
    assert!(page.contains("passes = 2") && page.contains("passes = 3"), "{page}");
    let unknown = school.opens("osei@example.org", "/curricula/lower-back-basics").await;
    let mut unknown = Writer { document: whole.replace("7-thick-fat.toml", "no-such"), ..unknown };
    assert!(unknown.act("publish").await.text().contains("no exercise with this name"));
}

#[tokio::test]
async fn a_copy_is_an_exercise_of_its_own() {
    let school = School::new().await;
    let mut client = school.app.signed_in("bell@example.org").await;
    let csrf = csrf_in(&client.get("/drafts").await.text());
    for (id, status) in [("stop-in-the-fat", 422), ("Not an id", 422), ("feel-again", 303)] {
        let begun =
            client.form("/drafts", &[("csrf", &csrf), ("exercise", EXERCISE), ("title", "Again"), ("id", id)]).await;
        assert_eq!(begun.status, status, "{id}: {}", begun.text());
        if status == 303 {
            let mut writer = Writer::at(client.clone(), begun.header("location").to_owned()).await;
            assert_eq!(writer.act("publish").await.status, 303);
        }
    }
    assert_eq!(client.get("/exercises/feel-again").await.status, 200);
    assert_eq!(client.get(&format!("/exercises/{EXERCISE}")).await.status, 200);
}

#[tokio::test]
async fn a_trainee_writes_nothing_and_another_school_sees_nothing() {
    let school = School::new().await;
    let writer = school.opens("osei@example.org", &format!("/exercises/{EXERCISE}")).await;
    let south = school.app.school("South").await;
    school.app.member(south, Role::Administrator, "head@south.example").await;
    let revisions = format!("/exercises/{EXERCISE}/revisions");
    for (email, status) in [("ada@example.org", 403), ("head@south.example", 404)] {
        let mut client = school.app.signed_in(email).await;
        let csrf = csrf_in(&client.get("/curricula").await.text());
        let fields = [("csrf", csrf.as_str()), ("seen", "1"), ("document", ""), ("act", "save")];
        assert_eq!(client.get(&writer.draft).await.status, status, "{email}");
        assert_eq!(client.get(&revisions).await.status, status, "{email}");
        assert_eq!(client.form(&writer.draft, &fields).await.status, status, "{email}");
        assert_eq!(client.form(&format!("{}/discard", writer.draft), &fields).await.status, status, "{email}");
        assert_eq!(client.form(&format!("/exercises/{EXERCISE}/draft"), &fields[..1]).await.status, status, "{email}");
    }
}

#[tokio::test]
async fn what_is_wrong_is_said_in_the_language_of_whoever_writes() {
    let school = School::new().await;
    let mut writer = school.opens("osei@example.org", &format!("/exercises/{EXERCISE}")).await;
    let language = [("csrf", writer.csrf.as_str()), ("language", "de")];
    assert_eq!(writer.client.form("/account/language", &language).await.status, 303);
    let saved = writer.act("save").await.text();
    assert!(
        saved.contains("ebene Schichten sind auch unter einer schrägen Nadel rotationssymmetrisch")
            && saved.contains("Winkel der"),
        "{saved}"
    );
    writer.replace("title =", "titel =");
    writer.replace("pass_mark = 60", "pass_mark = 600");
    writer.scene = writer.scene.replacen("tip_rupture_n", "tip_rupture_mn", 1);
    let refused = writer.act("publish").await;
    assert_eq!(refused.status, 422);
    for said in [
        "titel: unbekannter Schlüssel; meinten Sie `title`?",
        "title: fehlt; erlaubt: 1 bis 300 Zeichen in einer Zeile",
        "pass_mark: 600; erlaubt: eine Zahl von 0 bis 100",
        "layer[0].tip_rupture_n: fehlt; erlaubt: eine Zahl von 0 bis 100 N",
    ] {
        assert!(refused.text().contains(said), "{said} is not in\n{}", refused.text());
    }
    assert!(!refused.text().contains("allowed"), "{}", refused.text());
}
