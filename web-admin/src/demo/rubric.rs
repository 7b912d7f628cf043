//! A rubric of the demonstration that was made milder after it had been used: published as a revision of its own, and every
//! attempt of the first instructor's trainees graded again by it.

use anyhow::{Context, bail, ensure};

use super::experts::find;
use super::school::COHORTS;
use crate::AppState;
use crate::domain::CurrentPerson;
use crate::drafting::{self, Saved};
use crate::regrading::exercise as regrading;
use crate::storage::exercises::Revision;
use crate::storage::scores::SessionKey;
use crate::storage::{drafts, exercises, regradings, scores};
use crate::worker;

/// By how much a pass mark is lowered, in points; by more where nobody has missed it so closely.
const MILDER: f64 = 5.0;
/// Why.
const REASON: &str =
    "The exercise is new to everybody this year: the department has lowered its pass mark for all groups.";
/// How long after the lesson, in s.
const LATER_S: i64 = 3600;

/// What a lower pass mark of an exercise would change.
#[derive(Clone, Debug, PartialEq)]
struct Milder {
    exercise: String,
    /// By how much it is lowered, in points.
    points: f64,
    /// Attempts that would pass.
    passes: usize,
}

/// Publishes the milder rubric, looks what it would change, and confirms it. Nothing where everybody has passed everything.
///
/// # Errors
/// When the instructor is missing, or a part of the work fails.
pub(super) async fn lower(state: &AppState) -> anyhow::Result<()> {
    state.clock.advance(LATER_S);
    let instructor = find(state, COHORTS[0].instructor).await?.into_current().context("the first instructor")?;
    let Some(milder) = choose(state, &instructor).await? else { return Ok(()) };
    publish(state, &instructor, &milder).await?;
    let exercise = milder.exercise.as_str();
    let current = exercises::current(state.db.reader(), instructor.school_id, exercise).await?;
    let current = current.context("the exercise that was just published")?;
    let id = regrading::look(state, &instructor, (exercise, current.id)).await?;
    worker::work_off(state).await?;
    let shown = regrading::shown(state, &regrading::find(state, &instructor, id).await?).await?;
    ensure!(regrading::confirm(state, &instructor, id, (&shown, REASON)).await?, "nobody else grades meanwhile");
    worker::work_off(state).await
}

/// The exercise whose pass mark need be lowered least; of equals, the one where that lets most attempts pass.
async fn choose(state: &AppState, instructor: &CurrentPerson) -> anyhow::Result<Option<Milder>> {
    let mut all = Vec::new();
    for taught in exercises::all_current(state.db.reader(), instructor.school_id).await? {
        let misses = misses(state, instructor, &taught).await?;
        all.extend(Milder::of(&taught.exercise_id, &misses));
    }
    Ok(all.into_iter().min_by(|a, b| a.points.total_cmp(&b.points).then(b.passes.cmp(&a.passes))))
}

/// By how many points each attempt has missed the pass mark that has missed nothing else.
async fn misses(state: &AppState, instructor: &CurrentPerson, taught: &Revision) -> anyhow::Result<Vec<f64>> {
    let reader = state.db.reader();
    let mut misses = Vec::new();
    for stood in regradings::standing(reader, instructor, &taught.exercise_id).await? {
        let key = SessionKey { school_id: instructor.school_id, id: stood.session_id };
        let Some(score) = scores::newest(reader, key).await?.filter(|_| stood.override_id.is_none()) else { continue };
        if !score.passed && score.hard_fails.is_empty() {
            misses.push(taught.pass_mark - score.score);
        }
    }
    Ok(misses)
}

impl Milder {
    fn of(exercise: &str, misses: &[f64]) -> Option<Self> {
        let nearest = misses.iter().copied().reduce(f64::min)?;
        let points = nearest.ceil().max(MILDER);
        let passes = misses.iter().filter(|miss| **miss <= points).count();
        Some(Self { exercise: exercise.to_owned(), points, passes })
    }

    /// The document with the lower pass mark.
    fn written(&self, document: &str) -> String {
        let line = |line: &str| {
            let mark = line.strip_prefix("pass_mark = ").and_then(|mark| mark.trim().parse::<f64>().ok());
            mark.map_or_else(|| line.to_owned(), |mark| format!("pass_mark = {}\n", (mark - self.points).max(0.0)))
        };
        document.split_inclusive('\n').map(line).collect()
    }
}

async fn publish(state: &AppState, instructor: &CurrentPerson, milder: &Milder) -> anyhow::Result<()> {
    let id = drafting::exercise(state, instructor, &milder.exercise, None).await?;
    let draft = drafts::find(state.db.reader(), instructor.school_id, id).await?.context("the draft just begun")?;
    let mut texts = draft.texts;
    texts.document = milder.written(&texts.document);
    let saved = drafting::save(state, instructor, (id, draft.version), &texts).await?;
    let Saved::Kept(draft) = saved else { bail!("nobody else writes in the draft") };
    let checked = drafting::check(state, instructor.school_id, &draft).await?;
    ensure!(drafting::publish(state, instructor, &draft, &checked).await?, "the milder rubric was refused");
    Ok(())
}

#[cfg(test)]
mod tests {
    //! The demonstration must have a re-grading worth looking at: somebody passes who had failed. Fails when the mark is
    //! lowered by too little for anybody, or something else in the document changes.

    use super::Milder;

    #[test]
    fn the_mark_is_lowered_to_where_it_lets_somebody_pass() {
        for misses in [vec![0.4, 4.9, 5.1], vec![12.3], vec![60.0, 5.0]] {
            let milder = Milder::of("a", &misses).expect("somebody has failed");
            let passing = misses.iter().filter(|miss| **miss <= milder.points).count();
            assert!(milder.passes == passing && passing > 0, "{milder:?} of {misses:?}");
        }
        assert_eq!(Milder::of("a", &[0.4, 4.9, 5.1]).map(|milder| milder.passes), Some(2));
        assert_eq!(Milder::of("a", &[]), None);
    }

    #[test]
    fn the_pass_mark_alone_is_lowered() {
        let milder = Milder::of("a", &[4.0]).expect("somebody has failed");
        let written = milder.written("id = \"a\"\npass_mark = 60\ntime_limit_s = 180\n");
        assert_eq!(written, "id = \"a\"\npass_mark = 55\ntime_limit_s = 180\n");
    }
}
