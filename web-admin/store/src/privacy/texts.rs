//! Free texts by a person and about their attempts: counts, search and redaction.

use assessment::questionnaire::Answer;
use documents::Instrument;
use documents::instrument::ScaleKind;
use futures::TryStreamExt;
use model::ids::{PersonId, SchoolId, SessionId};
use model::privacy::texts::{MOST_MENTIONS, TextCounts};
use model::{Moment, count_i64};
use sqlx::FromRow;
use uuid::Uuid;

use crate::engine::{Executor, twin};
use crate::{Connection, Json, Pool, Result};

/// Replaces a redacted text. The triggers of the database contain the same text.
pub const ERASED: &str = "[erased]";

/// Person whose texts are selected, and the time limit.
#[derive(Clone, Copy, Debug)]
pub struct TextOwner {
    /// School.
    pub school_id: SchoolId,
    /// Person.
    pub person_id: PersonId,
    /// Texts written later are left unchanged.
    pub until: Moment,
}

/// Relation of a text to the person.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextSide {
    /// Written by the person.
    Written,
    /// Written by others about the person.
    About,
}

/// Makes a statement from an action, the condition for the person, and further conditions.
macro_rules! plain {
    ($does:literal, $whose:literal, $and:literal) => {
        concat!($does, " WHERE school_id = $1 ", $whose, " ", $and)
    };
}

/// Returns the number of texts by and about a person.
pub async fn count_texts(reader: &Pool, whose: TextOwner) -> Result<TextCounts> {
    let mut texts = TextCounts::default();
    for (side, found) in [(TextSide::Written, &mut texts.written), (TextSide::About, &mut texts.about)] {
        *found = plain_texts(reader, whose, side).await?;
        let answers = answers_of(&mut *reader.acquire().await?, whose, side).await?;
        *found += count_i64(answers.len());
    }
    texts.sealed = sqlx::query_scalar(
        "SELECT count(*) FROM (SELECT lower(substr(hex(id), 1, 8) || '-' || substr(hex(id), 9, 4) || '-'
             || substr(hex(id), 13, 4) || '-' || substr(hex(id), 17, 4) || '-' || substr(hex(id), 21)) AS text
           FROM sessions WHERE school_id = $1 AND trainee_id = $2) s
         CROSS JOIN audit_log a WHERE a.object = s.text AND a.details ->> '$.reason' IS NOT NULL",
    )
    .bind(whose.school_id)
    .bind(whose.person_id)
    .fetch_one(reader)
    .await?;
    Ok(texts)
}

async fn plain_texts(reader: &Pool, whose: TextOwner, side: TextSide) -> Result<i64> {
    let statement = match side {
        TextSide::Written => {
            "SELECT (SELECT count(*) FROM comments WHERE school_id = $1 AND author_id = $2 AND made_at <= $3 AND body <> '[erased]')
               + (SELECT count(*) FROM score_overrides WHERE school_id = $1 AND made_by = $2 AND made_at <= $3
                  AND reason <> '[erased]')
               + (SELECT count(*) FROM regrade_reasons WHERE school_id = $1 AND made_by = $2 AND made_at <= $3
                  AND reason <> '[erased]')
               + (SELECT count(*) FROM regradings WHERE school_id = $1 AND made_by = $2 AND made_at <= $3
                  AND reason <> '[erased]')
               + (SELECT count(*) FROM support_notes WHERE school_id = $1 AND by_id = $2 AND made_at <= $3
                  AND body <> '[erased]')"
        }
        TextSide::About => {
            "SELECT (SELECT count(*) FROM sessions s CROSS JOIN comments c
                  WHERE c.school_id = s.school_id AND c.session_id = s.id AND s.school_id = $1 AND s.trainee_id = $2
                  AND c.author_id <> $2 AND c.made_at <= $3
                    AND c.body <> '[erased]')
               + (SELECT count(*) FROM sessions s CROSS JOIN score_overrides o
                  WHERE o.school_id = s.school_id AND o.session_id = s.id AND s.school_id = $1 AND s.trainee_id = $2
                  AND o.made_by <> $2 AND o.made_at <= $3
                    AND o.reason <> '[erased]')
               + (SELECT count(*) FROM sessions s CROSS JOIN regrade_reasons w
                  WHERE w.school_id = s.school_id AND w.session_id = s.id AND s.school_id = $1 AND s.trainee_id = $2
                  AND w.made_by IS DISTINCT FROM $2 AND w.made_at <= $3
                    AND w.reason <> '[erased]')
               + (SELECT count(*) FROM expert_declarations WHERE school_id = $1 AND person_id = $2 AND given_at <= $3
                  AND how <> '[erased]')"
        }
    };
    sqlx::query_scalar(statement).bind(whose.school_id).bind(whose.person_id).bind(whose.until).fetch_one(reader).await
}

