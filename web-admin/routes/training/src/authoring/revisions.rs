//! `/exercises/{id}/revisions` and `/curricula/{id}/revisions`: published revisions, and the
//! differences between two of them.

use acts::error::Error;
use axum::extract::{Path, Query, State};
use model::ids::RevisionId;
use pages::authoring::diff::{DiffLine, compare_lines};
use pages::authoring::revisions::{RevisionRow, RevisionsPage};
use pages::training::addresses::exercise_href;
use pages::{NavPlace, Shell, format};
use routes_base::AppState;
use routes_base::auth::{Csrf, Teacher};
use routes_base::error::PageError;
use serde::Deserialize;
use store::authoring::exercises;
use store::training::curricula;

/// The two revisions to compare; by default the two newest.
#[derive(Debug, Deserialize)]
pub(super) struct ComparedQuery {
    from: Option<RevisionId>,
    to: Option<RevisionId>,
}

impl ComparedQuery {
    /// Returns the two revisions, which must be among the listed ones.
    fn among(&self, rows: &[RevisionRow]) -> Result<(RevisionId, RevisionId), Error> {
        let pick = |asked: Option<RevisionId>, otherwise: usize| match asked {
            Some(id) => rows.iter().find(|row| row.id == id),
            None => rows.get(otherwise).or(rows.first()),
        };
        let (from, to) = (pick(self.from, 1), pick(self.to, 0));
        from.zip(to).map(|(from, to)| (from.id, to.id)).ok_or(Error::NotFound)
    }
}

pub(super) async fn compare_exercise_revisions(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path(id): Path<String>,
    Query(compared): Query<ComparedQuery>,
    csrf: Csrf,
) -> Result<RevisionsPage, PageError> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let current = exercises::find_current_revision(reader, school, &id).await?.ok_or(Error::NotFound)?;
    let row = |revision: exercises::Revision| RevisionRow {
        id: revision.id,
        title: revision.title,
        hash: format::shorten_hash(&revision.exercise_sha256).to_owned(),
        published_at: revision.published_at.to_utc(),
        current: revision.id == current.id,
    };
    let revisions: Vec<_> =
        exercises::list_exercise_revisions(reader, school, &id).await?.into_iter().map(row).collect();
    let (from, to) = compared.among(&revisions)?;
    let older = exercises::read_exercise_bytes(reader, school, from).await?.ok_or(Error::NotFound)?;
    let newer = exercises::read_exercise_bytes(reader, school, to).await?.ok_or(Error::NotFound)?;
    let shell = Shell::new(&person, csrf.token(), NavPlace::Curricula);
    let parts = vec![
        (tr!("Exercise"), compare_documents(&older.exercise, &newer.exercise)),
        (tr!("Scene"), compare_documents(&older.scene, &newer.scene)),
    ];
    Ok(RevisionsPage { shell, title: current.title, href: exercise_href(&id), revisions, from, to, parts })
}

pub(super) async fn compare_course_revisions(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path(id): Path<String>,
    Query(compared): Query<ComparedQuery>,
    csrf: Csrf,
) -> Result<RevisionsPage, PageError> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let taught = curricula::list_taught_curricula(reader, school).await?;
    let current = taught.into_iter().find(|course| course.curriculum_id == id).ok_or(Error::NotFound)?;
    let row = |revision: curricula::CurriculumRevision| RevisionRow {
        id: revision.id,
        title: revision.title,
        hash: format::shorten_hash(&revision.sha256).to_owned(),
        published_at: revision.published_at.to_utc(),
        current: revision.id == current.revision_id,
    };
    let revisions: Vec<_> =
        curricula::list_curriculum_revisions(reader, school, &id).await?.into_iter().map(row).collect();
    let (from, to) = compared.among(&revisions)?;
    let older = curricula::read_curriculum_bytes(reader, school, from).await?.ok_or(Error::NotFound)?;
    let newer = curricula::read_curriculum_bytes(reader, school, to).await?.ok_or(Error::NotFound)?;
    let shell = Shell::new(&person, csrf.token(), NavPlace::Curricula);
    let parts = vec![(tr!("Course"), compare_documents(&older, &newer))];
    Ok(RevisionsPage { shell, title: current.title, href: "/curricula".to_owned(), revisions, from, to, parts })
}

fn compare_documents(older: &[u8], newer: &[u8]) -> Vec<Vec<DiffLine>> {
    compare_lines(&String::from_utf8_lossy(older), &String::from_utf8_lossy(newer))
}
