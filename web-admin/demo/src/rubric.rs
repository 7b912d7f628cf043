//! A changed pass mark in the demonstration: published as a new revision, and applied to all
//! attempts of the first instructor's trainees by re-grading.

use acts::authoring::drafting;
use acts::authoring::drafting::SaveOutcome;
use acts::scoring::regrading::exercise as regrading;
use anyhow::{Context, bail, ensure};
use model::{CurrentPerson, SessionKey};
use routes_base::AppState;
use store::authoring::{drafts, exercises};
use store::scoring::{regradings, scores};

use crate::experts::find_expert;
use crate::school::COHORTS;

/// Minimum change of the pass mark, in points; larger if no score is that close.
const POINTS: f64 = 5.0;
/// Time between the lesson and the change, in s.
const LATER_S: i64 = 3600;

/// A new pass mark of an exercise, and its effect.
#[derive(Clone, Debug, PartialEq)]
struct RubricChange {
    exercise: String,
    /// Current and new pass mark, 0–100.
    marks: (f64, f64),
    /// Number of attempts whose result changes.
    attempts: usize,
    reason: &'static str,
}

/// Publishes the changed rubric, previews the re-grading and confirms it.
///
/// # Errors
/// Fails if the instructor is missing, there is no suitable attempt, or an operation fails.
pub(super) async fn change_rubric(state: &AppState) -> anyhow::Result<()> {
    state.clock.advance(LATER_S);
    let instructor = find_expert(state, COHORTS[0].instructor).await?.into_current().context("the first instructor")?;
    let change = choose_rubric(state, &instructor).await?.context("an attempt whose result a pass mark decides")?;
    publish_rubric(state, &instructor, &change).await?;
    let exercise = change.exercise.as_str();
    let current = exercises::find_current_revision(state.db.reader(), instructor.school_id, exercise).await?;
    let current = current.context("the exercise that was just published")?;
    let id = regrading::look(state, &instructor, exercise, current.id).await?;
    worker::work_off_jobs(state).await?;
    let shown =
        regrading::find(state, &instructor, id).await?.shown_sha256.context("a re-grading that was looked at")?;
    ensure!(regrading::confirm(state, &instructor, id, &shown, change.reason).await?, "nobody else grades meanwhile");
    worker::work_off_jobs(state).await
}

/// Chooses a lower pass mark if there is a failed attempt; otherwise, as in the first weeks, a
/// higher one. Prefers the exercise with the smallest change of the mark, and among equals the one
/// for which most results change.
async fn choose_rubric(state: &AppState, instructor: &CurrentPerson) -> anyhow::Result<Option<RubricChange>> {
    let (mut milder, mut stricter) = (Vec::new(), Vec::new());
    for taught in exercises::list_current_exercises(state.db.reader(), instructor.school_id).await? {
        let scores = wait_for_regrading(state, instructor, &taught.exercise_id).await?;
        milder.extend(RubricChange::milder(&taught.exercise_id, taught.pass_mark, &scores));
        stricter.extend(RubricChange::stricter(&taught.exercise_id, taught.pass_mark, &scores));
    }
    let all = if milder.is_empty() { stricter } else { milder };
    Ok(all.into_iter().min_by(|a, b| a.points().total_cmp(&b.points()).then(b.attempts.cmp(&a.attempts))))
}

/// Returns the scores of the attempts whose result depends on the pass mark alone.
async fn wait_for_regrading(state: &AppState, instructor: &CurrentPerson, exercise: &str) -> anyhow::Result<Vec<f64>> {
    let reader = state.db.reader();
    let mut decided = Vec::new();
    for stood in regradings::standing(reader, instructor, exercise).await? {
        let key = SessionKey { school_id: instructor.school_id, id: stood.session_id };
        let score = scores::find_newest_score(reader, key).await?.filter(|_| stood.override_id.is_none());
        decided.extend(score.filter(|score| score.hard_fails.is_empty()).map(|score| score.score));
    }
    Ok(decided)
}