/// Redacts the texts of one side. Returns their number.
pub async fn redact_texts(writer: &mut Connection, whose: TextOwner, side: TextSide) -> Result<u64> {
    let mut redacted = 0;
    let statements: &[&str] = match side {
        TextSide::Written => &[
            plain!(
                "UPDATE comments SET body = '[erased]'",
                "AND author_id = $2",
                "AND made_at <= $3 AND body <> '[erased]'"
            ),
            plain!(
                "UPDATE score_overrides SET reason = '[erased]'",
                "AND made_by = $2",
                "AND made_at <= $3 AND reason <> '[erased]'"
            ),
            plain!(
                "UPDATE regrade_reasons SET reason = '[erased]'",
                "AND made_by = $2",
                "AND made_at <= $3 AND reason <> '[erased]'"
            ),
            plain!(
                "UPDATE regradings SET reason = '[erased]'",
                "AND made_by = $2",
                "AND made_at <= $3 AND reason <> '[erased]'"
            ),
            plain!(
                "UPDATE support_notes SET body = '[erased]', subject = CASE WHEN subject IS NOT NULL THEN '[erased]' END",
                "AND by_id = $2",
                "AND made_at <= $3 AND body <> '[erased]'"
            ),
        ],
        TextSide::About => &[
            plain!(
                "UPDATE comments SET body = '[erased]'",
                "AND session_id IN (SELECT id FROM sessions WHERE school_id = $1 AND trainee_id = $2)",
                "AND author_id <> $2 AND made_at <= $3 AND body <> '[erased]'"
            ),
            plain!(
                "UPDATE score_overrides SET reason = '[erased]'",
                "AND session_id IN (SELECT id FROM sessions WHERE school_id = $1 AND trainee_id = $2)",
                "AND made_by <> $2 AND made_at <= $3 AND reason <> '[erased]'"
            ),
            plain!(
                "UPDATE regrade_reasons SET reason = '[erased]'",
                "AND session_id IN (SELECT id FROM sessions WHERE school_id = $1 AND trainee_id = $2)",
                "AND made_by IS DISTINCT FROM $2 AND made_at <= $3 AND reason <> '[erased]'"
            ),
            plain!(
                "UPDATE expert_declarations SET how = '[erased]'",
                "AND person_id = $2",
                "AND given_at <= $3 AND how <> '[erased]'"
            ),
        ],
    };
    for statement in statements.iter().copied() {
        let done = sqlx::query(statement).bind(whose.school_id).bind(whose.person_id).bind(whose.until);
        redacted += done.execute(&mut *writer).await?.rows_affected();
    }
    for given in answers_of(writer, whose, side).await? {
        let statement = match given.kind {
            TextKind::Response => "UPDATE survey_responses SET answers = $3 WHERE school_id = $1 AND id = $2",
            TextKind::Rating => "UPDATE ratings SET answers = $3 WHERE school_id = $1 AND id = $2",
        };
        let done = sqlx::query(statement).bind(whose.school_id).bind(given.id).bind(Json(given.answers));
        redacted += done.execute(&mut *writer).await?.rows_affected();
    }
    Ok(redacted)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TextKind {
    Response,
    Rating,
}

/// Redacted answers that contained free texts.
struct TextAnswers {
    kind: TextKind,
    id: Uuid,
    answers: Vec<Option<Answer>>,
}

#[derive(FromRow)]
struct TextRow {
    id: Uuid,
    answers: Json<Vec<Option<Answer>>>,
    document: Vec<u8>,
}

/// Returns the survey responses and ratings that contain free texts, with redacted answers.
async fn answers_of(connection: &mut Connection, whose: TextOwner, side: TextSide) -> Result<Vec<TextAnswers>> {
    let mut found = Vec::new();
    let kinds: &[TextKind] =
        if side == TextSide::Written { &[TextKind::Response, TextKind::Rating] } else { &[TextKind::Rating] };
    for kind in kinds {
        let statement = match (kind, side) {
            (TextKind::Response, _) => {
                "SELECT r.id, r.answers, i.bytes AS document FROM survey_responses r
                 JOIN surveys u ON u.id = r.survey_id JOIN instrument_revisions i ON i.id = u.revision_id
                 WHERE r.school_id = $1 AND r.person_id = $2 AND coalesce(r.submitted_at, r.consented_at, 0) <= $3"
            }
            (TextKind::Rating, TextSide::Written) => {
                "SELECT r.id, r.answers, i.bytes AS document FROM ratings r
                 JOIN rating_rounds o ON o.id = r.round_id JOIN instrument_revisions i ON i.id = o.revision_id
                 WHERE r.school_id = $1 AND r.rater_id = $2 AND coalesce(r.finished_at, o.made_at) <= $3"
            }
            (TextKind::Rating, TextSide::About) => {
                "SELECT r.id, r.answers, i.bytes AS document FROM sessions s
                 CROSS JOIN ratings r
                 JOIN rating_rounds o ON o.id = r.round_id JOIN instrument_revisions i ON i.id = o.revision_id
                 WHERE r.school_id = s.school_id AND r.session_id = s.id AND s.school_id = $1 AND s.trainee_id = $2
                 AND r.rater_id <> $2
                   AND coalesce(r.finished_at, o.made_at) <= $3"
            }
        };
        let rows: Vec<TextRow> = sqlx::query_as(statement)
            .bind(whose.school_id)
            .bind(whose.person_id)
            .bind(whose.until)
            .fetch_all(&mut *connection)
            .await?;
        let given = rows.into_iter().filter_map(|row| {
            let answers = list_redacted_texts(&row.document, &row.answers)?;
            Some(TextAnswers { kind: *kind, id: row.id, answers })
        });
        found.extend(given);
    }
    Ok(found)
}

/// Returns the answers with their free texts redacted, or `None` if they contain no free text. If
/// the document no longer parses, every text is treated as free text.
fn list_redacted_texts(document: &[u8], answers: &[Option<Answer>]) -> Option<Vec<Option<Answer>>> {
    let instrument = Instrument::from_bytes("published instrument", document).ok();
    let is_free = |at: usize| {
        instrument.as_ref().is_none_or(|instrument| {
            let scale = instrument.items.get(at).and_then(|item| instrument.scale(item));
            matches!(scale, Some(ScaleKind::Text { .. }))
        })
    };
    let mut changed = false;
    let kept = answers.iter().enumerate().map(|(at, answer)| match answer {
        Some(Answer::Text(text)) if is_free(at) && !text.is_empty() && text != ERASED => {
            changed = true;
            Some(Answer::Text(ERASED.to_owned()))
        }
        other => other.clone(),
    });
    let kept = kept.collect();
    changed.then_some(kept)
}

/// A text about another person's attempt that mentions a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mention {
    /// The attempt.
    pub session_id: SessionId,
    /// The text.
    pub text: String,
}

