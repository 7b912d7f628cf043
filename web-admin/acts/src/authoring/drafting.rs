//! Editing documents in the browser: drafts, their validation, and publication as revisions.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;

use documents::curriculum::CurriculumEntry;
use documents::{Curriculum, ExerciseBundle, Instrument, Issue, Wording};
use model::CurrentPerson;
use model::authoring::draft::{DraftRemark, DraftVerdict};
use model::authoring::find_exercise_id;
use model::ids::{DraftId, RevisionId, SchoolId};
use model::training::progress::Mastery;
use store::audit::{Actor, AuditEntry};
use store::authoring::drafts::{DocumentDraft, DraftEditor, DraftKind, NewDocumentDraft, Texts};
use store::authoring::exercises::RevisionBytes;
use store::authoring::{drafts, exercises, pictures};
use store::surveys::instruments;
use store::training::curricula;

use crate::authoring::instruments::{course_surveys, publish_text};
use crate::authoring::publishing;
use crate::authoring::publishing::{CourseRefused, DocumentPublisher};
use crate::error::{Error, refuse_trainees};
use crate::sandbox;
use crate::sandbox_jobs::{DraftQuestion, SandboxRequest, SandboxResponse, same_id};
use crate::service::Service;

/// Result of validating a draft.
#[derive(Debug)]
pub enum Checked {
    /// An exercise; it can be published if the verdict contains no problem.
    Exercise(Box<DraftVerdict>),
    /// A valid course.
    Course(Box<CheckedCourse>),
    /// A valid instrument.
    Instrument(Box<Instrument>),
    /// Problems of a course or an instrument, in document order.
    Refused(Vec<Issue>),
    /// Not validated yet, because earlier requests of this school are being processed; when to
    /// retry, in s.
    Waiting(u64),
}

/// A valid course.
#[derive(Debug)]
pub struct CheckedCourse {
    /// The course.
    pub course: Curriculum,
    /// Rule by which its exercises count as mastered.
    pub mastery: Mastery,
    /// Titles of its exercises, by id.
    pub titles: BTreeMap<String, Wording>,
}

/// Result of saving a draft.
#[derive(Debug)]
pub enum SaveOutcome {
    /// Saved; contains the new version.
    Kept(DocumentDraft),
    /// Edit conflict: another person has saved the draft since it was read, and nothing was
    /// written. Contains their version.
    Elsewhere(DocumentDraft),
}

/// Returns the draft of an exercise, or creates one from the current revision.
///
/// # Errors
/// Fails if there is no such exercise.
pub async fn open_exercise(state: &Service, person: &CurrentPerson, exercise_id: &str) -> Result<DraftId, Error> {
    refuse_trainees(person)?;
    let (current, texts) = current_exercise(state, person.school_id, exercise_id).await?;
    let draft = NewDocumentDraft {
        kind: DraftKind::Exercise,
        document_id: exercise_id,
        based_on: Some(current),
        texts: &texts,
    };
    begin_draft_of(state, person, &draft).await
}

/// Returns the current revision of an exercise, with its texts.
pub(crate) async fn current_exercise(
    state: &Service,
    school: SchoolId,
    exercise_id: &str,
) -> Result<(RevisionId, Texts), Error> {
    let reader = state.db.reader();
    let current = exercises::find_current_revision(reader, school, exercise_id).await?.ok_or(Error::NotFound)?;
    let bytes = exercises::read_exercise_bytes(reader, school, current.id).await?.ok_or(Error::NotFound)?;
    Ok((current.id, Texts { document: text(bytes.exercise)?, scene: text(bytes.scene)? }))
}

/// Returns the draft of a course, or creates one from the current revision.
///
/// # Errors
/// Fails if there is no such course.
pub async fn open_course(state: &Service, person: &CurrentPerson, course_id: &str) -> Result<DraftId, Error> {
    refuse_trainees(person)?;
    let (reader, school) = (state.db.reader(), person.school_id);
    let taught = curricula::list_taught_curricula(reader, school).await?;
    let current = taught.into_iter().find(|course| course.curriculum_id == course_id).ok_or(Error::NotFound)?;
    let bytes = curricula::read_curriculum_bytes(reader, school, current.revision_id).await?.ok_or(Error::NotFound)?;
    let texts = Texts { document: text(bytes)?, scene: String::new() };
    let draft = NewDocumentDraft { kind: DraftKind::Course, document_id: course_id, based_on: None, texts: &texts };
    begin_draft_of(state, person, &draft).await
}

