//! Documents written in forms. Fails when a form loses what it does not know, when what is typed into one view is not in the other, when a
//! row does not come or go, when an error does not stand at its field, or when an author cannot get from a title to a published exercise in a
//! course.

use model::Role;
use scraper::{Html, Selector};

use crate::support::App;
use crate::support::client::{Answer, Client, csrf_in};

/// An instructor of a school with the shipped course.
async fn instructor() -> (App, Client) {
    let app = App::new().await;
    let school = app.school("North").await;
    app.publish(school).await;
    app.member(school, Role::Instructor, "osei@example.org").await;
    let client = app.signed_in("osei@example.org").await;
    (app, client)
}

/// The page of a draft, and what stands in its form.
pub(crate) struct FormWriter {
    pub(crate) client: Client,
    pub(crate) draft: String,
    pub(crate) fields: Vec<(String, String)>,
}

impl FormWriter {
    pub(crate) async fn at(mut client: Client, draft: &str) -> Self {
        let page = client.get(draft).await;
        assert_eq!(page.status, 200, "{}", page.text());
        let draft = draft.split(['#', '?']).next().unwrap_or_default().to_owned();
        Self { client, draft, fields: fields_of_form(&page.text()) }
    }

    pub(crate) fn set(&mut self, name: &str, value: &str) {
        let field = self.fields.iter_mut().find(|(known, _)| known == name);
        field.unwrap_or_else(|| panic!("no field {name}")).1 = value.to_owned();
    }

    pub(crate) fn value(&self, name: &str) -> &str {
        self.fields.iter().find(|(known, _)| known == name).map_or("", |(_, value)| value)
    }

    pub(crate) async fn act(&mut self, act: &str) -> Answer {
        let mut fields: Vec<(&str, &str)> =
            self.fields.iter().map(|(name, value)| (name.as_str(), value.as_str())).collect();
        fields.push(("act", act));
        let answer = self.client.form(&self.draft, &fields).await;
        let page = if answer.status == 303 {
            let location = answer.header("location").split('#').next().unwrap_or_default().to_owned();
            self.client.get(&location).await.text()
        } else {
            answer.text()
        };
        self.fields = fields_of_form(&page);
        answer
    }
}

/// What a browser would send of the page's editor if nobody touched it.
fn fields_of_form(page: &str) -> Vec<(String, String)> {
    let page = Html::parse_document(page);
    let select = |what: &str| Selector::parse(what).expect("a selector");
    let all = select("form.editor input, form.editor textarea, form.editor select");
    let chosen = select("option[selected]");
    let first = select("option");
    let fields = page.select(&all).filter_map(|field| {
        let name = field.attr("name")?.to_owned();
        let value = match field.value().name() {
            "textarea" => field.text().collect::<String>().trim_start_matches('\n').replace('\n', "\r\n"),
            "select" => {
                let option = field.select(&chosen).next().or_else(|| field.select(&first).next());
                option.and_then(|option| option.attr("value")).unwrap_or_default().to_owned()
            }
            _ if field.attr("type") == Some("checkbox") => field.attr("checked").and(field.attr("value"))?.to_owned(),
            _ => field.attr("value").unwrap_or_default().to_owned(),
        };
        Some((name, value))
    });
    fields.collect()
}

async fn begin(client: &mut Client, document: &str) -> String {
    let csrf = csrf_in(&client.get("/curricula").await.text());
    client.form(&format!("{document}/draft"), &[("csrf", &csrf)]).await.header("location").to_owned()
}

pub(crate) fn unix(text: &str) -> String {
    text.replace("\r\n", "\n")
}

#[tokio::test]
async fn saving_an_unchanged_form_keeps_every_byte_of_a_document() {
    let (_app, mut client) = instructor().await;
    let folder = crate::support::course_folder();
    let files = std::fs::read_dir(&folder).unwrap().map(|file| file.unwrap().path());
    for file in files.filter(|file| file.extension().is_some_and(|extension| extension == "toml")) {
        let text = std::fs::read_to_string(&file).unwrap();
        let id = text.lines().find_map(|line| line.strip_prefix("id = \"")).unwrap().trim_end_matches('"').to_owned();
        let is_course = file.ends_with("course.toml");
        let document = if is_course { format!("/curricula/{id}") } else { format!("/exercises/{id}") };
        let draft = begin(&mut client, &document).await;
        let mut writer = FormWriter::at(client.clone(), &draft).await;
        assert!(writer.value("view") == "form", "{id}");
        assert_eq!(writer.act("save").await.status, 200, "{id}");
        assert_eq!(unix(writer.value("document")), text, "{id}");
    }
}