/// Returns comments and override reasons by others about others' attempts that contain one of the
/// words as a whole word, in upper or lower case. The database preselects candidates, so that only
/// few of a large school's texts are read.
pub async fn list_mentions(reader: &Pool, whose: TextOwner, words: &[String]) -> Result<Vec<Mention>> {
    let mut found = Vec::new();
    let mut rows = sqlx::query_as::<_, (SessionId, String)>(
        twin!(
            reader,
            "SELECT c.session_id, c.body FROM comments c JOIN sessions s ON s.school_id = c.school_id AND s.id = c.session_id
             WHERE c.school_id = $1 AND c.author_id <> $2 AND s.trainee_id <> $2
               AND EXISTS (SELECT 1 FROM json_each($3) w WHERE lower(c.body) LIKE w.value)
             UNION ALL
             SELECT o.session_id, o.reason FROM score_overrides o JOIN sessions s ON s.school_id = o.school_id AND s.id = o.session_id
             WHERE o.school_id = $1 AND o.made_by <> $2 AND s.trainee_id <> $2
               AND EXISTS (SELECT 1 FROM json_each($3) w WHERE lower(o.reason) LIKE w.value)",
            "SELECT c.session_id, c.body FROM comments c JOIN sessions s ON s.school_id = c.school_id AND s.id = c.session_id
             WHERE c.school_id = $1 AND c.author_id <> $2 AND s.trainee_id <> $2
               AND lower(c.body) LIKE ANY (ARRAY(SELECT value FROM json_each($3)))
             UNION ALL
             SELECT o.session_id, o.reason FROM score_overrides o JOIN sessions s ON s.school_id = o.school_id AND s.id = o.session_id
             WHERE o.school_id = $1 AND o.made_by <> $2 AND s.trainee_id <> $2
               AND lower(o.reason) LIKE ANY (ARRAY(SELECT value FROM json_each($3)))",
        ),
    )
    .bind(whose.school_id)
    .bind(whose.person_id)
    .bind(Json(words.iter().map(|word| pattern_of(word)).collect::<Vec<_>>()))
    .fetch(reader);
    while let Some((session_id, text)) = rows.try_next().await? {
        if found.len() < MOST_MENTIONS && names_one(&text, words) {
            found.push(Mention { session_id, text });
        }
    }
    Ok(found)
}

