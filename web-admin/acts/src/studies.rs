//! Validation studies: made, joined by guests and people of the school, left, and ended.

use model::ids::{PersonId, RevisionId, StudyId};
use model::survey::{Identity, ResponseState, Survey};
use model::{CurrentPerson, Moment, Role};
use serde_json::json;
use store::audit::AuditEntry;
use store::studies::{self, NewParticipant, NewStudy, Study, StudyAttempt, StudyLines, StudyPlan};
use store::surveys::{self, NewResponse, NewSurvey, StudyOccasion};
use store::{Connection, Write, directory, people, sign_in_codes};

use crate::erasing::{self, Eraser};
use crate::erasures::ErasureScope;
use crate::error::Error;
use crate::secret;
use crate::service::Service;
use crate::stations::give_sign_in_code;
use crate::study_consents::revision_of_terms;
use crate::surveys::{SurveyLink, link_expiry};

/// A study as somebody wants it.
#[derive(Clone, Debug)]
pub struct StudyRequest {
    /// Title.
    pub title: String,
    /// Ids of its exercises.
    pub exercises: Vec<String>,
    /// Attempts asked of each participant at each exercise.
    pub attempts: u32,
    /// Names of the groups, from the least experienced to the experts.
    pub groups: Vec<String>,
    /// What is asked of each participant.
    pub questions: Vec<String>,
    /// Instruments asked after each attempt: revision and title.
    pub after_each: Vec<(RevisionId, String)>,
    /// Instruments asked after the last attempt.
    pub at_end: Vec<(RevisionId, String)>,
    /// What participants agree to.
    pub consent: String,
    /// Who answers for the data.
    pub controller: String,
    /// Whom to ask.
    pub contact: String,
    /// How long its data are kept after its end, in months.
    pub kept_months: u32,
    /// The participants are a program's.
    pub generated: bool,
}

/// Makes a study that belongs to whoever asks, with what it asks.
///
/// # Errors
/// [`Error::Unprocessable`] where the school teaches no such exercise.
pub async fn make_study(state: &Service, by: &CurrentPerson, wanted: &StudyRequest) -> Result<StudyId, Error> {
    let now = state.clock.now();
    let new = NewStudy {
        school_id: by.school_id,
        title: &wanted.title,
        owner_id: by.id,
        attempts: wanted.attempts,
        groups: &wanted.groups,
        questions: &wanted.questions,
        consent: &wanted.consent,
        controller: &wanted.controller,
        contact: &wanted.contact,
        kept_months: wanted.kept_months,
        generated: wanted.generated,
    };
    let mut tx = state.db.write().await?;
    let id = studies::insert_study(&mut tx, &new, now).await?;
    for exercise in &wanted.exercises {
        if !studies::add_study_exercise(&mut tx, by.school_id, id, exercise).await? {
            return Err(Error::Unprocessable(tr!("exercise: “{id}” is taught nowhere here", id = exercise)));
        }
    }
    let each = wanted.after_each.iter().map(|asked| (asked, false));
    for ((revision, title), at_end) in each.chain(wanted.at_end.iter().map(|asked| (asked, true))) {
        let survey = NewSurvey {
            school_id: by.school_id,
            revision_id: *revision,
            title,
            owner_id: Some(by.id),
            identity: Identity::Pseudonymous,
            after_attempts: true,
            fresh_hours: None,
            study: Some(StudyOccasion { id, at_end }),
            generated: wanted.generated,
            opens_at: now,
            closes_at: None,
        };
        let survey = surveys::insert(&mut tx, &survey, now).await?;
        for exercise in &wanted.exercises {
            surveys::add_exercise(&mut tx, by.school_id, survey, exercise).await?;
        }
    }
    let details = json!({ "exercises": wanted.exercises, "attempts": wanted.attempts, "groups": wanted.groups });
    AuditEntry::by(by, "study.made", id).with(details).append(&mut tx, now).await?;
    tx.commit().await?;
    Ok(id)
}

/// What is to be another way in a study.
#[derive(Clone, Debug)]
pub struct StudyChange {
    /// Title.
    pub title: String,
    /// Whom to ask.
    pub contact: String,
    /// How long its data are kept after its end, in months.
    pub kept_months: u32,
    /// What participants agree to, while nobody has.
    pub terms: Option<StudyTerms>,
}

