//! Writing documents in the browser: drafts, what is wrong with them, and how they become revisions.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;

use documents::curriculum::CurriculumEntry;
use documents::{Curriculum, ExerciseBundle, Instrument, Issue, Wording};
use model::CurrentPerson;
use model::authoring::find_exercise_id;
use model::draft::{DraftRemark, DraftVerdict};
use model::ids::{DraftId, RevisionId, SchoolId};
use model::progress::Mastery;
use store::audit::{Actor, AuditEntry};
use store::drafts::{DocumentDraft, DraftEditor, DraftKind, NewDocumentDraft, Texts};
use store::exercises::RevisionBytes;
use store::{curricula, drafts, exercises, instruments, pictures};

use crate::error::{Error, refuse_trainees};
use crate::judging::{DraftQuestion, JudgeAnswer, JudgeQuestion, same_id};
use crate::publishing::{CourseRefused, DocumentPublisher};
use crate::service::Service;
use crate::{asking, publishing, surveys};

/// What a draft comes to.
#[derive(Debug)]
pub enum Checked {
    /// An exercise, which could be published where nothing is wrong.
    Exercise(Box<DraftVerdict>),
    /// A course that could be published.
    Course(Box<CheckedCourse>),
    /// An instrument that could be published.
    Instrument(Box<Instrument>),
    /// What is wrong with a course or an instrument, in the order of the documents.
    Refused(Vec<Issue>),
    /// Nobody knows yet, for others of this school are before it; when to ask again, in s.
    Waiting(u64),
}

/// A course that could be published.
#[derive(Debug)]
pub struct CheckedCourse {
    /// The course.
    pub course: Curriculum,
    /// When an exercise of it is mastered.
    pub mastery: Mastery,
    /// Titles of its exercises, by their ids.
    pub titles: BTreeMap<String, Wording>,
}

/// What became of a save.
#[derive(Debug)]
pub enum SaveOutcome {
    /// The draft as it is now.
    Kept(DocumentDraft),
    /// Somebody else has saved it since it was seen: nothing was written. Theirs.
    Elsewhere(DocumentDraft),
}

/// The draft of an exercise, begun from its current revision where there is none.
///
/// # Errors
/// When there is no such exercise.
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

/// The current revision of an exercise, with its texts.
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

/// The draft of a course, begun from its current revision where there is none.
///
/// # Errors
/// When there is no such course.
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

/// The draft of an instrument, begun from its current revision where there is none.
///
/// # Errors
/// When there is no such instrument.
pub async fn open_instrument(state: &Service, person: &CurrentPerson, instrument_id: &str) -> Result<DraftId, Error> {
    refuse_trainees(person)?;
    let document = current_instrument(state, person.school_id, instrument_id).await?;
    let texts = Texts { document, scene: String::new() };
    let kind = DraftKind::Instrument;
    begin_draft_of(state, person, &NewDocumentDraft { kind, document_id: instrument_id, based_on: None, texts: &texts })
        .await
}

/// The text of an instrument's current revision.
pub(crate) async fn current_instrument(
    state: &Service,
    school: SchoolId,
    instrument_id: &str,
) -> Result<String, Error> {
    let current = instruments::find_current_instrument(state.db.reader(), school, instrument_id).await?;
    text(current.ok_or(Error::NotFound)?.bytes)
}

/// The draft of a document, begun where there is none.
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

/// A published document was UTF-8 when it was read.
fn text(bytes: Vec<u8>) -> Result<String, Error> {
    String::from_utf8(bytes).map_err(|error| Error::Internal(anyhow::Error::new(error).context("a published document")))
}

/// Saves a draft over the version that was seen.
///
/// # Errors
/// When there is no such draft, or the database fails.
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

/// Publishes a draft that could be: a new revision, and the draft is gone. Attempts already made keep theirs. False when somebody
/// has saved the draft meanwhile.
///
/// # Errors
/// When the database fails, or a course's mastery rule cannot be kept.
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
            surveys::publish_text(&mut tx, &publisher, instrument, draft.texts.document.as_bytes()).await?;
            surveys::course_surveys(&mut tx, by.school, by.now).await?;
        }
        _ => return Ok(false),
    }
    tx.commit().await?;
    Ok(true)
}

