//! Other records about a person in their data export, by kind: the rows as stored, without hashes
//! of secrets.
//!
//! The name of a column determines its conversion: `…_at` is a time, `is_…` a boolean, `…_json`
//! JSON.

use std::collections::BTreeMap;

use model::Moment;
use model::ids::{PersonId, SchoolId};
use serde_json::Value;
use sqlx::{Column, Row, TypeInfo, ValueRef};
use uuid::Uuid;

use crate::engine::AnswerRow;
use crate::{Pool, Result};

/// A kind of record and its query, by school and person.
struct RecordKind {
    key: &'static str,
    rows: &'static str,
}

const fn kind(key: &'static str, rows: &'static str) -> RecordKind {
    RecordKind { key, rows }
}

/// Records about the person, including those made by others.
const ABOUT: [RecordKind; 30] = [
    kind(
        "entrustments",
        "SELECT o.code, o.title, e.level, e.note, p.display_name AS decided_by, e.decided_at FROM entrustments e
         JOIN outcomes o ON o.school_id = e.school_id AND o.id = e.outcome_id
         JOIN people p ON p.school_id = e.school_id AND p.id = e.decided_by
         WHERE e.school_id = $1 AND e.person_id = $2 ORDER BY e.decided_at, e.id",
    ),
    // The result is the candidate's to see once the exam is closed.
    kind(
        "exam_sittings",
        "SELECT e.title AS exam, e.exercise_id, p.display_name AS examiner, t.begun_at, t.finished_at,
           CASE WHEN e.closed_at IS NULL THEN '[]' ELSE t.answers END AS answers_json FROM exam_sittings t
         JOIN exams e ON e.school_id = t.school_id AND e.id = t.exam_id
         JOIN people p ON p.school_id = t.school_id AND p.id = t.examiner_id
         WHERE t.school_id = $1 AND t.person_id = $2 ORDER BY t.begun_at, t.id",
    ),
    kind(
        "exam_files",
        "SELECT f.id, f.session_id, p.display_name AS made_by, f.made_at, f.sha256, f.bytes FROM exam_files f
         JOIN people p ON p.school_id = f.school_id AND p.id = f.made_by
         WHERE f.school_id = $1 AND f.person_id = $2 ORDER BY f.made_at, f.id",
    ),
    kind(
        "grades_for_platforms",
        "SELECT v.name AS platform, l.page, d.subject, d.state, d.body AS message_json, d.stamped_at, d.sent_at, d.tries,
           d.next_run_at, d.last_status, d.last_answer, d.made_at
         FROM deliveries d JOIN platforms v ON v.school_id = d.school_id AND v.id = d.platform_id
         JOIN platform_links l ON l.school_id = d.school_id AND l.id = d.link_id
         WHERE d.school_id = $1 AND d.person_id = $2 ORDER BY d.id",
    ),
    kind(
        "overrides",
        "SELECT o.session_id, o.score, o.passed AS is_pass, o.reason, p.display_name AS made_by, o.made_at
         FROM sessions s CROSS JOIN score_overrides o
         JOIN people p ON p.id = o.made_by WHERE o.school_id = s.school_id AND o.session_id = s.id AND s.school_id = $1
         AND s.trainee_id = $2 ORDER BY o.made_at, o.id",
    ),
    kind(
        "regrades",
        "SELECT w.session_id, w.score_id, w.reason, p.display_name AS made_by, w.made_at
         FROM sessions s CROSS JOIN regrade_reasons w
         LEFT JOIN people p ON p.id = w.made_by WHERE w.school_id = s.school_id AND w.session_id = s.id
         AND s.school_id = $1 AND s.trainee_id = $2 ORDER BY w.made_at",
    ),
    kind(
        "reviews",
        "SELECT r.session_id, p.display_name AS reviewed_by, r.reviewed_at
         FROM sessions s CROSS JOIN reviews r
         JOIN people p ON p.id = r.reviewed_by WHERE r.school_id = s.school_id AND r.session_id = s.id
         AND s.school_id = $1 AND s.trainee_id = $2 ORDER BY r.reviewed_at",
    ),
    kind(
        "supervisions",
        "SELECT v.session_id, p.display_name AS confirmed_by, v.confirmed_at FROM supervisions v
         JOIN people p ON p.id = v.confirmed_by WHERE v.school_id = $1 AND v.trainee_id = $2 ORDER BY v.confirmed_at",
    ),
    kind(
        "consents",
        "SELECT d.wording, d.how, d.given_at, r.display_name AS recorded_by, d.withdrawn_at, w.display_name AS withdrawn_by
         FROM expert_declarations d JOIN people r ON r.id = d.recorded_by LEFT JOIN people w ON w.id = d.withdrawn_by
         WHERE d.school_id = $1 AND d.person_id = $2 ORDER BY d.given_at, d.id",
    ),
    kind(
        "cohort_requests",
        "SELECT q.cohort_id, c.name AS cohort, p.display_name AS asked_by, q.asked_at FROM cohort_requests q
         JOIN cohorts c ON c.id = q.cohort_id JOIN people p ON p.id = q.asked_by
         WHERE q.school_id = $1 AND q.person_id = $2 ORDER BY q.asked_at",
    ),
    kind(
        "cohort_acts",
        "SELECT d.cohort_id, c.name AS cohort, d.act, p.display_name AS done_by, d.done_at FROM cohort_acts d
         JOIN cohorts c ON c.id = d.cohort_id LEFT JOIN people p ON p.id = d.done_by
         WHERE d.school_id = $1 AND d.person_id = $2 ORDER BY d.done_at, d.id",
    ),
    kind(
        "record_consents",
        "SELECT r.endpoint, c.wording, c.given_at, c.withdrawn_at FROM record_consents c
         JOIN record_stores r ON r.school_id = c.school_id AND r.id = c.store_id
         WHERE c.school_id = $1 AND c.person_id = $2 ORDER BY c.given_at, c.id",
    ),
    kind(
        "statements",
        "SELECT s.id, r.endpoint, s.state, s.made_at, s.sent_at FROM statements s
         JOIN record_stores r ON r.school_id = s.school_id AND r.id = s.store_id
         WHERE s.school_id = $1 AND s.person_id = $2 ORDER BY s.made_at, s.id",
    ),
    kind(
        "badges",
        "SELECT id, place, curriculum_id, curriculum_sha256, needed, issued_at, revoked_at FROM badges
         WHERE school_id = $1 AND person_id = $2 ORDER BY place",
    ),
    kind(
        "assignment_extensions",
        "SELECT assignment_id, days, due_at FROM assignment_extensions WHERE school_id = $1 AND person_id = $2",
    ),
    kind(
        "task_extensions",
        "SELECT task_id, days, due_at FROM segment_extensions WHERE school_id = $1 AND person_id = $2",
    ),
    kind(
        "signed_in_until",
        "SELECT w.expires_at AS ends_at FROM people p JOIN web_sessions w
         ON w.data ->> '$.person.person_id' = lower(substr(hex(p.id), 1, 8) || '-' || substr(hex(p.id), 9, 4) || '-'
           || substr(hex(p.id), 13, 4) || '-' || substr(hex(p.id), 17, 4) || '-' || substr(hex(p.id), 21))
         WHERE p.school_id = $1 AND p.id = $2",
    ),
    kind("password_links", "SELECT purpose, expires_at FROM account_links WHERE school_id = $1 AND person_id = $2"),
    kind(
        "studies",
        "SELECT u.title, u.controller, u.contact, u.consent, t.facts AS facts_json, t.added_at, t.agreed_at, t.withdrawn_at
         FROM study_participants t JOIN studies u ON u.id = t.study_id WHERE t.school_id = $1 AND t.person_id = $2",
    ),
    kind("calendar_feed", "SELECT made_at FROM calendar_feeds WHERE school_id = $1 AND person_id = $2"),
    kind("sign_in_codes", "SELECT made_at FROM sign_in_codes WHERE school_id = $1 AND person_id = $2"),
    kind(
        "recording_links",
        "SELECT session_id, expires_at FROM recording_links WHERE school_id = $1 AND made_by = $2",
    ),
    kind(
        "notices",
        "SELECT kind, by_id, session_id, comment_id, assignment_id, round_id, made_at, read_at, mailed_at FROM notices
         WHERE school_id = $1 AND person_id = $2 ORDER BY made_at, id",
    ),
    kind(
        "support_notes",
        "SELECT n.kind, n.subject, n.body, n.mailed AS is_mailed, p.display_name AS made_by, n.made_at FROM support_notes n
         JOIN people p ON p.id = n.by_id WHERE n.school_id = $1 AND n.person_id = $2 ORDER BY n.made_at, n.id",
    ),
    kind(
        "letters",
        "SELECT kind, assignment_id, tries, next_run_at, sent_at, error FROM mails
         WHERE school_id = $1 AND person_id = $2 ORDER BY id",
    ),
    kind(
        "retention_warnings",
        "SELECT active_at, warned_at, told_at, tries, next_run_at, error FROM retention_warnings
         WHERE school_id = $1 AND person_id = $2",
    ),
    kind(
        "survey_letters",
        "SELECT u.title AS survey, l.name, l.email, l.sent_at, l.error FROM people p
         JOIN survey_letters l ON l.school_id = p.school_id AND l.email = p.email JOIN surveys u ON u.id = l.survey_id
         WHERE p.school_id = $1 AND p.id = $2",
    ),
    kind(
        "surveys_answered",
        "SELECT u.title AS survey, x.session_id FROM survey_participations x JOIN surveys u ON u.id = x.survey_id
         WHERE x.school_id = $1 AND x.person_id = $2",
    ),
    kind(
        "answers_begun",
        "SELECT u.title AS survey, r.session_id, r.state, r.label, r.role, r.device, r.language, r.answers AS answers_json,
           r.consented_at, r.expires_at FROM survey_responses r JOIN surveys u ON u.id = r.survey_id
         WHERE r.school_id = $1 AND r.person_id = $2 AND r.submitted_at IS NULL",
    ),
    kind(
        "unfinished_uploads",
        "SELECT id, length AS length_bytes, received AS received_bytes, session_id, expires_at FROM uploads
         WHERE school_id = $1 AND person_id = $2",
    ),
];

