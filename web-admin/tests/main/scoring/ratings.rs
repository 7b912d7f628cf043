//! Ratings by several instructors, through the front door. Fails when a rater is sent whose attempt it is, how it was
//! scored or what the others gave; when a finished rating changes; when agreement is another than the formula's; and when
//! somebody rates who was not asked.

use acts::authoring::instruments;
use acts::training::deadlines;
use model::Role;
use model::ids::SessionId;
use store::studies::{self, NewParticipant, NewStudy};
use web_admin::{outbox, worker};

use crate::support::client::{Answer, Client, csrf_in};
use crate::support::recordings::{Attempt, record};
use crate::support::{App, Member, course_folder};

const ITEMS: [&str; 7] = ["preparation", "tissue", "control", "economy", "feel", "flow", "overall"];
const NAME: &str = "Ada Quillfeather";

struct School {
    app: App,
    ada: Member,
    raters: [Member; 2],
    attempts: Vec<SessionId>,
}

impl School {
    /// Ada has made three attempts. Her teacher asks; one rater teaches her, too, the other does not.
    async fn new() -> Self {
        let app = App::new().await;
        let north = app.school("North").await;
        app.publish(north).await;
        let now = app.state.clock.now();
        let document = course_folder().with_file_name("instruments").join("global-rating-puncture.toml");
        app.write(async |tx| instruments::publish(tx, north, &document, now).await.unwrap()).await;
        let ada = app.member(north, Role::Trainee, "ada@example.org").await;
        let teacher = app.member(north, Role::Instructor, "teacher@example.org").await;
        let near = app.member(north, Role::Instructor, "near@example.org").await;
        let far = app.member(north, Role::Instructor, "far@example.org").await;
        app.cohort(north, "Spring", &[&ada.person, &teacher.person, &near.person]).await;
        let named = sqlx::query("UPDATE people SET display_name = $1 WHERE id = $2").bind(NAME).bind(ada.person.id);
        app.write(async |tx| named.execute(tx).await.unwrap()).await;
        let mut attempts = Vec::new();
        for depth_mm in [10.0, 14.0, 18.0] {
            let attempt = Attempt { depth_mm, ..Attempt::default() };
            assert_eq!(app.with_token(&ada.token).upload(&record(&attempt)).await.status, 201);
            attempts.push(attempt.session_id);
        }
        worker::work_off_jobs(&app.state).await.unwrap();
        Self { app, ada, raters: [near, far], attempts }
    }

    async fn teacher(&self) -> Client {
        self.app.signed_in("teacher@example.org").await
    }

    /// Asks both raters for ratings of some attempts.
    async fn ask(&self, teacher: &mut Client, title: &str, attempts: &[SessionId]) -> Answer {
        let csrf = csrf_in(&teacher.get("/ratings/new").await.text());
        let raters = self.raters.each_ref().map(|rater| rater.person.id.to_string());
        let attempts: Vec<String> = attempts.iter().map(SessionId::to_string).collect();
        let mut fields = vec![("csrf", csrf.as_str()), ("title", title), ("instrument", "global-rating-puncture")];
        fields.extend(raters.iter().map(|id| ("rater", id.as_str())));
        fields.extend(attempts.iter().map(|id| ("attempt", id.as_str())));
        teacher.form("/ratings", &fields).await
    }

    /// A round of all attempts, and its page.
    async fn round(&self, teacher: &mut Client) -> String {
        let asked = self.ask(teacher, "Spring round", &self.attempts).await;
        assert_eq!(asked.status, 303, "{}", asked.text());
        asked.header("location").to_owned()
    }
}

/// Gives every item of a rating the same points.
async fn rate(rater: &mut Client, page: &str, points: &str, step: &str) -> Answer {
    let csrf = csrf_in(&rater.get(page).await.text());
    let items = ITEMS.map(|item| format!("q.{item}"));
    let mut fields = vec![("csrf", csrf.as_str()), ("do", step)];
    fields.extend(items.iter().map(|name| (name.as_str(), points)));
    rater.form(page, &fields).await
}

/// Finishes everything that a rater is asked for in a round, by the attempts' exercise order unknown to them.
async fn rate_all(rater: &mut Client, round: &str, points: &[&str]) {
    for points in points {
        let next = rater.get(round).await.link("/rate/");
        assert_eq!(rate(rater, &next, points, "finish").await.status, 303);
    }
}