/// Returns the draft of an instrument, or creates one from the current revision.
///
/// # Errors
/// Fails if there is no such instrument.
pub async fn open_instrument(state: &Service, person: &CurrentPerson, instrument_id: &str) -> Result<DraftId, Error> {
    refuse_trainees(person)?;
    let document = current_instrument(state, person.school_id, instrument_id).await?;
    let texts = Texts { document, scene: String::new() };
    let kind = DraftKind::Instrument;
    begin_draft_of(state, person, &NewDocumentDraft { kind, document_id: instrument_id, based_on: None, texts: &texts })
        .await
}

/// Returns the text of an instrument's current revision.
pub(crate) async fn current_instrument(
    state: &Service,
    school: SchoolId,
    instrument_id: &str,
) -> Result<String, Error> {
    let current = instruments::find_current_instrument(state.db.reader(), school, instrument_id).await?;
    text(current.ok_or(Error::NotFound)?.bytes)
}

/// Returns the draft of a document, or creates one.
pub(crate) async fn begin_draft_of(
    state: &Service,
    person: &CurrentPerson,
    draft: &NewDocumentDraft<'_>,
) -> Result<DraftId, Error> {
    let by = draft_editor(state, person);
    let mut tx = state.db.write().await?;
    if let Some(begun) = drafts::find_draft_of(&mut *tx, by.school, draft.kind, draft.document_id).await? {
        return Ok(begun);
    }
    let id = drafts::begin_draft(&mut tx, by, draft).await?;
    AuditEntry::new(by.school, Actor::Person(by.person), "draft.begun", draft.document_id)
        .append(&mut tx, by.now)
        .await?;
    tx.commit().await?;
    Ok(id)
}

/// Decodes a published document. It was UTF-8 when it was published.
fn text(bytes: Vec<u8>) -> Result<String, Error> {
    String::from_utf8(bytes).map_err(|error| Error::Internal(anyhow::Error::new(error).context("a published document")))
}

/// Saves a draft if its version is still `seen`.
///
/// # Errors
/// Fails if there is no such draft, or the database fails.
pub async fn save_draft(
    state: &Service,
    person: &CurrentPerson,
    id: DraftId,
    seen: i64,
    texts: &Texts,
) -> Result<SaveOutcome, Error> {
    refuse_trainees(person)?;
    let by = draft_editor(state, person);
    let mut tx = state.db.write().await?;
    let kept = drafts::save_draft(&mut tx, by, id, seen, texts).await?;
    let draft = drafts::find_draft(&mut *tx, by.school, id).await?.ok_or(Error::NotFound)?;
    tx.commit().await?;
    Ok(if kept { SaveOutcome::Kept(draft) } else { SaveOutcome::Elsewhere(draft) })
}

/// Publishes a valid draft as a new revision and deletes the draft. Earlier attempts keep their
/// revision. Returns false if the draft has been saved in the meantime.
///
/// # Errors
/// Fails if the database fails, or a course's mastery rule is invalid.
pub async fn publish(
    state: &Service,
    person: &CurrentPerson,
    draft: &DocumentDraft,
    checked: &Checked,
) -> Result<bool, Error> {
    let by = draft_editor(state, person);
    let publisher = DocumentPublisher { school: by.school, by: Actor::Person(by.person), now: by.now };
    let exercise = match checked {
        Checked::Exercise(_) => Some(sound(state, by.school, draft).await?),
        _ => None,
    };
    let mut tx = state.db.write().await?;
    if !drafts::remove_draft(&mut tx, by.school, draft.id, draft.version).await? {
        return Ok(false);
    }
    match (checked, exercise) {
        (Checked::Exercise(_), Some(exercise)) => drop(publishing::exercise(&mut tx, &publisher, &exercise).await?),
        (Checked::Course(checked), _) => {
            let published =
                publishing::curriculum(&mut tx, &publisher, &checked.course, draft.texts.document.as_bytes()).await;
            published.map_err(|refused| match refused {
                CourseRefused::Document(why) => Error::Unprocessable(why),
                CourseRefused::Work(error) => Error::Internal(error),
            })?;
        }
        (Checked::Instrument(instrument), _) => {
            publish_text(&mut tx, &publisher, instrument, draft.texts.document.as_bytes()).await?;
            course_surveys(&mut tx, by.school, by.now).await?;
        }
        _ => return Ok(false),
    }
    tx.commit().await?;
    Ok(true)
}

/// Deletes a draft if its version is still `seen`; returns false otherwise.
pub async fn discard(state: &Service, person: &CurrentPerson, id: DraftId, seen: i64) -> Result<bool, Error> {
    refuse_trainees(person)?;
    let by = draft_editor(state, person);
    let mut tx = state.db.write().await?;
    let draft = drafts::find_draft(&mut *tx, by.school, id).await?.ok_or(Error::NotFound)?;
    let removed = drafts::remove_draft(&mut tx, by.school, id, seen).await?;
    if removed {
        AuditEntry::new(by.school, Actor::Person(by.person), "draft.discarded", &draft.document_id)
            .append(&mut tx, by.now)
            .await?;
    }
    tx.commit().await?;
    Ok(removed)
}