#[tokio::test]
async fn form_and_text_views_share_input_and_place_errors_at_fields() {
    let (_app, mut client) = instructor().await;
    let draft = begin(&mut client, "/exercises/stop-in-the-fat").await;
    let mut writer = FormWriter::at(client, &draft).await;
    let before = unix(writer.value("document"));
    writer.set("x.target.depth_mm", "8,50");
    writer.set("x.rubric[1].metric", "stop_time_s.skin.rim@2");
    assert_eq!(writer.act("toml").await.status, 303);
    let text = unix(writer.value("document"));
    let changed = before.replace("depth_mm = 9.5\n", "depth_mm = 8.50\n");
    let changed = changed.replacen(
        "metric = \"overshoot_mm\"\nfull = 0.5\nzero = 5\nweight = 3\n",
        "metric = \"stop_time_s.skin.rim\"\nfull = 0.5\nzero = 5\nweight = 3\nversion = 2\n",
        1,
    );
    assert_eq!(text, changed);
    writer.set("document", &text.replace("Stop in the fat", "Halt in the fat"));
    assert_eq!(writer.act("form").await.status, 303);
    assert_eq!(writer.value("x.title.en"), "Halt in the fat");
    assert_eq!(writer.value("x.target.depth_mm"), "8.50", "as it was written");
    writer.set("x.pass_mark", "700");
    writer.set("x.hard_fail[0].above", "far");
    let refused = writer.act("publish").await;
    assert_eq!(refused.status, 422);
    let page = refused.text();
    for wanted in ["id=\"f-pass-mark-why\">700; allowed", "href=\"#f-hard-fail-0-above\"", "value=\"far\""] {
        assert!(page.contains(wanted), "{wanted} is missing in {page}");
    }
    writer.set("document", "no TOML [");
    assert_eq!(writer.act("save").await.status, 200);
    assert_eq!(writer.value("view"), "", "a text that is no TOML is shown as it is");
}

#[tokio::test]
async fn rows_are_added_and_removed_by_buttons() {
    let (_app, mut client) = instructor().await;
    let draft = begin(&mut client, "/exercises/stop-in-the-fat").await;
    let mut writer = FormWriter::at(client, &draft).await;
    let before = unix(writer.value("document"));
    writer.set("new.rubric", "lateral_peak_n");
    writer.set("x.title.en", "Changed on the way");
    let added = writer.act("add:rubric").await;
    assert!(added.header("location").ends_with("#f-rubric-4"), "{}", added.header("location"));
    assert_eq!(
        (writer.value("x.rubric[4].metric"), writer.value("x.title.en")),
        ("lateral_peak_n", "Changed on the way")
    );
    writer.act("remove:rubric[4]").await;
    writer.set("x.title.en", "Stop in the fat");
    writer.act("add:coaching").await;
    writer.act("remove:coaching[2]").await;
    assert_eq!(unix(writer.value("document")), before);
    assert_eq!(writer.act("remove:rubric[x]").await.status, 400, "an act that there is not");
}

#[tokio::test]
async fn the_scene_of_another_exercise_is_taken_with_its_layers() {
    let (_app, mut client) = instructor().await;
    let draft = begin(&mut client, "/exercises/stop-in-the-fat").await;
    let mut writer = FormWriter::at(client, &draft).await;
    assert!(!writer.value("scene").contains("lumbar vessel"));
    writer.set("new.scene", "avoid-the-vessel");
    writer.set("x.pass_mark", "66");
    let taken = writer.act("scene").await;
    assert!(taken.header("location").ends_with("#f-scene"), "{}", taken.text());
    assert!(writer.value("scene").contains("lumbar vessel"));
    let document = unix(writer.value("document"));
    assert!(document.contains("scene = \"../scenes/lower-back-vessel.toml\"") && document.contains("pass_mark = 66\n"));
    writer.set("new.rubric", "structure_clearance_mm.lumbar vessel");
    writer.act("add:rubric").await;
    writer.set("new.scene", "no-such");
    assert_eq!(writer.act("scene").await.status, 404);
}