#[tokio::test]
async fn rater_sees_no_name_no_score_and_no_rating_of_others() {
    let school = School::new().await;
    let mut teacher = school.teacher().await;
    let round = school.round(&mut teacher).await;
    let mut far = school.app.signed_in("far@example.org").await;
    rate_all(&mut far, &round, &["5", "5", "5"]).await;
    let mut near = school.app.signed_in("near@example.org").await;
    let own = near.get(&round).await.link("/rate/");
    let id = own.rsplit('/').next().unwrap();
    let api = format!("/api/v1/ratings/{id}");
    let paths = ["/ratings", &round, &own, &format!("{api}/replay"), &format!("{api}/series?points=50")];
    for path in paths {
        let answer = near.get(path).await;
        assert_eq!(answer.status, 200, "{path}");
        let text = answer.text();
        for hidden in [NAME, &school.ada.person.pseudonym, "out of 100", "/sessions/", "ICC", "Mean"] {
            assert!(!text.contains(hidden), "{path} tells {hidden}: {text}");
        }
        assert!(school.attempts.iter().all(|attempt| !text.contains(&attempt.to_string())), "{path}: {text}");
    }
    for part in ["replay", "replay/frames"] {
        let asked = axum::http::Request::get(format!("{api}/{part}"))
            .header("if-modified-since", "Fri, 01 Jan 2100 00:00:00 GMT");
        let answer = near.send(asked.body(axum::body::Body::empty()).unwrap()).await;
        assert_eq!(answer.status, 200, "a condition finds out no time");
        for telling in ["last-modified", "etag"] {
            assert_eq!(answer.header(telling), "", "{part}");
        }
    }
    let frames = near.get(&format!("{api}/replay/frames")).await;
    assert!(frames.status == 200 && frames.body.len() > 1000, "the replay is there");
    assert_eq!(near.get(&format!("{round}/ratings.csv")).await.status, 409);
    let grade = format!("/sessions/{}/grade", school.attempts[0]);
    assert!(!near.get(&grade).await.text().contains("Global rating"), "nor on the page of the grade");

    rate_all(&mut near, &round, &["3", "3", "3"]).await;
    assert!(near.get(&round).await.text().contains(NAME), "it is told once all are finished");
    assert!(near.get(&grade).await.text().contains("Global rating"));
    assert!(!far.get(&round).await.text().contains(NAME), "and only of those whom one teaches");
}

#[tokio::test]
async fn a_rating_is_not_finished_by_oversight() {
    let school = School::new().await;
    let round = school.round(&mut school.teacher().await).await;
    let mut far = school.app.signed_in("far@example.org").await;
    let page = far.get(&round).await.link("/rate/");
    let csrf = csrf_in(&far.get(&page).await.text());
    let first = format!("q.{}", ITEMS[0]);
    let some = [("csrf", csrf.as_str()), ("do", "finish"), (first.as_str(), "4")];
    let refused = far.form(&page, &some).await;
    assert_eq!(refused.status, 422);
    assert_eq!(refused.text().matches("Choose one, or tick").count(), ITEMS.len() - 1, "{}", refused.text());
    let leave: Vec<String> = ITEMS[1..].iter().map(|item| format!("leave.{item}")).collect();
    let mut on_purpose = some.to_vec();
    on_purpose.extend(leave[1..].iter().map(|name| (name.as_str(), "yes")));
    let one_left = far.form(&page, &on_purpose).await;
    assert_eq!((one_left.status.as_u16(), one_left.text().matches("Choose one, or tick").count()), (422, 1));
    on_purpose.push((leave[0].as_str(), "yes"));
    assert_eq!(far.form(&page, &on_purpose).await.status, 303);
    assert!(far.get(&page).await.text().contains("Finished"));
}

