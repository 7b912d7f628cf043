//! Whom a new revision of a course concerns.

use model::PersonKey;
use model::authoring::draft::CourseChange;
use model::ids::{PersonId, SchoolId};
use model::training::progress::Progress;
use store::training::practice;

use crate::authoring::drafting::CheckedCourse;
use crate::error::Error;
use crate::service::Service;
use crate::training::assignments::taught_curricula;

/// People whose attempts are read at once.
const AT_ONCE: u32 = 200;

/// Counts who has mastered the course as it is taught and who is under way; nobody where the exercises and the rule stay the same.
///
/// # Errors
/// When the database fails.
pub async fn find_course_change(
    state: &Service,
    school: SchoolId,
    checked: &CheckedCourse,
) -> Result<CourseChange, Error> {
    let mut change = CourseChange::default();
    let taught = taught_curricula(state, school).await?;
    let Some((_, course)) = taught.into_iter().find(|(taught, _)| taught.curriculum_id == checked.course.id) else {
        return Ok(change);
    };
    let now_taught = course.steps.iter().map(|step| &step.exercise);
    if now_taught.eq(checked.course.entries.iter().map(|entry| &entry.exercise)) && course.rule == checked.mastery {
        return Ok(change);
    }
    let mut after = PersonId::nil();
    loop {
        let key = PersonKey { school_id: school, person_id: after };
        let practised = practice::list_school_practice(state.db.reader(), key, AT_ONCE).await?;
        let Some((last, _)) = practised.last_key_value() else { return Ok(change) };
        after = *last;
        for attempts in practised.values() {
            let progress = Progress::of(&course, attempts);
            change.mastered += usize::from(progress.complete());
            change.under_way += usize::from(!progress.complete() && progress.attempts() > 0);
        }
    }
}
