//! Ratings and marked pops of the demonstration: generated from the attempts, stored by the same
//! functions as real ones, and labelled as generated.

use acts::scoring::ratings::Rated;
use acts::scoring::{ratings, segments};
use acts::training::deadlines;
use anyhow::Context;
use assessment::questionnaire::Answer;
use documents::instrument::ScaleKind;
use model::training::due;
use model::{CurrentPerson, Moment};
use routes_base::AppState;
use store::operations::schools;
use store::scoring::ratings::NewRound;
use store::scoring::segments::NewTask;
use store::scoring::{ratings as stored, segments as traces};
use store::surveys::instruments;
use store::training::reports::ListedAttempt;
use store::training::{practice, reports};

use crate::DAY_S;
use crate::assignments::find_first_cohort;
use crate::experts::find_expert;
use crate::school::{COHORTS, EXPERTS, LEARNERS};
use crate::study::scatter_of_seed;

/// Number of rated attempts.
const RATED: usize = 8;
/// Number of trainees who have marked the traces.
const MARKERS: usize = 5;

async fn find_rater(state: &AppState, name: &str) -> anyhow::Result<CurrentPerson> {
    find_expert(state, name).await?.into_current().context("somebody who may sign in")
}

/// Creates a rating round in which the first instructor asks three others to rate the latest
/// attempts; the last rater has one left.
///
/// # Errors
/// Fails if the people or the instrument are missing, or the database fails.
pub(super) async fn hold_rating_round(state: &AppState) -> anyhow::Result<()> {
    let reader = state.db.reader();
    let asking = find_rater(state, COHORTS[0].instructor).await?;
    let latest = reports::latest_taught(reader, &asking).await?;
    let rated: Vec<ListedAttempt> = latest.into_iter().filter(|listed| listed.score.is_some()).take(RATED).collect();
    let instrument = instruments::find_current_instrument(reader, asking.school_id, "global-rating-puncture").await?;
    let (Some(instrument), 2..) = (instrument, rated.len()) else { return Ok(()) };
    let mut raters = Vec::new();
    for name in [COHORTS[1].instructor, EXPERTS[0], EXPERTS[1]] {
        raters.push(find_rater(state, name).await?);
    }
    let new = NewRound {
        revision_id: instrument.id,
        title: "Ratings of the latest attempts".to_owned(),
        generated: true,
        sessions: rated.iter().map(|listed| listed.id).collect(),
        raters: raters.iter().map(|rater| rater.id).collect(),
    };
    let round = ratings::make(state, &asking, &new).await?;
    for (place, rater) in raters.iter().enumerate() {
        let own = stored::own(reader, rater, round).await?;
        let left = usize::from(place + 1 == raters.len());
        for rating in &own[left..] {
            let mut open = ratings::open(state, rater, rating.id).await?;
            let known = rated.iter().position(|listed| listed.id == rating.session_id).context("a rated attempt")?;
            let score = rated[known].score.unwrap_or_default() / 100.0;
            invent_rating(&mut open, score, place as u64, known as u64);
            open.finish(state, rater).await?;
        }
    }
    Ok(())
}

/// Generates points from the score, the strictness of the rater, and chance.
fn invent_rating(open: &mut Rated, score: f64, rater: u64, attempt: u64) {
    for (at, item) in open.instrument.items.iter().enumerate() {
        let Some(ScaleKind::Likert { points, .. }) = open.instrument.scale(item) else { continue };
        let chance = 0.10 * scatter_of_seed(attempt * 31 + rater * 7)
            + 0.12 * scatter_of_seed(attempt * 101 + rater * 13 + at as u64);
        let share = (0.05 + 0.85 * score + 0.08 * scatter_of_seed(rater + 500) + chance).clamp(0.0, 1.0);
        open.rating.answers.0[at] = Some(Answer::Number(1.0 + (share * (f64::from(*points) - 1.0)).round()));
    }
}

/// Creates a task in which the first instructor's trainees mark the pops of two of the instructor's
/// attempts by tomorrow; some have done so, and one has an extension.
///
/// # Errors
/// Fails if the people are missing, or the database fails.
pub(super) async fn mark_pops(state: &AppState, now: Moment) -> anyhow::Result<()> {
    let reader = state.db.reader();
    let asking = find_rater(state, COHORTS[0].instructor).await?;
    let shown = practice::list_trainee_practice(reader, asking.school_id, asking.id).await?;
    let sessions = shown.iter().filter(|attempt| attempt.passed).take(2).map(|attempt| attempt.session).collect();
    let time_zone = schools::find_time_zone(reader, asking.school_id).await?;
    let day = due::local(now.plus_s(DAY_S), &time_zone).machine;
    let due = due::read(&format!("{}T18:00", day.get(..10).context("a date")?), &time_zone)?;
    let new = NewTask {
        title: "Where are the pops?".to_owned(),
        cohort_id: find_first_cohort(state, asking.school_id).await?,
        due: Some((due.local, due.at)),
        time_zone,
        sessions,
    };
    let task = segments::make(state, &asking, &new).await?;
    let traces = traces::list_traces(reader, asking.school_id, task).await?;
    let trainees = LEARNERS.iter().filter(|learner| learner.cohort == 0).take(MARKERS);
    for (place, learner) in (0_u64..).zip(trainees) {
        let trainee = find_rater(state, learner.name).await?;
        for (n, trace) in (0_u64..).zip(&traces) {
            let pops = segments::truth(state, asking.school_id, trace).await?;
            let marked = invent_marks(&pops, place * 10 + n);
            segments::mark(state, &trainee, trace, marked, true).await?;
        }
    }
    let last = LEARNERS.iter().rfind(|learner| learner.cohort == 0).context("somebody who has not")?;
    let (last, task) = (find_rater(state, last.name).await?, segments::task(state, &asking, task).await?);
    Ok(deadlines::extend(state, &asking, segments::dated(&task), last.id, 3).await?)
}

/// Generates marks near the pops, with a realistic scatter; occasionally a pop is missed.
fn invent_marks(pops: &[f64], seed: u64) -> Vec<f64> {
    let near = |(n, pop): (u64, &f64)| {
        let missed = scatter_of_seed(seed * 97 + n * 11) > 0.8;
        let moment: f64 = pop + 0.11 * scatter_of_seed(seed * 53 + n) + 0.03 * scatter_of_seed(seed + n * 71);
        (!missed).then(|| (moment.max(0.0) * 100.0).round() / 100.0)
    };
    let mut marks: Vec<f64> = (0_u64..).zip(pops).filter_map(near).collect();
    marks.sort_by(f64::total_cmp);
    marks
}
