//! The people of the demonstration school and their accounts.

use acts::operations::fixtures;
use acts::operations::fixtures::GeneratedPerson;
use acts::people::accounts;
use acts::training::cohorts;
use anyhow::{Context, ensure};
use model::Role;
use model::ids::{PersonId, SchoolId};
use routes_base::AppState;
use store::people::{self, Person};
use store::training::cohorts as stored_cohorts;

use crate::assignments::find_demo_person;
use crate::school::{self, ADMINISTRATOR, COHORT_BEFORE, COHORTS, EXPERTS, LEARNERS, LEARNERS_BEFORE, Learner};

/// Registrar's number of the first trainee; the others follow consecutively.
const FIRST_NUMBER: u32 = 2_025_001;
/// Registrar's number of the first trainee of the year before.
const FIRST_NUMBER_BEFORE: u32 = 2_024_001;

/// A trainee of the demonstration.
#[derive(Clone, Debug)]
pub struct Trainee {
    /// Their id.
    pub id: PersonId,
    /// Their school.
    pub school_id: SchoolId,
    /// Pseudonym that replaces their name in recordings.
    pub pseudonym: String,
    /// How they attend and learn.
    pub learner: Learner,
}

/// An account for signing in.
#[derive(Clone, Debug)]
pub struct DemoAccount {
    /// Role.
    pub role: Role,
    /// Name of its owner.
    pub name: &'static str,
    /// Email address.
    pub email: String,
}

/// Creates the school: an administrator, the cohorts with their instructors, and the trainees in
/// the order of [`LEARNERS`].
///
/// # Errors
/// Fails if the database contains people already, or the database fails.
pub async fn found_school(
    state: &AppState,
    password: &str,
) -> anyhow::Result<(SchoolId, Vec<Trainee>, Vec<DemoAccount>)> {
    let anybody = people::count_people(state.db.reader()).await?;
    ensure!(
        anybody == 0,
        "{}: already contains people; the demonstration needs an empty folder",
        state.config.data_dir.display()
    );
    let people = list_everybody();
    let founded = fixtures::found_school(state, school::SCHOOL, &people, password).await?;
    let school_id = founded.first().context("somebody")?.school_id;
    let account = |person: GeneratedPerson| DemoAccount { role: person.role, name: person.name, email: person.email };
    Ok((school_id, pair_trainees(founded, &LEARNERS), people.into_iter().map(account).collect()))
}

/// Adds the cohort of the year before, taught by the instructor of the first cohort. Returns its trainees in the order of
/// [`LEARNERS_BEFORE`].
///
/// # Errors
/// Fails if the database fails.
pub async fn found_cohort_before(state: &AppState, password: &str) -> anyhow::Result<Vec<Trainee>> {
    let people = list_learners(&LEARNERS_BEFORE, FIRST_NUMBER_BEFORE, |_| COHORT_BEFORE);
    let founded = fixtures::found_school(state, school::SCHOOL, &people, password).await?;
    let administrator = find_demo_person(state, ADMINISTRATOR).await?.into_current().context("an administrator")?;
    let known = stored_cohorts::list_cohorts(state.db.reader(), administrator.school_id).await?;
    let cohort = known.iter().find(|cohort| cohort.name == COHORT_BEFORE).context("the cohort")?.id;
    cohorts::add_member(state, &administrator, cohort, &school::email_of(COHORTS[0].instructor)).await?;
    Ok(pair_trainees(founded, &LEARNERS_BEFORE))
}

/// Disables the accounts of the cohort of the year before, which has left the school.
///
/// # Errors
/// Fails if the database fails.
pub async fn let_cohort_leave(state: &AppState, trainees: &[Trainee]) -> anyhow::Result<()> {
    let administrator = find_demo_person(state, ADMINISTRATOR).await?.into_current().context("an administrator")?;
    for trainee in trainees {
        accounts::disable(state, &administrator, trainee.id).await?;
    }
    Ok(())
}

/// Pairs the trainees among people with their learning curves, in order.
fn pair_trainees(founded: Vec<Person>, learners: &[Learner]) -> Vec<Trainee> {
    let trainees = founded.into_iter().filter(|person| person.role == Role::Trainee);
    let pair = |(person, learner): (Person, &Learner)| Trainee {
        id: person.id,
        school_id: person.school_id,
        pseudonym: person.pseudonym,
        learner: *learner,
    };
    trainees.zip(learners).map(pair).collect()
}

/// Lists all people, in the order in which they are added.
fn list_everybody() -> Vec<GeneratedPerson> {
    let mut people = vec![person(ADMINISTRATOR, Role::Administrator, None)];
    people.extend(COHORTS.iter().map(|cohort| person(cohort.instructor, Role::Instructor, Some(cohort.name))));
    people.extend(EXPERTS.map(|expert| person(expert, Role::Instructor, None)));
    people.extend(list_learners(&LEARNERS, FIRST_NUMBER, |learner| COHORTS[learner.cohort].name));
    people
}

/// Lists trainees with consecutive numbers.
fn list_learners(
    learners: &[Learner],
    first: u32,
    cohort_of: impl Fn(&Learner) -> &'static str,
) -> Vec<GeneratedPerson> {
    let numbered = |(learner, number): (&Learner, u32)| GeneratedPerson {
        registrar_id: Some(number.to_string()),
        ..person(learner.name, Role::Trainee, Some(cohort_of(learner)))
    };
    learners.iter().zip(first..).map(numbered).collect()
}

fn person(name: &'static str, role: Role, cohort: Option<&'static str>) -> GeneratedPerson {
    GeneratedPerson { name, email: school::email_of(name), role, cohort, registrar_id: None }
}