/// Records of the person's actions on the data of other people or of the school.
const DONE: [RecordKind; 24] = [
    kind(
        "comments_made",
        "SELECT id, session_id, answers, kind, from_s, to_s, body, made_at, withdrawn_at FROM comments
         WHERE school_id = $1 AND author_id = $2 ORDER BY made_at, id",
    ),
    kind(
        "overrides_made",
        "SELECT session_id, score, passed AS is_pass, reason, made_at FROM score_overrides
         WHERE school_id = $1 AND made_by = $2 ORDER BY made_at, id",
    ),
    kind(
        "regrades_made",
        "SELECT session_id, score_id, reason, made_at FROM regrade_reasons WHERE school_id = $1 AND made_by = $2",
    ),
    kind(
        "reviews_made",
        "SELECT session_id, reviewed_at FROM reviews WHERE school_id = $1 AND reviewed_by = $2 ORDER BY reviewed_at",
    ),
    kind(
        "supervisions_confirmed",
        "SELECT session_id, confirmed_at FROM supervisions WHERE school_id = $1 AND confirmed_by = $2 ORDER BY confirmed_at",
    ),
    kind(
        "entrustments_decided",
        "SELECT person_id, outcome_id, level, decided_at FROM entrustments WHERE school_id = $1 AND decided_by = $2
         ORDER BY decided_at, id",
    ),
    kind(
        "exam_files_made",
        "SELECT id, session_id, made_at, sha256 FROM exam_files WHERE school_id = $1 AND made_by = $2 ORDER BY made_at, id",
    ),
    kind(
        "exams_made",
        "SELECT id, title, cohort_id, exercise_id, second_rater_id, made_at, closed_at FROM exams
         WHERE school_id = $1 AND (made_by = $2 OR second_rater_id = $2) ORDER BY made_at",
    ),
    kind(
        "exam_sittings_held",
        "SELECT exam_id, person_id, begun_at, answers AS answers_json, finished_at FROM exam_sittings
         WHERE school_id = $1 AND examiner_id = $2 ORDER BY begun_at, id",
    ),
    kind(
        "consents_recorded",
        "SELECT person_id, wording, how, given_at, recorded_by, withdrawn_at, withdrawn_by FROM expert_declarations
         WHERE school_id = $1 AND (recorded_by = $2 OR withdrawn_by = $2) ORDER BY given_at, id",
    ),
    kind(
        "cohort_requests_made",
        "SELECT cohort_id, person_id, asked_at FROM cohort_requests WHERE school_id = $1 AND asked_by = $2",
    ),
    kind(
        "cohort_acts_done",
        "SELECT cohort_id, person_id, act, done_at FROM cohort_acts WHERE school_id = $1 AND done_by = $2 ORDER BY done_at",
    ),
    kind(
        "assignments_made",
        "SELECT id, exercise_id, curriculum_id, cohort_id, person_id, due_at, made_at, withdrawn_at FROM assignments
         WHERE school_id = $1 AND made_by = $2 ORDER BY made_at",
    ),
    kind(
        "tasks_made",
        "SELECT id, title, cohort_id, due_at, made_at, withdrawn_at FROM segment_tasks
         WHERE school_id = $1 AND made_by = $2 ORDER BY made_at",
    ),
    kind(
        "rounds_made",
        "SELECT id, title, made_at, withdrawn_at FROM rating_rounds WHERE school_id = $1 AND made_by = $2 ORDER BY made_at",
    ),
    kind(
        "ratings_given",
        "SELECT id, round_id, answers AS answers_json, may_know AS is_known, finished_at FROM ratings
         WHERE school_id = $1 AND rater_id = $2 ORDER BY id",
    ),
    kind(
        "surveys_made",
        "SELECT id, title, identity, opens_at, closes_at, created_at FROM surveys WHERE school_id = $1 AND owner_id = $2",
    ),
    kind(
        "regradings_made",
        "SELECT id, exercise_id, reason, made_at, confirmed_at FROM regradings WHERE school_id = $1 AND made_by = $2",
    ),
    kind(
        "drafts_saved",
        "SELECT id, kind, document_id, document, scene, saved_at FROM drafts WHERE school_id = $1 AND saved_by = $2",
    ),
    kind("studies_made", "SELECT id, title, created_at, closed_at FROM studies WHERE school_id = $1 AND owner_id = $2"),
    kind(
        "study_participants_added",
        "SELECT study_id, person_id, added_at FROM study_participants WHERE school_id = $1 AND added_by = $2",
    ),
    kind(
        "support_notes_made",
        "SELECT person_id, kind, subject, body, mailed AS is_mailed, made_at FROM support_notes
         WHERE school_id = $1 AND by_id = $2 ORDER BY made_at, id",
    ),
    kind("rosters_sent", "SELECT id, file_name, made_at FROM rosters WHERE school_id = $1 AND made_by = $2"),
    kind("pairing_codes_made", "SELECT expires_at FROM pairing_codes WHERE school_id = $1 AND made_by = $2"),
];

