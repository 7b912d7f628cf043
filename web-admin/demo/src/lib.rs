//! The demonstration school: people, a course, and weeks of attempts. They are actually simulated,
//! and uploaded and scored by the same code as in a real school.

mod assignments;
mod attempt;
mod crowd;
mod exam;
mod experts;
mod lesson;
mod outcomes;
mod people;
mod raters;
mod rubric;
pub mod school;
mod study;
mod validation;

use std::path::PathBuf;

use acts::authoring::{importing, instruments, publishing};
use acts::recordings::intake::{Bearer, RecordingReceipt};
use acts::recordings::{Received, intake};
use acts::replicas;
use acts::training::assignments::find_taught_curriculum;
use anyhow::{Context, ensure};
use attempt::{AttemptTask, MadeRecording};
pub use crowd::ATTEMPTS_EACH;
use documents::ExerciseBundle;
use indicatif::{ProgressBar, ProgressStyle};
use law::operator::Occasion;
use model::Moment;
use model::ids::{PersonId, SchoolId};
use model::training::progress::{Course, Progress};
pub use people::DemoAccount;
use people::{Trainee, found_school};
use routes_base::AppState;
use rust_embed::RustEmbed;
use school::{COHORT_BEFORE, COHORTS, LEARNERS, LEARNERS_BEFORE, Learner};
use store::audit::Actor;
use store::authoring::exercises;
use store::training::practice;

const DAY_S: i64 = 86_400;
/// The first attempt of a day begins at 9:00 UTC; the next ones follow every 15 minutes.
const OPENING_S: i64 = 9 * 3600;
const SLOT_S: i64 = 900;
/// From four in the afternoon on, the day's attempts and the comments on them are complete.
const CLOSING_S: i64 = 16 * 3600;
/// Weeks from a day of the year before to the same weekday of this year.
const WEEKS_OF_YEAR: i64 = 52;
/// Greatest number of weeks that the cohort of the year before practises.
const WEEKS_BEFORE: u32 = 6;
/// The course that all trainees practise. The school teaches every shipped course.
const COURSE: &str = "lower-back-basics";
/// The course for those who have mastered the first one, on a whole patient.
const NEXT_COURSE: &str = "lumbar-epidural-on-a-body";

/// The shipped curricula, embedded so that the program needs no folder.
#[derive(RustEmbed)]
#[folder = "../../curricula"]
struct Curricula;

/// Options of the demonstration.
#[derive(Clone, Debug)]
pub struct Demonstration {
    /// Weeks of practice before now, 1 to 26.
    pub weeks: u32,
    /// Password of every account.
    pub password: String,
    /// Seed of all patients and hands.
    pub seed: u64,
    /// Number of additional generated trainees, for measuring page times.
    pub crowd: u32,
}

/// A planned attempt.
struct Slot {
    learner: usize,
    at: Moment,
    weeks_left: u32,
}

/// Creates the school in an empty database. Returns the accounts for signing in.
///
/// # Errors
/// Fails if the database contains people already, or an operation fails.
pub async fn make_demonstration(state: &AppState, wanted: &Demonstration) -> anyhow::Result<Vec<DemoAccount>> {
    let now = state.clock.now();
    let from = end_of_practice(now).plus_s(-7 * DAY_S * i64::from(wanted.weeks));
    let from_before = from.plus_s(-7 * DAY_S * WEEKS_OF_YEAR);
    let (year_before, past) = (state.at(from_before), state.at(from));
    let (school, trainees, accounts) = found_school(&year_before, &wanted.password).await?;
    publish_curricula(&year_before).await?;
    let former = people::found_cohort_before(&year_before, &wanted.password).await?;
    let slots_before = schedule_attempts(from_before, wanted.weeks.min(WEEKS_BEFORE), &LEARNERS_BEFORE);
    let slots = schedule_attempts(from, wanted.weeks, &LEARNERS);
    let attempts = experts::ATTEMPTS + validation::ATTEMPTS + slots_before.len() + slots.len();
    let progress = simulation_progress_bar(attempts);
    assignments::begin_demo_term(&year_before, &[COHORT_BEFORE]).await?;
    practise_all(&year_before, wanted.seed.wrapping_add(1), &former, &slots_before, &progress).await?;
    people::let_cohort_leave(&year_before, &former).await?;
    assignments::begin_demo_term(&past, &COHORTS.map(|cohort| cohort.name)).await?;
    experts::demonstrate(&past, school, wanted.seed, &progress).await?;
    validation::hold_validation_study(&past, school, wanted.seed, &progress).await?;
    practise_all(&past, wanted.seed, &trainees, &slots, &progress).await?;
    progress.finish_and_clear();
    lesson::teach_lesson(&past).await?;
    rubric::change_rubric(&past).await?;
    raters::hold_rating_round(&past).await?;
    exam::hold_demo_exam(&past).await?;
    study::hold_study(&past, school, &trainees).await?;
    assignments::assign_demo_tasks(&past, now).await?;
    outcomes::decide_on_outcomes(&past, now).await?;
    assignments::support_demo_trainee(&past, now).await?;
    raters::mark_pops(&past, now).await?;
    assignments::remind_demo_people(&past, now).await?;
    if wanted.crowd > 0 {
        crowd::gather_crowd(state, &trainees[0], wanted).await?;
    }
    // Release the leases, so that the service started next has nothing to take over.
    replicas::leave(state).await?;
    Ok(accounts)
}