#[tokio::test]
async fn whoever_asked_sees_agreement_and_the_trainee_the_mean() {
    let school = School::new().await;
    let mut teacher = school.teacher().await;
    let round = school.round(&mut teacher).await;
    let page = teacher.get(&round).await.text();
    assert!(page.contains("0 of 3") && page.contains("not computable: 0 observations, at least 2 needed"), "{page}");
    // By attempt, not by the rater's own order: near gives 1, 2, 4 and far 2, 4, 5 of 5, so 7, 14, 28 and 14, 28, 35.
    for (email, points) in [("near@example.org", ["1", "2", "4"]), ("far@example.org", ["2", "4", "5"])] {
        let mut rater = school.app.signed_in(email).await;
        for (attempt, points) in school.attempts.iter().zip(points) {
            let id: SessionId = sqlx::query_scalar(
                "SELECT r.id FROM ratings r JOIN people p ON p.id = r.rater_id WHERE p.email = $1 AND r.session_id = $2",
            )
            .bind(email)
            .bind(attempt)
            .fetch_one(school.app.state.db.reader())
            .await
            .unwrap();
            assert_eq!(rate(&mut rater, &format!("/rate/{id}"), points, "finish").await.status, 303);
        }
    }
    // MSR 220.5, MSC 130.67, MSE 8.17: (2,1) = 212.33/(228.67 + 2·122.5/3), (2,k) = 212.33/(220.5 + 122.5/3).
    let page = teacher.get(&round).await.text();
    for wanted in ["3 of 3", "0.68", "0.81", "3 attempts", "; 0 excluded"] {
        assert!(page.contains(wanted), "{wanted} is missing in {page}");
    }
    let csv = teacher.get(&format!("{round}/ratings.csv")).await.text();
    assert_eq!(csv.lines().count(), 7, "{csv}");
    assert!(
        csv.lines().next().unwrap().ends_with("feel,flow,overall,global,trainee_id,pseudonym,rater_id,may_know")
            && csv.contains(",35"),
        "{csv}"
    );
    let told = |line: &&str| {
        line.ends_with(if line.contains(&school.raters[0].person.id.to_string()) { ",yes" } else { ",no" })
    };
    assert_eq!(csv.lines().skip(1).filter(told).count(), 6, "one of the raters teaches Ada: {csv}");
    assert!(page.contains("may recognise the trainee"), "{page}");
    let far = school.app.signed_in("far@example.org").await.get(&format!("{round}/ratings.csv")).await.text();
    assert!(
        school.attempts.iter().all(|attempt| !far.contains(&attempt.to_string())),
        "no id, which tells the time: {far}"
    );
    let mut ada = school.app.signed_in("ada@example.org").await;
    let grade = ada.get(&format!("/sessions/{}/grade", school.attempts[2])).await.text();
    assert!(grade.contains("31.5") && grade.contains("Global rating") && !grade.contains(&round), "{grade}");
    assert_eq!(ada.get(&round).await.status, 403);
    let held = ada.get("/account/export").await.json();
    let given = held["ratings"].as_array().unwrap();
    assert!(given.len() == 6 && given.iter().any(|rating| rating["answers"][0] == 5.0), "{held}");
    assert!(!held.to_string().contains(&school.raters[0].person.id.to_string()), "without the raters: {held}");
}

#[tokio::test]
async fn rating_is_saved_as_given_and_closed_when_finished() {
    let school = School::new().await;
    let mut teacher = school.teacher().await;
    let round = school.round(&mut teacher).await;
    let mut near = school.app.signed_in("near@example.org").await;
    let own = near.get(&round).await.link("/rate/");
    assert_eq!(rate(&mut near, &own, "4", "save").await.status, 204);
    let page = near.get(&own).await.text();
    assert_eq!(page.matches("value=\"4\" checked").count(), 7, "{page}");
    let refused = rate(&mut near, &own, "9", "finish").await;
    assert_eq!(refused.status, 422);
    assert!(refused.text().contains("role=\"alert\""), "{}", refused.text());
    assert_eq!(rate(&mut near, &own, "2", "maybe").await.status, 400);
    assert_eq!(rate(&mut near, &own, "2", "finish").await.status, 303);
    for step in ["save", "finish"] {
        assert_eq!(rate(&mut near, &own, "5", step).await.status, 409, "{step} after the end");
    }
    let mut far = school.app.signed_in("far@example.org").await;
    let id = own.rsplit('/').next().unwrap();
    for path in [own.clone(), format!("/api/v1/ratings/{id}/replay"), format!("/api/v1/ratings/{id}/series")] {
        assert_eq!(far.get(&path).await.status, 404, "somebody else's rating: {path}");
        assert_eq!(teacher.get(&path).await.status, 404, "also for whoever asked: {path}");
    }
}

#[tokio::test]
async fn what_cannot_be_asked_is_refused_and_what_was_typed_stays() {
    let school = School::new().await;
    let mut teacher = school.teacher().await;
    for (title, attempts, word) in
        [("", &school.attempts[..], "title: 0 characters"), ("A \"round\"", &[], "Attempts: 0")]
    {
        let refused = school.ask(&mut teacher, title, attempts).await;
        assert_eq!(refused.status, 422, "{}", refused.text());
        let page = refused.text().to_lowercase();
        assert!(page.contains(&word.to_lowercase()), "{page}");
        assert_eq!(page.matches(" checked").count(), 2 + attempts.len(), "{page}");
    }
    assert_eq!(school.ask(&mut teacher, "x", &[SessionId::random()]).await.status, 404);
    let mut far = school.app.signed_in("far@example.org").await;
    assert_eq!(school.ask(&mut far, "x", &school.attempts).await.status, 404, "not an attempt of theirs");
    let csrf = csrf_in(&teacher.get("/ratings/new").await.text());
    let (attempt, ada) = (school.attempts[0].to_string(), school.ada.person.id.to_string());
    let near = school.raters[0].person.id.to_string();
    let common =
        [("csrf", csrf.as_str()), ("title", "x"), ("instrument", "global-rating-puncture"), ("attempt", &attempt)];
    for (raters, word) in [(&[&near][..], "raters: 1"), (&[&near, &ada], "instructors of the school")] {
        let fields: Vec<_> = common.into_iter().chain(raters.iter().map(|id| ("rater", id.as_str()))).collect();
        let refused = teacher.form("/ratings", &fields).await;
        assert_eq!(refused.status, 422);
        assert!(refused.text().to_lowercase().contains(word), "{}", refused.text());
    }
    let rounds: i64 =
        sqlx::query_scalar("SELECT count(*) FROM rating_rounds").fetch_one(school.app.state.db.reader()).await.unwrap();
    assert_eq!(rounds, 0, "nothing was half-made");
}

