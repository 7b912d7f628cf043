//! Roster import: a file is previewed first, then imported exactly as previewed, in one
//! transaction.

use std::collections::BTreeMap;
use std::time::Duration;

use data_encoding::{BASE64, HEXLOWER};
use model::ids::{CohortId, PersonId, RosterId, SchoolId};
use model::people::email::email_in_ascii;
use model::people::roster::{
    CourseRoster, LineOutcome, MappingDoubt, Roster, RosterChange, RosterDifference, RosterEntry, RosterMapping,
    RosterOutcome, RosterRequest, RosterTable, Unreadable, is_workbook,
};
use model::{CurrentPerson, PersonKey, Role};
use serde_json::json;
use sha2::{Digest, Sha256};
use store::auth::account_links::Purpose;
use store::auth::lti::courses;
use store::people::directory::Details;
use store::people::rosters::{About, NewRosterDraft, RosterDraft};
use store::people::{directory, rosters};
use store::training::cohorts;
use store::training::cohorts::{Attribution, Membership, MembershipKey};
use store::{Connection, audit};

use crate::auth::federation::identities::{self, TakenMember};
use crate::error::Error;
use crate::people::{accounts, course_rosters};
use crate::sandbox;
use crate::sandbox_jobs::{SandboxRequest, SandboxResponse};
use crate::service::Service;

/// How long a roster can be confirmed, in s.
pub const DRAFT_LIFETIME_S: i64 = 86_400;
/// Maximum time in the school's queue for reading a workbook.
const PATIENCE: Duration = Duration::from_secs(10);

/// Preview of a roster.
#[derive(Clone, Debug)]
pub struct RosterPreview {
    /// Name of the uploaded file.
    pub file_name: String,
    /// Column headings.
    pub headings: Vec<String>,
    /// Meaning of the columns.
    pub mapping: RosterMapping,
    /// Headings of ignored columns.
    pub ignored: Vec<String>,
    /// Changes that the import would make.
    pub difference: RosterDifference,
    /// Hash of the changes, so that only the previewed changes can be confirmed.
    pub digest: String,
    /// The roster lists the members of a course of a learning platform.
    pub is_course: bool,
}

/// The columns of a roster, for assigning their meanings.
#[derive(Clone, Debug)]
pub struct RosterColumnsLook {
    /// Name of the uploaded file.
    pub file_name: String,
    /// Its table.
    pub table: RosterTable,
    /// Meaning of the columns: already assigned, or guessed.
    pub mapping: RosterMapping,
    /// Why the guess needs confirmation.
    pub doubts: Vec<MappingDoubt>,
}

/// Stores an uploaded roster for preview. The meaning of its columns is the one assigned in this
/// school before to the same headings, else the guess if it is certain.
///
/// # Errors
/// Returns [`Error::Unprocessable`] if it cannot be read; fails if the database fails.
pub async fn keep(
    state: &Service,
    by: &CurrentPerson,
    file_name: &str,
    body: &[u8],
    wanted: &RosterRequest,
) -> Result<RosterId, Error> {
    let table = parse(state, by.school_id, body).await?;
    let known = rosters::find_roster_mapping(state.db.reader(), by.school_id, &headings_sha256(&table)).await?;
    let guess = table.guess();
    let certain = guess.doubts.is_empty().then_some(guess.mapping);
    let mapping = known.filter(|known| known.fits(table.headings.len())).or(certain);
    let wanted = &RosterRequest { mapping, ..wanted.clone() };
    let draft = NewRosterDraft { school_id: by.school_id, made_by: by.id, file_name, body, wanted };
    let mut tx = state.db.write().await?;
    let id = rosters::keep_roster(&mut tx, &draft, state.clock.now()).await?;
    tx.commit().await?;
    Ok(id)
}

/// Returns the hash of a file's headings.
fn headings_sha256(table: &RosterTable) -> [u8; 32] {
    Sha256::digest(table.headings.join("\u{1f}")).into()
}

