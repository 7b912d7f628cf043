//! Creates drafts: copies an exercise or an instrument under a new title, begins an empty course or
//! instrument, and adds an exercise to a course.

pub mod drafting;
pub(crate) mod image_copies;
pub mod images;
pub mod importing;
pub mod instruments;
pub mod publishing;

use model::authoring::{EditedDocument, FieldSort, find_exercise_id, id_from_title};
use model::ids::{DraftId, SchoolId};
use model::{CurrentPerson, authoring};
use store::authoring::drafts::{DraftKind, NewDocumentDraft, Texts};
use store::authoring::{drafts, exercises};
use store::surveys::instruments::find_current_instrument;
use store::training::curricula;

use crate::authoring::drafting::{
    SaveOutcome, begin_draft_of, current_exercise, current_instrument, draft_editor, open_course, save_draft,
};
use crate::error::{Error, refuse_trainees};
use crate::service::Service;

/// Maximum length of a document id, in characters.
const LONGEST_ID: usize = 64;
/// Maximum length of a title, in characters; the document schema has the same limit.
const LONGEST_TITLE: usize = 300;

/// A document to create.
#[derive(Clone, Copy, Debug)]
pub struct NewDocument<'a> {
    /// Its title.
    pub title: &'a str,
    /// Its id; empty to derive it from the title.
    pub id: &'a str,
}

/// A draft and the version that the editor has seen, for optimistic locking.
#[derive(Clone, Copy, Debug)]
pub struct SeenDraft {
    /// The draft.
    pub id: DraftId,
    /// The version.
    pub version: i64,
}

/// An exercise in a course draft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AddedExercise {
    /// The draft.
    pub draft: DraftId,
    /// Row of the exercise, from 0.
    pub row: usize,
}

/// Creates a draft of a new exercise, as a copy of another.
///
/// # Errors
/// Fails if the exercise does not exist, or the title or id is not allowed.
pub async fn copy_exercise(
    state: &Service,
    person: &CurrentPerson,
    exercise_id: &str,
    new: NewDocument<'_>,
) -> Result<DraftId, Error> {
    refuse_trainees(person)?;
    let (current, texts) = current_exercise(state, person.school_id, exercise_id).await?;
    let title = check_title(new.title)?;
    let id = choose_id(state, person.school_id, DraftKind::Exercise, new).await?;
    let document = name_document(&texts.document, &id, title);
    let texts = Texts { document, ..texts };
    let draft =
        NewDocumentDraft { kind: DraftKind::Exercise, document_id: &id, based_on: Some(current), texts: &texts };
    begin_draft_of(state, person, &draft).await
}

/// Creates a draft of a new course without exercises.
///
/// # Errors
/// Fails if the title or id is not allowed.
pub async fn begin_course(state: &Service, person: &CurrentPerson, new: NewDocument<'_>) -> Result<DraftId, Error> {
    refuse_trainees(person)?;
    let title = check_title(new.title)?;
    let id = choose_id(state, person.school_id, DraftKind::Course, new).await?;
    let texts = Texts { document: name_document(EMPTY_COURSE, &id, title), scene: String::new() };
    let draft = NewDocumentDraft { kind: DraftKind::Course, document_id: &id, based_on: None, texts: &texts };
    begin_draft_of(state, person, &draft).await
}

/// Creates a draft of a new instrument: a copy of another, or an empty one.
///
/// # Errors
/// Fails if the instrument does not exist, or the title or id is not allowed.
pub async fn begin_instrument(
    state: &Service,
    person: &CurrentPerson,
    original: Option<&str>,
    new: NewDocument<'_>,
) -> Result<DraftId, Error> {
    refuse_trainees(person)?;
    let document = match original {
        Some(id) => current_instrument(state, person.school_id, id).await?,
        None => EMPTY_INSTRUMENT.to_owned(),
    };
    let title = check_title(new.title)?;
    let id = choose_id(state, person.school_id, DraftKind::Instrument, new).await?;
    let texts = Texts { document: name_instrument(&document, &id, title), scene: String::new() };
    let draft = NewDocumentDraft { kind: DraftKind::Instrument, document_id: &id, based_on: None, texts: &texts };
    begin_draft_of(state, person, &draft).await
}

/// Text of an empty instrument; its language becomes that of its author.
const EMPTY_INSTRUMENT: &str = "id = \"instrument\"
title = {}
duration_min = 1
";

/// Text of an empty course. The mastery rule is an example, the one that the shipped courses use.
const EMPTY_COURSE: &str = "id = \"course\"
title = \"Course\"

