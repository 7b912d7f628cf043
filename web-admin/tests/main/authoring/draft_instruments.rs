//! Instruments written in forms. Fails when a form changes what nobody has changed, when an error does not stand at its field, when an author
//! cannot get from a title to answers in two languages, or when publishing changes what somebody has answered already.

use acts::authoring::instruments::documents_in;
use documents::Instrument;

use crate::authoring::draft_forms::{FormWriter, unix};
use crate::support::client::{Client, csrf_in};
use crate::support::course_folder;
use crate::surveys::{School, send};

/// The page of an instrument's draft, as an instructor has it.
async fn open(client: &mut Client, instrument: &str) -> FormWriter {
    let csrf = csrf_in(&client.get("/surveys/instruments").await.text());
    let begun = client.form(&format!("/surveys/instruments/{instrument}/draft"), &[("csrf", &csrf)]).await;
    assert_eq!(begun.status, 303, "{}", begun.text());
    FormWriter::at(client.clone(), begun.header("location")).await
}

async fn begin(client: &mut Client, original: &str, title: &str) -> FormWriter {
    let csrf = csrf_in(&client.get("/drafts").await.text());
    let fields =
        [("csrf", csrf.as_str()), ("kind", "instrument"), ("instrument", original), ("title", title), ("id", "")];
    let begun = client.form("/drafts", &fields).await;
    assert_eq!(begun.status, 303, "{}", begun.text());
    FormWriter::at(client.clone(), begun.header("location")).await
}

/// Types a text into its field in both languages.
fn say(writer: &mut FormWriter, text: &str, [english, german]: [&str; 2]) {
    writer.set(&format!("x.{text}.en"), english);
    writer.set(&format!("x.{text}.de"), german);
}

fn tick(writer: &mut FormWriter, field: &str) {
    assert!(writer.fields.contains(&("box".to_owned(), field.to_owned())), "no box {field}");
    writer.fields.push((format!("x.{field}"), "yes".to_owned()));
}

#[tokio::test]
async fn saving_an_unchanged_form_keeps_every_byte_of_an_instrument() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let files = documents_in(course_folder().parent().unwrap()).unwrap();
    assert!(files.len() >= 6);
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        let id = file.file_stem().unwrap().to_str().unwrap().to_owned();
        let mut writer = open(&mut teacher, &id).await;
        assert_eq!(writer.value("view"), "form", "{id}");
        let saved = writer.act("save").await;
        assert_eq!(saved.status, 200, "{id}");
        assert!(!saved.text().contains("notice bad"), "{id}: {}", saved.text());
        assert_eq!(unix(writer.value("document")), text, "{id}");
        let title = writer.value("x.title.en").to_owned();
        writer.set("x.title.en", "Another title");
        writer.act("save").await;
        let changed = text.replacen(&format!("en = \"{title}\""), "en = \"Another title\"", 1);
        assert_eq!(unix(writer.value("document")), changed, "{id}");
    }
}