/// Reads a file. A workbook is read by a helper with memory and time limits, in the school's queue.
async fn parse(state: &Service, school: SchoolId, body: &[u8]) -> Result<RosterTable, Error> {
    let parsed = if is_workbook(body) {
        let _place = state.helpers.enter(school, PATIENCE).await?;
        match sandbox::ask(state, SandboxRequest::Workbook(BASE64.encode(body))).await? {
            SandboxResponse::Sheet(sheet) => sheet.and_then(RosterTable::of_sheet),
            SandboxResponse::Died(how) => {
                tracing::warn!(%school, how, "sandboxed process crashed on a workbook; workbook rejected");
                Err(Unreadable::TooMuch)
            }
            other => return Err(anyhow::anyhow!("unexpected answer to a request to read a workbook: {other:?}").into()),
        }
    } else {
        let body = body.to_vec();
        tokio::task::spawn_blocking(move || RosterTable::read(&body)).await?
    };
    parsed.map_err(|refused| Error::Unprocessable(refused.to_string()))
}

/// Returns a stored roster that was uploaded as a file.
async fn find_file(state: &Service, school: SchoolId, id: RosterId) -> Result<RosterDraft, Error> {
    let draft = rosters::find_roster(state.db.reader(), school, id).await?;
    draft.filter(|draft| !draft.wanted.0.is_course).ok_or(Error::NotFound)
}

/// What a stored roster contains.
enum RosterContent {
    /// Lines of a file.
    Table(RosterTable),
    /// Members of a course of a learning platform.
    Course(CourseRoster),
}

impl RosterContent {
    async fn read(state: &Service, school: SchoolId, draft: &RosterDraft) -> Result<Self, Error> {
        Ok(match draft.wanted.0.is_course {
            true => Self::Course(serde_json::from_slice(&draft.body).map_err(anyhow::Error::from)?),
            false => Self::Table(parse(state, school, &draft.body).await?),
        })
    }

    async fn look(
        self,
        connection: &mut Connection,
        school: SchoolId,
        draft: RosterDraft,
    ) -> Result<Option<RosterPreview>, Error> {
        match self {
            Self::Table(table) => look(connection, school, draft, table).await,
            Self::Course(roster) => {
                let difference = course_rosters::compare(connection, school, &roster, &draft.wanted.0).await?;
                let digest = digest_of(&difference)?;
                let (file_name, mapping) = (draft.file_name, RosterMapping::default());
                let (headings, ignored, is_course) = (Vec::new(), Vec::new(), true);
                Ok(Some(RosterPreview { file_name, headings, mapping, ignored, difference, digest, is_course }))
            }
        }
    }
}

/// Returns the columns of a stored roster and their meaning, assigned or guessed.
///
/// # Errors
/// Fails if there is no such roster, or the database fails.
pub async fn look_at_columns(state: &Service, school: SchoolId, id: RosterId) -> Result<RosterColumnsLook, Error> {
    let draft = find_file(state, school, id).await?;
    let table = parse(state, school, &draft.body).await?;
    let guess = table.guess();
    let (mapping, doubts) = match draft.wanted.0.mapping {
        Some(said) => (said, Vec::new()),
        None => (guess.mapping, guess.doubts),
    };
    Ok(RosterColumnsLook { file_name: draft.file_name, table, mapping, doubts })
}

/// Assigns the meaning of the columns, for this roster and for later ones of the school with the
/// same headings.
///
/// # Errors
/// Fails if there is no such roster, a required column is missing, or the database fails.
pub async fn assign_columns(
    state: &Service,
    by: &CurrentPerson,
    id: RosterId,
    mapping: &RosterMapping,
) -> Result<(), Error> {
    let now = state.clock.now();
    // Read the workbook before the write lock is taken, since it takes a while.
    let draft = find_file(state, by.school_id, id).await?;
    let table = parse(state, by.school_id, &draft.body).await?;
    if !mapping.fits(table.headings.len()) {
        return Err(Error::BadRequest("a column is missing or chosen twice".to_owned()));
    }
    let wanted = RosterRequest { mapping: Some(mapping.clone()), ..draft.wanted.0 };
    let mut tx = state.db.write().await?;
    if !rosters::change_roster_request(&mut tx, by.school_id, id, &wanted).await? {
        return Err(Error::NotFound);
    }
    rosters::remember_roster_mapping(&mut tx, by.school_id, &headings_sha256(&table), mapping, now).await?;
    let told = json!({ "mapping": mapping });
    audit::AuditEntry::by(by, "roster.columns_assigned", id).with(told).append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}