# An exercise is mastered with three passes in the last five attempts.
[mastery]
rule = \"passes\"
passes = 3
of = 5
";

/// Appends an exercise to the draft of a course. Trainees see it once that draft is published. If
/// the draft already contains the exercise, returns its row.
///
/// # Errors
/// Fails if the course or exercise does not exist, or the course's draft is not valid TOML.
pub async fn add_to_course(
    state: &Service,
    person: &CurrentPerson,
    course_id: &str,
    exercise_id: &str,
) -> Result<AddedExercise, Error> {
    refuse_trainees(person)?;
    let (reader, school) = (state.db.reader(), person.school_id);
    exercises::find_current_revision(reader, school, exercise_id).await?.ok_or(Error::NotFound)?;
    let id = open_course(state, person, course_id).await?;
    let draft = drafts::find_draft(reader, school, id).await?.ok_or(Error::NotFound)?;
    let files = drafting::find_course_files(state, school, course_id).await?;
    let mut document = EditedDocument::from_text(&draft.texts.document).ok_or_else(refuse_unreadable)?;
    let rows = document.count_rows("exercise");
    let named = |row: &usize| {
        let file = document.written_at(&format!("exercise[{row}].file"));
        find_exercise_id(&files, &file) == exercise_id
    };
    if let Some(row) = (0..rows).find(named) {
        return Ok(AddedExercise { draft: id, row });
    }
    authoring::add_course_exercise(&mut document, exercise_id);
    let texts = Texts { document: document.into_text(), ..draft.texts };
    match save_draft(state, person, id, draft.version, &texts).await? {
        SaveOutcome::Kept(_) => Ok(AddedExercise { draft: id, row: rows }),
        SaveOutcome::Elsewhere(_) => {
            Err(Error::Conflict(tr!("another person has just saved the draft of this course; try again").to_owned()))
        }
    }
}

/// Replaces the scene in an exercise draft by that of another exercise, meshes included, and saves
/// the draft.
///
/// # Errors
/// Fails if the draft or exercise does not exist, or the database fails.
pub async fn take_scene(
    state: &Service,
    person: &CurrentPerson,
    seen: SeenDraft,
    document: &str,
    exercise_id: &str,
) -> Result<SaveOutcome, Error> {
    refuse_trainees(person)?;
    let school = person.school_id;
    let (revision, theirs) = current_exercise(state, school, exercise_id).await?;
    let mut edited = EditedDocument::from_text(document);
    if let (Some(edited), Some(source)) = (edited.as_mut(), EditedDocument::from_text(&theirs.document)) {
        edited.write_field("scene", FieldSort::Text, &source.written_at("scene"));
    }
    let document = edited.map_or_else(|| document.to_owned(), EditedDocument::into_text);
    let texts = Texts { document, scene: theirs.scene };
    let by = draft_editor(state, person);
    let mut tx = state.db.write().await?;
    let kept = drafts::save_draft(&mut tx, by, seen.id, seen.version, &texts).await?;
    if kept {
        drafts::rebase_draft(&mut tx, school, seen.id, revision).await?;
    }
    let draft = drafts::find_draft(&mut *tx, school, seen.id).await?.ok_or(Error::NotFound)?;
    tx.commit().await?;
    Ok(if kept { SaveOutcome::Kept(draft) } else { SaveOutcome::Elsewhere(draft) })
}

fn refuse_unreadable() -> Error {
    let why = tr!("the draft of this course is not valid TOML: correct it before you add an exercise");
    Error::Conflict(why.to_owned())
}

fn check_title(title: &str) -> Result<&str, Error> {
    let title = title.trim();
    match !title.is_empty() && title.chars().count() <= LONGEST_TITLE && !title.chars().any(char::is_control) {
        true => Ok(title),
        false => Err(Error::Unprocessable(tr!(
            "title: “{title}”; allowed: 1 to {most} characters on one line",
            title = title,
            most = LONGEST_TITLE
        ))),
    }
}

/// Chooses the id of a new document: the requested one if it is free, else the first free one
/// derived from the title.
async fn choose_id(state: &Service, school: SchoolId, kind: DraftKind, new: NewDocument<'_>) -> Result<String, Error> {
    let wanted = new.id.trim();
    if !wanted.is_empty() {
        check_new_id(wanted)?;
        return match is_taken(state, school, kind, wanted).await? {
            false => Ok(wanted.to_owned()),
            true => Err(Error::Unprocessable(tr!(
                "id: “{id}” is already taken; choose another, or edit that document",
                id = wanted
            ))),
        };
    }
    let made = id_from_title(new.title);
    check_new_id(&made).map_err(|_| {
        Error::Unprocessable(tr!(
            "id: none can be derived from the title “{title}”; enter one",
            title = new.title.trim()
        ))
    })?;
    for number in 1..1000 {
        let id = if number == 1 { made.clone() } else { format!("{made}-{number}") };
        if !is_taken(state, school, kind, &id).await? {
            return Ok(id);
        }
    }
    Err(Error::Unprocessable(tr!("id: “{id}” is already taken; choose another, or edit that document", id = made)))
}