#[tokio::test]
async fn from_a_title_to_answers_in_german() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let mut writer = begin(&mut teacher, "", "How was the course?").await;
    let refused = writer.act("publish").await;
    assert_eq!(refused.status, 422);
    for missing in ["f-source-why", "f-licence-why", "#f-item", "#f-scale"] {
        assert!(refused.text().contains(missing), "{missing} is missing in {}", refused.text());
    }
    writer.set("new.languages", "de");
    writer.act("add:languages").await;
    say(&mut writer, "title", ["How was the course?", "Wie war der Kurs?"]);
    writer.set("x.source", "Ours");
    writer.set("x.licence", "Free to use");
    writer.set("new.item", "new:likert");
    let added = writer.act("add:item").await;
    assert!(added.header("location").ends_with("#f-item-0"), "{}", added.header("location"));
    say(&mut writer, "item[0].text", ["It was useful.", "Er war nützlich."]);
    writer.set("new.item", writer.value("x.scale[0].id").to_owned().as_str());
    writer.act("add:item").await;
    say(&mut writer, "item[1].text", ["It was too long.", "Er war zu lang."]);
    writer.set("new.item", "new:yes-no");
    writer.act("add:item").await;
    say(&mut writer, "item[2].text", ["Would you come again?", "Würden Sie wiederkommen?"]);
    assert_eq!(writer.value("x.scale[1].option[0].text.de"), "Ja", "words that the service knows are there");
    writer.act("up:item[2]").await;
    writer.act("add:score").await;
    say(&mut writer, "score[0].title", ["Usefulness", "Nutzen"]);
    tick(&mut writer, "score[0].items:q-1");
    tick(&mut writer, "score[0].items:q-2");
    writer.act("save").await;
    tick(&mut writer, "score[0].reversed:q-2");
    writer.set("x.item[0].id", "useful");
    let looked = writer.act("look:de").await;
    let questions = looked.header("location").to_owned();
    assert!(questions.ends_with("/questions?lang=de"), "{}", looked.text());
    let seen = teacher.get(&questions).await.text();
    for wanted in ["lang=\"de\"", "Er war nützlich.", "Stimme gar nicht zu", "Nichts wird gespeichert", "Ja"] {
        assert!(seen.contains(wanted), "{wanted} is missing in {seen}");
    }
    let place = |text: &str| seen.find(text).unwrap_or_else(|| panic!("{text}"));
    assert!(place("wiederkommen") < place("zu lang"), "the last moved up");
    let mut writer = FormWriter::at(teacher.clone(), &writer.draft.clone()).await;
    assert!(unix(writer.value("document")).contains("items = [\"useful\", \"q-2\"]"), "{}", writer.value("document"));
    let done = writer.act("publish").await.header("location").to_owned();
    assert_eq!(done, "/surveys/instruments/how-was-the-course?published=yes");
    let page = teacher.get(&done).await.text();
    assert!(page.contains("Published.") && page.contains("/surveys/new?instrument=how-was-the-course"), "{page}");
    let chosen = teacher.get("/surveys/new?instrument=how-was-the-course").await.text();
    assert!(chosen.contains("value=\"how-was-the-course\" selected"), "{chosen}");
    let survey = school.survey(&mut teacher, "how-was-the-course", &[("identity", "anonymous")]).await;
    let link = school.links(&mut teacher, &survey, "Dr A").await.remove(0);
    let mut stranger = school.app.stranger();
    send(&mut stranger, &link, &[("do", "begin"), ("consent", "yes"), ("lang", "de")]).await;
    let form = stranger.get(&link).await.text();
    assert!(form.contains("Er war nützlich.") && form.contains("Antworten senden"), "{form}");
    let answers = [("do", "send"), ("page", "0"), ("q.useful", "5"), ("q.q-2", "2"), ("q.q-3", "yes")];
    assert_eq!(send(&mut stranger, &link, &answers).await.status, 303);
    let results = teacher.get(&format!("{survey}/results")).await.text();
    assert!(results.contains("Usefulness"), "{results}");
    let mut head = school.app.signed_in("head@example.org").await;
    let log = head.get("/admin/audit").await.text();
    assert!(log.contains("how-was-the-course"), "publishing is audited: {log}");
}

#[tokio::test]
async fn a_published_revision_that_was_answered_stays_as_it_was() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let survey = school.survey(&mut teacher, "sus", &[("identity", "anonymous")]).await;
    let link = school.links(&mut teacher, &survey, "Dr A").await.remove(0);
    let mut writer = open(&mut teacher, "sus").await;
    writer.set("x.item[0].text.en", "Another wording.");
    let document = unix(writer.value("document"));
    assert_eq!(writer.act("publish").await.status, 303);
    let asked = |page: String| page.contains("Another wording.");
    let mut stranger = school.app.stranger();
    send(&mut stranger, &link, &[("do", "begin"), ("consent", "yes"), ("lang", "en")]).await;
    assert!(!asked(stranger.get(&link).await.text()), "a survey keeps asking its own revision");
    let later = school.survey(&mut teacher, "sus", &[("identity", "anonymous")]).await;
    let link = school.links(&mut teacher, &later, "Dr B").await.remove(0);
    send(&mut stranger, &link, &[("do", "begin"), ("consent", "yes"), ("lang", "en")]).await;
    assert!(asked(stranger.get(&link).await.text()));
    let published = teacher.get("/surveys/instruments/sus/document.toml").await.text();
    let differ = published.lines().zip(document.lines()).filter(|(is, was)| is != was).count();
    assert_eq!((differ, published.lines().count()), (1, document.lines().count()), "{published}");
}

