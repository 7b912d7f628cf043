//! Teaching in the demonstration: comments, a grade override and reviews.

use acts::scoring::reviewing;
use acts::training::comments;
use anyhow::Context;
use attempt::{AttemptCurve, MarkKind};
use model::ids::SessionId;
use model::scoring::review::ReviewFilter;
use model::training::comment::{Comment, CommentKind};
use model::{CurrentPerson, Role};
use routes_base::AppState;
use store::people::{self, Person};
use store::recordings::sessions;
use store::recordings::sessions::Session;
use store::scoring::grades::NewOverride;
use store::scoring::reviews::WaitingReview;
use store::scoring::{reviews, scores};
use store::training::reports::ListedAttempt;
use store::training::{practice, reports};

use crate::school::{self, COHORTS, LEARNERS};

/// Number of attempts left in the review queue.
const LEFT: usize = 6;
/// Time between the last attempt and the lesson, in s.
const LATER_S: i64 = 3600;

/// Has the first cohort's instructor review and comment on the attempts.
pub async fn teach_lesson(state: &AppState) -> anyhow::Result<()> {
    state.clock.advance(LATER_S);
    let reader = state.db.reader();
    let instructor = people::find_person_by_email(reader, &school::email_of(COHORTS[0].instructor)).await?;
    let instructor = instructor.and_then(Person::into_current).context("the first instructor")?;
    let mut waiting = list_waiting(state, &instructor).await?;
    waiting.sort_by_key(|attempt| attempt.started_at);
    for old in &waiting[..waiting.len().saturating_sub(LEFT)] {
        let session = pick_attempt(state, &instructor, old.id).await?;
        reviewing::set_reviewed(state, &instructor, &session, true).await?;
    }
    confirm_presence(state).await?;
    let latest = reports::latest_taught(reader, &instructor).await?;
    let mut scored = latest.iter().filter(|listed| listed.score.is_some());
    if let Some(first) = scored.next() {
        comment_on(state, &instructor, &pick_attempt(state, &instructor, first.id).await?).await?;
    }
    let is_narrow = |listed: &&ListedAttempt| {
        listed.passed == Some(false) && listed.hard_fails.as_ref().is_none_or(|failures| failures.0.is_empty())
    };
    if let Some(second) = scored.find(is_narrow) {
        let session = pick_attempt(state, &instructor, second.id).await?;
        let reason = "Someone bumped into the station while the needle was held still. I saw it: without the bump, the attempt passes.";
        let new = NewOverride { grade: Some((75.0, true)), reason, made_by: instructor.id };
        reviewing::override_grade(state, &instructor, &session, &new).await?;
    }
    Ok(())
}

/// Marks attempts of the person who masters the course as supervised, so that a certificate can be saved.
async fn confirm_presence(state: &AppState) -> anyhow::Result<()> {
    let certified = LEARNERS.iter().find(|learner| learner.is_certified()).context("somebody who is certified")?;
    let find = async |name: &str| {
        let found = people::find_person_by_email(state.db.reader(), &school::email_of(name)).await?;
        found.and_then(Person::into_current).with_context(|| format!("{name} is missing"))
    };
    let (trainee, instructor) = (find(certified.name).await?, find(COHORTS[certified.cohort].instructor).await?);
    for attempt in practice::list_trainee_practice(state.db.reader(), trainee.school_id, trainee.id).await? {
        let session = pick_attempt(state, &instructor, attempt.session).await?;
        reviewing::set_supervised(state, &instructor, &session, true).await?;
    }
    Ok(())
}

/// Ratings and surveys that wait for an answer.
async fn list_waiting(state: &AppState, instructor: &CurrentPerson) -> anyhow::Result<Vec<WaitingReview>> {
    let mut waiting: Vec<WaitingReview> = Vec::new();
    loop {
        let after = waiting.last().map(WaitingReview::place);
        let next = reviews::list_review_queue(state.db.reader(), instructor, &ReviewFilter::default(), after).await?;
        if next.is_empty() {
            return Ok(waiting);
        }
        waiting.extend(next);
    }
}

async fn pick_attempt(state: &AppState, viewer: &CurrentPerson, id: SessionId) -> anyhow::Result<Session> {
    sessions::find_visible_session(state.db.reader(), viewer, id).await?.context("a taught attempt")
}

/// Adds a comment at each notable moment.
async fn comment_on(state: &AppState, instructor: &CurrentPerson, session: &Session) -> anyhow::Result<()> {
    let Some(curve) = scores::find_curve(state.db.reader(), session.key()).await? else { return Ok(()) };
    let trainee = people::find_person(state.db.reader(), session.trainee_id).await?.and_then(Person::into_current);
    let trainee = trainee.filter(|person| person.role == Role::Trainee).context("who tried")?;
    let at = |kind| moment_in_attempt(&curve, kind);
    let said = [
        (instructor, CommentKind::Praise, at(MarkKind::Contact), "Straight to the skin, without a pause."),
        (instructor, CommentKind::Teaching, at(MarkKind::TipRupture), "The first pop: only the stylet is through yet."),
        (
            instructor,
            CommentKind::Error,
            at(MarkKind::RimRupture),
            "You push on after the second pop. Stop, then go on.",
        ),
        (&trainee, CommentKind::Question, at(MarkKind::Confirm), "How could I have known here that I was deep enough?"),
    ];
    for (who, kind, from_s, body) in said {
        let Some(from_s) = from_s.filter(|from_s| *from_s <= session.duration_s) else { continue };
        comments::add_comment(state, who, session, &Comment { kind, from_s, to_s: None, body: body.to_owned() })
            .await?;
    }
    Ok(())
}

/// Returns the first mark of a kind, in s.
fn moment_in_attempt(curve: &AttemptCurve, kind: MarkKind) -> Option<f64> {
    curve.marks.iter().find(|mark| mark.kind == kind).map(|mark| mark.t_s)
}