/// Validates a draft: parses it as publishing would, plans its tissue and tries its rubric.
/// Dropping the future ends the work on an exercise.
///
/// # Errors
/// Fails if the database fails, or no helper can be started.
pub async fn check(state: &Service, school: SchoolId, draft: &DocumentDraft) -> Result<Checked, Error> {
    let checked = match draft.kind {
        DraftKind::Exercise => {
            let bytes = bytes(state, school, draft).await?;
            let language = words::current().code().to_owned();
            let at_hand = pictures::list_draft_pictures(state.db.reader(), school, draft.id).await?;
            let pictures = at_hand.into_iter().map(|picture| picture.name).collect();
            let question = DraftQuestion { id: draft.document_id.clone(), bytes, pictures, language };
            let verdict = examine(state, school, question).await;
            verdict.map(|verdict| Checked::Exercise(Box::new(verdict)))
        }
        DraftKind::Course => course_checked(state, school, draft).await,
        DraftKind::Instrument => Ok(check_instrument(&draft.texts, &draft.document_id)),
    };
    match checked {
        Err(Error::Busy { retry_after_s }) => Ok(Checked::Waiting(retry_after_s)),
        checked => checked,
    }
}

/// Validates a course. It references published exercises only, so the work is bounded; still, it
/// takes a place in its school's preview queue like an exercise.
async fn course_checked(state: &Service, school: SchoolId, draft: &DocumentDraft) -> Result<Checked, Error> {
    let place = state.previews.enter(school).await?;
    let (texts, id) = (draft.texts.clone(), draft.document_id.clone());
    let known = ExerciseShelf::of(state, school, &id).await?;
    let check = move || {
        let _place = place;
        check_course(&texts, &known, &id)
    };
    Ok(tokio::task::spawn_blocking(check).await?)
}

/// Returns the documents of an exercise draft, with the meshes of the revision that it is based on.
async fn bytes(state: &Service, school: SchoolId, draft: &DocumentDraft) -> Result<RevisionBytes, Error> {
    let meshes = match draft.based_on {
        Some(revision) => {
            exercises::read_exercise_bytes(state.db.reader(), school, revision).await?.map(|bytes| bytes.meshes)
        }
        None => None,
    };
    let Texts { document, scene } = draft.texts.clone();
    Ok(RevisionBytes { exercise: document.into_bytes(), scene: scene.into_bytes(), meshes: meshes.unwrap_or_default() })
}

/// Returns the exercise of a draft that has been validated.
async fn sound(state: &Service, school: SchoolId, draft: &DocumentDraft) -> Result<ExerciseBundle, Error> {
    let RevisionBytes { exercise, scene, meshes } = bytes(state, school, draft).await?;
    let at_hand = pictures::read_draft_pictures(state.db.reader(), school, draft.id).await?;
    let pictures: Vec<_> = at_hand.into_iter().map(|picture| (picture.name, picture.bytes)).collect();
    let read = move || ExerciseBundle::from_parts(&exercise, &scene, &meshes)?.with_pictures(&pictures);
    let read = tokio::task::spawn_blocking(read).await?;
    Ok(read.map_err(|refused| anyhow::Error::new(refused).context("a draft that could be published"))?)
}

/// Validates an instrument. It references nothing outside itself and is small, so it needs no
/// queue.
fn check_instrument(texts: &Texts, id: &str) -> Checked {
    let read = Instrument::from_bytes("document", texts.document.as_bytes());
    match read.and_then(|read| same_id(&read.id, id).map(|()| read)) {
        Ok(instrument) => Checked::Instrument(Box::new(instrument)),
        Err(refused) => Checked::Refused(refused.issues),
    }
}

fn check_course(texts: &Texts, known: &ExerciseShelf, id: &str) -> Checked {
    let files = known.files();
    let of_file = |file: &str| known.exercise(&find_exercise_id(&files, file));
    let read = Curriculum::from_parts(texts.document.as_bytes(), of_file);
    let course = match read.and_then(|course| same_id(&course.id, id).map(|()| course)) {
        Ok(course) => course,
        Err(refused) => return Checked::Refused(refused.issues),
    };
    let titled =
        |entry: &CurriculumEntry| Some((entry.exercise.clone(), known.exercise(&entry.exercise)?.exercise.title));
    let titles = course.entries.iter().filter_map(titled).collect();
    match Mastery::from_rule(&course.mastery) {
        Ok(mastery) => Checked::Course(Box::new(CheckedCourse { course, mastery, titles })),
        Err(why) => Checked::Refused(vec![publishing::no_limit(why)]),
    }
}

