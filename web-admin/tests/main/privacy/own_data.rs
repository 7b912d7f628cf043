//! One's own data hold everything. Fails when a table that refers to a person, or to an attempt of theirs, is neither in the file nor named
//! below with a reason; when somebody's rows are missing from it; and when it holds a secret's hash.

use std::collections::BTreeSet;

use model::Role;
use model::ids::PersonId;
use serde_json::Value;
use sqlx::AssertSqlSafe;
use store::people;
use store::privacy::exports;

use crate::every_route::World;
use crate::support::client::csrf_in;
use crate::support::recordings::{Attempt, record};
use crate::support::{App, PASSWORD};

/// What refers to a person: table and column, and under which key it stands in the file.
const HELD: [(&str, &str); 67] = [
    ("notices.person_id", "notices"),
    ("api_tokens.person_id", "access/tokens"),
    ("account_links.person_id", "password_links"),
    ("assignment_extensions.person_id", "assignment_extensions"),
    ("assignments.made_by", "assignments_made"),
    ("assignments.person_id", "assignments"),
    ("badges.person_id", "badges"),
    ("calendar_feeds.person_id", "calendar_feed"),
    ("record_consents.person_id", "record_consents"),
    ("statements.person_id", "statements"),
    ("cohort_acts.done_by", "cohort_acts_done"),
    ("cohort_acts.person_id", "cohort_acts"),
    ("cohort_members.person_id", "cohorts"),
    ("cohort_requests.asked_by", "cohort_requests_made"),
    ("cohort_requests.person_id", "cohort_requests"),
    ("comments.author_id", "comments_made"),
    ("drafts.saved_by", "drafts_saved"),
    ("entrustments.decided_by", "entrustments_decided"),
    ("entrustments.person_id", "entrustments"),
    ("exam_files.made_by", "exam_files_made"),
    ("exam_files.person_id", "exam_files"),
    ("exam_sittings.examiner_id", "exam_sittings_held"),
    ("exam_sittings.person_id", "exam_sittings"),
    ("exams.made_by", "exams_made"),
    ("exams.second_rater_id", "exams_made"),
    ("expert_declarations.person_id", "consents"),
    ("expert_declarations.recorded_by", "consents_recorded"),
    ("expert_declarations.withdrawn_by", "consents_recorded"),
    ("deliveries.person_id", "grades_for_platforms"),
    ("identities.person_id", "access/identities"),
    ("mails.person_id", "letters"),
    ("pairing_codes.made_by", "pairing_codes_made"),
    ("passkeys.person_id", "access/passkeys"),
    ("rating_rounds.made_by", "rounds_made"),
    ("ratings.rater_id", "ratings_given"),
    ("recording_links.made_by", "recording_links"),
    ("regrade_reasons.made_by", "regrades_made"),
    ("regrade_reasons.session_id", "regrades"),
    ("regradings.made_by", "regradings_made"),
    ("retention_warnings.person_id", "retention_warnings"),
    ("reviews.reviewed_by", "reviews_made"),
    ("rosters.made_by", "rosters_sent"),
    ("score_overrides.made_by", "overrides_made"),
    ("segment_extensions.person_id", "task_extensions"),
    ("segment_marks.person_id", "marked_pops"),
    ("segment_tasks.made_by", "tasks_made"),
    ("sessions.trainee_id", "attempts"),
    ("sign_in_codes.person_id", "sign_in_codes"),
    ("studies.owner_id", "studies_made"),
    ("study_participants.added_by", "study_participants_added"),
    ("study_participants.person_id", "studies"),
    ("support_notes.by_id", "support_notes_made"),
    ("support_notes.person_id", "support_notes"),
    ("supervisions.confirmed_by", "supervisions_confirmed"),
    ("supervisions.trainee_id", "supervisions"),
    ("survey_participations.person_id", "surveys_answered"),
    ("surveys.owner_id", "surveys_made"),
    ("uploads.person_id", "unfinished_uploads"),
    // By an attempt of theirs.
    ("comments.session_id", "comments"),
    ("exam_files.session_id", "exam_files"),
    ("metrics.session_id", "metrics"),
    ("ratings.session_id", "ratings"),
    ("recording_links.session_id", "recording_links"),
    ("reviews.session_id", "reviews"),
    ("score_overrides.session_id", "overrides"),
    ("scores.session_id", "scores"),
    ("supervisions.session_id", "supervisions"),
];

