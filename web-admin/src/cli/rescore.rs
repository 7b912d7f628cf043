//! `web-admin rescore`: grades every attempt at an exercise by its current rubric.

use acts::people::admin_commands;
use acts::scoring::regrading;
use acts::scoring::regrading::{Regrader, Rubric};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use model::scoring::judgement;
use store::audit::Actor;
use store::recordings::sessions;
use store::recordings::sessions::Session;
use store::scoring::scores;

use super::{CommandFailure, StorageArgs, say_line};
use crate::AppState;

/// Options of `web-admin rescore`.
#[derive(Debug, Args)]
pub struct RescoreArgs {
    /// Exercise whose attempts are graded by its current rubric
    #[arg(value_name = "EXERCISE")]
    exercise: String,
    #[command(flatten)]
    storage: StorageArgs,
    /// School [default: the only one there is]
    #[arg(long)]
    school: Option<String>,
    /// Adds the new scores; without it they are only shown. Earlier scores are kept, and overrides
    /// remain in force
    #[arg(long, requires = "reason")]
    apply: bool,
    /// Reason, required with --apply; it is shown in the history of every changed grade
    #[arg(long, requires = "apply")]
    reason: Option<String>,
}

pub(super) async fn run_rescore(args: &RescoreArgs) -> Result<(), CommandFailure> {
    let reason = args.reason.as_deref().map(judgement::reason).transpose();
    let reason = reason.map_err(|refused| CommandFailure::Usage(refused.to_string()))?;
    let state = args.storage.open().await?;
    let school = admin_commands::find_school(&state, args.school.as_deref()).await?;
    let attempts = sessions::list_scored_sessions(state.db.reader(), school.id, &args.exercise).await?;
    if attempts.is_empty() {
        return Err(CommandFailure::Usage(format!("{}: {} has no scored attempt at it", args.exercise, school.name)));
    }
    let rubric = Rubric::of_today(&state, school.id, &args.exercise).await.map_err(anyhow::Error::from)?;
    let rubric = rubric
        .ok_or_else(|| CommandFailure::Usage(format!("{}: no longer taught, so there is no rubric", args.exercise)))?;
    let bar = grading_progress_bar(attempts.len());
    let mut changed = 0;
    for attempt in &attempts {
        changed += usize::from(regrade_attempt(&state, attempt, &rubric, reason.as_deref(), &bar).await?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let done =
        if reason.is_some() { "re-graded" } else { "would be re-graded; run with --apply --reason TEXT to do so" };
    say_line(format_args!("{changed} of {} attempts {done}", attempts.len()));
    state.db.close().await;
    Ok(())
}

fn grading_progress_bar(attempts: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("grading {pos}/{len} attempts {wide_bar} {eta}");
    ProgressBar::new(attempts as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Scores one attempt, prints the change and, with a reason, stores the new score. Returns whether
/// the rubric differs from that of the newest score.
async fn regrade_attempt(
    state: &AppState,
    attempt: &Session,
    rubric: &Rubric,
    reason: Option<&str>,
    bar: &ProgressBar,
) -> Result<bool, CommandFailure> {
    let before = scores::find_newest_score(state.db.reader(), attempt.key()).await?;
    let Some(before) = before.filter(|before| before.rubric_sha256 != rubric.sha256()) else { return Ok(false) };
    let again = rubric.judge(state, attempt).await.map_err(anyhow::Error::from)?;
    bar.suspend(|| {
        let word = |passed| if passed { "passed" } else { "not passed" };
        say_line(format_args!(
            "{}  {:.1} {} -> {:.1} {}",
            attempt.id,
            before.score,
            word(before.passed),
            again.score,
            word(again.passed)
        ));
    });
    if reason.is_some() {
        let by = Regrader { actor: Actor::CommandLine, reason };
        regrading::apply(state, by, attempt, &again).await.map_err(anyhow::Error::from)?;
    }
    Ok(true)
}
