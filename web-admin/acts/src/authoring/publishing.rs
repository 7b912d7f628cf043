//! Publishes documents as revisions.

use std::fmt;
use std::path::{Path, PathBuf};

use anyhow::Context;
use assessment::statistics::NotComputable;
use data_encoding::HEXLOWER;
use documents::load::{Document, read_document};
use documents::{Curriculum, DocumentError, ExerciseBundle, Issue};
use model::Moment;
use model::ids::SchoolId;
use model::training::progress::Mastery;
use phrase::phrase;
use serde_json::json;
use sha2::{Digest, Sha256};
use store::Connection;
use store::audit::{Actor, AuditEntry};
use store::authoring::exercises;
use store::authoring::exercises::NewRevision;
use store::training::curricula;
use store::training::curricula::{NewCurriculum, NewEntry};

/// Why a course was not published.
#[derive(Debug)]
pub enum CourseRefused {
    /// A document is invalid; the text names the place.
    Document(String),
    /// An operation failed.
    Work(anyhow::Error),
}

impl From<DocumentError> for CourseRefused {
    fn from(error: DocumentError) -> Self {
        Self::Document(error.to_string())
    }
}

impl From<anyhow::Error> for CourseRefused {
    fn from(error: anyhow::Error) -> Self {
        Self::Work(error)
    }
}

impl From<store::Error> for CourseRefused {
    fn from(error: store::Error) -> Self {
        Self::Work(anyhow::Error::new(error).context("database"))
    }
}

/// Result of publishing a document.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Published {
    /// Kind of the document, such as `course` or `exercise`.
    pub kind: &'static str,
    /// Its id.
    pub id: String,
    /// Whether this revision is new to the school.
    pub new: bool,
}

impl fmt::Display for Published {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = if self.new { "new" } else { "unchanged" };
        write!(f, "{word:9} {} {}", self.kind, self.id)
    }
}

/// School, actor and time of a publication.
#[derive(Clone, Debug)]
pub struct DocumentPublisher {
    /// School.
    pub school: SchoolId,
    /// Actor.
    pub by: Actor,
    /// Time.
    pub now: Moment,
}

impl DocumentPublisher {
    pub(crate) fn did<'a>(&self, action: &'a str, object: &str) -> AuditEntry<'a> {
        AuditEntry::new(self.school, self.by.clone(), action, object)
    }
}

/// Lists each `course.toml` in a folder or one level below it, sorted.
///
/// # Errors
/// Fails if the folder cannot be read.
pub fn courses_in(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut candidates = vec![folder.join("course.toml")];
    for entry in std::fs::read_dir(folder)? {
        candidates.push(entry?.path().join("course.toml"));
    }
    candidates.retain(|path| path.is_file());
    candidates.sort();
    Ok(candidates)
}

/// Publishes a course and its exercises. A revision with identical bytes is reused.
///
/// # Errors
/// Fails if a document is invalid, or the database fails.
pub async fn course(
    writer: &mut Connection,
    school: SchoolId,
    path: &Path,
    now: Moment,
) -> Result<Vec<Published>, CourseRefused> {
    let Document::Curriculum(course, bundles) = read_document(path)? else {
        return Err(CourseRefused::Document(format!("{}: not a curriculum", path.display())));
    };
    let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
    let publisher = DocumentPublisher { school, by: Actor::CommandLine, now };
    let mut published = Vec::new();
    for bundle in &bundles {
        published.push(exercise(writer, &publisher, bundle).await?);
    }
    published.push(curriculum(writer, &publisher, &course, &bytes).await?);
    Ok(published)
}