#[tokio::test]
async fn a_round_that_was_taken_back_is_gone_for_everybody() {
    let school = School::new().await;
    let mut teacher = school.teacher().await;
    let round = school.round(&mut teacher).await;
    let mut near = school.app.signed_in("near@example.org").await;
    rate_all(&mut near, &round, &["3"]).await;
    let open = near.get(&round).await.link("/rate/");
    assert!(near.get("/review").await.text().contains("Rate 2 attempts"));
    let csrf = csrf_in(&near.get(&round).await.text());
    assert_eq!(near.form(&format!("{round}/withdraw"), &[("csrf", &csrf)]).await.status, 403, "a rater cannot");
    let csrf = csrf_in(&teacher.get(&round).await.text());
    assert_eq!(teacher.form(&format!("{round}/withdraw"), &[("csrf", &csrf)]).await.status, 303);
    for path in [&round, &open] {
        assert_eq!(near.get(path).await.status, 404, "{path}");
    }
    let grade = teacher.get(&format!("/sessions/{}/grade", school.attempts[0])).await.text();
    assert!(!grade.contains("Global rating"), "{grade}");
    assert!(!near.get("/review").await.text().contains("Rate 2"));
}

#[tokio::test]
async fn raters_are_reminded_once_after_a_week() {
    let school = School::new().await;
    let mut teacher = school.teacher().await;
    let round = school.round(&mut teacher).await;
    let mut near = school.app.signed_in("near@example.org").await;
    rate_all(&mut near, &round, &["3", "3", "3"]).await;
    let letters = async || {
        deadlines::remind(&school.app.state).await.unwrap();
        outbox::work_off_letters(&school.app.state).await.unwrap();
        let rows = sqlx::query_scalar("SELECT count(*) FROM mails WHERE kind = 'reminder' AND sent_at IS NOT NULL");
        let count: i64 = rows.fetch_one(school.app.state.db.reader()).await.unwrap();
        count
    };
    assert_eq!(letters().await, 0, "not on the first day");
    let older = sqlx::query("UPDATE rating_rounds SET made_at = made_at - $1").bind(8 * 86_400_000_000_i64);
    school.app.write(async |tx| older.execute(tx).await.unwrap()).await;
    assert_eq!([letters().await, letters().await], [1, 1], "the one who has not rated, once");
}

#[tokio::test]
async fn a_rater_who_runs_a_study_with_the_trainee_is_marked() {
    let school = School::new().await;
    let far = school.raters[1].person.clone().into_current().unwrap();
    let (app, now) = (&school.app, school.app.state.clock.now());
    let lines = ["One".to_owned()];
    let new = NewStudy {
        school_id: far.school_id,
        title: "A study",
        owner_id: far.id,
        attempts: 3,
        groups: &lines,
        questions: &[],
        consent: "I take part.",
        controller: "North",
        contact: "a@example.org",
        kept_months: 12,
        generated: false,
    };
    let id = app.write(async |tx| studies::insert_study(tx, &new, now).await.unwrap()).await;
    let study = studies::find_visible_study(app.state.db.reader(), &far, id).await.unwrap().unwrap();
    let ada =
        NewParticipant { study: &study, person_id: school.ada.person.id, group_place: 0, facts: &[], added_by: far.id };
    assert!(app.write(async |tx| studies::add_participant(tx, ada, now).await.unwrap()).await);
    let mut teacher = school.teacher().await;
    school.round(&mut teacher).await;
    let marked: i64 = sqlx::query_scalar("SELECT count(*) FROM ratings WHERE may_know AND rater_id = $1")
        .bind(far.id)
        .fetch_one(app.state.db.reader())
        .await
        .unwrap();
    assert_eq!(marked, 3, "who is asked to take part may be known to whoever asks");
}

#[tokio::test]
async fn a_rating_that_waits_stands_on_the_raters_home_page() {
    let school = School::new().await;
    let mut teacher = school.teacher().await;
    let round = school.round(&mut teacher).await;
    let home = school.app.signed_in("far@example.org").await.get("/").await.text();
    assert!(home.contains("asks you to rate 3 attempts: “Spring round”") && home.contains(&round), "{home}");
    assert!(!teacher.get("/").await.text().contains("asks you to rate"), "who asks is not asked");
}
