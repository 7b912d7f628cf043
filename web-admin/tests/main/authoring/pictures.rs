//! Pictures of briefings. Fails when one is lost on its way from a file or a browser to the page of its exercise, when somebody sees one who may
//! not see the exercise, when a file brings more than pixels, when a refused one takes with it what was typed, or when a picture changes how an
//! attempt is judged.

use axum::body::Body;
use axum::http::{Request, header};
use documents::ExerciseBundle;
use documents::picture::{MOST_PICTURES, MOST_SENT_BYTES};
use model::Role;
use scraper::{Html, Selector};

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::{App, course_folder};

const PICTURED: &str = "/exercises/avoid-the-vessel";

/// A school with the shipped course, an instructor and a trainee.
struct PictureSchool {
    app: App,
    instructor: Client,
    trainee: Client,
}

impl PictureSchool {
    async fn new() -> Self {
        let app = App::new().await;
        let school = app.school("North").await;
        app.publish(school).await;
        app.member(school, Role::Instructor, "osei@example.org").await;
        app.member(school, Role::Trainee, "ada@example.org").await;
        let instructor = app.signed_in("osei@example.org").await;
        let trainee = app.signed_in("ada@example.org").await;
        Self { app, instructor, trainee }
    }

    /// The draft of an exercise, begun by the instructor.
    async fn draft(&mut self, exercise: &str) -> String {
        let csrf = csrf_in(&self.instructor.get("/curricula").await.text());
        let begun = self.instructor.form(&format!("/exercises/{exercise}/draft"), &[("csrf", &csrf)]).await;
        begun.header("location").to_owned()
    }
}

/// The picture of a shipped exercise, as it lies there.
fn shipped_picture() -> Vec<u8> {
    let bundle = ExerciseBundle::read(&course_folder().join("6-avoid-the-vessel.toml")).unwrap();
    bundle.pictures.first().expect("a picture").bytes.clone()
}

/// The values of an attribute in a page.
fn attributes(page: &str, which: &str, attribute: &str) -> Vec<String> {
    let page = Html::parse_document(page);
    let found = Selector::parse(which).expect("a selector");
    page.select(&found).filter_map(|element| element.attr(attribute).map(str::to_owned)).collect()
}

/// What the editor on a page holds.
fn typed_in(page: &str) -> Vec<(String, String)> {
    let page = Html::parse_document(page);
    let inputs =
        "form.editor input:not([type=file]):not([type=checkbox]), form.editor input[checked], form.editor textarea";
    let found = Selector::parse(inputs).expect("a selector");
    let value = |field: scraper::ElementRef<'_>| match field.attr("value") {
        Some(value) => value.to_owned(),
        None => field.text().collect::<String>().trim_start_matches('\n').to_owned(),
    };
    page.select(&found).filter_map(|field| Some((field.attr("name")?.to_owned(), value(field)))).collect()
}

/// Sends a draft with a picture as a browser would: fields, the file among them, and more fields.
async fn send_picture(client: &mut Client, draft: &str, file: &[u8], changed: &[(&str, &str)]) -> Answer {
    let mut fields = typed_in(&client.get(draft).await.text());
    for (name, value) in changed {
        let known = fields.iter_mut().find(|(known, _)| known == name);
        known.unwrap_or_else(|| panic!("no field {name}")).1 = (*value).to_owned();
    }
    fields.push(("act".to_owned(), "add:picture".to_owned()));
    let mut body = Vec::new();
    for (at, (name, value)) in fields.iter().enumerate() {
        if at == 5 {
            let head = "Content-Disposition: form-data; name=\"new.picture\"; filename=\"Frau Beispiel.png\"";
            body.extend(format!("--XX\r\n{head}\r\nContent-Type: image/png\r\n\r\n").bytes());
            body.extend(file);
            body.extend(b"\r\n");
        }
        body.extend(format!("--XX\r\nContent-Disposition: form-data; name=\"{name}\"\r\n\r\n{value}\r\n").bytes());
    }
    body.extend(b"--XX--\r\n");
    let path = format!("{}/pictures", draft.split('#').next().unwrap_or_default());
    let request = Request::post(path).header(header::CONTENT_TYPE, "multipart/form-data; boundary=XX");
    client.send(request.body(Body::from(body)).unwrap()).await
}

