//! Search in a school's audit log, from its end. Each search reads a limited number of rows and
//! returns where to continue: the log of a large school has millions of rows.

use std::collections::BTreeMap;

use model::Moment;
use model::ids::SchoolId;
use model::titles::StoredTitle;
use sqlx::FromRow;

use crate::{Executor, Result};

/// An entry of a school's audit log.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct SchoolAct {
    /// Sequence number in the audit log.
    pub seq: i64,
    /// When the entry was written.
    pub at: Moment,
    /// Actor, as stored in the log.
    pub actor: String,
    /// Name of the actor, if the actor is a person.
    pub actor_name: Option<String>,
    /// Action, for example `session.scored`.
    pub action: String,
    /// Id of the object.
    pub object: String,
    /// Additional details, as JSON.
    pub details: String,
}

/// Search criteria.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AuditSearch {
    /// School to search.
    pub school: SchoolId,
    /// Prefixes of actions as a JSON array, for example `session` for `session.scored`; `[]`
    /// matches all.
    pub themes: String,
    /// Part of the name of the actor or of the person acted on, or the complete id of the object;
    /// empty matches all.
    pub words: String,
    /// Earliest time; `None` means no limit.
    pub since: Option<Moment>,
    /// Maximum number of rows to read.
    pub window: u32,
    /// Maximum number of entries to return.
    pub limit: u32,
}

/// A page of search results, latest first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundActs {
    /// The entries.
    pub acts: Vec<SchoolAct>,
    /// Cursor of the next page: rows before it have not been read. `None` after the last page.
    pub before: Option<i64>,
}

#[derive(FromRow)]
struct ReadWindow {
    #[sqlx(try_from = "i64")]
    rows: u32,
    first: Option<i64>,
}

/// Returns the latest matching entries before a position in the log.
pub async fn search_audit_log<'e>(
    executor: impl Executor<'e> + Copy,
    search: &AuditSearch,
    before: i64,
) -> Result<FoundActs> {
    let window: ReadWindow = sqlx::query_as(
        "SELECT count(*) AS rows, min(seq) AS first
         FROM (SELECT seq FROM audit_log WHERE school_id = $1 AND seq < $2 ORDER BY seq DESC LIMIT $3 + 0) recent",
    )
    .bind(search.school)
    .bind(before)
    .bind(i64::from(search.window))
    .fetch_one(executor)
    .await?;
    let Some(first) = window.first else { return Ok(FoundActs { acts: Vec::new(), before: None }) };
    let acts: Vec<SchoolAct> = sqlx::query_as(
        "SELECT a.seq, a.at, a.actor, p.display_name AS actor_name, a.action, a.object, a.details
         FROM audit_log a
         LEFT JOIN people p ON p.school_id = a.school_id AND length(a.actor) = 36
           AND p.id = unhex(replace(a.actor, '-', ''))
         LEFT JOIN people o ON $5 <> '' AND o.school_id = a.school_id AND length(a.object) = 36
           AND o.id = unhex(replace(a.object, '-', ''))
         WHERE a.school_id = $1 AND a.seq < $2 AND a.seq >= $3
           AND ($4 = '[]' OR substr(a.action, 1, instr(a.action, '.') - 1) IN (SELECT value FROM json_each($4)))
           AND ($5 = '' OR a.object = $5 OR instr(lower(a.actor), lower($5)) > 0
             OR instr(lower(p.display_name), lower($5)) > 0 OR instr(lower(o.display_name), lower($5)) > 0)
           AND a.at >= $6
         ORDER BY a.seq DESC LIMIT $7 + 0",
    )
    .bind(search.school)
    .bind(before)
    .bind(first)
    .bind(&search.themes)
    .bind(&search.words)
    .bind(search.since.unwrap_or(Moment::from_micros(i64::MIN)))
    .bind(i64::from(search.limit))
    .fetch_all(executor)
    .await?;
    let full = acts.last().filter(|_| acts.len() >= search.limit as usize).map(|last| last.seq);
    // If the oldest row read is earlier than `since`, all older rows are, too.
    let ended = match search.since {
        Some(since) => find_row_time(executor, first).await?.is_some_and(|read| read < since),
        None => false,
    };
    let unread = (window.rows >= search.window && !ended).then_some(first);
    Ok(FoundActs { before: full.or(unread), acts })
}

/// Returns the position of the first row that was not written before `at`, or the position after
/// the last row. It uses a binary search: rows are in the order of their times, unless the clock
/// was set back.
pub async fn find_audit_place<'e>(executor: impl Executor<'e> + Copy, at: Moment) -> Result<i64> {
    let (mut low, mut high) = (1, audit_end(executor).await? + 1);
    while low < high {
        let middle = low + (high - low) / 2;
        let written = find_row_time(executor, middle).await?;
        if written.is_some_and(|written| written < at) { low = middle + 1 } else { high = middle }
    }
    Ok(low)
}