/// Returns the ids of exercises by the file names in the course's current revision.
///
/// # Errors
/// Fails if the database fails.
pub async fn find_course_files(
    state: &Service,
    school: SchoolId,
    course_id: &str,
) -> Result<BTreeMap<String, String>, Error> {
    Ok(ExerciseShelf::of(state, school, course_id).await?.files())
}

/// The school's exercises that a course may reference. Each is parsed on first use.
struct ExerciseShelf {
    /// By id.
    documents: BTreeMap<String, RevisionBytes>,
    /// Parsed exercises by id; `None` if parsing failed.
    read: RefCell<BTreeMap<String, Option<ExerciseBundle>>>,
    /// The course's current revision, and the ids of its exercises in order.
    published: Option<(Vec<u8>, Vec<String>)>,
}

impl ExerciseShelf {
    async fn of(state: &Service, school: SchoolId, course_id: &str) -> Result<Self, Error> {
        let reader = state.db.reader();
        let documents = exercises::all_documents(reader, school).await?;
        let taught = curricula::list_taught_curricula(reader, school).await?;
        let published = match taught.into_iter().find(|course| course.curriculum_id == course_id) {
            Some(current) => {
                let ids = curricula::exercise_ids(reader, current.revision_id).await?;
                curricula::read_curriculum_bytes(reader, school, current.revision_id).await?.map(|bytes| (bytes, ids))
            }
            None => None,
        };
        Ok(Self { documents, read: RefCell::default(), published })
    }

    /// Returns the ids by the file names in the course's current revision.
    fn files(&self) -> BTreeMap<String, String> {
        let Some((course, ids)) = &self.published else { return BTreeMap::new() };
        let next = Cell::new(0);
        let in_order = |_: &str| self.exercise(ids.get(next.replace(next.get() + 1))?);
        let entries = Curriculum::from_parts(course, in_order).map(|course| course.entries).unwrap_or_default();
        entries.into_iter().map(|entry| (entry.file, entry.exercise)).collect()
    }

    fn exercise(&self, id: &str) -> Option<ExerciseBundle> {
        if let Some(known) = self.read.borrow().get(id) {
            return known.clone();
        }
        let bytes = self.documents.get(id)?;
        // It was parsed when it was published, so a failure is a bug here; the course then sees no
        // such exercise.
        let read = ExerciseBundle::from_parts(&bytes.exercise, &bytes.scene, &bytes.meshes);
        let read = read.inspect_err(|error| tracing::error!(id, %error, "published exercise is invalid")).ok();
        self.read.borrow_mut().insert(id.to_owned(), read.clone());
        read
    }
}

/// Returns the editor of a draft and the current time.
pub(crate) fn draft_editor(state: &Service, person: &CurrentPerson) -> DraftEditor {
    DraftEditor { school: person.school_id, person: person.id, now: state.clock.now() }
}

/// Examines the draft of an exercise, or returns the cached verdict. Dropping the future ends the
/// work.
///
/// # Errors
/// Returns [`Error::Busy`] if the school's queue does not advance in time; fails if no helper can
/// be started.
pub async fn examine(state: &Service, school: SchoolId, question: DraftQuestion) -> Result<DraftVerdict, Error> {
    let (previews, key) = (&state.previews, question.sha256());
    if let Some(told) = previews.told(&key) {
        return Ok(told);
    }
    let _place = previews.enter(school).await?;
    // The previous request in the queue may have examined the same draft.
    if let Some(told) = previews.told(&key) {
        return Ok(told);
    }
    match sandbox::ask(state, SandboxRequest::Draft(Box::new(question))).await? {
        SandboxResponse::Examined(verdict) => {
            previews.keep(key, &verdict);
            Ok(*verdict)
        }
        SandboxResponse::Died(how) => {
            tracing::warn!(%school, how, "draft exceeds the limits of a preview");
            Ok(too_costly(state))
        }
        other => Err(anyhow::anyhow!("unexpected answer to a request to check a draft: {other:?}").into()),
    }
}

/// Returns the verdict on a draft that exceeds the time or memory limit.
fn too_costly(state: &Service) -> DraftVerdict {
    let budget_s = state.config.preview_time.as_secs();
    let memory_mb = state.config.helper.as_ref().map_or(0, |helper| helper.memory_mb);
    let what = tr!(
        "checking this takes more than {seconds} s or {memory} MB, the most allowed; use a larger tissue.tolerance, fewer layers or a shorter time limit",
        seconds = budget_s,
        memory = memory_mb
    );
    DraftVerdict { problems: vec![DraftRemark::on_all(tr!("Too expensive to check"), what)], ..DraftVerdict::default() }
}