/// Returns the changes that a stored roster would make now; `None` if the meaning of its columns
/// has not been assigned.
///
/// # Errors
/// Fails if there is no such roster, or the database fails.
pub async fn preview(state: &Service, school: SchoolId, id: RosterId) -> Result<Option<RosterPreview>, Error> {
    let draft = rosters::find_roster(state.db.reader(), school, id).await?.ok_or(Error::NotFound)?;
    if draft.wanted.0.mapping.is_none() && !draft.wanted.0.is_course {
        return Ok(None);
    }
    let content = RosterContent::read(state, school, &draft).await?;
    let mut connection = state.db.reader().acquire().await?;
    content.look(&mut connection, school, draft).await
}

fn digest_of(difference: &RosterDifference) -> Result<String, Error> {
    let shown = serde_json::to_vec(difference).map_err(anyhow::Error::from)?;
    Ok(HEXLOWER.encode(&Sha256::digest(shown)))
}

async fn look(
    connection: &mut Connection,
    school: SchoolId,
    draft: RosterDraft,
    table: RosterTable,
) -> Result<Option<RosterPreview>, Error> {
    let Some(mapping) = draft.wanted.0.mapping.clone() else { return Ok(None) };
    let mut roster = table.people(&mapping);
    let mut wanted = draft.wanted.0;
    let cohorts = cohorts::list_cohorts(&mut *connection, school).await?;
    roster.spell_cohorts(cohorts.into_iter().map(|cohort| cohort.name), &mut wanted.cohort);
    let about = about(&roster, &wanted);
    let known = rosters::list_known_people(connection, school, &about).await?;
    let difference = RosterDifference::of(&roster, &known, &wanted);
    let digest = digest_of(&difference)?;
    let headings = table.headings;
    Ok(Some(RosterPreview {
        file_name: draft.file_name,
        headings,
        mapping,
        ignored: roster.ignored,
        difference,
        digest,
        is_course: false,
    }))
}

/// Returns the keys of all people concerned: those in the roster, in any spelling that an earlier
/// version may have stored, and the members of cohorts that people missing from the roster are to
/// leave.
fn about(roster: &Roster, wanted: &RosterRequest) -> About {
    let entries = || roster.rows.iter().filter_map(|row| row.entry.as_ref().ok());
    let filled = entries().flat_map(|entry| {
        let else_all = wanted.cohort.iter().filter(|_| entry.cohorts.is_empty());
        entry.cohorts.iter().chain(else_all)
    });
    About {
        emails: entries().flat_map(|entry| [entry.email.clone(), email_in_ascii(&entry.email)]).collect(),
        numbers: entries()
            .filter_map(|entry| entry.registrar_id.as_deref())
            .flat_map(|number| [number.to_owned(), number.to_uppercase(), number.to_lowercase()])
            .collect(),
        cohorts: filled.filter(|_| wanted.remove_missing).cloned().collect(),
    }
}

/// Imports a roster, and queues invitations if requested. Returns `None`, and writes nothing, if
/// its changes differ from those previewed.
///
/// # Errors
/// Fails if there is no such roster, or the database fails.
pub async fn confirm(
    state: &Service,
    by: &CurrentPerson,
    id: RosterId,
    digest: &str,
    invite: bool,
) -> Result<Option<RosterDifference>, Error> {
    // Read the file before the write lock is taken; a stored roster never changes.
    let draft = rosters::find_roster(state.db.reader(), by.school_id, id).await?.ok_or(Error::NotFound)?;
    let content = RosterContent::read(state, by.school_id, &draft).await?;
    let mut tx = state.db.write().await?;
    let draft = rosters::find_roster(&mut *tx, by.school_id, id).await?.ok_or(Error::NotFound)?;
    let Some(RosterPreview { difference, .. }) =
        content.look(&mut tx, by.school_id, draft).await?.filter(|preview| preview.digest == digest)
    else {
        return Ok(None);
    };
    let mut import =
        Import { tx: &mut tx, state, by, cohorts: BTreeMap::new(), added: Vec::new(), changed: Vec::new() };
    for line in &difference.lines {
        import.line(line, invite).await?;
    }
    for leaving in &difference.leaving {
        let cohort = import.cohort(&leaving.cohort).await?;
        let deed = import.deed();
        cohorts::leave_cohort(
            import.tx,
            MembershipKey { school_id: by.school_id, cohort_id: cohort, person_id: leaving.person },
            deed,
        )
        .await?;
    }
    let Import { added, changed, cohorts, .. } = import;
    for cohort in cohorts.into_values() {
        courses::forget_checks(&mut tx, by.school_id, cohort).await?;
    }
    let left: Vec<PersonId> = difference.leaving.iter().map(|leaving| leaving.person).collect();
    let told = json!({ "added": added, "changed": changed, "left_a_cohort": left, "difference_sha256": digest });
    audit::AuditEntry::by(by, "roster.imported", id).with(told).append(&mut tx, state.clock.now()).await?;
    rosters::discard_roster(&mut tx, by.school_id, id).await?;
    tx.commit().await?;
    state.mails.notify_one();
    Ok(Some(difference))
}

