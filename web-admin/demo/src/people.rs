//! The people of the demonstration school and their accounts.

use acts::operations::fixtures;
use acts::operations::fixtures::GeneratedPerson;
use anyhow::{Context, ensure};
use model::Role;
use model::ids::{PersonId, SchoolId};
use routes_base::AppState;
use store::people;

use crate::school::{self, ADMINISTRATOR, COHORTS, EXPERTS, LEARNERS};

/// Registrar's number of the first trainee; the others follow consecutively.
const FIRST_NUMBER: u32 = 2_025_001;

/// A trainee of the demonstration.
#[derive(Clone, Debug)]
pub struct Trainee {
    /// Their id.
    pub id: PersonId,
    /// Their school.
    pub school_id: SchoolId,
    /// Pseudonym that replaces their name in recordings.
    pub pseudonym: String,
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
    let trainees = founded.into_iter().filter(|person| person.role == Role::Trainee);
    let trainees = trainees.map(|person| Trainee { id: person.id, school_id, pseudonym: person.pseudonym }).collect();
    let account = |person: GeneratedPerson| DemoAccount { role: person.role, name: person.name, email: person.email };
    Ok((school_id, trainees, people.into_iter().map(account).collect()))
}

/// Lists all people, in the order in which they are added.
fn list_everybody() -> Vec<GeneratedPerson> {
    let person =
        |name, role, cohort| GeneratedPerson { name, email: school::email_of(name), role, cohort, registrar_id: None };
    let mut people = vec![person(ADMINISTRATOR, Role::Administrator, None)];
    people.extend(COHORTS.iter().map(|cohort| person(cohort.instructor, Role::Instructor, Some(cohort.name))));
    people.extend(EXPERTS.map(|expert| person(expert, Role::Instructor, None)));
    let learner = |(learner, number): (&school::Learner, u32)| GeneratedPerson {
        registrar_id: Some(number.to_string()),
        ..person(learner.name, Role::Trainee, Some(COHORTS[learner.cohort].name))
    };
    people.extend(LEARNERS.iter().zip(FIRST_NUMBER..).map(learner));
    people
}