/// Throws a draft away in the version that was seen. False when it is another by now.
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

/// Reads a draft as publishing would, plans its tissue and tries its rubric. Dropped, the work on an exercise ends.
///
/// # Errors
/// When the database fails, or nobody can be asked.
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

/// A course names exercises that are published, so reading it is bounded work; its school waits for it like for an exercise.
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

/// What was written in the draft of an exercise, with the meshes of the revision that it is based on.
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

/// The exercise of a draft in which nothing was found wrong.
async fn sound(state: &Service, school: SchoolId, draft: &DocumentDraft) -> Result<ExerciseBundle, Error> {
    let RevisionBytes { exercise, scene, meshes } = bytes(state, school, draft).await?;
    let at_hand = pictures::read_draft_pictures(state.db.reader(), school, draft.id).await?;
    let pictures: Vec<_> = at_hand.into_iter().map(|picture| (picture.name, picture.bytes)).collect();
    let read = move || ExerciseBundle::from_parts(&exercise, &scene, &meshes)?.with_pictures(&pictures);
    let read = tokio::task::spawn_blocking(read).await?;
    Ok(read.map_err(|refused| anyhow::Error::new(refused).context("a draft that could be published"))?)
}

/// An instrument names nothing outside itself and is small, so it is read at once.
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

/// Ids of exercises by the names that a course's current revision gives their files.
///
/// # Errors
/// When the database fails.
pub async fn find_course_files(
    state: &Service,
    school: SchoolId,
    course_id: &str,
) -> Result<BTreeMap<String, String>, Error> {
    Ok(ExerciseShelf::of(state, school, course_id).await?.files())
}

/// The school's exercises, as a course may name them. Each is read when it is named.
struct ExerciseShelf {
    /// By id.
    documents: BTreeMap<String, RevisionBytes>,
    /// Those that were read, by id.
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

    /// Ids by the names of files in the course's current revision.
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
        // It was read when it was published, so a refusal now is our fault: then the course names nothing.
        let read = ExerciseBundle::from_parts(&bytes.exercise, &bytes.scene, &bytes.meshes);
        let read = read.inspect_err(|error| tracing::error!(id, %error, "a published exercise is refused")).ok();
        self.read.borrow_mut().insert(id.to_owned(), read.clone());
        read
    }
}

/// Who changes a draft, and when.
pub(crate) fn draft_editor(state: &Service, person: &CurrentPerson) -> DraftEditor {
    DraftEditor { school: person.school_id, person: person.id, now: state.clock.now() }
}

/// What a draft of an exercise comes to. Dropped, the work on it ends.
///
/// # Errors
/// [`Error::Busy`] when its school's turn does not come in time; else when nobody can be asked.
pub async fn examine(state: &Service, school: SchoolId, question: DraftQuestion) -> Result<DraftVerdict, Error> {
    let (previews, key) = (&state.previews, question.sha256());
    if let Some(told) = previews.told(&key) {
        return Ok(told);
    }
    let _place = previews.enter(school).await?;
    // Whoever was before may have asked the same.
    if let Some(told) = previews.told(&key) {
        return Ok(told);
    }
    match asking::ask(state, JudgeQuestion::Draft(Box::new(question))).await? {
        JudgeAnswer::Examined(verdict) => {
            previews.keep(key, &verdict);
            Ok(*verdict)
        }
        JudgeAnswer::Died(how) => {
            tracing::warn!(%school, how, "a draft costs more than a preview may");
            Ok(too_costly(state))
        }
        other => Err(anyhow::anyhow!("a draft was to be looked at, and this came: {other:?}").into()),
    }
}

/// What is said of a draft that costs more than it may.
fn too_costly(state: &Service) -> DraftVerdict {
    let budget_s = state.config.preview_time.as_secs();
    let memory_mb = state.config.helper.as_ref().map_or(0, |helper| helper.memory_mb);
    let what = tr!(
        "to find out what it comes to takes more than {seconds} s or {memory} MB; allowed: what takes less. A larger \
         tissue.tolerance, fewer layers and a shorter time limit cost less",
        seconds = budget_s,
        memory = memory_mb
    );
    DraftVerdict { problems: vec![DraftRemark::on_all(tr!("Too costly"), what)], ..DraftVerdict::default() }
}