/// Returns a LIKE pattern that matches every text with the word, if only ASCII letters are
/// converted to lower case. All other characters match anything, and so do `i` and `k`, which are
/// also the lower case of characters outside ASCII.
fn pattern_of(word: &str) -> String {
    let spelt = word.chars().map(|c| if c.is_ascii_alphanumeric() && !matches!(c, 'i' | 'k') { c } else { '%' });
    format!("%{}%", spelt.collect::<String>())
}

fn names_one(text: &str, words: &[String]) -> bool {
    let text = text.to_lowercase();
    let mut said = text.split(|c: char| !c.is_alphanumeric());
    said.any(|word| words.iter().any(|wanted| wanted == word))
}

/// Returns the words of a name to search for: those with at least three characters, in lower case.
#[must_use]
pub fn words_of(name: &str) -> Vec<String> {
    let words = name.split(|c: char| !c.is_alphanumeric()).map(str::to_lowercase);
    words.filter(|word| word.chars().count() >= 3).collect()
}

/// Returns the path and hash of a person's recordings that were received before the time limit and
/// have not been deleted.
pub async fn recordings(writer: &mut Connection, whose: TextOwner) -> Result<Vec<ErasedRecording>> {
    sqlx::query_as(
        "SELECT recording_path, recording_sha256 FROM sessions
         WHERE school_id = $1 AND trainee_id = $2 AND received_at <= $3 AND recording_erased_at IS NULL",
    )
    .bind(whose.school_id)
    .bind(whose.person_id)
    .bind(whose.until)
    .fetch_all(writer)
    .await
}

/// A deleted recording, or one to be deleted.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct ErasedRecording {
    /// Path of the file, relative to the recordings folder.
    pub recording_path: String,
    /// SHA-256 of the file.
    pub recording_sha256: String,
}

/// Records that the recordings of a person were deleted, and cancels the scoring of pending ones.
pub async fn note_erased_recordings(writer: &mut Connection, whose: TextOwner) -> Result<()> {
    for statement in [
        "DELETE FROM jobs WHERE school_id = $1 AND session_id IN (
           SELECT id FROM sessions WHERE school_id = $1 AND trainee_id = $2 AND received_at <= $3 AND state = 'pending')",
        "UPDATE sessions SET state = 'refused', refusal = 'the recording was erased'
         WHERE school_id = $1 AND trainee_id = $2 AND received_at <= $3 AND state = 'pending'",
        "UPDATE sessions SET recording_erased_at = $3
         WHERE school_id = $1 AND trainee_id = $2 AND received_at <= $3 AND recording_erased_at IS NULL",
    ] {
        sqlx::query(statement)
            .bind(whose.school_id)
            .bind(whose.person_id)
            .bind(whose.until)
            .execute(&mut *writer)
            .await?;
    }
    Ok(())
}

/// Returns all deleted recordings, for checking that their files no longer exist.
pub async fn all_erased(reader: &Pool) -> Result<Vec<ErasedRecording>> {
    sqlx::query_as("SELECT recording_path, recording_sha256 FROM sessions WHERE recording_erased_at > 0")
        .fetch_all(reader)
        .await
}

#[cfg(test)]
mod tests {
    //! Names must match as whole words only, in upper and lower case.

    use super::*;

    #[test]
    fn a_name_is_found_as_a_word_in_any_case() {
        let words = words_of("Ana Özil-Ek");
        assert_eq!(words, ["ana", "özil"]);
        for (text, expected) in [
            ("Well done, ANA!", true),
            ("as ÖZIL's hand", true),
            ("the anatomy", false),
            ("banana", false),
            ("", false),
        ] {
            assert_eq!(names_one(text, &words), expected, "{text}");
        }
    }

    #[test]
    fn a_pattern_asks_only_for_letters_that_have_one_other_case() {
        // The Kelvin sign, \u{212a}, and the dotted capital I, \u{130}, also become `k` and `i` in
        // lower case.
        for (word, pattern) in [("ana", "%ana%"), ("özil", "%%z%l%"), ("erika2", "%er%%a2%")] {
            assert_eq!(pattern_of(word), pattern);
        }
    }
}
