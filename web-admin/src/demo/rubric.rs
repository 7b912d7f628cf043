//! A rubric of the demonstration that was made milder after it had been used: published as a revision of its own, and every
//! attempt of the first instructor's trainees graded again by it.

use anyhow::{Context, bail, ensure};

use super::experts::find;
use super::school::COHORTS;
use crate::AppState;
use crate::domain::CurrentPerson;
use crate::drafting::{self, Saved};
use crate::error::Error;
use crate::regrading::exercise as regrading;
use crate::storage::{drafts, exercises};
use crate::worker;

/// An exercise with attempts that fail closely.
const EXERCISE: &str = "oblique-approach";
/// By how much its pass mark is lowered, in points.
const MILDER: u32 = 5;
/// Why.
const REASON: &str =
    "The oblique path is new to everybody this year: the department has lowered the pass mark for all groups.";
/// How long after the lesson, in s.
const LATER_S: i64 = 3600;

/// Publishes the milder rubric, looks what it would change, and confirms it.
///
/// # Errors
/// When the instructor or the exercise are missing, or a part of the work fails.
pub(super) async fn lower(state: &AppState) -> anyhow::Result<()> {
    state.clock.advance(LATER_S);
    let instructor = find(state, COHORTS[0].instructor).await?.into_current().context("the first instructor")?;
    publish(state, &instructor).await?;
    let current = exercises::current(state.db.reader(), instructor.school_id, EXERCISE).await?;
    let current = current.context("the exercise that was just published")?;
    let id = match regrading::look(state, &instructor, (EXERCISE, current.id)).await {
        Err(Error::Conflict(_)) => return Ok(()), // Nobody has come so far yet.
        looked => looked?,
    };
    worker::work_off(state).await?;
    let shown = regrading::shown(state, &regrading::find(state, &instructor, id).await?).await?;
    ensure!(regrading::confirm(state, &instructor, id, (&shown, REASON)).await?, "nobody else grades meanwhile");
    worker::work_off(state).await
}

async fn publish(state: &AppState, instructor: &CurrentPerson) -> anyhow::Result<()> {
    let id = drafting::exercise(state, instructor, EXERCISE, None).await?;
    let draft = drafts::find(state.db.reader(), instructor.school_id, id).await?.context("the draft just begun")?;
    let mut texts = draft.texts;
    texts.document = milder(&texts.document);
    let saved = drafting::save(state, instructor, (id, draft.version), &texts).await?;
    let Saved::Kept(draft) = saved else { bail!("nobody else writes in the draft") };
    let checked = drafting::check(state, instructor.school_id, &draft).await?;
    ensure!(drafting::publish(state, instructor, &draft, &checked).await?, "the milder rubric was refused");
    Ok(())
}

/// The document with a lower pass mark.
fn milder(document: &str) -> String {
    let line = |line: &str| {
        let mark = line.strip_prefix("pass_mark = ").and_then(|mark| mark.trim().parse::<u32>().ok());
        mark.map_or_else(|| line.to_owned(), |mark| format!("pass_mark = {}\n", mark.saturating_sub(MILDER)))
    };
    document.split_inclusive('\n').map(line).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_pass_mark_alone_is_lowered() {
        let milder = super::milder("id = \"a\"\npass_mark = 60\ntime_limit_s = 180\n");
        assert_eq!(milder, "id = \"a\"\npass_mark = 55\ntime_limit_s = 180\n");
    }
}