/// Returns all records, by kind.
pub(super) async fn of_person(
    reader: &Pool,
    school: SchoolId,
    person: PersonId,
) -> Result<BTreeMap<&'static str, Vec<Value>>> {
    let mut held = BTreeMap::new();
    for kind in ABOUT.iter().chain(&DONE) {
        let statement = kind.rows;
        let rows = sqlx::query(statement).bind(school).bind(person).fetch_all(reader).await?;
        held.insert(kind.key, rows.iter().map(object).collect::<Result<_>>()?);
    }
    Ok(held)
}

/// Converts a row into a JSON object.
fn object(row: &AnswerRow) -> Result<Value> {
    let mut object = serde_json::Map::new();
    for (at, column) in row.columns().iter().enumerate() {
        let name = column.name();
        object.insert(name.strip_suffix("_json").unwrap_or(name).to_owned(), value(row, at, name)?);
    }
    Ok(Value::Object(object))
}

fn value(row: &AnswerRow, at: usize, name: &str) -> Result<Value> {
    let raw = row.try_get_raw(at)?;
    if raw.is_null() {
        return Ok(Value::Null);
    }
    let kind = raw.type_info().name().to_owned();
    Ok(match kind.as_str() {
        "INTEGER" | "INT8" if name.ends_with("_at") => row.try_get::<Moment, _>(at)?.to_string().into(),
        "INTEGER" if name.starts_with("is_") => (row.try_get::<i64, _>(at)? != 0).into(),
        "BOOL" => row.try_get::<bool, _>(at)?.into(),
        "INTEGER" | "INT8" => row.try_get::<i64, _>(at)?.into(),
        "REAL" | "FLOAT8" => row.try_get::<f64, _>(at)?.into(),
        "BLOB" | "UUID" => row.try_get::<Uuid, _>(at)?.to_string().into(),
        _ if name.ends_with("_json") => {
            let text: String = row.try_get(at)?;
            serde_json::from_str(&text).unwrap_or(Value::String(text))
        }
        _ => row.try_get::<String, _>(at)?.into(),
    })
}
