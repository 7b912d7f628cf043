//! The people of the demonstration school and how they sign in.

use anyhow::ensure;
use serde_json::json;
use sqlx::SqliteConnection;
use uuid::Uuid;

use super::school::{self, ADMINISTRATOR, COHORTS, EXPERTS, LEARNERS};
use crate::AppState;
use acts::secret;
use model::{Moment, Role};
use store::audit::{Actor, Entry};
use store::cohorts::{self, Deed, Membership};
use store::people::{self, NewPerson, Person};
use store::schools;

/// A trainee of the demonstration.
#[derive(Clone, Debug)]
pub struct Trainee {
    /// Their id.
    pub id: Uuid,
    /// Their school.
    pub school_id: Uuid,
    /// What recordings say instead of a name.
    pub pseudonym: String,
}

/// An account to sign in with.
#[derive(Clone, Debug)]
pub struct Account {
    /// What it may do.
    pub role: Role,
    /// Whose it is.
    pub name: &'static str,
    /// Address to sign in with.
    pub email: String,
}

/// Founds the school: an administrator, the cohorts with their instructors, and the trainees in the order of
/// [`LEARNERS`].
///
/// # Errors
/// When there are people already, or the database fails.
pub async fn found(state: &AppState, password: &str) -> anyhow::Result<(Uuid, Vec<Trainee>, Vec<Account>)> {
    let anybody = people::count(state.db.reader()).await?;
    ensure!(
        anybody == 0,
        "{}: people are here already; a demonstration needs an empty folder",
        state.config.data_dir.display()
    );
    let hash = secret::hash_password(password, state.config.password_cost)?;
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    let school_id = schools::find_or_create(&mut tx, school::SCHOOL, now).await?.id;
    let mut founding = Founding { tx: &mut tx, school_id, hash, now, accounts: Vec::new() };
    founding.add(ADMINISTRATOR, Role::Administrator).await?;
    let mut cohort_ids = Vec::new();
    for cohort in COHORTS {
        let id = cohorts::find_or_create(founding.tx, school_id, cohort.name, now).await?.id;
        let instructor = founding.add(cohort.instructor, Role::Instructor).await?;
        founding.join(&instructor, id).await?;
        cohort_ids.push(id);
    }
    for expert in EXPERTS {
        founding.add(expert, Role::Instructor).await?;
    }
    let mut trainees = Vec::new();
    for learner in LEARNERS {
        let person = founding.add(learner.name, Role::Trainee).await?;
        founding.join(&person, cohort_ids[learner.cohort]).await?;
        trainees.push(Trainee { id: person.id, school_id, pseudonym: person.pseudonym });
    }
    let accounts = founding.accounts;
    tx.commit().await?;
    Ok((school_id, trainees, accounts))
}

/// A school in the making.
struct Founding<'a> {
    tx: &'a mut SqliteConnection,
    school_id: Uuid,
    hash: String,
    now: Moment,
    accounts: Vec<Account>,
}

impl Founding<'_> {
    async fn add(&mut self, name: &'static str, role: Role) -> anyhow::Result<Person> {
        let email = school::email(name);
        let new =
            NewPerson { school_id: self.school_id, role, email: &email, display_name: name, password_hash: &self.hash };
        let person = people::add(self.tx, &new, self.now).await?;
        Entry::new(self.school_id, Actor::CommandLine, "person.added", person.id)
            .with(json!({ "role": role }))
            .append(self.tx, self.now)
            .await?;
        self.accounts.push(Account { role, name, email });
        Ok(person)
    }

    async fn join(&mut self, person: &Person, cohort_id: Uuid) -> anyhow::Result<()> {
        let membership = Membership { school_id: self.school_id, cohort_id, person_id: person.id, role: person.role };
        Ok(cohorts::join(self.tx, membership, Deed { by: None, at: self.now }).await?)
    }
}