#[tokio::test]
async fn from_a_title_to_an_exercise_in_a_course() {
    let (_app, mut client) = instructor().await;
    let csrf = csrf_in(&client.get("/drafts").await.text());
    let copy =
        [("csrf", csrf.as_str()), ("kind", "exercise"), ("exercise", "stop-in-the-fat"), ("title", "Größer im Fett")];
    let begun = client.form("/drafts", &copy).await.header("location").to_owned();
    let mut writer = FormWriter::at(client.clone(), &begun).await;
    assert!(unix(writer.value("document")).contains("id = \"groesser-im-fett\"\ntitle = \"Größer im Fett\"\n"));
    let again = client.form("/drafts", &copy).await.header("location").to_owned();
    assert!(client.get(&again).await.text().contains("groesser-im-fett-2"), "another id for another document");
    let published = writer.act("publish").await.header("location").to_owned();
    assert_eq!(published, "/exercises/groesser-im-fett?published=yes");
    let page = client.get(&published).await.text();
    assert!(page.contains("Published.") && page.contains("/assignments?task=exercise:groesser-im-fett"), "{page}");
    let chosen = client.get("/assignments?task=exercise:groesser-im-fett").await.text();
    assert!(chosen.contains("value=\"exercise:groesser-im-fett\" selected"), "{chosen}");
    let add = [("csrf", csrf.as_str()), ("course", "lower-back-basics")];
    let course = client.form("/exercises/groesser-im-fett/course", &add).await.header("location").to_owned();
    assert!(course.ends_with("#f-exercise-7"), "{course}");
    let twice = client.form("/exercises/groesser-im-fett/course", &add).await.header("location").to_owned();
    assert_eq!(twice, course, "once is enough");
    let mut writer = FormWriter::at(client.clone(), course.split('#').next().unwrap()).await;
    writer.fields.push(("x.exercise[7].prerequisites:feel-the-layers".to_owned(), "yes".to_owned()));
    writer.act("up:exercise[7]").await;
    let done = writer.act("publish").await;
    assert_eq!(done.header("location"), "/curricula?published=lower-back-basics", "{}", done.text());
    let page = client.get("/curricula?published=lower-back-basics").await.text();
    let place = |title: &str| page.find(title).unwrap_or_else(|| panic!("{title}"));
    assert!(
        place("Größer im Fett") < place("A long way through fat") && page.contains("after Feel the layers"),
        "{page}"
    );
}

#[tokio::test]
async fn a_course_begins_from_nothing() {
    let (_app, mut client) = instructor().await;
    let csrf = csrf_in(&client.get("/drafts").await.text());
    let begin = [("csrf", csrf.as_str()), ("kind", "course"), ("title", "Our first days"), ("id", "")];
    let refused = client.form("/drafts", &[begin[0], begin[1], ("title", "针"), begin[3]]).await;
    assert_eq!(refused.status, 422);
    assert!(
        refused.text().contains("none can be derived") && refused.text().contains("value=\"针\""),
        "{}",
        refused.text()
    );
    let draft = client.form("/drafts", &begin).await.header("location").to_owned();
    let mut writer = FormWriter::at(client.clone(), &draft).await;
    assert_eq!(writer.act("publish").await.status, 422, "a course without exercises is none");
    writer.set("new.exercise", "stop-in-the-fat");
    writer.act("add:exercise").await;
    writer.set("x.mastery.rule", "cusum");
    writer.act("save").await;
    for (key, value) in [("p0", "0.20"), ("p1", "0.40"), ("alpha", "0.05"), ("beta", "0.10")] {
        writer.set(&format!("x.mastery.{key}"), value);
    }
    let done = writer.act("publish").await;
    assert_eq!(done.header("location"), "/curricula?published=our-first-days", "{}", done.text());
}

#[tokio::test]
async fn readers_get_documents_in_their_language_or_the_documents_own() {
    let (_app, mut client) = instructor().await;
    let csrf = csrf_in(&client.get("/drafts").await.text());
    let draft = begin(&mut client, "/exercises/stop-in-the-fat").await;
    let mut writer = FormWriter::at(client.clone(), &draft).await;
    writer.set("x.hard_fail[0].why.de", "Viel zu tief.");
    writer.set("new.languages", "fr");
    writer.act("add:languages").await;
    writer.set("x.title.fr", "Arrêt dans la graisse");
    writer.act("publish").await;
    for (language, title, why, course) in [
        ("de", "Im Fett anhalten", "Viel zu tief.", "Sieben Übungen"),
        ("en", "Stop in the fat", "The needle went", "Seven exercises"),
    ] {
        let choice = [("csrf", csrf.as_str()), ("language", language)];
        assert_eq!(client.form("/account/language", &choice).await.status, 303);
        let page = client.get("/exercises/stop-in-the-fat").await.text();
        assert!(page.contains(title) && page.contains(why), "{page}");
        assert!(client.get("/curricula").await.text().contains(course), "{course}");
        for list in ["/curricula", "/assignments", "/drafts"] {
            let page = client.get(list).await.text();
            assert!(page.contains(title) && !page.contains('\u{1f}'), "{list}: {page}");
        }
    }
}
