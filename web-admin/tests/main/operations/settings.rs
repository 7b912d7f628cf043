//! What a school settles for itself. Fails when a value is lost or taken that cannot be had, when a letter goes out that the school does
//! not send, or in another language than it has chosen, and when a test letter that was not taken is said to be sent.

use model::ids::{AssignmentId, DatedId, SchoolId, SessionId};
use model::letters::mail::MailKind;
use model::{Moment, Role};
use platform::clock::Clock;
use platform::config::MailTo;
use store::letters::mails;
use store::letters::mails::NewMail;
use store::operations::schools;
use web_admin::{outbox, worker};

use crate::support::App;
use crate::support::client::{Answer, Client, csrf_in};
use crate::support::recordings::{Attempt, record};

const NOW: Moment = Moment::from_micros(1_767_268_800_000_000);
const PAGE: &str = "/admin/settings";

async fn post(head: &mut Client, path: &str, fields: &[(&str, &str)]) -> Answer {
    let csrf = csrf_in(&head.get(PAGE).await.text());
    head.form(path, &[&[("csrf", csrf.as_str())], fields].concat()).await
}

async fn school() -> (App, SchoolId, Client) {
    let app = App::with(Clock::fixed(NOW), |_| {}).await;
    let (north, _) = (app.school("North").await, app.school("South").await);
    app.member(north, Role::Administrator, "head@example.org").await;
    let head = app.signed_in("head@example.org").await;
    (app, north, head)
}

fn letters(app: &App) -> Vec<String> {
    let MailTo::Folder(folder) = &app.state.config.mail else { panic!("letters are files") };
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    entries.map(|entry| std::fs::read_to_string(entry.unwrap().path()).unwrap()).collect()
}

#[tokio::test]
async fn settings_apply_to_every_page_and_invalid_ones_are_rejected() {
    let (app, north, mut head) = school().await;
    let fields = |name, zone| [("name", name), ("time_zone", zone), ("letter_language", "de"), ("mails_news", "yes")];
    for (name, zone, why) in [
        ("South", "UTC", "another school"),
        ("", "UTC", "1 to 120"),
        ("a\u{7}b", "UTC", "name"),
        ("Northern", "Europe/Atlantis", "Europe/Atlantis"),
    ] {
        let refused = post(&mut head, PAGE, &fields(name, zone)).await;
        assert_eq!(refused.status, 422, "{name} {zone}");
        assert!(refused.text().contains(why), "{why}: {}", refused.text());
    }
    assert_eq!(schools::find_school_name(app.state.db.reader(), north).await.unwrap(), "North", "nothing has changed");
    let kept = post(&mut head, PAGE, &fields("  Northern School ", "Europe/Berlin")).await;
    assert_eq!(kept.header("location"), "/admin/settings?saved=true");
    let page = head.get(PAGE).await.text();
    assert!(
        page.contains("value=\"Northern School\"") && page.contains("All times: local time in Europe/Berlin"),
        "{page}"
    );
    assert!(head.get("/account").await.text().contains("Northern School"));
    let settled = schools::find_school_settings(app.state.db.reader(), north).await.unwrap();
    assert_eq!((settled.mails_reminders, settled.mails_news), (false, true), "a box that is not ticked is off");
    assert_eq!(post(&mut head, PAGE, &[("letter_language", "tlh")]).await.status, 400);
}

#[tokio::test]
async fn disabled_letter_stays_and_others_use_the_schools_language() {
    let (app, north, mut head) = school().await;
    let ada = app.member(north, Role::Trainee, "ada@example.org").await;
    let fields = [("name", "North"), ("time_zone", "UTC"), ("letter_language", "de")];
    post(&mut head, PAGE, &fields).await;
    for kind in [MailKind::Reset, MailKind::Reminder, MailKind::News] {
        let assignment_id = (kind == MailKind::Reminder).then(|| DatedId::from(AssignmentId::made_at(NOW)));
        let mail = NewMail { school_id: north, person_id: ada.person.id, kind, assignment_id };
        app.write(async |tx| mails::queue_mail(tx, mail, NOW).await.unwrap()).await;
    }
    outbox::work_off_letters(&app.state).await.unwrap();
    let sent = letters(&app);
    assert_eq!(sent.len(), 1, "the link alone: {sent:#?}");
    assert!(sent[0].contains("Passwort"), "{sent:#?}");
}

#[tokio::test]
async fn a_test_letter_tells_whether_it_was_taken() {
    let (app, _, mut head) = school().await;
    let sent = post(&mut head, "/admin/settings/test-letter", &[]).await;
    assert!(sent.status == 200 && sent.text().contains("was sent to head@example.org"), "{}", sent.text());
    assert!(letters(&app)[0].contains("settings page"), "{:?}", letters(&app));
    let closed =
        App::with(Clock::fixed(NOW), |config| config.mail = MailTo::Smtp("smtp://127.0.0.1:1".to_owned())).await;
    let north = closed.school("North").await;
    closed.member(north, Role::Administrator, "head@example.org").await;
    let mut head = closed.signed_in("head@example.org").await;
    let page = post(&mut head, "/admin/settings/test-letter", &[]).await.text();
    assert!(page.contains("was not sent") && page.contains("through the mail server"), "{page}");
}

#[tokio::test]
async fn trainees_see_cohort_figures_only_if_the_school_allows_it() {
    let (app, north, mut head) = school().await;
    app.publish(north).await;
    let teacher = app.member(north, Role::Instructor, "teacher@example.org").await;
    let mut members = Vec::new();
    for n in 0..6 {
        members.push(app.member(north, Role::Trainee, &format!("t{n}@example.org")).await);
    }
    let people: Vec<_> = members.iter().chain([&teacher]).map(|member| &member.person).collect();
    app.cohort(north, "Spring", &people).await;
    let mut own = None;
    for member in &members {
        let attempt = Attempt { session_id: SessionId::random(), ..Attempt::default() };
        assert_eq!(app.with_token(&member.token).upload(&record(&attempt)).await.status, 201);
        own.get_or_insert(attempt.session_id);
    }
    worker::work_off_jobs(&app.state).await.unwrap();
    let page = format!("/sessions/{}", own.unwrap());
    let heading = "<th scope=\"col\" class=\"num\">Cohort</th>";
    let mut trainee = app.signed_in("t0@example.org").await;
    assert!(trainee.get(&page).await.text().contains(heading), "five others");
    let fields = [("name", "North"), ("time_zone", "UTC"), ("letter_language", "en")];
    assert_eq!(post(&mut head, PAGE, &fields).await.status, 303);
    assert!(!trainee.get(&page).await.text().contains(heading), "the box is not ticked");
    let mut teacher = app.signed_in("teacher@example.org").await;
    assert!(teacher.get(&page).await.text().contains(heading), "whoever teaches sees them");
}