#[tokio::test]
async fn instrument_form_shows_the_errors_of_stylet_check_at_fields() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let mut writer = open(&mut teacher, "sus").await;
    writer.set("x.scale[0].points", "50");
    writer.set("x.score[0].factor", "much");
    writer.set("x.item[3].text.de", "");
    let refused = writer.act("publish").await;
    assert_eq!(refused.status, 422);
    let page = refused.text();
    let document = unix(writer.value("document"));
    let issues = Instrument::from_bytes("document", document.as_bytes()).unwrap_err().issues;
    let remarks = page.split("<li class=\"notice bad\">").count() - 1;
    assert_eq!(remarks, issues.len(), "{issues:#?} {page}");
    for field in ["f-scale-0-points", "f-score-0-factor", "f-item-3-text-de"] {
        assert!(page.contains(&format!("href=\"#{field}\"")), "{field} is missing in {page}");
        assert!(page.contains(&format!("id=\"{field}-why\"")), "{field} is missing in {page}");
    }
    assert!(page.contains("1 text is missing or wrong in it."), "{page}");
    assert!(page.contains("<details class=\"form-row folded\" id=\"f-item-3\" open>"), "{page}");
    assert!(page.contains("<details class=\"form-row folded\" id=\"f-item-4\">"), "{page}");
    let preview = teacher.get(&format!("{}/questions?lang=de", writer.draft)).await;
    assert_eq!(preview.header("location"), writer.draft, "what is wrong is not shown");
    let looked = writer.act("look:de").await;
    assert!(looked.status == 200 && looked.text().contains("Saved."), "{}", looked.text());
    writer.act("toml").await;
    let toml = teacher.get(&format!("{}?view=toml", writer.draft)).await.text();
    assert!(toml.contains("scale[0].points: 50; allowed: a whole number from 2 to 11"), "{toml}");
}

#[tokio::test]
async fn copy_has_its_own_title_and_removed_question_leaves_scores() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let mut writer = begin(&mut teacher, "nasa-tlx-weighted", "Our load").await;
    assert_eq!((writer.value("x.title.en"), writer.value("x.title.de")), ("Our load", ""));
    writer.set("x.title.de", "Unsere Last");
    let page = writer.act("save").await.text();
    assert!(
        page.contains("It is removed from the scores ") && page.contains("These refer to it and must be changed: "),
        "{page}"
    );
    assert!(writer.act("remove:item[20]").await.header("location").ends_with("#f-item"));
    let document = unix(writer.value("document"));
    assert!(!document.contains("effort-or-frustration"), "neither asked nor counted: {document}");
    Instrument::from_bytes("document", document.as_bytes()).unwrap();
    assert_eq!(writer.act("publish").await.header("location"), "/surveys/instruments/our-load?published=yes");
    let list = teacher.get("/surveys/instruments").await.text();
    assert!(list.contains("Our load") && list.contains("NASA Task Load Index (weighted)"), "{list}");
    let again = begin(&mut teacher, "nasa-tlx-weighted", "Our load").await;
    assert!(unix(again.value("document")).contains("id = \"our-load-2\""), "another id for another document");
    let csrf = csrf_in(&teacher.get("/drafts").await.text());
    let fields = [("csrf", csrf.as_str()), ("kind", "instrument"), ("instrument", "sus"), ("title", "针"), ("id", "")];
    let refused = teacher.form("/drafts", &fields).await;
    assert_eq!(refused.status, 422);
    assert!(refused.text().contains("value=\"sus\" selected") && refused.text().contains("value=\"针\""));
}

#[tokio::test]
async fn a_course_comes_to_ask_what_was_written() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let mut written = begin(&mut teacher, "free-comment", "Three words").await;
    written.set("x.title.de", "Drei Worte");
    written.act("publish").await;
    let page = teacher.get("/surveys/instruments/three-words").await.text();
    let fields = [("csrf", csrf_in(&page)), ("course", "lower-back-basics".to_owned())];
    let fields = fields.each_ref().map(|(name, value)| (*name, value.as_str()));
    let course = teacher.form("/surveys/instruments/three-words/course", &fields).await.header("location").to_owned();
    assert!(course.ends_with("#f-exercise"), "{course}");
    let mut writer = FormWriter::at(teacher.clone(), course.split('#').next().unwrap()).await;
    writer.set("x.exercise[0].survey", "three-words");
    assert_eq!(writer.act("publish").await.status, 303);
    let nowhere = teacher.form("/surveys/instruments/no-such/course", &fields).await;
    assert_eq!(nowhere.status, 404);
}