/// What refers to them and stands in the file elsewhere, or not at all, with the reason.
const NOT_BY_ITSELF: [(&str, &str); 21] = [
    ("ceremonies.person_id", "what their passkey was asked, for the five minutes until it answers"),
    ("provisioned_people.person_id", "what the school's directory calls them: its own data, beside name and address"),
    ("identities.made_by", "the log: who joined whose account"),
    ("sign_in_flows.person_id", "a sign-in that has not come back, for ten minutes"),
    ("notices.by_id", "what they did is in their comments, overrides, ratings and assignments"),
    ("notices.session_id", "`notices`, by the person"),
    ("second_factors.person_id", "`access`: since when; never the secret"),
    ("recovery_codes.person_id", "`access`: how many are left"),
    ("practice.trainee_id", "sums over `scores`"),
    ("practice_signs.trainee_id", "the same"),
    ("survey_responses.person_id", "`survey_answers` where they were sent, `answers_begun` before that"),
    ("survey_responses.session_id", "the same"),
    ("survey_participations.session_id", "`surveys_answered`, by the person"),
    ("uploads.session_id", "`unfinished_uploads`, by the person; the attempt is in `attempts`"),
    ("grades.session_id", "which of `scores` and `overrides` counts: the newest"),
    ("jobs.session_id", "the queue: `state` of the attempt says that it waits"),
    ("regrading_lines.session_id", "what a re-grading has come to is in `scores`"),
    ("unhashed_motions.session_id", "a queue of recordings to be read"),
    ("segment_traces.session_id", "which attempts others mark; nothing of it tells of the person"),
    ("session_curves.session_id", "made of the recording, which the file leads to"),
    ("sessions.repeats", "the other attempt's id, for whoever judges; `uncounted` says so"),
];

/// What names them without a foreign key, and where it stands.
const LOOSE: [(&str, &str); 5] = [
    ("audit_log", "log"),
    ("web_sessions", "signed_in_until"),
    ("survey_letters", "survey_letters"),
    // An address that was typed, for the minutes until it is looked up: whose it is, nobody has asked yet.
    ("asked_links", ""),
    // What a learning platform calls a teacher who chooses content, for an hour; `access/identities` has it, too.
    ("content_choices", ""),
];

async fn references(app: &App) -> BTreeSet<String> {
    let tables: Vec<String> = sqlx::query_scalar("SELECT name FROM sqlite_schema WHERE type = 'table'")
        .fetch_all(app.state.db.reader())
        .await
        .unwrap();
    let mut found = BTreeSet::new();
    for table in tables {
        let keys = format!(
            "SELECT \"from\" FROM pragma_foreign_key_list('{table}') WHERE \"table\" IN ('people', 'sessions') AND \"to\" = 'id'"
        );
        let columns: Vec<String> =
            sqlx::query_scalar(AssertSqlSafe(keys)).fetch_all(app.state.db.reader()).await.unwrap();
        found.extend(columns.into_iter().map(|column| format!("{table}.{column}")));
    }
    found
}

#[tokio::test]
async fn every_table_with_a_person_is_exported_or_has_a_reason() {
    only_on!(Sqlite, "reads SQLite's catalogue: both schemas are one");
    let app = App::new().await;
    let known: BTreeSet<String> = HELD.iter().chain(&NOT_BY_ITSELF).map(|(column, _)| (*column).to_owned()).collect();
    assert_eq!(known.len(), HELD.len() + NOT_BY_ITSELF.len(), "each once");
    let found = references(&app).await;
    let missing: Vec<_> = found.difference(&known).collect();
    assert!(missing.is_empty(), "neither exported nor named with a reason: {missing:?}");
    // A reference to oneself within a table is no foreign key of the schema.
    let gone: Vec<_> = known.difference(&found).filter(|column| *column != "sessions.repeats").collect();
    assert!(gone.is_empty(), "named, and not in the schema: {gone:?}");
    let named: Vec<String> = sqlx::query_scalar(
        "SELECT DISTINCT m.name FROM sqlite_schema m, pragma_table_info(m.name) c
         WHERE m.type = 'table' AND m.name <> 'people' AND c.name IN ('email', 'actor', 'pseudonym', 'data') ORDER BY 1",
    )
    .fetch_all(app.state.db.reader())
    .await
    .unwrap();
    let loose: BTreeSet<&str> = LOOSE.iter().map(|(table, _)| *table).collect();
    assert!(named.iter().all(|table| loose.contains(table.as_str())), "{named:?}");
}

async fn held(app: &App, person: &people::Person) -> Value {
    let held = exports::of_person(app.state.db.reader(), person.school_id, person.id).await.unwrap().unwrap();
    serde_json::to_value(held).unwrap()
}

async fn rows(app: &App, reference: &str, person: PersonId) -> i64 {
    let (table, column) = reference.split_once('.').unwrap();
    let by = match column {
        "session_id" => "SELECT id FROM sessions WHERE trainee_id = $1",
        _ => "SELECT $1",
    };
    // Their own comments and comments on their attempts stand under two keys; ratings are told when they are given.
    let only = match reference {
        "comments.session_id" => " AND withdrawn_at IS NULL",
        "ratings.session_id" => " AND finished_at IS NOT NULL",
        "recording_links.session_id" => " AND made_by = $1",
        _ => "",
    };
    let count = format!("SELECT count(*) FROM {table} WHERE {column} IN ({by}){only}");
    sqlx::query_scalar(AssertSqlSafe(count)).bind(person).fetch_one(app.state.db.reader()).await.unwrap()
}

