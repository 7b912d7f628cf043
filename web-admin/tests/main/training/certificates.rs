//! A certificate through the front door: who has mastered a course saves a page, and anybody checks it without the service.
//! Fails when one is issued for less, in another's language, or when what is printed or signed is not what was earned.

use acts::authoring::publishing;
use acts::training::certificates;
use data_encoding::HEXLOWER;
use model::ids::SessionId;
use model::training::certificate::check_certificate;
use model::training::certificate_note::CertificateNote;
use model::{Moment, PersonKey, Role};
use pages::training::qr::draw_qr_code;
use platform::clock::Clock;
use platform::config::Config;
use sha2::{Digest, Sha256};
use store::people;
use web_admin::worker;
use words::Language;

use crate::support::client::{Client, csrf_in};
use crate::support::recordings::{Attempt, FORGED, record};
use crate::support::{App, Member, course_folder};

/// 2026-05-20 09:30 UTC; attempts begin before.
const NOW: Moment = Moment::from_micros(1_779_269_400_000_000);
/// A course of one exercise that is mastered with one pass, whatever the score.
const COURSE: &str = "id = \"one-step\"\ntitle = \"One <step> & no more\"\n[mastery]\nrule = \"passes\"\npasses = 1\nof = 1\n\
                      [[exercise]]\nfile = \"only.toml\"\n";

pub(super) async fn school() -> (App, Member) {
    school_with(|_| {}).await
}

/// The same, with changes to the configuration.
pub(super) async fn school_with(change: impl FnOnce(&mut Config)) -> (App, Member) {
    let app = App::with(Clock::fixed(NOW), change).await;
    let school = app.school("North & Sons").await;
    let folder = app.folder.path().join("short");
    std::fs::create_dir_all(folder.join("course")).unwrap();
    std::fs::create_dir_all(folder.join("scenes")).unwrap();
    for scene in std::fs::read_dir(course_folder().join("../scenes")).unwrap() {
        let scene = scene.unwrap();
        std::fs::copy(scene.path(), folder.join("scenes").join(scene.file_name())).unwrap();
    }
    let exercise = std::fs::read_to_string(course_folder().join("1-feel-the-layers.toml")).unwrap();
    std::fs::write(folder.join("course/only.toml"), exercise.replace("pass_mark = 60", "pass_mark = 0")).unwrap();
    let path = folder.join("course/course.toml");
    std::fs::write(&path, COURSE).unwrap();
    let now = app.state.clock.now();
    app.write(async |tx| publishing::course(tx, school, &path, now).await.unwrap()).await;
    let ada = app.member(school, Role::Trainee, "ada@example.org").await;
    app.member(school, Role::Administrator, "head@example.org").await;
    let teacher = app.member(school, Role::Instructor, "teacher@example.org").await;
    app.cohort(school, "A", &[&ada.person, &teacher.person]).await;
    (app, ada)
}

