//! Links of surveys by mail. Fails when somebody is written to twice, when an address reaches the audit log or leads to an answer,
//! when a letter that did not go out is not shown, or when one bad address lets the others go.

use std::path::PathBuf;

use platform::config::MailTo;
use store::surveys::{self as stored, letters};
use web_admin::outbox;

use crate::support::client::{Answer, Client, csrf_in};
use crate::surveys::{School, send};

/// Folder into which the letters of a school go.
fn folder(school: &School) -> PathBuf {
    let MailTo::Folder(folder) = &school.app.state.config.mail else { panic!("mail goes to a folder") };
    folder.clone()
}

/// Sends what is due; every letter that has gone out so far.
async fn letters_out(school: &School) -> Vec<String> {
    outbox::work_off_letters(&school.app.state).await.unwrap();
    let Ok(entries) = std::fs::read_dir(folder(school)) else { return Vec::new() };
    let mut read: Vec<String> = entries.map(|entry| std::fs::read_to_string(entry.unwrap().path()).unwrap()).collect();
    read.sort();
    read
}

fn link_in(letter: &str) -> String {
    // A long line is folded in a mail.
    let plain = letter.replace("=\r\n", "");
    let secret = plain.split("/survey/").nth(1).unwrap_or_else(|| panic!("no link in {letter}"));
    format!("/survey/{}", secret.split_whitespace().next().unwrap())
}

async fn ask(teacher: &mut Client, survey: &str, addresses: &str) -> Answer {
    let csrf = csrf_in(&teacher.get(survey).await.text());
    send(teacher, &format!("{survey}/links"), &[("csrf", &csrf), ("labels", addresses), ("do", "mail")]).await
}

#[tokio::test]
async fn each_professional_gets_one_letter_and_the_log_no_address() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let survey = school.survey(&mut teacher, "sus", &[("identity", "anonymous")]).await;
    let asked = ask(&mut teacher, &survey, "Dr Ek <Ek@example.org>\nbo@example.org\n").await;
    assert_eq!(asked.header("location"), format!("{survey}?mailed=2&before=0#letters"));
    let letters = letters_out(&school).await;
    assert_eq!(letters.len(), 2, "{letters:#?}");
    let ek = letters.iter().find(|letter| letter.contains("ek@example.org")).unwrap();
    assert!(ek.contains("Dear Dr Ek") && ek.contains("North"), "{ek}");
    assert!(school.app.stranger().get(&link_in(ek)).await.text().contains("are anonymous"));
    let again = ask(&mut teacher, &survey, "ek@example.org\ncy@example.org\ncy@example.org").await;
    assert_eq!(again.header("location"), format!("{survey}?mailed=1&before=2#letters"));
    assert_eq!(letters_out(&school).await.len(), 3, "one more");
    let page = teacher.get(again.header("location").split('#').next().unwrap()).await.text();
    assert!(page.contains("2 already received an email") && page.matches("Sent").count() >= 3, "{page}");
    let reader = school.app.state.db.reader();
    let told: Vec<String> =
        sqlx::query_scalar("SELECT details || object FROM audit_log").fetch_all(reader).await.unwrap();
    assert!(!told.iter().any(|line| line.contains('@')), "{told:#?}");
    let tied: i64 = sqlx::query_scalar(
        "SELECT (SELECT count(*) FROM survey_letters WHERE response_id IS NOT NULL)
           + (SELECT count(*) FROM survey_responses WHERE label IS NOT NULL)",
    )
    .fetch_one(reader)
    .await
    .unwrap();
    assert_eq!(tied, 0, "nothing leads from an address to an anonymous answer");
}

#[tokio::test]
async fn letters_of_a_school_have_an_hourly_limit_that_is_said_before() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let survey = school.survey(&mut teacher, "sus", &[("identity", "anonymous")]).await;
    assert!(teacher.get(&survey).await.text().contains("300 emails can be sent now"));
    let lines = |from: u32| (from..from + 200).map(|n| format!("p{n}@example.org\n")).collect::<String>();
    assert_eq!(ask(&mut teacher, &survey, &lines(0)).await.status, 303);
    let refused = ask(&mut teacher, &survey, &lines(200)).await;
    assert_eq!(refused.status, 422);
    assert!(refused.text().contains("200 emails; 100 can be sent now"), "{}", refused.text());
    school.app.state.clock.advance(3601);
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    assert_eq!(ask(&mut teacher, &survey, &lines(200)).await.status, 303, "an hour later they can");
}