#[tokio::test]
async fn what_is_in_a_table_about_somebody_is_in_their_file() {
    let world = World::new().await;
    let app = world.open().await;
    let mut seen = BTreeSet::new();
    for name in ["own", "same", "other", "teacher", "colleague", "admin"] {
        let person = people::find_person_by_email(app.state.db.reader(), &format!("{name}@north.example"))
            .await
            .unwrap()
            .unwrap();
        let held = held(&app, &person).await;
        for (reference, key) in HELD {
            let list = held
                .pointer(&format!("/{key}"))
                .and_then(Value::as_array)
                .unwrap_or_else(|| panic!("no {key} in the file of {name}"));
            let expected = rows(&app, reference, person.id).await;
            assert!(expected == 0 || !list.is_empty(), "{name}: {expected} rows of {reference}, and no {key}");
            if expected > 0 {
                seen.insert(key);
            }
        }
        for (_, key) in LOOSE.iter().filter(|(_, key)| !key.is_empty()) {
            assert!(held[key].is_array(), "no {key} in the file of {name}");
        }
        assert!(!held["signed_in_until"].as_array().unwrap().is_empty(), "{name} is signed in");
    }
    assert!(seen.len() > 18, "the rest was tried on nobody: {seen:?}");
}

#[tokio::test]
async fn export_includes_reasons_and_consents_and_no_secret() {
    let app = App::new().await;
    let school = app.school("North").await;
    let ana = app.member(school, Role::Trainee, "ana@example.org").await;
    let teacher = app.member(school, Role::Instructor, "teacher@example.org").await;
    app.cohort(school, "A", &[&ana.person, &teacher.person]).await;
    app.publish(school).await;
    let attempt = Attempt::default();
    assert_eq!(app.with_token(&ana.token).upload(&record(&attempt)).await.status, 201);
    worker::work_off_jobs(&app.state).await.unwrap();
    let mut teaching = app.signed_in("teacher@example.org").await;
    let page = format!("/sessions/{}", attempt.session_id);
    let csrf = csrf_in(&teaching.get(&page).await.text());
    for (path, fields) in [
        (format!("{page}/override"), vec![("score", "55"), ("result", "failed"), ("reason", "the hand was led")]),
        (format!("{page}/supervision"), vec![("confirm", "yes")]),
        (format!("{page}/comments"), vec![("kind", "praise"), ("from_s", "0.1"), ("body", "A calm hand")]),
        ("/expert-consent".to_owned(), vec![("consent", "given")]),
    ] {
        let done = teaching.form(&path, &[&[("csrf", csrf.as_str())], &fields[..]].concat()).await;
        assert!(done.status.as_u16() < 400, "{path}: {} {}", done.status, done.text());
    }
    app.stranger().sign_in("ana@example.org", "wrong").await;
    let mut own = app.signed_in("ana@example.org").await;
    let file = own.get("/account/export").await;
    let held = file.json();
    assert_eq!(held["overrides"][0]["reason"], "the hand was led", "{held}");
    assert_eq!(held["overrides"][0]["is_pass"], false);
    assert_eq!(held["supervisions"][0]["confirmed_by"], "Somebody");
    assert!(held["scores"][0]["deductions"].is_array(), "{held}");
    assert_eq!(held["comments"][0]["body"], "A calm hand");
    assert_eq!(held["attempts"][0]["recording_sha256"].as_str().map(str::len), Some(64));
    assert_eq!(held["access"]["tokens"].as_array().map(Vec::len), Some(1));
    let log: Vec<&str> = held["log"].as_array().unwrap().iter().map(|row| row["action"].as_str().unwrap()).collect();
    for action in ["person.signed_in", "sign_in.failed", "session.uploaded", "session.scored", "grade.overridden"] {
        assert!(log.contains(&action), "{action} in {log:?}");
    }
    for secret in [ana.token.as_str(), PASSWORD, "argon2", "token_sha256", "code_hash"] {
        assert!(!file.text().contains(secret), "{secret} is told");
    }
    let theirs = teaching.get("/account/export").await.json();
    assert_eq!(theirs["comments_made"][0]["body"], "A calm hand", "{theirs}");
    assert_eq!(theirs["overrides_made"][0]["reason"], "the hand was led");
    assert!(theirs["consents"][0]["wording"].as_str().is_some_and(|wording| !wording.is_empty()), "{theirs}");
}
