//! A crowd of generated trainees in addition to the demonstration's people, for measuring page
//! times.

use acts::operations::fixtures;
use anyhow::Context;
use indicatif::ProgressBar;
use model::ids::SessionId;
use platform::secret;
use routes_base::AppState;
use store::operations::fixtures::GeneratedCrowd;
use store::training::practice;

use crate::people::Trainee;
use crate::{DAY_S, Demonstration};

/// Attempts per trainee of the crowd.
pub const ATTEMPTS_EACH: u32 = 100;
/// Period over which the attempts are spread, in days before now.
const DAYS: i64 = 3 * 365;
/// Trainees per transaction: few enough to keep the write-ahead log small.
const BLOCK: u32 = 250;

/// Generates the crowd and its attempts. They all share the recording of `trainee`'s latest
/// attempt.
///
/// # Errors
/// Fails if that trainee has no attempt, or the database fails.
pub(super) async fn gather_crowd(state: &AppState, trainee: &Trainee, wanted: &Demonstration) -> anyhow::Result<()> {
    let password_hash = secret::hash_password(&wanted.password, state.config.password_cost)?;
    let crowd = GeneratedCrowd {
        school_id: trainee.school_id,
        trainees: wanted.crowd,
        cohort_size: 30,
        attempts_each: ATTEMPTS_EACH,
        password_hash: &password_hash,
        from_us: state.clock.now().plus_s(-DAY_S * DAYS).micros(),
        every_us: DAY_S * DAYS * 1_000_000 / i64::from(ATTEMPTS_EACH),
        model: latest_of_trainee(state, trainee).await?,
    };
    fixtures::found_crowd(state, &crowd).await?;
    let progress = ProgressBar::new(u64::from(wanted.crowd));
    for first in (0..wanted.crowd).step_by(BLOCK as usize) {
        let after = wanted.crowd.min(first.saturating_add(BLOCK));
        fixtures::practise_crowd(state, &crowd, first..after).await?;
        progress.inc(u64::from(after - first));
    }
    progress.finish_and_clear();
    fixtures::conclude_crowd(state, &crowd).await
}

async fn latest_of_trainee(state: &AppState, trainee: &Trainee) -> anyhow::Result<SessionId> {
    let attempts = practice::list_trainee_practice(state.db.reader(), trainee.school_id, trainee.id).await?;
    Ok(attempts.last().context("nobody has made an attempt that the generated ones could be like")?.session)
}