/// Presses a button of a draft.
async fn press(client: &mut Client, draft: &str, act: &str) -> Answer {
    let mut fields = typed_in(&client.get(draft).await.text());
    fields.push(("act".to_owned(), act.to_owned()));
    let fields: Vec<(&str, &str)> = fields.iter().map(|(name, value)| (name.as_str(), value.as_str())).collect();
    client.form(draft.split('#').next().unwrap_or_default(), &fields).await
}

#[tokio::test]
async fn published_picture_has_localised_text_and_its_media_type() {
    let PictureSchool { app, mut trainee, .. } = PictureSchool::new().await;
    let page = trainee.get(PICTURED).await.text();
    let [src] = attributes(&page, "figure.picture img", "src").try_into().expect("one picture");
    let alt = attributes(&page, "figure.picture img", "alt").remove(0);
    let csrf = csrf_in(&page);
    trainee.form("/account/language", &[("csrf", &csrf), ("language", "de")]).await;
    let german = trainee.get(PICTURED).await.text();
    let german_alt = attributes(&german, "figure.picture img", "alt").remove(0);
    assert!(!alt.is_empty() && alt != german_alt, "{alt}");
    assert!(german_alt.contains("Gefäß") && german.contains("<figcaption"), "{german_alt}");
    let picture = trainee.get(&src).await;
    assert_eq!((picture.status.as_u16(), picture.body == shipped_picture()), (200, true), "byte for byte");
    for (name, value) in [
        ("content-type", "image/png"),
        ("x-content-type-options", "nosniff"),
        ("content-security-policy", "default-src 'none'; sandbox"),
        ("cache-control", "private, max-age=31536000, immutable"),
    ] {
        assert_eq!(picture.header(name), value, "{name}");
    }
    let again = Request::get(&src).header(header::IF_NONE_MATCH, picture.header("etag"));
    assert_eq!(trainee.send(again.body(Body::empty()).unwrap()).await.status, 304);
    let plain = src.split('?').next().unwrap();
    assert_eq!(trainee.get(plain).await.header("cache-control"), "private, no-cache");
    for nothing in ["0", "2", "-1", "x", "1.png"] {
        assert_eq!(trainee.get(&format!("{PICTURED}/pictures/{nothing}")).await.status, 404, "{nothing}");
    }
    assert_eq!(app.stranger().get(&src).await.status, 303);
    let south = app.school("South").await;
    app.member(south, Role::Administrator, "abroad@example.org").await;
    assert_eq!(app.signed_in("abroad@example.org").await.get(&src).await.status, 404);
}

#[tokio::test]
async fn a_station_is_told_of_the_pictures_and_gets_them() {
    let app = App::new().await;
    let school = app.school("North").await;
    app.publish(school).await;
    let mut station = app.with_token(&app.station(school).await);
    let told = station.get("/api/v1/exercises/avoid-the-vessel").await.json();
    let [picture] = told["pictures"].as_array().unwrap().as_slice() else { panic!("{told}") };
    assert!(told["exercise_toml"].as_str().unwrap().contains(picture["file"].as_str().unwrap()), "{told}");
    let got = station.get(picture["href"].as_str().unwrap()).await;
    assert_eq!((got.status.as_u16(), got.header("content-type")), (200, "application/octet-stream"));
    assert!(got.body == shipped_picture());
    station.get("/api/v1/exercises/avoid-the-vessel/pictures/9").await.is_problem(404, "nothing");
    let without = station.get("/api/v1/exercises/feel-the-layers").await.json();
    assert_eq!(without["pictures"], serde_json::json!([]));
}

