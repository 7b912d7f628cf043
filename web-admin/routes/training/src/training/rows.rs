//! Converts stored attempts to rows of a list.

use pages::people::listed::ListQuery;
use pages::training::trainee::OwnAttemptRow;
use pages::{StatusWord, metric};
use serde::Deserialize;
use store::recordings::sessions::SessionState;
use store::training::reports::ListedAttempt;

/// Returns rows for a list of one trainee's attempts.
pub(crate) fn own_rows(attempts: Vec<ListedAttempt>) -> Vec<OwnAttemptRow> {
    attempts.into_iter().map(|attempt| OwnAttemptRow { trainee: None, ..make_attempt_row(attempt) }).collect()
}

/// Returns rows for a list that mixes trainees.
pub(crate) fn mixed_rows(attempts: Vec<ListedAttempt>) -> Vec<OwnAttemptRow> {
    attempts.into_iter().map(make_attempt_row).collect()
}

fn make_attempt_row(attempt: ListedAttempt) -> OwnAttemptRow {
    let status = match (attempt.state, attempt.passed) {
        (SessionState::Pending, _) => StatusWord::Waiting,
        (SessionState::Refused, _) => StatusWord::Refused,
        (SessionState::Scored, Some(true)) => StatusWord::Passed,
        (SessionState::Scored, _) => StatusWord::Failed,
    };
    OwnAttemptRow {
        href: format!("/sessions/{}", attempt.id),
        at: attempt.started_at.to_utc(),
        status,
        note: note_of_attempt(&attempt),
        trainee: Some(attempt.trainee),
        exercise: attempt.exercise,
        score: attempt.score,
        computed: attempt.computed,
        flagged: attempt.flagged,
        uncounted: attempt.uncounted,
    }
}

/// Returns why an attempt was refused or failed, or else its largest deduction.
fn note_of_attempt(attempt: &ListedAttempt) -> String {
    if let Some(refusal) = &attempt.refusal {
        return refusal.clone();
    }
    if attempt.computed.is_some() {
        return tr!("an instructor has set another score").to_owned();
    }
    if let Some(failure) = attempt.hard_fails.as_ref().and_then(|fails| fails.0.first()) {
        return metric::say_failure(failure);
    }
    let deductions = attempt.deductions.as_ref().map_or(&[][..], |json| &json.0);
    let dearest = deductions.iter().filter(|d| d.points > 0.0).max_by(|a, b| a.points.total_cmp(&b.points));
    dearest.map_or_else(String::new, metric::short_deduction_reason)
}

/// Whom of a long list of people a page shows.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct PeopleOnPage {
    q: String,
    page: Option<u32>,
}

impl From<PeopleOnPage> for ListQuery {
    fn from(PeopleOnPage { q, page }: PeopleOnPage) -> Self {
        Self { q, page, kept: Vec::new() }
    }
}
