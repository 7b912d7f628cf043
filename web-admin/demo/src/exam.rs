//! An exam of the demonstration: the first cohort at one station, rated by its instructor and by a
//! blinded second rater. The ratings are generated from the attempts.

use std::collections::BTreeMap;
use std::sync::Arc;

use acts::scoring::{exams, ratings};
use anyhow::Context;
use assessment::questionnaire::Answer;
use documents::Instrument;
use documents::instrument::ScaleKind;
use model::ids::{CohortId, PersonId};
use model::training::progress::ScoredAttempt;
use model::{CurrentPerson, Moment, Role};
use routes_base::AppState;
use store::scoring::exams::NewExam;
use store::scoring::ratings as stored;
use store::surveys::instruments;
use store::training::{practice, reports};

use crate::DAY_S;
use crate::assignments::{find_demo_person, find_first_cohort};
use crate::school::{COHORTS, EXPERTS};
use crate::study::scatter_of_seed;

/// Time limit, in min.
const LIMIT_MIN: u32 = 10;
/// Time from the begin of a sitting to the attempt, and from the attempt to the finished form, in s.
const BEFORE_S: i64 = 75;
const AFTER_S: i64 = 330;
/// The form of this candidate is finished late, by this time in s.
const LATE: usize = 3;
const LATE_S: i64 = 290;

/// Holds the exam, closes it, and rates all attempts a second time.
///
/// # Errors
/// Fails if the people or the instrument are missing, or the database fails.
pub(super) async fn hold_demo_exam(state: &AppState) -> anyhow::Result<()> {
    let reader = state.db.reader();
    let examiner = find_demo_person(state, COHORTS[0].instructor).await?.into_current().context("an instructor")?;
    let second = find_demo_person(state, EXPERTS[0]).await?.into_current().context("an expert")?;
    let cohort_id = find_first_cohort(state, examiner.school_id).await?;
    let candidates = find_latest_attempts(state, &examiner, cohort_id).await?;
    let instrument = instruments::find_current_instrument(reader, examiner.school_id, "puncture-checklist").await?;
    let (Some(instrument), Some((_, first))) = (instrument, candidates.first()) else { return Ok(()) };
    let new = NewExam {
        title: "Station 1 (generated ratings)".to_owned(),
        cohort_id,
        exercise_id: first.exercise.to_string(),
        revision_id: instrument.id,
        limit_min: LIMIT_MIN,
        second_rater_id: Some(second.id),
    };
    let day_before = state.at(Moment::from(first.at).plus_s(-DAY_S));
    let id = exams::make(&day_before, &examiner, &new).await?;
    let exam = exams::find(state, &examiner, id).await?;
    for (place, (candidate, attempt)) in candidates.iter().enumerate() {
        let at = Moment::from(attempt.at);
        exams::begin(&state.at(at.plus_s(-BEFORE_S)), &examiner, &exam, *candidate).await?;
        let mut open = exams::open(state, &examiner, exam.clone(), *candidate).await?;
        invent_checklist(&open.instrument, &mut open.sitting.answers, attempt.score / 100.0, place as u64 * 17);
        let finish = state.at(at.plus_s(AFTER_S + if place == LATE { LATE_S } else { 0 }));
        open.finish(&finish, &examiner).await?;
    }
    exams::request_second_ratings(state, &examiner, &exam).await?;
    exams::close(state, &examiner, &exam).await?;
    let round = exams::find(state, &examiner, id).await?.round_id.context("a round")?;
    for rating in stored::own(reader, &second, round).await? {
        let mut open = ratings::open(state, &second, rating.id).await?;
        let of_session = |(_, (_, attempt)): &(usize, &(PersonId, ScoredAttempt))| attempt.session == rating.session_id;
        let (place, (_, attempt)) = candidates.iter().enumerate().find(of_session).context("a rated attempt")?;
        invent_checklist(&open.instrument, &mut open.rating.answers, attempt.score / 100.0, place as u64 * 17 + 5);
        open.finish(state, &second).await?;
    }
    Ok(())
}

/// Returns the latest attempt of each trainee of a cohort at the exercise that most of them have
/// tried, in order of time.
async fn find_latest_attempts(
    state: &AppState,
    viewer: &CurrentPerson,
    cohort: CohortId,
) -> anyhow::Result<Vec<(PersonId, ScoredAttempt)>> {
    let reader = state.db.reader();
    let mut latest: BTreeMap<Arc<str>, BTreeMap<PersonId, ScoredAttempt>> = BTreeMap::new();
    for trainee in reports::members(reader, viewer.school_id, cohort, Role::Trainee).await? {
        // In order of time, so that the last one of each exercise stays.
        for attempt in practice::list_trainee_practice(reader, viewer.school_id, trainee.id).await? {
            latest.entry(attempt.exercise.clone()).or_default().insert(trainee.id, attempt);
        }
    }
    let most = latest.into_values().max_by_key(BTreeMap::len).unwrap_or_default();
    let mut candidates: Vec<(PersonId, ScoredAttempt)> = most.into_iter().collect();
    candidates.sort_by_key(|(_, attempt)| attempt.at);
    Ok(candidates)
}

/// Generates the answers to a checklist from the score, 0 to 1, and chance.
fn invent_checklist(instrument: &Instrument, answers: &mut [Option<Answer>], score: f64, seed: u64) {
    for (at, item) in instrument.items.iter().enumerate() {
        let Some(ScaleKind::Slider { min, max, .. }) = instrument.scale(item) else { continue };
        let hardness = 0.35 + 0.75 * at as f64 / instrument.items.len() as f64;
        let is_done = score + 0.15 * scatter_of_seed(seed * 31 + at as u64) > hardness;
        answers[at] = Some(Answer::Number(if is_done { *max } else { *min }));
    }
}