impl RubricChange {
    /// Returns a pass mark at which at least one failed attempt passes.
    fn milder(exercise: &str, mark: f64, scores: &[f64]) -> Option<Self> {
        let failed = scores.iter().copied().filter(|score| *score < mark);
        let nearest = failed.clone().reduce(f64::max)?;
        let to = nearest.floor().min(mark - POINTS).max(0.0);
        let attempts = failed.filter(|score| *score >= to).count();
        let reason =
            "The exercise is new to everybody this year: the department has lowered its pass mark for all groups.";
        Some(Self { exercise: exercise.to_owned(), marks: (mark, to), attempts, reason })
    }

    /// Returns a pass mark at which at least one passed attempt fails.
    fn stricter(exercise: &str, mark: f64, scores: &[f64]) -> Option<Self> {
        let passed = scores.iter().copied().filter(|score| *score >= mark && *score < 100.0);
        let nearest = passed.clone().reduce(f64::min)?;
        let to = (nearest.floor() + 1.0).max(mark + POINTS).min(100.0);
        let attempts = passed.filter(|score| *score < to).count();
        let reason = "Nobody has failed so far: the department has raised the pass mark for all groups.";
        Some(Self { exercise: exercise.to_owned(), marks: (mark, to), attempts, reason })
    }

    /// Returns the size of the change, in points.
    fn points(&self) -> f64 {
        (self.marks.0 - self.marks.1).abs()
    }

    /// Returns the document with the new pass mark.
    fn written(&self, document: &str) -> String {
        let line = |line: &str| match line.strip_prefix("pass_mark = ") {
            Some(_) => format!("pass_mark = {}\n", self.marks.1),
            None => line.to_owned(),
        };
        document.split_inclusive('\n').map(line).collect()
    }
}

async fn publish_rubric(state: &AppState, instructor: &CurrentPerson, change: &RubricChange) -> anyhow::Result<()> {
    let id = drafting::open_exercise(state, instructor, &change.exercise).await?;
    let draft =
        drafts::find_draft(state.db.reader(), instructor.school_id, id).await?.context("the draft just begun")?;
    let mut texts = draft.texts;
    texts.document = change.written(&texts.document);
    let saved = drafting::save_draft(state, instructor, id, draft.version, &texts).await?;
    let SaveOutcome::Kept(draft) = saved else { bail!("nobody else writes in the draft") };
    let checked = drafting::check(state, instructor.school_id, &draft).await?;
    ensure!(drafting::publish(state, instructor, &draft, &checked).await?, "the changed rubric was refused");
    Ok(())
}

#[cfg(test)]
mod tests {
    //! The re-grading must change at least one result, keep the mark within 0 to 100, and leave the
    //! rest of the document unchanged.

    use super::RubricChange;

    #[test]
    fn the_mark_is_changed_to_where_somebody_has_another_result() {
        for scores in [vec![69.6, 65.0, 64.9, 100.0], vec![0.3], vec![70.0, 99.9], vec![100.0, 12.0]] {
            let passing = |mark: f64| scores.iter().filter(|score| **score >= mark).count();
            let [milder, stricter] =
                [RubricChange::milder("a", 70.0, &scores), RubricChange::stricter("a", 70.0, &scores)];
            for RubricChange { marks: (from, to), attempts, .. } in milder.iter().chain(&stricter) {
                assert!((0.0..=100.0).contains(to), "{to}");
                assert!(*attempts > 0 && passing(*to).abs_diff(passing(*from)) == *attempts, "{scores:?}: {to}");
            }
            assert_eq!(milder.is_some(), scores.iter().any(|score| *score < 70.0));
        }
        assert_eq!(RubricChange::milder("a", 70.0, &[69.6, 65.0, 64.9]).map(|change| change.attempts), Some(2));
        assert_eq!(RubricChange::stricter("a", 70.0, &[100.0]), None, "nobody can miss a full score");
    }

    #[test]
    fn the_pass_mark_alone_is_changed() {
        let milder = RubricChange::milder("a", 60.0, &[58.0]).expect("somebody has failed");
        let written = milder.written("id = \"a\"\npass_mark = 60\ntime_limit_s = 180\n");
        assert_eq!(written, "id = \"a\"\npass_mark = 55\ntime_limit_s = 180\n");
    }
}