/// What participants of a study agree to.
#[derive(Clone, Debug)]
pub struct StudyTerms {
    /// Attempts asked of each participant at each exercise.
    pub attempts: u32,
    /// Names of the groups, from the least experienced to the experts.
    pub groups: Vec<String>,
    /// What is asked of each participant.
    pub questions: Vec<String>,
    /// What they agree to.
    pub consent: String,
    /// Who answers for the data.
    pub controller: String,
}

/// Changes a study. What somebody has agreed to stays, and its data are not kept longer than they were told.
///
/// # Errors
/// [`Error::Unprocessable`] when somebody takes part, and the terms are to change or the data to be kept longer; [`Error::Conflict`]
/// when its data are erased.
pub async fn change_study(
    state: &Service,
    by: &CurrentPerson,
    study: &Study,
    change: &StudyChange,
) -> Result<(), Error> {
    if study.erased_at.is_some() {
        return Err(Error::Conflict(tr!("the data of this study are erased").to_owned()));
    }
    let mut tx = state.db.write().await?;
    if studies::count_participants(&mut *tx, study).await? > 0 {
        if change.terms.is_some() {
            let why = tr!("somebody takes part already: what they agreed to stays as it is");
            return Err(Error::Unprocessable(why.to_owned()));
        }
        if change.kept_months > study.kept_months {
            return Err(Error::Unprocessable(tr!(
                "months: {n}; participants were told that their data are kept for {most} at most",
                n = change.kept_months,
                most = study.kept_months
            )));
        }
    }
    let lines = StudyLines { title: &change.title, contact: &change.contact, kept_months: change.kept_months };
    studies::change_study_lines(&mut tx, study, lines).await?;
    if let Some(terms) = &change.terms {
        let StudyTerms { attempts, groups, questions, consent, controller } = terms;
        let plan = StudyPlan { attempts: *attempts, groups, questions, consent, controller };
        studies::change_study_plan(&mut tx, study, plan).await?;
    }
    let details = json!({ "title": change.title, "contact": change.contact, "kept_months": change.kept_months, "terms": change.terms.is_some() });
    AuditEntry::by(by, "study.changed", study.id).with(details).append(&mut tx, state.clock.now()).await?;
    Ok(tx.commit().await?)
}

/// Group and answers of a person who is invited to a study.
#[derive(Clone, Debug)]
pub struct ParticipantFacts {
    /// The place of their group in the study's.
    pub group_place: u32,
    /// What the study asked them, in the order of its questions.
    pub facts: Vec<String>,
}

/// A guest who has just been added: shown once, for only the code's hash is kept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GuestCode {
    /// Who, by the pseudonym alone.
    pub pseudonym: String,
    /// The code, good for signing in once.
    pub code: String,
}

fn open_study(study: &Study) -> Result<&Study, Error> {
    match study.closed_at {
        None => Ok(study),
        Some(_) => Err(Error::Conflict(tr!("this study has ended; open it again first").to_owned())),
    }
}

/// Adds a guest, and makes the code with which they agree at a station.
///
/// # Errors
/// [`Error::Conflict`] when the study has ended.
pub async fn add_guest(
    state: &Service,
    by: &CurrentPerson,
    study: &Study,
    told: &ParticipantFacts,
) -> Result<GuestCode, Error> {
    let (study, now) = (open_study(study)?, state.clock.now());
    let mut tx = state.db.write().await?;
    let guest = people::add_guest(&mut tx, by.school_id, now).await?;
    join(
        &mut tx,
        by,
        NewParticipant {
            study,
            person_id: guest.id,
            group_place: told.group_place,
            facts: &told.facts,
            added_by: by.id,
        },
        now,
    )
    .await?;
    tx.commit().await?;
    let code = give_sign_in_code(state, by, guest.id).await?;
    Ok(GuestCode { pseudonym: guest.pseudonym, code })
}