#[tokio::test]
async fn mastered_course_gives_a_certificate_that_anyone_can_verify() {
    let (app, ada) = school().await;
    let german = Language::named("de");
    app.write(async |tx| {
        people::set_language(tx, PersonKey { school_id: ada.person.school_id, person_id: ada.person.id }, german)
            .await
            .unwrap()
    })
    .await;
    let mut browser = app.signed_in("ada@example.org").await;
    let csrf = csrf_in(&browser.get("/account").await.text());
    let address = format!("/trainees/{}/certificates/one-step", ada.person.id);
    let none = browser.form(&address, &[("csrf", &csrf)]).await;
    assert_eq!(none.status, 409, "{}", none.text());

    let attempt = Attempt { bundle: &FORGED, ..Attempt::default() };
    app.with_token(&ada.token).upload(&record(&attempt)).await;
    worker::work_off_jobs(&app.state).await.unwrap();
    let unproved = browser.form(&address, &[("csrf", &csrf)]).await;
    assert_eq!(unproved.status, 409, "mastered, and neither signed nor supervised: {}", unproved.text());
    assert!(!browser.get("/").await.text().contains(&address));
    let mut teacher = app.signed_in("teacher@example.org").await;
    let theirs = csrf_in(&teacher.get("/account").await.text());
    let there = format!("/sessions/{}/supervision", attempt.session_id);
    assert_eq!(teacher.form(&there, &[("csrf", &theirs), ("confirm", "yes")]).await.status, 303);
    assert!(browser.get("/").await.text().contains(&address), "supervised");
    let page = browser.form(&address, &[("csrf", &csrf)]).await;
    assert_eq!((page.status.as_u16(), page.header("content-type")), (200, "text/html; charset=utf-8"));
    assert!(page.header("content-disposition").contains("certificate-one-step.html"));
    let html = page.text();
    assert!(html.contains("<html lang=\"de\">") && html.contains("One &#60;step&#62; &#38; no more"), "{html}");
    assert!(!html.contains("src=") && !html.contains("href="), "it needs nothing else: {html}");

    let key = certificates::public_key(&app.state.config.keys_dir).unwrap();
    let stated = check_certificate(html.as_bytes(), &key).unwrap();
    assert_eq!((stated.school.as_str(), stated.course.as_str()), ("North & Sons", "One <step> & no more"));
    assert_eq!(stated.trainee, ada.person.display_name);
    assert_eq!(stated.exercises.len(), 1);
    assert!(stated.rule.starts_with("mastered with 1 pass"), "what programs read is English: {}", stated.rule);
    assert!(stated.attempts.is_some_and(|told| told.contains("supervised")));
    let note = CertificateNote {
        note: CertificateNote::VERSION,
        school: stated.school.clone(),
        trainee: stated.trainee.clone(),
        course: stated.course.clone(),
        issued_at: stated.issued_at.clone(),
    };
    let query = note.signed_query(&certificates::signing_key(&app.state.config.keys_dir).unwrap()).unwrap();
    let code = draw_qr_code(&format!("{}/certificate?{query}", app.state.config.address())).unwrap();
    assert!(html.contains(&code), "the code on the page is that of what is certified");
    let checked = app.stranger().get(&format!("/certificate?{query}")).await;
    assert!(checked.status == 200 && checked.text().contains("Genuine"), "{}", checked.text());
    let changed = app.stranger().get(&format!("/certificate?{}", query.replacen("of=", "of=A", 1))).await;
    assert!(changed.status == 200 && changed.text().contains("Not genuine"), "{}", changed.text());
    let forged = html.replace("North", "South");
    assert!(check_certificate(forged.as_bytes(), &key).unwrap_err().to_string().contains("signature"));

    let mut head = app.signed_in("head@example.org").await;
    let theirs = csrf_in(&head.get("/admin").await.text());
    let mut ask = async |needed| head.form("/admin/certificate-needs", &[("csrf", &theirs), ("needed", needed)]).await;
    assert_eq!(ask("nothing").await.status, 303);
    let confirm = [("csrf", csrf_in(&teacher.get("/account").await.text())), ("confirm", "no".to_owned())];
    teacher.form(&there, &confirm.each_ref().map(|(key, value)| (*key, value.as_str()))).await;
    assert_eq!(browser.form(&address, &[("csrf", &csrf)]).await.status, 200, "the school asks for nothing more");
    assert_eq!(ask("supervised").await.status, 303);
    assert_eq!(browser.form(&address, &[("csrf", &csrf)]).await.status, 409);
    assert_eq!(ask("everything").await.status, 400);
}