#[tokio::test]
async fn instructor_adds_orders_removes_and_publishes_pictures() {
    let mut school = PictureSchool::new().await;
    let draft = school.draft("stop-in-the-fat").await;
    let client = &mut school.instructor;
    let file = [shipped_picture().as_slice(), b"<script>alert('Frau Beispiel')</script>"].concat();
    let added = send_picture(client, &draft, &file, &[("x.pass_mark", "61"), ("new.picture.alt", "The fat")]).await;
    assert_eq!(added.status, 303, "{}", added.text());
    assert!(added.header("location").ends_with("#f-picture-0"), "{}", added.header("location"));
    let added = send_picture(client, &draft, &shipped_picture(), &[("new.picture.alt", "The vessel")]).await;
    assert!(added.header("location").ends_with("#f-picture-1"), "{}", added.header("location"));
    let page = client.get(&draft).await.text();
    let [first, second] = attributes(&page, "img.thumb", "src").try_into().expect("two pictures");
    let shown = client.get(&first).await;
    assert_eq!((shown.status.as_u16(), shown.header("content-type")), (200, "image/png"));
    assert!(!String::from_utf8_lossy(&shown.body).contains("Beispiel"), "only what can be seen is kept");
    assert!(!page.contains("Beispiel"), "what the file was called can name a person");
    assert_ne!(first, second);
    press(client, &draft, "up:picture[1]").await;
    let page = client.get(&draft).await.text();
    assert_eq!(attributes(&page, "img.thumb", "src"), [second.clone(), first.clone()]);
    let toml = typed_in(&client.get(&format!("{draft}?view=toml")).await.text());
    let text = &toml.iter().find(|(name, _)| name == "document").unwrap().1;
    assert!(text.contains("[[picture]]\nfile = \"picture-2.png\"\nalt = \"The vessel\"\n"), "{text}");
    assert!(text.contains("pass_mark = 61"), "what was typed beside it is saved");
    press(client, &draft, "remove:picture[1]").await;
    assert_eq!(press(client, &draft, "publish").await.header("location"), "/exercises/stop-in-the-fat?published=yes");
    let page = school.trainee.get("/exercises/stop-in-the-fat").await.text();
    assert_eq!(attributes(&page, "figure.picture img", "alt"), ["The vessel"]);
    let src = attributes(&page, "figure.picture img", "src").remove(0);
    assert_eq!(school.trainee.get(&src).await.status, 200);
    assert_eq!(school.trainee.get(&second).await.status, 403, "a draft is for those who teach");
    let copy = begin_copy(&mut school.instructor, "stop-in-the-fat").await;
    let page = school.instructor.get(&copy).await.text();
    assert_eq!(attributes(&page, "img.thumb", "alt"), ["The vessel"], "a copy brings its pictures");
    let done = press(&mut school.instructor, &copy, "publish").await;
    assert_eq!(done.header("location"), "/exercises/another-one?published=yes", "{}", done.text());
}

async fn begin_copy(client: &mut Client, exercise: &str) -> String {
    let csrf = csrf_in(&client.get("/drafts").await.text());
    let copy = [("csrf", csrf.as_str()), ("kind", "exercise"), ("exercise", exercise), ("title", "Another one")];
    client.form("/drafts", &copy).await.header("location").to_owned()
}

