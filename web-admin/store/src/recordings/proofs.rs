//! Proofs of attempts: signature, re-simulation, supervision.

use std::collections::BTreeSet;

use model::ids::{PersonId, SchoolId, SessionId};
use model::{Needed, Proof, SessionKey};
use sqlx::FromRow;

use crate::{Executor, Result};

/// Returns the proofs of an attempt.
///
/// # Errors
/// If there is no such attempt, or the database fails.
pub async fn find_proof(executor: impl Executor<'_>, session: SessionKey) -> Result<Proof> {
    sqlx::query_as("SELECT signed, resimulated, supervised FROM proofs WHERE school_id = $1 AND session_id = $2")
        .bind(session.school_id)
        .bind(session.id)
        .fetch_one(executor)
        .await
}

#[derive(FromRow)]
struct Proved {
    session_id: SessionId,
    #[sqlx(flatten)]
    proof: Proof,
}

/// Returns the attempts of a trainee with sufficient proof.
pub async fn list_proved_sessions(
    executor: impl Executor<'_>,
    school: SchoolId,
    trainee: PersonId,
    needed: Needed,
) -> Result<BTreeSet<SessionId>> {
    let proved: Vec<Proved> = sqlx::query_as(
        "SELECT session_id, signed, resimulated, supervised FROM proofs WHERE school_id = $1 AND trainee_id = $2",
    )
    .bind(school)
    .bind(trainee)
    .fetch_all(executor)
    .await?;
    Ok(proved.into_iter().filter(|one| needed.met_by(one.proof)).map(|one| one.session_id).collect())
}