/// Returns the time at which a row was written, or `None` if there is no such row.
pub async fn find_row_time(executor: impl Executor<'_>, seq: i64) -> Result<Option<Moment>> {
    sqlx::query_scalar("SELECT at FROM audit_log WHERE seq = $1").bind(seq).fetch_optional(executor).await
}

async fn audit_end(executor: impl Executor<'_>) -> Result<i64> {
    sqlx::query_scalar("SELECT coalesce(max(seq), 0) FROM audit_log").fetch_one(executor).await
}

/// Kind of object that an action was applied to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, sqlx::Type)]
#[sqlx(type_name = "text", rename_all = "lowercase")]
pub enum AuditObjectKind {
    /// A person, shown by their name.
    Person,
    /// A cohort, shown by its name.
    Cohort,
    /// An attempt, shown by the name of its trainee.
    Session,
    /// The school, shown by its name.
    School,
    /// An assignment, shown by the title of its exercise or course, or else by the id.
    Assignment,
    /// A survey, shown by its title.
    Survey,
    /// A study, shown by its title.
    Study,
    /// A round of ratings, shown by its title.
    Round,
    /// A task to mark pops, shown by its title.
    Segments,
    /// A training station, shown by its name.
    Station,
}

crate::engine::read_natively!(Text: AuditObjectKind);

impl AuditObjectKind {
    /// Returns the word used in exported files.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Person => "person",
            Self::Cohort => "cohort",
            Self::Session => "attempt",
            Self::School => "school",
            Self::Assignment => "assignment",
            Self::Survey => "survey",
            Self::Study => "study",
            Self::Round => "rating_round",
            Self::Segments => "marking_task",
            Self::Station => "station",
        }
    }
}

/// The named object of an action.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AuditObject {
    /// Kind of object.
    pub kind: AuditObjectKind,
    /// Its name.
    pub name: String,
}

/// Returns the names of objects by id. The result leaves out strings that are not ids and objects
/// that no longer exist. `CROSS JOIN` makes SQLite look each id up in the index.
///
/// # Errors
/// If the database fails.
pub async fn name_audit_objects(
    executor: impl Executor<'_>,
    school: SchoolId,
    ids: &[String],
) -> Result<BTreeMap<String, AuditObject>> {
    let rows: Vec<(String, AuditObjectKind, StoredTitle)> = sqlx::query_as(
        "WITH wanted AS (SELECT value AS word, unhex(replace(value, '-', '')) AS id FROM json_each($2)
                         WHERE length(value) = 36)
         SELECT w.word, 'person' AS kind, x.display_name AS name FROM wanted w
           CROSS JOIN people x
         WHERE x.school_id = $1 AND x.id = w.id
         UNION ALL SELECT w.word, 'cohort', x.name FROM wanted w CROSS JOIN cohorts x
         WHERE x.school_id = $1 AND x.id = w.id
         UNION ALL SELECT w.word, 'session', p.display_name FROM wanted w
           CROSS JOIN sessions x
           JOIN people p ON p.school_id = x.school_id AND p.id = x.trainee_id WHERE x.school_id = $1 AND x.id = w.id
         UNION ALL SELECT w.word, 'school', x.name FROM wanted w CROSS JOIN schools x
         WHERE x.id = w.id AND x.id = $1
         UNION ALL SELECT w.word, 'assignment', coalesce(r.title, c.title, x.exercise_id, x.curriculum_id) FROM wanted w
           CROSS JOIN assignments x
           LEFT JOIN exercises e ON e.school_id = x.school_id AND e.exercise_id = x.exercise_id
           LEFT JOIN exercise_revisions r ON r.id = e.revision_id
           LEFT JOIN curricula u ON u.school_id = x.school_id AND u.curriculum_id = x.curriculum_id
           LEFT JOIN curriculum_revisions c ON c.id = u.revision_id WHERE x.school_id = $1 AND x.id = w.id
         UNION ALL SELECT w.word, 'survey', x.title FROM wanted w CROSS JOIN surveys x
         WHERE x.school_id = $1 AND x.id = w.id
         UNION ALL SELECT w.word, 'study', x.title FROM wanted w CROSS JOIN studies x
         WHERE x.school_id = $1 AND x.id = w.id
         UNION ALL SELECT w.word, 'round', x.title FROM wanted w CROSS JOIN rating_rounds x
         WHERE x.school_id = $1 AND x.id = w.id
         UNION ALL SELECT w.word, 'segments', x.title FROM wanted w
           CROSS JOIN segment_tasks x
         WHERE x.school_id = $1 AND x.id = w.id
         UNION ALL SELECT w.word, 'station', x.station FROM wanted w
           CROSS JOIN api_tokens x WHERE x.school_id = $1 AND x.id = w.id AND x.station IS NOT NULL",
    )
    .bind(school)
    .bind(serde_json::Value::from(ids).to_string())
    .fetch_all(executor)
    .await?;
    Ok(rows.into_iter().map(|(id, kind, name)| (id, AuditObject { kind, name: name.into() })).collect())
}