#[tokio::test]
async fn invalid_picture_is_rejected_and_the_typed_fields_are_kept() {
    let mut school = PictureSchool::new().await;
    let draft = school.draft("stop-in-the-fat").await;
    let client = &mut school.instructor;
    let before = typed_in(&client.get(&draft).await.text());
    let huge = vec![0; MOST_SENT_BYTES + 1];
    let cut = &shipped_picture()[..2000];
    for (file, why) in [
        (&b""[..], "Choose a picture first."),
        (b"<svg xmlns=\"http://www.w3.org/2000/svg\"/>", "neither PNG nor JPEG"),
        (b"\0\0\0\x18ftypheic", "HEIC"),
        (cut, "unreadable as PNG"),
        (&huge, "larger than 12 MB"),
    ] {
        let changed = [("x.pass_mark", "61"), ("x.title.en", "Typed & kept"), ("new.picture.alt", "Said of it")];
        let refused = send_picture(client, &draft, file, &changed).await;
        assert_eq!(refused.status, 422, "{why}");
        let page = refused.text();
        assert!(page.contains(why) && page.contains("role=\"alert\""), "{why} is not said by {page}");
        let typed = typed_in(&page);
        for (name, value) in changed {
            assert!(typed.contains(&(name.to_owned(), value.to_owned())), "{name} is lost for {why}");
        }
    }
    let shown =
        |fields: &[(String, String)]| fields.iter().filter(|(name, _)| name != "csrf").cloned().collect::<Vec<_>>();
    assert_eq!(shown(&typed_in(&client.get(&draft).await.text())), shown(&before), "nothing was saved");
    let text = "#".repeat(2 * 1024 * 1024 + 1);
    let refused = send_picture(client, &draft, cut, &[("document", &text)]).await;
    assert_eq!(refused.status, 422, "only the file may be larger than 2 MB");
    assert!(refused.text().contains("more than 2 MB of text"), "{}", refused.text());
    let csrf = csrf_in(&client.get(&draft).await.text());
    let plain = client.form(&format!("{draft}/pictures"), &[("csrf", &csrf)]).await;
    assert_eq!(plain.status, 400, "a form that brings no file");
    let mut forged =
        Request::post(format!("{draft}/pictures")).header(header::CONTENT_TYPE, "multipart/form-data; boundary=XX");
    forged = forged.header(header::ACCEPT, "text/html");
    let body = "--XX\r\nContent-Disposition: form-data; name=\"new.picture\"; filename=\"x\"\r\n\r\nx\r\n--XX--\r\n";
    assert_eq!(client.send(forged.body(Body::from(body)).unwrap()).await.status, 403, "no page of ours sent it");
}

#[tokio::test]
async fn draft_limits_its_pictures_and_rejects_unknown_files() {
    let mut school = PictureSchool::new().await;
    let draft = school.draft("stop-in-the-fat").await;
    let client = &mut school.instructor;
    for _ in 0..MOST_PICTURES {
        let added = send_picture(client, &draft, &shipped_picture(), &[("new.picture.alt", "One")]).await;
        assert_eq!(added.status, 303, "{}", added.text());
    }
    let page = client.get(&draft).await.text();
    assert!(attributes(&page, "input[type=file]", "name").is_empty(), "there is no room for another");
    let mut fields = typed_in(&client.get(&format!("{draft}?view=toml")).await.text());
    let document = fields.iter_mut().find(|(name, _)| name == "document").unwrap();
    document.1 = document.1.replace("file = \"picture-1.png\"", "file = \"elsewhere.png\"");
    fields.push(("act".to_owned(), "publish".to_owned()));
    let fields: Vec<(&str, &str)> = fields.iter().map(|(name, value)| (name.as_str(), value.as_str())).collect();
    let refused = client.form(&draft, &fields).await;
    assert_eq!(refused.status, 422);
    assert!(
        refused.text().contains("picture[0].file: &#34;elsewhere.png&#34;; allowed: picture-1.png"),
        "{}",
        refused.text()
    );
    press(client, &draft, "form").await;
    let page = client.get(&draft).await.text();
    assert!(page.contains("elsewhere.png") && attributes(&page, "img.thumb", "src").len() == MOST_PICTURES - 1);
}

#[tokio::test]
async fn somebody_elses_save_is_not_passed_over_by_a_picture() {
    let mut school = PictureSchool::new().await;
    let draft = school.draft("stop-in-the-fat").await;
    let (mut theirs, client) = (school.instructor.clone(), &mut school.instructor);
    press(&mut theirs, &draft, "save").await;
    let late = send_picture(client, &draft, &shipped_picture(), &[("seen", "1"), ("new.picture.alt", "Late")]).await;
    assert_eq!(late.status, 409, "{}", late.text());
    assert!(attributes(&client.get(&draft).await.text(), "img.thumb", "src").is_empty());
}