/// Returns whether an id is used by a published document or a draft.
async fn is_taken(state: &Service, school: SchoolId, kind: DraftKind, id: &str) -> Result<bool, Error> {
    let reader = state.db.reader();
    let published = match kind {
        DraftKind::Exercise => exercises::find_current_revision(reader, school, id).await?.is_some(),
        DraftKind::Course => {
            let taught = curricula::list_taught_curricula(reader, school).await?;
            taught.iter().any(|course| course.curriculum_id == id)
        }
        DraftKind::Instrument => find_current_instrument(reader, school, id).await?.is_some(),
    };
    Ok(published || drafts::find_draft_of(reader, school, kind, id).await?.is_some())
}

fn check_new_id(id: &str) -> Result<(), Error> {
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    match !id.is_empty() && id.len() <= LONGEST_ID && id.chars().all(allowed) {
        true => Ok(()),
        false => Err(Error::Unprocessable(tr!(
            "id: “{id}”; allowed: 1 to {most} lower-case letters, digits and hyphens",
            id = id,
            most = LONGEST_ID
        ))),
    }
}

/// Returns the document with another id and title, otherwise unchanged.
fn name_document(document: &str, id: &str, title: &str) -> String {
    let Some(mut edited) = EditedDocument::from_text(document) else { return document.to_owned() };
    edited.write_field("id", FieldSort::Text, id);
    edited.write_field("title", FieldSort::Text, title);
    edited.into_text()
}

/// Returns the instrument with another id and a title in one language only: the current language if
/// the instrument has it, else its first. Titles in other languages are removed, since they belong
/// to the original.
fn name_instrument(document: &str, id: &str, title: &str) -> String {
    let Some(mut edited) = EditedDocument::from_text(document) else { return document.to_owned() };
    let language = words::current().code();
    edited.name_own_language(language);
    let languages = edited.languages();
    let named = languages.iter().find(|known| *known == language).or(languages.first()).cloned();
    let named = named.unwrap_or_else(|| language.to_owned());
    edited.write_field("id", FieldSort::Text, id);
    edited.write_field(&format!("title.{named}"), FieldSort::Translation, title);
    for other in languages.iter().filter(|other| **other != named) {
        edited.write_field(&format!("title.{other}"), FieldSort::Translation, "");
    }
    edited.into_text()
}

#[cfg(test)]
mod tests {
    //! A copy gets its own id and title, and nothing else in it may change.

    use super::*;

    #[test]
    fn a_copy_has_another_id_and_title_and_no_other_change() {
        let document = "# about\nid = \"a\"\ntitle = \"T\" # old\nidle = 1\n[x]\nid = \"b\"\n";
        let copy = "# about\nid = \"c-2\"\ntitle = \"Über\" # old\nidle = 1\n[x]\nid = \"b\"\n";
        assert_eq!(name_document(document, "c-2", "Über"), copy);
        assert!(name_document(EMPTY_COURSE, "x", "Y").starts_with("id = \"x\"\ntitle = \"Y\"\n"));
        assert!(check_new_id("c-2").is_ok());
        for wrong in ["", "C", "a b", "ä", "../x", &"x".repeat(65)] {
            assert!(check_new_id(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_copied_instrument_keeps_no_title_of_another() {
        let document = "id = \"a\" # which\ntitle = { de = \"Alt\", en = \"Old\" }\nlanguages = [\"de\", \"en\"]\n";
        let copy = "id = \"b\" # which\ntitle = { en = \"New\" }\nlanguages = [\"de\", \"en\"]\n";
        assert_eq!(name_instrument(document, "b", "New").replace("  ", " "), copy);
        let begun = name_instrument(EMPTY_INSTRUMENT, "b", "New");
        assert!(begun.contains("languages = [\"en\"]") && begun.contains("en = \"New\""), "{begun}");
        assert_eq!(name_instrument("no [", "b", "New"), "no [");
    }

    #[test]
    fn a_title_is_one_line() {
        assert_eq!(check_title("  A b ").ok(), Some("A b"));
        for wrong in [" ", "a\nb", &"x".repeat(301)] {
            assert!(check_title(wrong).is_err(), "{wrong}");
        }
    }
}
