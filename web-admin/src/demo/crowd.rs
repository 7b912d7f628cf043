//! A crowd beside the demonstration's people: generated, to measure pages on.

use anyhow::Context;
use indicatif::ProgressBar;
use serde_json::json;
use uuid::Uuid;

use super::people::Trainee;
use super::{DAY_S, Demonstration};
use crate::AppState;
use acts::secret;
use store::audit::{Actor, Entry};
use store::generated::{self, Crowd};
use store::practice;

/// Attempts of each trainee of the crowd.
pub const ATTEMPTS_EACH: u32 = 100;
/// How long before now they began.
const DAYS: i64 = 3 * 365;
/// Trainees whose attempts are one transaction: few enough for the write-ahead log to stay small.
const BLOCK: u32 = 250;

/// Generates the crowd, its attempts in the three years before now. They share the recording of `trainee`'s latest one.
///
/// # Errors
/// When that trainee has made none, or the database fails.
pub(super) async fn gather(state: &AppState, trainee: &Trainee, wanted: &Demonstration) -> anyhow::Result<()> {
    let password_hash = secret::hash_password(&wanted.password, state.config.password_cost)?;
    let crowd = Crowd {
        school_id: trainee.school_id,
        trainees: wanted.crowd,
        cohort_size: 30,
        attempts_each: ATTEMPTS_EACH,
        password_hash: &password_hash,
        from_us: state.clock.now().plus_s(-DAY_S * DAYS).micros(),
        every_us: DAY_S * DAYS * 1_000_000 / i64::from(ATTEMPTS_EACH),
        model: latest(state, trainee).await?,
    };
    let mut tx = state.db.write().await?;
    generated::found(&mut tx, &crowd).await?;
    tx.commit().await?;
    let progress = ProgressBar::new(u64::from(wanted.crowd));
    for first in (0..wanted.crowd).step_by(BLOCK as usize) {
        let after = wanted.crowd.min(first.saturating_add(BLOCK));
        block(state, &crowd, first..after).await?;
        progress.inc(u64::from(after - first));
    }
    progress.finish_and_clear();
    let mut tx = state.db.write().await?;
    generated::conclude(&mut tx, &crowd).await?;
    Ok(tx.commit().await?)
}

/// The attempts of some trainees, and ten acts of each in the audit log.
async fn block(state: &AppState, crowd: &Crowd<'_>, trainees: std::ops::Range<u32>) -> anyhow::Result<()> {
    let mut tx = state.db.write().await?;
    generated::practise(&mut tx, crowd, trainees.clone()).await?;
    for place in trainees.flat_map(|place| [place; 10]) {
        Entry::new(crowd.school_id, Actor::CommandLine, "session.generated", format!("generated-{place}"))
            .with(json!({ "attempts": ATTEMPTS_EACH / 10 }))
            .append(&mut tx, state.clock.now())
            .await?;
    }
    Ok(tx.commit().await?)
}

async fn latest(state: &AppState, trainee: &Trainee) -> anyhow::Result<Uuid> {
    let attempts = practice::of_trainee(state.db.reader(), trainee.school_id, trainee.id).await?;
    Ok(attempts.last().context("nobody has made an attempt that the generated ones could be like")?.session)
}