fn simulation_progress_bar(attempts: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("simulating and scoring {pos}/{len} attempts {wide_bar} {eta}");
    ProgressBar::new(attempts as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

fn day_number(at: Moment) -> i64 {
    at.micros().div_euclid(DAY_S * 1_000_000)
}

/// The midnight, UTC, until which people practise: the one before now, or the next one once everybody of today has been there.
fn end_of_practice(now: Moment) -> Moment {
    Moment::from_micros(day_number(now.plus_s(DAY_S - CLOSING_S)) * DAY_S * 1_000_000)
}

/// Performs the attempts of a group of trainees, day by day.
async fn practise_all(
    state: &AppState,
    seed: u64,
    trainees: &[Trainee],
    slots: &[Slot],
    progress: &ProgressBar,
) -> anyhow::Result<()> {
    let school = trainees.first().context("a trainee")?.school_id;
    let mut tried = vec![0; trainees.len()];
    for day in slots.chunk_by(|a, b| day_number(a.at) == day_number(b.at)) {
        let tasks = plan_day(state, seed, trainees, day, &mut tried).await?;
        practise(state, school, tasks, progress).await?;
    }
    Ok(())
}

/// Every attempt of weeks that begin at a midnight, in order of time.
fn schedule_attempts(from: Moment, weeks: u32, learners: &[Learner]) -> Vec<Slot> {
    let mut slots = Vec::new();
    for day in 0..weeks * 7 {
        let midnight = from.plus_s(i64::from(day) * DAY_S);
        // The epoch was a Thursday.
        let weekday = (day_number(midnight) + 3).rem_euclid(7).unsigned_abs() as u8;
        let weeks_left = (weeks * 7 - 1 - day) / 7;
        let coming = (0..learners.len()).filter(|&learner| learners[learner].comes(weekday, weeks_left));
        slots.extend(coming.zip(0_i64..).map(|(learner, n)| Slot {
            learner,
            at: midnight.plus_s(OPENING_S + n * SLOT_S),
            weeks_left,
        }));
    }
    slots
}

/// Plans the attempts of one day.
async fn plan_day(
    state: &AppState,
    seed: u64,
    trainees: &[Trainee],
    day: &[Slot],
    tried: &mut [u32],
) -> anyhow::Result<Vec<(PersonId, AttemptTask)>> {
    let mut tasks = Vec::new();
    for slot in day {
        let trainee = &trainees[slot.learner];
        let n = tried[slot.learner];
        tried[slot.learner] += 1;
        let task = AttemptTask {
            bundle: next_exercise(state, trainee, n).await?,
            skill: trainee.learner.skill(n, slot.weeks_left),
            seed: seed.wrapping_mul(1_000_003) ^ ((slot.learner as u64) << 32) ^ u64::from(n),
            occasion: Occasion {
                person: seed.wrapping_mul(1_000_003) ^ slot.learner as u64,
                day: day_number(slot.at).unsigned_abs(),
                attempt: u64::from(n),
            },
            trainee: trainee.pseudonym.clone(),
            at: slot.at,
        };
        tasks.push((trainee.id, task));
    }
    Ok(tasks)
}

/// Returns the exercise that the course recommends next; after the last exercise of both courses,
/// repeats the second course from its beginning.
async fn next_exercise(state: &AppState, trainee: &Trainee, n: u32) -> anyhow::Result<ExerciseBundle> {
    let reader = state.db.reader();
    let attempts = practice::list_trainee_practice(reader, trainee.school_id, trainee.id).await?;
    let course = async |id: &str| anyhow::Ok(find_taught_curriculum(state, trainee.school_id, id).await?.1);
    let next = |course: &Course| Progress::of(course, &attempts).next;
    let first = course(COURSE).await?;
    if let Some(step) = next(&first) {
        return current_bundle(state, trainee.school_id, &first, step).await;
    }
    let second = course(NEXT_COURSE).await?;
    let step = next(&second).unwrap_or(n as usize % second.steps.len());
    current_bundle(state, trainee.school_id, &second, step).await
}

async fn current_bundle(
    state: &AppState,
    school: SchoolId,
    course: &Course,
    step: usize,
) -> anyhow::Result<ExerciseBundle> {
    let exercise = &course.steps[step].exercise;
    let reader = state.db.reader();
    let revision = exercises::find_current_revision(reader, school, exercise)
        .await?
        .context("the course names no such exercise")?;
    let bytes =
        exercises::read_exercise_bytes(reader, school, revision.id).await?.context("a revision without documents")?;
    Ok(ExerciseBundle::from_parts(&bytes.exercise, &bytes.scene, &bytes.meshes)?)
}

/// Performs attempts, uploads their recordings, and scores them.
async fn practise(
    state: &AppState,
    school_id: SchoolId,
    tasks: Vec<(PersonId, AttemptTask)>,
    progress: &ProgressBar,
) -> anyhow::Result<()> {
    for MadeRecording { by, path, ends } in attempt::perform_demo_attempts(state, tasks).await? {
        let actor = Actor::Person(by);
        let bearer = Bearer { school_id, trainee_id: Some(by), station_id: None, actor, ahead_us: None };
        take_in(state, &bearer, path, ends).await?;
        progress.inc(1);
    }
    worker::work_off_jobs(state).await
}

/// Uploads a recording at the end of its attempt.
async fn take_in(state: &AppState, bearer: &Bearer, path: PathBuf, ends: Moment) -> anyhow::Result<RecordingReceipt> {
    let waited_s = (ends.micros() - state.clock.now().micros()) / 1_000_000;
    state.clock.advance(waited_s.max(0));
    let received = tokio::task::spawn_blocking(move || Received::adopt(path)).await??;
    intake::take_in(state, bearer, received).await.context("an attempt was not taken in")
}

/// Publishes the shipped curricula.
async fn publish_curricula(state: &AppState) -> anyhow::Result<()> {
    let folder = state.config.data_dir.join("curricula");
    for name in Curricula::iter() {
        let file = Curricula::get(&name).context("an embedded document")?;
        let path = folder.join(&*name);
        std::fs::create_dir_all(path.parent().context("a folder")?)?;
        std::fs::write(&path, &file.data).with_context(|| path.display().to_string())?;
    }
    let instruments = instruments::documents_in(&folder)?;
    importing::import_instruments(state, None, &instruments).await?;
    let courses = publishing::courses_in(&folder)?;
    ensure!(!courses.is_empty(), "no course is shipped");
    for course in courses {
        importing::import_course(state, None, &course).await?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    //! No attempt may be in the future or out of order.

    use crate::*;

    #[test]
    fn weeks_end_with_yesterday_or_in_the_evening_with_today() {
        let afternoon = Moment::from_micros(1_795_269_600_000_000); // 2026-11-21 14:00 UTC, a Saturday
        let end = end_of_practice(afternoon);
        assert_eq!(end.to_string(), "2026-11-21T00:00:00Z");
        assert_eq!(end_of_practice(afternoon.plus_s(2 * 3600)).to_string(), "2026-11-22T00:00:00Z");
        let slots = schedule_attempts(end.plus_s(-14 * DAY_S), 2, &LEARNERS);
        assert!(slots.iter().all(|slot| slot.at < end));
        assert!(slots.is_sorted_by_key(|slot| slot.at));
        let last = slots.last().expect("somebody comes on Fridays");
        assert_eq!(day_number(last.at), day_number(end) - 1, "the last attempt is of yesterday");
        let comes = |name: &str| slots.iter().any(|slot| LEARNERS[slot.learner].name == name);
        assert!(comes("Ada Okafor") && !comes("Nina Castellano") && !comes("Daria Novak"));
    }
}
