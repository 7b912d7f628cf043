//! Experts of the demonstration: the instructors perform the first exercises and consent to be part
//! of the reference corridor.

use acts::privacy::consents;
use acts::scoring::reviewing;
use acts::training::assignments::find_taught_curriculum;
use anyhow::Context;
use indicatif::ProgressBar;
use law::operator::{Occasion, Skill};
use model::ids::{PersonId, SchoolId};
use model::scoring::corridor::WORDING;
use model::training::progress::Course;
use model::{CurrentPerson, Moment};
use routes_base::AppState;
use store::people::{self, Person};
use store::privacy::experts::NewDeclaration;
use store::recordings::sessions;
use store::training::practice;

use crate::attempt::AttemptTask;
use crate::school::{self, ADMINISTRATOR, COHORTS, EXPERTS};
use crate::{COURSE, current_bundle, practise};

/// Number of exercises they perform, from the first of the course.
const SHOWN: usize = 4;
/// Maximum number of attempts until they pass.
const TRIES: u64 = 3;
/// Number of attempts if each expert passes at once.
pub(super) const ATTEMPTS: usize = SHOWN * (COHORTS.len() + EXPERTS.len());
/// Start of the experts' first attempt, in s after midnight, before the trainees begin; and the
/// interval between attempts, in s.
const OPENING_S: i64 = 5 * 3600;
const APART_S: i64 = 300;

/// An exercise that an expert has not passed yet.
struct OpenStep {
    expert: Person,
    /// Seed of the expert's individual traits.
    person: u64,
    step: usize,
}

/// Has every expert pass the first exercises, and records their consent.
///
/// # Errors
/// Fails if the people or the course are missing, or an operation fails.
pub(super) async fn demonstrate(
    state: &AppState,
    school: SchoolId,
    seed: u64,
    progress: &ProgressBar,
) -> anyhow::Result<()> {
    let administrator = find_expert(state, ADMINISTRATOR).await?.into_current().context("the administrator")?;
    let mut experts = Vec::new();
    for name in COHORTS.iter().map(|cohort| cohort.instructor).chain(EXPERTS) {
        experts.push(find_expert(state, name).await?);
    }
    let (_, course) = find_taught_curriculum(state, school, COURSE).await?;
    let begun = state.clock.now().plus_s(OPENING_S);
    for again in 0..TRIES {
        let open = list_open_steps(state, &course, &experts).await?;
        let at = Moment::max(begun, state.clock.now());
        let tasks = plan_open_steps(state, &course, &open, at, seed ^ (again << 48)).await?;
        progress.inc_length(if again == 0 { 0 } else { tasks.len() as u64 });
        practise(state, school, tasks, progress).await?;
    }
    for expert in &experts {
        look_through(state, &administrator, expert).await?;
        let how = "signed on paper, in the department’s folder";
        let new = NewDeclaration { wording: WORDING, how, given_at: state.clock.now(), recorded_by: administrator.id };
        consents::record_consent(state, &administrator, expert.id, new).await?;
    }
    Ok(())
}

pub(super) async fn find_expert(state: &AppState, name: &str) -> anyhow::Result<Person> {
    people::find_person_by_email(state.db.reader(), &school::email_of(name))
        .await?
        .context("somebody of the demonstration is missing")
}

async fn list_open_steps(state: &AppState, course: &Course, experts: &[Person]) -> anyhow::Result<Vec<OpenStep>> {
    let mut open = Vec::new();
    for (expert, person) in experts.iter().zip(0..) {
        let attempts = practice::list_trainee_practice(state.db.reader(), expert.school_id, expert.id).await?;
        let passed = |step: &usize| attempts.iter().any(|a| a.passed && *a.exercise == course.steps[*step].exercise);
        let steps = (0..course.steps.len().min(SHOWN)).filter(|step| !passed(step));
        open.extend(steps.map(|step| OpenStep { expert: expert.clone(), person, step }));
    }
    Ok(open)
}

/// Plans one attempt at each, in sequence.
async fn plan_open_steps(
    state: &AppState,
    course: &Course,
    open: &[OpenStep],
    from: Moment,
    seed: u64,
) -> anyhow::Result<Vec<(PersonId, AttemptTask)>> {
    let mut tasks = Vec::new();
    for (n, OpenStep { expert, person, step }) in open.iter().enumerate() {
        let task = AttemptTask {
            bundle: current_bundle(state, expert.school_id, course, *step).await?,
            skill: Skill::expert(),
            seed: seed.wrapping_mul(7_000_003) ^ (n as u64),
            occasion: Occasion { person: *person, day: seed, attempt: *step as u64 },
            trainee: expert.pseudonym.clone(),
            at: from.plus_s(i64::try_from(n)? * APART_S),
        };
        tasks.push((expert.id, task));
    }
    Ok(tasks)
}

/// Marks the attempts of an expert as reviewed, to keep them out of the review queue.
async fn look_through(state: &AppState, administrator: &CurrentPerson, expert: &Person) -> anyhow::Result<()> {
    for attempt in practice::list_trainee_practice(state.db.reader(), expert.school_id, expert.id).await? {
        let session = sessions::find_session(state.db.reader(), expert.school_id, attempt.session).await?;
        reviewing::set_reviewed(state, administrator, &session.context("an expert’s attempt")?, true).await?;
    }
    Ok(())
}