/// Invites a member of the school. The member accepts signed in, by [`join_study`].
///
/// # Errors
/// [`Error::Unprocessable`] when nobody of the school has the address or they take part already; [`Error::Conflict`] when the
/// study has ended.
pub async fn add_member(
    state: &Service,
    by: &CurrentPerson,
    study: &Study,
    email: &str,
    told: &ParticipantFacts,
) -> Result<(), Error> {
    let (study, now) = (open_study(study)?, state.clock.now());
    let mut tx = state.db.write().await?;
    let person = people::find_person_by_email(&mut *tx, email).await?;
    let person = person.filter(|person| {
        person.school_id == by.school_id && person.disabled_at.is_none() && person.role != Role::Guest
    });
    let Some(person) = person else {
        return Err(Error::Unprocessable(tr!("“{email}” is nobody’s address in this school", email = email)));
    };
    let new = NewParticipant {
        study,
        person_id: person.id,
        group_place: told.group_place,
        facts: &told.facts,
        added_by: by.id,
    };
    if !join(&mut tx, by, new, now).await? {
        return Err(Error::Unprocessable(tr!("{name} takes part already, or is asked to", name = person.display_name)));
    }
    Ok(tx.commit().await?)
}

async fn join(
    writer: &mut Connection,
    by: &CurrentPerson,
    new: NewParticipant<'_>,
    now: Moment,
) -> Result<bool, Error> {
    if !studies::add_participant(writer, new, now).await? {
        return Ok(false);
    }
    let details = json!({ "person": new.person_id, "group": new.group_place });
    AuditEntry::by(by, "study.asked", new.study.id).with(details).append(writer, now).await?;
    Ok(true)
}

/// Accepts an invitation to a study under the terms that were shown.
///
/// # Errors
/// [`Error::NotFound`] when they are not asked any more; [`Error::Conflict`] when the terms are others by now.
pub async fn join_study(state: &Service, by: &CurrentPerson, study: StudyId, terms: &str) -> Result<(), Error> {
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    let asked = studies::list_study_requests(&mut *tx, by.into()).await?;
    let study = asked.into_iter().find(|asked| asked.id == study).ok_or(Error::NotFound)?;
    if terms != revision_of_terms(&study) {
        return Err(Error::Conflict(tr!("what you would agree to has changed: read it again").to_owned()));
    }
    studies::note_consent(&mut tx, &study, by.id, now).await?;
    let details = json!({ "terms_sha256": terms, "consent": study.consent });
    AuditEntry::by(by, "study.consented", study.id).with(details).append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}

/// Declines an invitation to a study, or leaves the study.
///
/// # Errors
/// [`Error::NotFound`] when they neither are asked nor take part.
pub async fn leave_study(state: &Service, by: &CurrentPerson, study: StudyId) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    let mut own = studies::list_study_requests(&mut *tx, by.into()).await?;
    own.extend(studies::list_joined_studies(&mut *tx, by.into()).await?);
    let study = own.into_iter().find(|own| own.id == study).ok_or(Error::NotFound)?;
    take_out(state, by, &study, by.id, tx).await
}

/// Makes a guest another code, in place of the one they had.
///
/// # Errors
/// [`Error::NotFound`] when they are no guest who takes part.
pub async fn renew_guest_code(
    state: &Service,
    by: &CurrentPerson,
    study: &Study,
    guest: PersonId,
) -> Result<GuestCode, Error> {
    let found = studies::find_participant(state.db.reader(), open_study(study)?, guest).await?;
    let found = found.filter(|found| found.name.is_none()).ok_or(Error::NotFound)?;
    let code = give_sign_in_code(state, by, guest).await?;
    Ok(GuestCode { pseudonym: found.pseudonym, code })
}

/// Takes somebody out of a study who withdraws their consent: what they told and answered for it goes, and a guest signs in
/// no more. A guest's recordings are erased on request; a member keeps theirs.
///
/// # Errors
/// [`Error::NotFound`] when they do not take part.
pub async fn withdraw_participant(
    state: &Service,
    by: &CurrentPerson,
    study: &Study,
    person: PersonId,
    erase_recordings: bool,
) -> Result<(), Error> {
    let tx = state.db.write().await?;
    take_out(state, by, study, person, tx).await?;
    let guest = directory::find_anybody(state.db.reader(), by.school_id, person).await?;
    match guest.filter(|known| known.role == Role::Guest && erase_recordings) {
        Some(guest) => {
            let everything = ErasureScope { written: true, about: true, recordings: true };
            erasing::erase(state, Eraser::person(by), &guest, by.school_id, everything).await
        }
        None => Ok(()),
    }
}