/// Publishes an exercise with its scene, meshes and images.
pub async fn exercise(
    writer: &mut Connection,
    publisher: &DocumentPublisher,
    bundle: &ExerciseBundle,
) -> anyhow::Result<Published> {
    let DocumentPublisher { school, now, .. } = *publisher;
    let bundle_sha256 = bundle_sha256(bundle);
    let known = exercises::find_revision_by_bundle(&mut *writer, school, &bundle_sha256).await?;
    let ExerciseBundle { exercise, scene, exercise_bytes, scene_bytes, meshes, pictures } = bundle;
    let new = NewRevision {
        exercise_id: &exercise.id,
        title: &exercise.title,
        difficulty: exercise.difficulty,
        pass_mark: exercise.pass_mark,
        exercise_sha256: &exercise.sha256,
        scene_sha256: &scene.sha256,
        bundle_sha256: &bundle_sha256,
        exercise_bytes,
        scene_bytes,
        meshes,
        pictures,
    };
    let revision = match known {
        Some(revision) => revision,
        None => exercises::publish_exercise(writer, school, &new, now).await?,
    };
    let before = exercises::find_current_revision(&mut *writer, school, &exercise.id).await?.map(|current| current.id);
    if before != Some(revision) {
        exercises::make_current(writer, school, &exercise.id, revision, now).await?;
        let details = json!({ "revision": revision, "sha256": exercise.sha256, "before": before });
        publisher.did("exercise.published", &exercise.id).with(details).append(writer, publisher.now).await?;
    }
    Ok(Published { kind: "exercise", id: exercise.id.clone(), new: known.is_none() })
}

/// Publishes the document of a course.
///
/// # Errors
/// Fails if no limit of the learning curve satisfies its mastery rule, or the database fails.
pub async fn curriculum(
    writer: &mut Connection,
    publisher: &DocumentPublisher,
    course: &Curriculum,
    bytes: &[u8],
) -> Result<Published, CourseRefused> {
    let DocumentPublisher { school, now, .. } = *publisher;
    let mastery = Mastery::from_rule(&course.mastery)
        .map_err(|why| CourseRefused::Document(format!("course {}: {}", course.id, no_limit(why))))?;
    let known = curricula::find_curriculum_by_hash(&mut *writer, school, &course.sha256).await?;
    let entries: Vec<_> = course.entries.iter().map(entry).collect();
    let new = NewCurriculum {
        curriculum_id: &course.id,
        title: &course.title,
        description: &course.description,
        mastery,
        sha256: &course.sha256,
        bytes,
        entries: &entries,
    };
    let revision = match known {
        Some(revision) => revision,
        None => curricula::publish_curriculum(writer, school, &new, now).await?,
    };
    let taught = curricula::list_taught_curricula(&mut *writer, school).await?;
    if !taught.iter().any(|current| current.revision_id == revision) {
        curricula::make_current(writer, school, &course.id, revision, now).await?;
        let details = json!({ "revision": revision, "sha256": course.sha256 });
        publisher.did("curriculum.published", &course.id).with(details).append(writer, publisher.now).await?;
    }
    Ok(Published { kind: "course", id: course.id.clone(), new: known.is_none() })
}

/// Returns the problem of a mastery rule for which no limit of the learning curve can be computed.
#[must_use]
pub fn no_limit(why: NotComputable) -> Issue {
    Issue {
        file: "course".to_owned(),
        line: 1,
        column: 1,
        field: "mastery".to_owned(),
        found: phrase!("no limit of the learning curve keeps the stated alpha ({why})", why = why.in_words()),
        allowed: phrase!("allowed: a larger alpha or within, or rates farther apart"),
    }
}

fn entry(entry: &documents::curriculum::CurriculumEntry) -> NewEntry {
    NewEntry {
        exercise_id: entry.exercise.clone(),
        prerequisites: entry.prerequisites.clone(),
        survey: entry.survey.clone(),
    }
}

/// Returns the SHA-256 of all parts of an exercise. Each part is preceded by its length, so that
/// moving a byte between two parts changes the hash.
fn bundle_sha256(bundle: &ExerciseBundle) -> String {
    let mut hash = Sha256::new();
    let mut part = |bytes: &[u8]| {
        hash.update((bytes.len() as u64).to_be_bytes());
        hash.update(bytes);
    };
    part(&bundle.exercise_bytes);
    part(&bundle.scene_bytes);
    for (name, bytes) in &bundle.meshes {
        part(name.as_bytes());
        part(bytes);
    }
    for picture in &bundle.pictures {
        part(picture.name.as_bytes());
        part(&picture.bytes);
    }
    HEXLOWER.encode(&hash.finalize())
}
