//! Published curricula and their exercises.

use std::collections::BTreeMap;

use documents::Wording;
use model::Moment;
use model::ids::{RevisionId, SchoolId};
use model::titles::{StoredTitle, store_wording};
use model::training::progress::{Course, CourseStep, CurveRule, EarlierCourse, Mastery};
use sqlx::FromRow;

use crate::{Connection, Executor, Json, Result};

/// A curriculum revision to be published.
#[derive(Clone, Debug)]
pub struct NewCurriculum<'a> {
    /// Curriculum id.
    pub curriculum_id: &'a str,
    /// Title shown to people.
    pub title: &'a Wording,
    /// Description.
    pub description: &'a Wording,
    /// Mastery rule.
    pub mastery: Mastery,
    /// SHA-256 of the document.
    pub sha256: &'a str,
    /// The document, byte for byte.
    pub bytes: &'a [u8],
    /// Exercises, in order.
    pub entries: &'a [NewEntry],
}

/// An exercise of a curriculum to be published.
#[derive(Clone, Debug)]
pub struct NewEntry {
    /// Exercise id.
    pub exercise_id: String,
    /// Ids of the exercises that must be mastered first.
    pub prerequisites: Vec<String>,
    /// Id of the questionnaire shown after each attempt.
    pub survey: Option<String>,
}

/// The current revision of a curriculum.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct TaughtCurriculum {
    /// Id of the current revision.
    pub revision_id: RevisionId,
    /// Curriculum id.
    pub curriculum_id: String,
    /// Title shown to people.
    #[sqlx(try_from = "StoredTitle")]
    pub title: String,
    /// Description.
    #[sqlx(try_from = "StoredTitle")]
    pub description: String,
    /// SHA-256 of the document.
    pub sha256: String,
    /// When an exercise of it is mastered.
    #[sqlx(flatten)]
    rule: MasteryColumns,
}

/// The mastery rule of a revision.
#[derive(Clone, Debug, PartialEq, FromRow)]
struct MasteryColumns {
    /// Passes needed …
    #[sqlx(try_from = "i64")]
    mastery_passes: u32,
    /// … out of this many latest attempts, unless mastery is judged by a learning curve.
    #[sqlx(try_from = "i64")]
    mastery_of: u32,
    mastery_curve: Option<Json<CurveRule>>,
}

impl MasteryColumns {
    fn rule(&self) -> Mastery {
        match &self.mastery_curve {
            Some(Json(curve)) => Mastery::Curve(*curve),
            None => Mastery::Passes { passes: self.mastery_passes, of: self.mastery_of },
        }
    }
}

/// A revision of a curriculum that another has replaced.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct ReplacedCurriculum {
    revision_id: RevisionId,
    curriculum_id: String,
    sha256: String,
    replaced_at: Moment,
    #[sqlx(flatten)]
    rule: MasteryColumns,
}

impl TaughtCurriculum {
    /// Its course, taken from among the exercises of several, with its earlier revisions among `replaced`, newest first.
    #[must_use]
    pub fn take_course(&self, steps: &mut CourseSteps, replaced: &[ReplacedCurriculum]) -> Course {
        let mut take = |revision| steps.remove(&revision).unwrap_or_default();
        let (current, rule) = (take(self.revision_id), self.rule.rule());
        let mut earlier: Vec<EarlierCourse> = Vec::new();
        for one in replaced.iter().filter(|one| one.curriculum_id == self.curriculum_id) {
            let (steps, their_rule) = (take(one.revision_id), one.rule.rule());
            let after = earlier.last().map_or((&current, &rule), |later| (&later.steps, &later.rule));
            // Where only words were changed, the later of the two stands for both.
            if after != (&steps, &their_rule) {
                let (sha256, until) = (one.sha256.clone(), one.replaced_at.to_utc());
                earlier.push(EarlierCourse { steps, rule: their_rule, sha256, until });
            }
        }
        Course { steps: current, rule, earlier }
    }
}