/// A year's results are not taken back because the course grows: publishing says whom it concerns, asks, and leaves masteries as they are.
#[tokio::test]
async fn a_course_that_grows_takes_the_mastery_from_nobody() {
    let (app, ada) = school().await;
    let school = ada.person.school_id;
    let bo = app.member(school, Role::Trainee, "bo@example.org").await;
    let attempt = Attempt { bundle: &FORGED, ..Attempt::default() };
    app.with_token(&ada.token).upload(&record(&attempt)).await;
    worker::work_off_jobs(&app.state).await.unwrap();
    app.publish(school).await;
    let mut head = app.signed_in("head@example.org").await;
    let csrf = csrf_in(&head.get("/admin").await.text());
    assert_eq!(head.form("/admin/certificate-needs", &[("csrf", &csrf), ("needed", "nothing")]).await.status, 303);
    let mut browser = app.signed_in("ada@example.org").await;
    let address = format!("/trainees/{}/certificates/one-step", ada.person.id);
    assert!(browser.get("/").await.text().contains(&address), "mastered");

    let mut teacher = app.signed_in("teacher@example.org").await;
    let csrf = csrf_in(&teacher.get("/account").await.text());
    let fields = [("csrf", csrf.as_str()), ("course", "one-step")];
    let added = teacher.form("/exercises/thick-fat/course", &fields).await;
    assert_eq!(added.status, 303, "{}", added.text());
    let draft = added.header("location").split('#').next().unwrap().to_owned();
    let page = teacher.get(&draft).await;
    let publish = async |teacher: &mut Client, seen: &str, act: &str| {
        let document = format!("{COURSE}[[exercise]]\nfile = \"thick-fat\"\n");
        let fields = [("csrf", csrf.as_str()), ("seen", seen), ("document", &document), ("act", act)];
        teacher.form(&draft, &fields).await
    };
    let asked = publish(&mut teacher, &seen_in(&page.text()), "publish").await;
    assert_eq!(asked.status, 422, "{}", asked.text());
    assert!(
        asked.text().contains("1 person has mastered the current revision")
            && !asked.text().contains("have started the course"),
        "{}",
        asked.text()
    );
    let done = publish(&mut teacher, &seen_in(&asked.text()), "insist").await;
    assert_eq!(done.header("location"), "/curricula?published=one-step", "{}", done.text());

    let home = browser.get("/").await.text();
    for said in ["Course mastered", "Added since:", "1</strong> of 2 exercises mastered", address.as_str()] {
        assert!(home.contains(said), "{said} is not in {home}");
    }
    let csrf = csrf_in(&home);
    let page = browser.form(&address, &[("csrf", &csrf)]).await;
    let key = certificates::public_key(&app.state.config.keys_dir).unwrap();
    let stated = check_certificate(page.text().as_bytes(), &key).unwrap();
    assert_eq!(stated.exercises.len(), 1, "what was mastered is what is certified");
    assert_eq!(stated.curriculum_sha256, sha256_of(COURSE), "by the revision under which it was");
    let transcript = browser.get(&format!("/trainees/{}/transcript", ada.person.id)).await.text();
    assert!(transcript.contains("Course mastered on "), "{transcript}");
    let mut bos = app.with_token(&bo.token);
    app.state.clock.advance(3600);
    let started_at = app.state.clock.now().plus_s(-600).to_utc();
    let attempt = Attempt { session_id: SessionId::random(), bundle: &FORGED, started_at, ..Attempt::default() };
    bos.upload(&record(&attempt)).await;
    worker::work_off_jobs(&app.state).await.unwrap();
    let home = app.signed_in("bo@example.org").await.get("/").await.text();
    assert!(home.contains("1</strong> of 2 exercises") && !home.contains("Course mastered"), "after it grew: {home}");
}

fn seen_in(page: &str) -> String {
    page.split("name=\"seen\" value=\"").nth(1).and_then(|rest| rest.split('"').next()).expect("a version").to_owned()
}

fn sha256_of(text: &str) -> String {
    HEXLOWER.encode(&Sha256::digest(text.as_bytes()))
}

/// Who has mastered one course and goes on with another has mastered the first.
#[tokio::test]
async fn a_cohort_counts_who_has_mastered_the_course_that_is_chosen() {
    let (app, ada) = school().await;
    app.publish(ada.person.school_id).await;
    let mut trainee = app.with_token(&ada.token);
    trainee.upload(&record(&Attempt { bundle: &FORGED, ..Attempt::default() })).await;
    let mut teacher = app.signed_in("teacher@example.org").await;
    let later = Attempt { session_id: SessionId::random(), ..Attempt::default() };
    trainee.upload(&record(&later)).await;
    worker::work_off_jobs(&app.state).await.unwrap();
    let cohort = teacher.get("/cohorts").await.link("/cohorts/");
    let figure = |page: &str| {
        let rest = page.split("Mastered the course</dt><dd>").nth(1).expect("the figure");
        rest.split('<').next().expect("a number").to_owned()
    };
    let page = teacher.get(&format!("{cohort}?course=one-step")).await.text();
    assert_eq!(figure(&page), "1", "{page}");
    assert!(page.contains("1 of 1") && page.contains("One &#60;step&#62;"), "{page}");
    let page = teacher.get(&format!("{cohort}?course=lower-back-basics")).await.text();
    assert_eq!(figure(&page), "0", "{page}");
    assert!(teacher.get("/").await.text().contains("1 trainee, 1 with a course mastered"));
}