/// An import in progress.
struct Import<'a> {
    tx: &'a mut Connection,
    state: &'a Service,
    by: &'a CurrentPerson,
    cohorts: BTreeMap<String, CohortId>,
    added: Vec<PersonId>,
    changed: Vec<PersonId>,
}

impl Import<'_> {
    async fn line(&mut self, line: &LineOutcome, invite: bool) -> Result<(), Error> {
        let Some(entry) = &line.entry else { return Ok(()) };
        match &line.outcome {
            RosterOutcome::New => self.add(entry, invite).await,
            RosterOutcome::Changed { person, changes } => self.change(entry, *person, changes).await,
            RosterOutcome::Unchanged | RosterOutcome::Together(_) | RosterOutcome::Refused(_) => Ok(()),
        }
    }

    async fn add(&mut self, entry: &RosterEntry, invite: bool) -> Result<(), Error> {
        let now = self.state.clock.now();
        let school = self.by.school_id;
        let person = rosters::enrol_person(self.tx, school, entry, now).await?;
        for cohort in &entry.cohorts {
            self.join(person, entry.role.unwrap_or(Role::Trainee), cohort).await?;
        }
        self.take_member(entry, person, true).await?;
        // Members of a course sign in by a launch.
        if invite && entry.identity.is_none() {
            accounts::queue_link(
                self.tx,
                self.state,
                PersonKey { school_id: school, person_id: person },
                Purpose::Invitation,
            )
            .await?;
        }
        self.added.push(person);
        Ok(())
    }

    async fn change(&mut self, entry: &RosterEntry, person: PersonId, changes: &[RosterChange]) -> Result<(), Error> {
        let school = self.by.school_id;
        let details = Details { name: &entry.name, email: &entry.email, registrar_id: entry.registrar_id.as_deref() };
        directory::change_details(self.tx, school, person, details).await?;
        for change in changes {
            match change {
                RosterChange::Joins(cohort) => {
                    let known =
                        directory::find_directory_entry(&mut *self.tx, school, person).await?.ok_or(Error::NotFound)?;
                    self.join(person, known.role, cohort).await?;
                }
                RosterChange::Enabled => drop(directory::enable_account(self.tx, school, person).await?),
                RosterChange::Disabled => accounts::disable_in(self.tx, self.state, self.by, person).await?,
                RosterChange::Identity => self.take_member(entry, person, false).await?,
                RosterChange::Name(_) | RosterChange::Email(_) | RosterChange::RegistrarId(_) => {}
            }
        }
        self.changed.push(person);
        Ok(())
    }

    /// Adds the identity that a person gets from the roster of a course.
    async fn take_member(&mut self, entry: &RosterEntry, person_id: PersonId, is_new: bool) -> Result<(), Error> {
        let Some(identity) = &entry.identity else { return Ok(()) };
        let person = PersonKey { school_id: self.by.school_id, person_id };
        let member = TakenMember { identity, person, is_new };
        identities::add_member_identity(self.tx, self.by, member, self.state.clock.now()).await
    }

    async fn join(&mut self, person_id: PersonId, role: Role, cohort: &str) -> Result<(), Error> {
        let cohort_id = self.cohort(cohort).await?;
        let membership = Membership { school_id: self.by.school_id, cohort_id, person_id, role };
        let deed = self.deed();
        Ok(cohorts::join_cohort(self.tx, membership, deed).await?)
    }

    fn deed(&self) -> Attribution {
        Attribution { by: Some(self.by.id), at: self.state.clock.now() }
    }

    async fn cohort(&mut self, name: &str) -> Result<CohortId, Error> {
        if let Some(known) = self.cohorts.get(name) {
            return Ok(*known);
        }
        let made = cohorts::find_or_create(self.tx, self.by.school_id, name, self.state.clock.now()).await?;
        self.cohorts.insert(name.to_owned(), made.id);
        Ok(made.id)
    }
}