#[derive(FromRow)]
struct CurriculumStepRow {
    revision_id: RevisionId,
    exercise_id: String,
    #[sqlx(try_from = "StoredTitle")]
    title: String,
    prerequisites: Json<Vec<String>>,
}

impl From<CurriculumStepRow> for CourseStep {
    fn from(row: CurriculumStepRow) -> Self {
        Self { exercise: row.exercise_id, title: row.title, prerequisites: row.prerequisites.0 }
    }
}

/// Steps of curricula, in order, by the revision of the curriculum.
pub type CourseSteps = BTreeMap<RevisionId, Vec<CourseStep>>;

/// Returns the curriculum revision with this hash, if it was ever published.
pub async fn find_curriculum_by_hash(
    executor: impl Executor<'_>,
    school: SchoolId,
    sha256: &str,
) -> Result<Option<RevisionId>> {
    sqlx::query_scalar("SELECT id FROM curriculum_revisions WHERE school_id = $1 AND sha256 = $2")
        .bind(school)
        .bind(sha256)
        .fetch_optional(executor)
        .await
}

/// Stores a revision and its entries.
///
/// # Errors
/// If this document was published before, or the database fails.
pub async fn publish_curriculum(
    writer: &mut Connection,
    school: SchoolId,
    curriculum: &NewCurriculum<'_>,
    now: Moment,
) -> Result<RevisionId> {
    let id = RevisionId::made_at(now);
    let (passes, of, curve) = match curriculum.mastery {
        Mastery::Passes { passes, of } => (passes, of, None),
        Mastery::Curve(curve) => (0, 0, Some(Json(curve))),
    };
    sqlx::query(
        "INSERT INTO curriculum_revisions (id, school_id, curriculum_id, title, description, mastery_passes,
         mastery_of, mastery_curve, sha256, bytes, published_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11)",
    )
    .bind(id)
    .bind(school)
    .bind(curriculum.curriculum_id)
    .bind(store_wording(curriculum.title))
    .bind(store_wording(curriculum.description))
    .bind(i64::from(passes))
    .bind(i64::from(of))
    .bind(curve)
    .bind(curriculum.sha256)
    .bind(curriculum.bytes)
    .bind(now)
    .execute(&mut *writer)
    .await?;
    for (position, entry) in (0_i64..).zip(curriculum.entries) {
        insert_entry(writer, id, position, entry).await?;
    }
    Ok(id)
}

async fn insert_entry(writer: &mut Connection, revision: RevisionId, position: i64, entry: &NewEntry) -> Result<()> {
    sqlx::query(
        "INSERT INTO curriculum_entries (revision_id, position, exercise_id, prerequisites, survey)
         VALUES ($1, $2, $3, $4, $5)",
    )
    .bind(revision)
    .bind(position)
    .bind(&entry.exercise_id)
    .bind(Json(&entry.prerequisites))
    .bind(&entry.survey)
    .execute(writer)
    .await
    .map(drop)
}

