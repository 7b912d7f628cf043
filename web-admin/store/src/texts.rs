//! Free texts that somebody wrote, or that others wrote about their attempts: counted, looked through, and made unreadable.

use assessment::questionnaire::Answer;
use documents::Instrument;
use documents::instrument::ScaleKind;
use futures::TryStreamExt;
use model::ids::{PersonId, SchoolId, SessionId};
use model::texts::{MOST_MENTIONS, TextCounts};
use model::{Moment, count_i64};
use sqlx::FromRow;
use uuid::Uuid;

use super::{Connection, Json, Pool, Result};
use crate::engine::{Executor, twin};

/// What stands where a text was. The database's triggers know it, too.
pub const ERASED: &str = "[erased]";

/// Whose texts, and until when they were written.
#[derive(Clone, Copy, Debug)]
pub struct Whose {
    /// School.
    pub school_id: SchoolId,
    /// Person.
    pub person_id: PersonId,
    /// What was written later is left alone.
    pub until: Moment,
}

/// Which texts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextSide {
    /// Their own.
    Written,
    /// Others' about them.
    About,
}

/// A statement for either side: what is done, then the rows that are theirs, then those about them.
macro_rules! plain {
    ($does:literal, $whose:literal, $and:literal) => {
        concat!($does, " WHERE school_id = $1 ", $whose, " ", $and)
    };
}

/// How many texts there are about somebody, and by them.
pub async fn count_texts(reader: &Pool, whose: Whose) -> Result<TextCounts> {
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

async fn plain_texts(reader: &Pool, whose: Whose, side: TextSide) -> Result<i64> {
    let statement = match side {
        TextSide::Written => {
            "SELECT (SELECT count(*) FROM comments WHERE school_id = $1 AND author_id = $2 AND made_at <= $3 AND body <> '[erased]')
               + (SELECT count(*) FROM score_overrides WHERE school_id = $1 AND made_by = $2 AND made_at <= $3
                  AND reason <> '[erased]')
               + (SELECT count(*) FROM regrade_reasons WHERE school_id = $1 AND made_by = $2 AND made_at <= $3
                  AND reason <> '[erased]')
               + (SELECT count(*) FROM regradings WHERE school_id = $1 AND made_by = $2 AND made_at <= $3
                  AND reason <> '[erased]')"
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

/// Makes the texts of a side unreadable; how many there were.
pub async fn redact_texts(writer: &mut Connection, whose: Whose, side: TextSide) -> Result<u64> {
    let mut redacted = 0;
    let statements = match side {
        TextSide::Written => [
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
        ],
        TextSide::About => [
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
    for statement in statements {
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

/// Answers with a free text among them, as they are to be afterwards.
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

/// Answers to surveys and ratings in which a free text stands.
async fn answers_of(connection: &mut Connection, whose: Whose, side: TextSide) -> Result<Vec<TextAnswers>> {
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

/// The answers without their free texts; none where there is no such text. Of a document that cannot be read any more every text is one.
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

/// A text of others in which a word stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mention {
    /// The attempt that it is about.
    pub session_id: SessionId,
    /// The text.
    pub text: String,
}

/// Comments and reasons about others' attempts, written by others, in which one of the words stands as a whole word, whatever its case.
/// The database picks what may hold one, so that of a large school's texts few are read.
pub async fn list_mentions(reader: &Pool, whose: Whose, words: &[String]) -> Result<Vec<Mention>> {
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

/// What every text that holds a word matches, with the lower case of ASCII alone. Its other characters can be any, and so can `i` and `k`: they
/// are the lower case of characters beyond ASCII, too.
fn pattern_of(word: &str) -> String {
    let spelt = word.chars().map(|c| if c.is_ascii_alphanumeric() && !matches!(c, 'i' | 'k') { c } else { '%' });
    format!("%{}%", spelt.collect::<String>())
}

fn names_one(text: &str, words: &[String]) -> bool {
    let text = text.to_lowercase();
    let mut said = text.split(|c: char| !c.is_alphanumeric());
    said.any(|word| words.iter().any(|wanted| wanted == word))
}

/// The words of a name that are looked for: of three letters and more, in lower case.
#[must_use]
pub fn words_of(name: &str) -> Vec<String> {
    let words = name.split(|c: char| !c.is_alphanumeric()).map(str::to_lowercase);
    words.filter(|word| word.chars().count() >= 3).collect()
}

/// The recordings of a person that are still there, until a moment: session, file and hash.
pub async fn recordings(writer: &mut Connection, whose: Whose) -> Result<Vec<ErasedRecording>> {
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

/// A recording that goes.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct ErasedRecording {
    /// The file, relative to the recordings folder.
    pub recording_path: String,
    /// SHA-256 of the file.
    pub recording_sha256: String,
}

/// Notes that the recordings of a person are gone, and that those that wait are never scored.
pub async fn note_erased_recordings(writer: &mut Connection, whose: Whose) -> Result<()> {
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

/// Every recording that was erased: for whoever looks whether its file is gone.
pub async fn all_erased(reader: &Pool) -> Result<Vec<ErasedRecording>> {
    sqlx::query_as("SELECT recording_path, recording_sha256 FROM sessions WHERE recording_erased_at > 0")
        .fetch_all(reader)
        .await
}

#[cfg(test)]
mod tests {
    //! A name that is looked for within other words finds everybody; one that differs in case only finds nobody.

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
        // The sign of the kelvin, \u{212a}, and the dotted capital, \u{130}, are `k` and `i` in lower case, too.
        for (word, pattern) in [("ana", "%ana%"), ("özil", "%%z%l%"), ("erika2", "%er%%a2%")] {
            assert_eq!(pattern_of(word), pattern);
        }
    }
}
