//! What the database itself keeps, whoever writes: each trigger by what it refuses, or by what follows.

use std::collections::BTreeSet;

use super::BothEngines;

/// A school with an attempt, and a row of each table that never changes.
const ROWS: [&str; 24] = [
    "INSERT INTO schools (id, name, created_at) VALUES (#1, 'North', 0)",
    "INSERT INTO people (id, school_id, email, display_name, pseudonym, password_hash, created_at)
     VALUES (#1, #1, 'ada@example.org', 'Ada', 'p-1', '', 0)",
    "INSERT INTO cohorts (id, school_id, name, created_at) VALUES (#1, #1, 'Autumn', 0)",
    "INSERT INTO sessions (school_id, id, trainee_id, exercise_id, exercise_sha256, scene_sha256, started_at, received_at,
       duration_s, complete, device, simulator_version, seed, state, recording_path, recording_sha256, recording_size,
       verify_flagged)
     VALUES (#1, #2, #1, 'lumbar', '', '', 0, 0, 1.0, TRUE, '', '', '0', 'scored', '', '', 1, TRUE)",
    "INSERT INTO exercise_revisions (id, school_id, exercise_id, title, difficulty, pass_mark, exercise_sha256, scene_sha256,
       bundle_sha256, exercise_bytes, scene_bytes, published_at) VALUES (#1, #1, 'lumbar', '', 1, 70.0, '', '', '', #hash, #hash, 0)",
    "INSERT INTO exercise_meshes (revision_id, position, name, bytes) VALUES (#1, 0, '', #hash)",
    "INSERT INTO exercise_pictures (revision_id, position, name, sha256, width, height, bytes) VALUES (#1, 0, '', '', 1, 1, #hash)",
    "INSERT INTO curriculum_revisions (id, school_id, curriculum_id, title, description, mastery_passes, mastery_of, sha256, bytes,
       published_at) VALUES (#1, #1, 'spine', '', '', 1, 1, '', #hash, 0)",
    "INSERT INTO instrument_revisions (id, school_id, instrument_id, title, sha256, bytes, published_at)
     VALUES (#1, #1, 'scale', '', '', #hash, 0)",
    "INSERT INTO scores (id, school_id, session_id, score, passed, rubric_id, rubric_sha256, deductions, hard_fails,
       simulator_version, computed_at) VALUES (#3, #1, #2, 20.0, FALSE, '', '', '[]', '[]', '', 0)",
    "INSERT INTO score_overrides (id, school_id, session_id, score, passed, reason, made_by, made_at)
     VALUES (#4, #1, #2, 90.0, TRUE, 'the needle was bent', #1, 0)",
    "INSERT INTO regrade_reasons (score_id, school_id, session_id, reason, made_at) VALUES (#3, #1, #2, 'a new rubric', 0)",
    "INSERT INTO rating_rounds (id, school_id, revision_id, title, generated, made_by, made_at)
     VALUES (#1, #1, #1, 'Round', FALSE, #1, 0)",
    "INSERT INTO ratings (id, school_id, round_id, session_id, rater_id, answers, finished_at)
     VALUES (#1, #1, #1, #2, #1, '[3, \"very steady\", null]', 0)",
    "INSERT INTO exercises (school_id, exercise_id, revision_id) VALUES (#1, 'lumbar', #1)",
    "INSERT INTO exams (id, school_id, title, cohort_id, exercise_id, revision_id, limit_min, made_by, made_at)
     VALUES (#1, #1, 'Station', #1, 'lumbar', #1, 10, #1, 0)",
    "INSERT INTO exam_sittings (id, school_id, exam_id, person_id, examiner_id, begun_at, answers, finished_at)
     VALUES (#1, #1, #1, #1, #1, 0, '[1]', 0)",
    "INSERT INTO outcomes (id, school_id, code, title, made_at) VALUES (#1, #1, 'EPA 1', 'Puncture', 0)",
    "INSERT INTO entrustments (id, school_id, outcome_id, person_id, level, note, decided_by, decided_at)
     VALUES (#1, #1, #1, #1, 3, 'steady', #1, 0)",
    "INSERT INTO exam_files (id, school_id, session_id, person_id, made_by, made_at, sha256, bytes, head)
     VALUES (#1, #1, #2, #1, #1, 0, '0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef', 1, #hash)",
    "INSERT INTO segment_tasks (id, school_id, title, cohort_id, time_zone, made_by, made_at)
     VALUES (#1, #1, 'Pops', #1, 'UTC', #1, 0)",
    "INSERT INTO segment_traces (id, school_id, task_id, session_id, position) VALUES (#1, #1, #1, #2, 1)",
    "INSERT INTO segment_marks (school_id, trace_id, person_id, marks, sent_at) VALUES (#1, #1, #1, '[]', 0)",
    "INSERT INTO audit_log (seq, at, actor, action, object, details, prev_hash, hash) VALUES (1, 0, '', '', '', '', #hash, #hash)",
];

/// What is refused, and in which words.
const FORBIDDEN: [(&str, &str); 31] = [
    ("UPDATE exercise_revisions SET title = 'x'", "a published exercise revision never changes"),
    ("DELETE FROM exercise_revisions", "a published exercise revision is never deleted"),
    ("UPDATE exercise_meshes SET name = 'x'", "a published mesh never changes"),
    ("DELETE FROM exercise_meshes", "a published mesh is never deleted"),
    ("UPDATE exercise_pictures SET name = 'x'", "a published picture never changes"),
    ("DELETE FROM exercise_pictures", "a published picture is never deleted"),
    ("UPDATE curriculum_revisions SET title = 'x'", "a published curriculum revision never changes"),
    ("DELETE FROM curriculum_revisions", "a published curriculum revision is never deleted"),
    ("UPDATE instrument_revisions SET title = 'x'", "a published instrument revision never changes"),
    ("DELETE FROM instrument_revisions", "a published instrument revision is never deleted"),
    ("UPDATE scores SET score = 100.0", "a score never changes: a re-grading adds a row"),
    ("DELETE FROM scores", "a score is never deleted"),
    (
        "UPDATE score_overrides SET score = 100.0, reason = '[erased]'",
        "an override never changes: another one is added",
    ),
    ("DELETE FROM score_overrides", "an override is never deleted"),
    ("UPDATE regrade_reasons SET reason = 'another'", "a reason never changes: another grade has another"),
    ("DELETE FROM regrade_reasons", "a reason is never deleted"),
    ("UPDATE ratings SET answers = '[4, \"very steady\", null]'", "a finished rating never changes"),
    ("UPDATE ratings SET answers = '[3, \"very steady\"]'", "a finished rating never changes"),
    ("UPDATE ratings SET answers = '[\"[erased]\", \"very steady\", null]'", "a finished rating never changes"),
    ("DELETE FROM ratings", "a rating is never deleted: the round is taken back"),
    (
        "UPDATE exam_sittings SET answers = '[0]'",
        "a sitting keeps its candidate, examiner and begin, and its answers once finished",
    ),
    ("DELETE FROM exam_sittings", "a sitting is never deleted"),
    ("UPDATE entrustments SET level = 5", "an entrustment never changes: a later one follows it"),
    ("DELETE FROM entrustments", "an entrustment is never deleted"),
    ("UPDATE exam_files SET head = #hash", "an exam file never changes: another one is frozen"),
    ("UPDATE exam_files SET bytes = 2", "an exam file never changes: another one is frozen"),
    ("DELETE FROM exam_files", "an exam file is never deleted"),
    ("UPDATE segment_marks SET marks = '[1.0]'", "sent marks never change"),
    ("UPDATE audit_log SET actor = 'x'", "the audit log is append-only"),
    ("DELETE FROM audit_log", "the audit log is append-only"),
    (
        "INSERT INTO audit_log (seq, at, actor, action, object, details, prev_hash, hash) VALUES (3, 0, '', '', '', '', #hash, #hash)",
        "the audit log is append-only",
    ),
];

/// What may change in rows that never change otherwise: texts that were erased.
const ERASURES: [&str; 5] = [
    "UPDATE entrustments SET note = ''",
    "UPDATE exam_files SET head = substr(head, 1, 0)",
    "UPDATE score_overrides SET reason = '[erased]'",
    "UPDATE regrade_reasons SET reason = '[erased]'",
    "UPDATE ratings SET answers = '[3, \"[erased]\", null]'",
];

async fn start() -> Option<BothEngines> {
    let mut both = BothEngines::start().await?;
    for row in ROWS {
        both.agree_to(row).await;
    }
    Some(both)
}

#[tokio::test]
async fn both_engines_refuse_the_same_in_the_same_words() {
    let Some(mut both) = start().await else { return };
    for (statement, words) in FORBIDDEN {
        both.refuse(statement, words).await;
    }
    for erasure in ERASURES {
        both.agree_to(erasure).await;
    }
    let triggers: Vec<String> = sqlx::query_scalar("SELECT sql FROM sqlite_schema WHERE type = 'trigger'")
        .fetch_all(&mut both.sqlite)
        .await
        .unwrap();
    let said = |sql: &String| Some(sql.split_once("RAISE(ABORT, '")?.1.split_once('\'')?.0.to_owned());
    let said: BTreeSet<String> = triggers.iter().filter_map(said).collect();
    let tried: BTreeSet<String> = FORBIDDEN.iter().map(|(_, words)| (*words).to_owned()).collect();
    assert_eq!(said, tried, "each refusal is tried");
}

#[tokio::test]
async fn nothing_that_stays_is_taken_away_all_at_once() {
    let Some(mut both) = start().await else { return };
    for (statement, words) in FORBIDDEN.iter().filter(|(statement, _)| statement.starts_with("DELETE")) {
        let statement = statement.replace("DELETE FROM", "TRUNCATE") + " CASCADE";
        let told = sqlx::raw_sql(sqlx::AssertSqlSafe(statement.clone())).execute(&mut both.postgres).await.unwrap_err();
        assert_eq!(told.as_database_error().unwrap().message(), *words, "{statement}");
    }
}

#[tokio::test]
async fn grades_and_ranks_follow_alike() {
    const GRADE: &str = "SELECT CAST(sum(score) AS BIGINT) * 10 + sum(passed) FROM grades";
    const RANK: &str = "SELECT CAST(sum(review_rank) AS BIGINT) * 10 + sum(reviewed) FROM sessions";
    let comment = |id: u32, answers: &str, kind: &str, from_s: &str| {
        format!(
            "INSERT INTO comments (id, school_id, session_id, author_id, answers, kind, from_s, body, made_at)
             VALUES (#{id}, #1, #2, #1, {answers}, {kind}, {from_s}, 'Why?', 0)"
        )
    };
    let score = |id: u32, score: &str| {
        format!(
            "INSERT INTO scores (id, school_id, session_id, score, passed, rubric_id, rubric_sha256, deductions, hard_fails,
               simulator_version, computed_at) VALUES (#{id}, #1, #2, {score}, FALSE, '', '', '[]', '[]', '', 1)"
        )
    };
    let withdrawn = "INSERT INTO score_overrides (id, school_id, session_id, reason, made_by, made_at)
                     VALUES (#6, #1, #2, 'it was not', #1, 1)";
    let review = "INSERT INTO reviews (school_id, session_id, reviewed_by, reviewed_at) VALUES (#1, #2, #1, 0)";
    let Some(mut both) = start().await else { return };
    assert_eq!((both.number(GRADE).await, both.number(RANK).await), (901, 20), "the override counts; the flag is left");
    for (statement, grade, rank) in [
        (score(5, "30.0").as_str(), 901, 20),
        (withdrawn, 300, 30),
        (&comment(7, "NULL", "'question'", "1.0"), 300, 70),
        (&comment(8, "#7", "NULL", "NULL"), 300, 30),
        ("UPDATE comments SET withdrawn_at = 1 WHERE answers IS NOT NULL", 300, 70),
        (review, 300, 71),
        ("UPDATE sessions SET verify_flagged = FALSE", 300, 51),
        ("DELETE FROM reviews", 300, 50),
    ] {
        both.agree_to(statement).await;
        assert_eq!((both.number(GRADE).await, both.number(RANK).await), (grade, rank), "{statement}");
    }
}