#[tokio::test]
async fn a_title_begins_no_letter_and_a_line_turns_nothing_around() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    for title in ["A\n\nDear Ana,\nclick here", "A\u{202E}B", "A\u{2029}B"] {
        let csrf = csrf_in(&teacher.get("/surveys/new").await.text());
        let fields = [("csrf", csrf.as_str()), ("instrument", "sus"), ("title", title), ("identity", "anonymous")];
        let refused = send(&mut teacher, "/surveys/new", &fields).await;
        assert_eq!(refused.status, 422, "{title:?}: {}", refused.text());
    }
    let survey = school.survey(&mut teacher, "sus", &[("identity", "anonymous")]).await;
    assert_eq!(ask(&mut teacher, &survey, "Ana \u{202E}kE <ana@example.org>").await.status, 422);
}

#[tokio::test]
async fn one_bad_address_is_named_and_none_is_written_to() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let survey = school.survey(&mut teacher, "sus", &[("identity", "named")]).await;
    for bad in ["Dr B", "=cmd@example.org", "Dr B <b@>", "b@example.org c@example.org"] {
        let refused = ask(&mut teacher, &survey, &format!("ek@example.org\n{bad}")).await;
        assert_eq!(refused.status, 422, "{bad}");
        let page = refused.text();
        assert!(page.contains("allowed: ana@example.org") && page.contains("ek@example.org"), "{page}");
    }
    assert!(letters_out(&school).await.is_empty());
    let mut other = school.app.signed_in("other@example.org").await;
    assert_eq!(ask(&mut other, &survey, "ek@example.org").await.status, 403, "only its owner asks");
}

#[tokio::test]
async fn a_letter_that_cannot_go_out_says_why_and_goes_later() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let survey = school.survey(&mut teacher, "sus", &[("identity", "named")]).await;
    let blocked = folder(&school);
    std::fs::write(&blocked, "in the way").unwrap();
    ask(&mut teacher, &survey, "Dr Ek <ek@example.org>").await;
    outbox::work_off_letters(&school.app.state).await.unwrap();
    let page = teacher.get(&survey).await.text();
    assert!(page.contains("cannot create the mail folder") && page.contains("; next try"), "{page}");
    std::fs::remove_file(&blocked).unwrap();
    school.app.state.clock.advance(60);
    let letters = letters_out(&school).await;
    assert_eq!(letters.len(), 1);
    assert_eq!(
        school.app.stranger().get(&link_in(&letters[0])).await.status,
        200,
        "the link is the last that was made"
    );
    let links: i64 = sqlx::query_scalar("SELECT count(*) FROM survey_responses")
        .fetch_one(school.app.state.db.reader())
        .await
        .unwrap();
    assert_eq!(links, 1, "a second try makes no second link");
}

#[tokio::test]
async fn a_letter_under_way_when_the_service_dies_is_not_sent_again() {
    let school = School::new().await;
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    let survey = school.survey(&mut teacher, "sus", &[("identity", "named")]).await;
    let link = school.links(&mut teacher, &survey, "Dr Ek").await.remove(0);
    ask(&mut teacher, &survey, "Dr Ek <ek@example.org>").await;
    let state = &school.app.state;
    let due = letters::list_due_survey_letters(state.db.reader(), state.clock.now(), 10).await.unwrap();
    let token = platform::secret::token_sha256(link.trim_start_matches("/survey/"));
    let response = stored::by_token(state.db.reader(), &token).await.unwrap().unwrap();
    school.app.write(async |tx| letters::claim_survey_letter(tx, &due[0], response.id).await.unwrap()).await;
    state.clock.advance(7 * 24 * 3600);
    assert!(letters_out(&school).await.is_empty());
    let mut teacher = school.app.signed_in("teacher@example.org").await;
    assert!(teacher.get(&survey).await.text().contains("It may have been sent"));
}