async fn take_out(
    state: &Service,
    by: &CurrentPerson,
    study: &Study,
    person: PersonId,
    mut tx: Write,
) -> Result<(), Error> {
    let now = state.clock.now();
    let guest = studies::find_participant(&mut *tx, study, person).await?.ok_or(Error::NotFound)?.name.is_none();
    studies::withdraw_participant(&mut tx, study, person, now).await?;
    if guest {
        people::disable_person(&mut tx, person, now).await?;
        sign_in_codes::end_sign_in_code(&mut tx, model::PersonKey { school_id: by.school_id, person_id: person })
            .await?;
    }
    let details = json!({ "person": person });
    AuditEntry::by(by, "study.left", study.id).with(details).append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}

/// Makes links to what a guest was asked and has not begun to answer: for each attempt, and at the end for the last. Somebody of the
/// school answers signed in.
///
/// # Errors
/// [`Error::NotFound`] when they are no guest who takes part.
pub async fn make_answer_links(
    state: &Service,
    by: &CurrentPerson,
    study: &Study,
    person: PersonId,
) -> Result<Vec<SurveyLink>, Error> {
    let (reader, now) = (state.db.reader(), state.clock.now());
    let found = studies::find_participant(reader, open_study(study)?, person).await?;
    let found = found.filter(|found| found.name.is_none()).ok_or(Error::NotFound)?;
    let attempts = studies::list_study_attempts(reader, study).await?;
    let own: Vec<&StudyAttempt> = attempts.iter().filter(|attempt| attempt.person_id == found.person_id).collect();
    let asked = studies::list_study_surveys(reader, study).await?;
    let role = people::find_person(reader, person).await?.ok_or(Error::NotFound)?.role;
    let mut links = Vec::new();
    let mut tx = state.db.write().await?;
    for survey in &asked {
        let after = own.iter().filter(|attempt| !survey.at_end || own.last() == Some(attempt));
        for attempt in after {
            if let Some(token) = link_to_answer(&mut tx, survey, attempt, role, now).await? {
                let label = tr!("{survey}, attempt {n}", survey = survey.title, n = attempt.number);
                links.push(SurveyLink { label, token });
            }
        }
    }
    let details = json!({ "person": person, "links": links.len() });
    AuditEntry::by(by, "study.links_made", study.id).with(details).append(&mut tx, now).await?;
    tx.commit().await?;
    Ok(links)
}

/// The secret of a link to an answer, where none was sent.
async fn link_to_answer(
    writer: &mut Connection,
    survey: &Survey,
    attempt: &StudyAttempt,
    role: Role,
    now: Moment,
) -> Result<Option<String>, Error> {
    let (token, session) = (secret::random_hex()?, Some(attempt.session_id));
    let token_sha256 = secret::token_sha256(&token);
    let begun = surveys::draft_of(&mut *writer, survey.school_id, survey.id, attempt.person_id, session).await?;
    if let Some(begun) = begun {
        let open = begun.state == ResponseState::Invited;
        if open {
            surveys::set_token(writer, begun.school_id, begun.id, &token_sha256).await?;
        }
        return Ok(open.then_some(token));
    }
    if surveys::answered(&mut *writer, survey, attempt.person_id, session).await? {
        return Ok(None);
    }
    let new = NewResponse {
        school_id: survey.school_id,
        survey_id: survey.id,
        token_sha256,
        role: role.as_str(),
        label: None,
        person_id: Some(attempt.person_id),
        session_id: session,
        language: "en",
        consented_at: None,
        expires_at: Some(link_expiry(survey, now)),
    };
    surveys::add(writer, &new).await?;
    Ok(Some(token))
}

/// Ends a study now, and what it asks; or opens it again.
///
/// # Errors
/// [`Error::Conflict`] when its data are erased.
pub async fn close_study(state: &Service, by: &CurrentPerson, study: &Study, closed: bool) -> Result<(), Error> {
    let now = state.clock.now();
    if study.erased_at.is_some() {
        return Err(Error::Conflict(tr!("the data of this study are erased").to_owned()));
    }
    let mut tx = state.db.write().await?;
    if !closed {
        studies::call_off_study_erasure(&mut tx, by.school_id, study.id).await?;
    }
    studies::close_study(&mut tx, by.school_id, study.id, closed.then_some(now)).await?;
    let action = if closed { "study.ended" } else { "study.opened" };
    AuditEntry::by(by, action, study.id).append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}