/// Makes a revision the one that is taught from a moment on, in place of the one before.
pub async fn make_current(
    writer: &mut Connection,
    school: SchoolId,
    id: &str,
    revision: RevisionId,
    now: Moment,
) -> Result<()> {
    sqlx::query(
        "INSERT INTO replaced_curricula (revision_id, replaced_at)
         SELECT revision_id, $3 FROM curricula WHERE school_id = $1 AND curriculum_id = $2
         ON CONFLICT (revision_id) DO UPDATE SET replaced_at = excluded.replaced_at",
    )
    .bind(school)
    .bind(id)
    .bind(now)
    .execute(&mut *writer)
    .await?;
    sqlx::query("DELETE FROM replaced_curricula WHERE revision_id = $1").bind(revision).execute(&mut *writer).await?;
    sqlx::query(
        "INSERT INTO curricula (school_id, curriculum_id, revision_id) VALUES ($1, $2, $3)
         ON CONFLICT (school_id, curriculum_id) DO UPDATE SET revision_id = excluded.revision_id",
    )
    .bind(school)
    .bind(id)
    .bind(revision)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns the curricula that a school teaches, sorted by id.
pub async fn list_taught_curricula(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<TaughtCurriculum>> {
    sqlx::query_as(
        "SELECT r.id AS revision_id, r.curriculum_id, r.title, r.description, r.sha256, r.mastery_passes, r.mastery_of, r.mastery_curve
         FROM curricula c JOIN curriculum_revisions r ON r.id = c.revision_id
         WHERE c.school_id = $1 ORDER BY c.curriculum_id",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// A revision of a curriculum, as listed.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct CurriculumRevision {
    /// Id of the revision.
    pub id: RevisionId,
    /// Title shown to people.
    #[sqlx(try_from = "StoredTitle")]
    pub title: String,
    /// SHA-256 of the document.
    pub sha256: String,
    /// Time of publication.
    pub published_at: Moment,
}

/// Returns all revisions of a curriculum, newest first.
pub async fn list_curriculum_revisions(
    executor: impl Executor<'_>,
    school: SchoolId,
    id: &str,
) -> Result<Vec<CurriculumRevision>> {
    // `rowid` is the order of insertion, which does not depend on the clock.
    sqlx::query_as(
        "SELECT id, title, sha256, published_at FROM curriculum_revisions
         WHERE school_id = $1 AND curriculum_id = $2 ORDER BY rowid DESC",
    )
    .bind(school)
    .bind(id)
    .fetch_all(executor)
    .await
}

/// Returns the document of a revision, byte for byte.
pub async fn read_curriculum_bytes(
    executor: impl Executor<'_>,
    school: SchoolId,
    revision: RevisionId,
) -> Result<Option<Vec<u8>>> {
    sqlx::query_scalar("SELECT bytes FROM curriculum_revisions WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(revision)
        .fetch_optional(executor)
        .await
}

/// Returns the ids of a revision's exercises, in order.
pub async fn exercise_ids(executor: impl Executor<'_>, revision: RevisionId) -> Result<Vec<String>> {
    sqlx::query_scalar("SELECT exercise_id FROM curriculum_entries WHERE revision_id = $1 ORDER BY position")
        .bind(revision)
        .fetch_all(executor)
        .await
}

/// The exercises of every revision of the curricula that a school teaches or has taught, each under its title in the revision that
/// trainees are given.
pub async fn list_course_steps(executor: impl Executor<'_>, school: SchoolId) -> Result<CourseSteps> {
    let rows: Vec<CurriculumStepRow> = sqlx::query_as(
        "SELECT e.revision_id, e.exercise_id, r.title, e.prerequisites
         FROM curriculum_revisions c JOIN curriculum_entries e ON e.revision_id = c.id
         JOIN exercises x ON x.school_id = $1 AND x.exercise_id = e.exercise_id
         JOIN exercise_revisions r ON r.id = x.revision_id
         WHERE c.school_id = $1 ORDER BY e.revision_id, e.position",
    )
    .bind(school)
    .fetch_all(executor)
    .await?;
    let mut steps = CourseSteps::new();
    for row in rows {
        steps.entry(row.revision_id).or_default().push(row.into());
    }
    Ok(steps)
}

/// The revisions that others have replaced, those replaced last first.
pub async fn list_replaced_curricula(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<ReplacedCurriculum>> {
    sqlx::query_as(
        "SELECT r.id AS revision_id, r.curriculum_id, r.sha256, p.replaced_at, r.mastery_passes, r.mastery_of, r.mastery_curve
         FROM curriculum_revisions r JOIN replaced_curricula p ON p.revision_id = r.id
         WHERE r.school_id = $1 ORDER BY p.replaced_at DESC, r.id DESC",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}
