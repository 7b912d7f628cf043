//! `/exercises/{id}/revisions` and `/curricula/{id}/revisions`: what was published, and how two of them differ.

use axum::extract::{Path, Query, State};
use serde::Deserialize;
use uuid::Uuid;

use crate::AppState;
use crate::domain::CurrentPerson;
use crate::drafting;
use crate::error::{Error, PageError};
use crate::routes::auth::Csrf;
use crate::storage::{curricula, exercises};
use crate::views::diff::diff;
use crate::views::draft::{RevisionRow, RevisionsPage};
use crate::views::trainee::exercise_href;
use crate::views::{Place, Shell, format};

/// Which two are compared; the two newest where nothing is said.
#[derive(Debug, Deserialize)]
pub(super) struct Compared {
    from: Option<Uuid>,
    to: Option<Uuid>,
}

impl Compared {
    /// The two, of those that there are.
    fn among(&self, rows: &[(Uuid, RevisionRow)]) -> Result<(Uuid, Uuid), Error> {
        let pick = |asked: Option<Uuid>, otherwise: usize| match asked {
            Some(id) => rows.iter().find(|(known, _)| *known == id),
            None => rows.get(otherwise).or(rows.first()),
        };
        let (from, to) = (pick(self.from, 1), pick(self.to, 0));
        from.zip(to).map(|((from, _), (to, _))| (*from, *to)).ok_or(Error::NotFound)
    }
}

pub(super) async fn of_exercise(
    State(state): State<AppState>,
    person: CurrentPerson,
    (Path(id), Query(compared)): (Path<String>, Query<Compared>),
    csrf: Csrf,
) -> Result<RevisionsPage, PageError> {
    drafting::staff_only(&person)?;
    let (reader, school) = (state.db.reader(), person.school_id);
    let current = exercises::current(reader, school, &id).await?.ok_or(Error::NotFound)?;
    let revisions = exercises::revisions(reader, school, &id).await?;
    let row = |revision: exercises::Revision| {
        let hash = format::short_hash(&revision.exercise_sha256).to_owned();
        let row = RevisionRow {
            id: revision.id.to_string(),
            title: revision.title,
            hash,
            published_at: revision.published_at.to_utc(),
            current: revision.id == current.id,
        };
        (revision.id, row)
    };
    let rows: Vec<_> = revisions.into_iter().map(row).collect();
    let (from, to) = compared.among(&rows)?;
    let older = exercises::bytes(reader, school, from).await?.ok_or(Error::NotFound)?;
    let newer = exercises::bytes(reader, school, to).await?.ok_or(Error::NotFound)?;
    Ok(RevisionsPage {
        shell: Shell::new(&person, csrf.token(), Place::Curricula),
        title: current.title,
        href: exercise_href(&id),
        revisions: rows.into_iter().map(|(_, row)| row).collect(),
        from: from.to_string(),
        to: to.to_string(),
        parts: vec![
            ("Exercise", lines(&older.exercise, &newer.exercise)),
            ("Scene", lines(&older.scene, &newer.scene)),
        ],
    })
}

pub(super) async fn of_course(
    State(state): State<AppState>,
    person: CurrentPerson,
    (Path(id), Query(compared)): (Path<String>, Query<Compared>),
    csrf: Csrf,
) -> Result<RevisionsPage, PageError> {
    drafting::staff_only(&person)?;
    let (reader, school) = (state.db.reader(), person.school_id);
    let taught = curricula::taught(reader, school).await?;
    let current = taught.into_iter().find(|course| course.curriculum_id == id).ok_or(Error::NotFound)?;
    let revisions = curricula::revisions(reader, school, &id).await?;
    let row = |revision: curricula::Listed| {
        let row = RevisionRow {
            id: revision.id.to_string(),
            title: revision.title,
            hash: format::short_hash(&revision.sha256).to_owned(),
            published_at: revision.published_at.to_utc(),
            current: revision.id == current.revision_id,
        };
        (revision.id, row)
    };
    let rows: Vec<_> = revisions.into_iter().map(row).collect();
    let (from, to) = compared.among(&rows)?;
    let older = curricula::bytes(reader, school, from).await?.ok_or(Error::NotFound)?;
    let newer = curricula::bytes(reader, school, to).await?.ok_or(Error::NotFound)?;
    Ok(RevisionsPage {
        shell: Shell::new(&person, csrf.token(), Place::Curricula),
        title: current.title,
        href: "/curricula".to_owned(),
        revisions: rows.into_iter().map(|(_, row)| row).collect(),
        from: from.to_string(),
        to: to.to_string(),
        parts: vec![("Course", lines(&older, &newer))],
    })
}

fn lines(older: &[u8], newer: &[u8]) -> Vec<Vec<crate::views::diff::DiffLine>> {
    diff(&String::from_utf8_lossy(older), &String::from_utf8_lossy(newer))
}
