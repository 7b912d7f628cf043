//! Which language somebody reads: the one of their account, else of their cookie, else of their browser, else English.
//! Fails when a choice is not kept, when one overrides a better one, or when an API answer, a file or another school's
//! mail changes its language.

use axum::body::Body;
use axum::http::{Request, header};
use model::Role;
use web_admin::outbox;

use crate::support::client::{Answer, Client};
use crate::support::{App, PASSWORD};

async fn app() -> App {
    let app = App::new().await;
    let school = app.school("North").await;
    app.member(school, Role::Trainee, "ada@example.org").await;
    app
}

/// A page as a browser with these wishes gets it.
async fn wishing(client: &mut Client, path: &str, wishes: &str) -> Answer {
    let request = Request::get(path).header(header::ACCEPT_LANGUAGE, wishes).body(Body::empty()).unwrap();
    client.send(request).await
}

fn language(answer: &Answer) -> (String, bool) {
    let page = answer.text();
    let lang = page.split("<html lang=\"").nth(1).and_then(|rest| rest.split('"').next()).unwrap_or_default();
    assert_eq!(lang, answer.header("content-language"), "the page and its header agree");
    (lang.to_owned(), page.contains("Passwort"))
}

#[tokio::test]
async fn stranger_reads_the_browsers_language_or_their_choice() {
    let app = app().await;
    let mut stranger = app.stranger();
    assert_eq!(language(&stranger.get("/login").await), ("en".to_owned(), false));
    for (wishes, code) in
        [("de-AT,de;q=0.9,en;q=0.5", "de"), ("fi,en;q=0.5,de;q=0.1", "en"), ("fi, sv", "en"), ("=;,;q", "en")]
    {
        let page = wishing(&mut stranger, "/login", wishes).await;
        assert_eq!(language(&page), (code.to_owned(), code == "de"), "{wishes}");
        assert!(page.header("vary").contains("accept-language"), "{}", page.header("vary"));
    }
    for open in ["/forgotten", "/certificate"] {
        assert_eq!(language(&wishing(&mut stranger, open, "de").await).0, "de", "{open} asks nobody to sign in");
    }
    let csrf = stranger.csrf().await;
    let chosen = stranger.form("/language", &[("csrf", &csrf), ("language", "de"), ("next", "/account")]).await;
    assert_eq!((chosen.status.as_u16(), chosen.header("location")), (303, "/login?next=/account"));
    assert!(chosen.header("set-cookie").starts_with("stylet_language=de;"), "{}", chosen.header("set-cookie"));
    stranger.cookie = Some(format!("{}; stylet_language=de", stranger.cookie.clone().unwrap()));
    assert_eq!(language(&wishing(&mut stranger, "/login", "en").await).0, "de", "a choice is worth more than a wish");
    stranger.cookie = Some("stylet_language=tlh".to_owned());
    assert_eq!(language(&wishing(&mut stranger, "/login", "de").await).0, "de", "an unknown choice is none");
}

#[tokio::test]
async fn the_account_decides_wherever_somebody_signs_in() {
    let app = app().await;
    let mut ada = app.stranger();
    ada.sign_in("ada@example.org", PASSWORD).await;
    assert_eq!(language(&wishing(&mut ada, "/account", "de").await).0, "de", "nothing is chosen yet");
    let csrf = crate::support::client::csrf_in(&ada.get("/account").await.text());
    let unknown = ada.form("/account/language", &[("csrf", &csrf), ("language", "tlh")]).await;
    assert_eq!(unknown.status, 400);
    assert!(unknown.text().contains("“tlh”; allowed: en, de"), "{}", unknown.text());
    let set = ada.form("/account/language", &[("csrf", &csrf), ("language", "de")]).await;
    assert_eq!((set.status.as_u16(), set.header("location")), (303, "/account"));
    let mut elsewhere = app.stranger();
    elsewhere.sign_in("ada@example.org", PASSWORD).await;
    assert_eq!(language(&wishing(&mut elsewhere, "/account", "en").await), ("de".to_owned(), true));
    assert!(elsewhere.get("/account/export").await.json()["person"]["language"] == "de");
    let missing = elsewhere.get("/sessions/nonsense").await;
    assert_eq!(language(&missing).0, "de", "an error, too");
    elsewhere.form("/account/language", &[("csrf", &csrf), ("language", "")]).await;
}

#[tokio::test]
async fn a_mail_is_in_the_language_of_whoever_gets_it() {
    let app = app().await;
    let mut ada = app.stranger();
    ada.sign_in("ada@example.org", PASSWORD).await;
    let csrf = crate::support::client::csrf_in(&ada.get("/account").await.text());
    ada.form("/account/language", &[("csrf", &csrf), ("language", "de")]).await;
    let mut stranger = app.stranger();
    let csrf = stranger.csrf().await;
    stranger.form("/forgotten", &[("csrf", &csrf), ("email", "ada@example.org")]).await;
    outbox::work_off_letters(&app.state).await.unwrap();
    let folder = app.folder.path().join("mail");
    let letter = std::fs::read_dir(folder).unwrap().next().unwrap().unwrap().path();
    let text = std::fs::read_to_string(letter).unwrap();
    assert!(text.contains("Neues Passwort") && !text.contains("Dear"), "{text}");
}

#[tokio::test]
async fn what_programs_read_stays_english() {
    let app = app().await;
    let mut program = app.stranger();
    let refused = wishing(&mut program, "/api/v1/sessions", "de").await;
    refused.is_problem(401, "a bearer token is needed");
    assert_eq!(refused.header("content-language"), "");
}
