//! Images in the briefings of drafts: copies only the pixels and adds the image with its
//! alternative text.

use std::collections::BTreeSet;

use documents::picture::{MOST_PICTURES, MOST_SENT_BYTES, PictureCopy, PictureFile};
use model::CurrentPerson;
use model::authoring::{EditedDocument, FieldSort};
use model::ids::SchoolId;
use store::authoring::drafts::Texts;
use store::authoring::{drafts, pictures};

use crate::authoring::SeenDraft;
use crate::authoring::drafting::{SaveOutcome, draft_editor};
use crate::authoring::image_copies::copy_picture;
use crate::error::{Error, refuse_trainees};
use crate::recordings::quotas::ensure_database_room;
use crate::service::Service;

/// An uploaded image for a briefing.
#[derive(Clone, Debug, Default)]
pub struct SentPicture {
    /// Content of the file.
    pub bytes: Vec<u8>,
    /// Whether the file exceeded the size limit and was cut off.
    pub is_cut: bool,
    /// Alternative text.
    pub alt: String,
}

/// Adds an image to the briefing of an exercise draft and saves the draft if its version is still
/// the one seen.
///
/// # Errors
/// Fails if the image is rejected, in which case nothing is saved, if there is no such draft, or if
/// the database fails.
pub async fn add_picture(
    state: &Service,
    person: &CurrentPerson,
    seen: SeenDraft,
    texts: &Texts,
    sent: SentPicture,
) -> Result<SaveOutcome, Error> {
    refuse_trainees(person)?;
    ensure_database_room(state)?;
    let school = person.school_id;
    drafts::find_draft(state.db.reader(), school, seen.id).await?.ok_or(Error::NotFound)?;
    let mut document = EditedDocument::from_text(&texts.document)
        .ok_or_else(|| refuse(tr!("This draft is not valid TOML: correct it before you add a picture.")))?;
    let named = list_named_pictures(&document);
    if document.count_rows("picture") >= MOST_PICTURES {
        return Err(Error::Unprocessable(tr!(
            "A briefing has {most} pictures at most: remove one before you add another.",
            most = MOST_PICTURES
        )));
    }
    let alt = sent.alt.trim().to_owned();
    let PictureCopy { kind, size, bytes } = copy_sent(state, school, sent).await?;
    let mut tx = state.db.write().await?;
    let at_hand = pictures::list_draft_pictures(&mut *tx, school, seen.id).await?;
    let taken: BTreeSet<&str> =
        at_hand.iter().map(|picture| picture.name.as_str()).chain(named.iter().map(String::as_str)).collect();
    let name = name_picture(kind.ending(), &taken);
    add_row(&mut document, &name, &alt);
    let texts = Texts { document: document.into_text(), ..texts.clone() };
    let kept = drafts::save_draft(&mut tx, draft_editor(state, person), seen.id, seen.version, &texts).await?;
    if kept {
        // Images without a row are deleted only now, since an editor may undo the removal of a row.
        for gone in at_hand.iter().filter(|picture| !named.contains(&picture.name)) {
            pictures::drop_draft_picture(&mut tx, seen.id, &gone.name).await?;
        }
        pictures::add_draft_picture(&mut tx, seen.id, &PictureFile { name, size, bytes }).await?;
    }
    let draft = drafts::find_draft(&mut *tx, school, seen.id).await?.ok_or(Error::NotFound)?;
    tx.commit().await?;
    Ok(if kept { SaveOutcome::Kept(draft) } else { SaveOutcome::Elsewhere(draft) })
}

fn refuse(why: &str) -> Error {
    Error::Unprocessable(why.to_owned())
}

/// Copies the pixels of the uploaded image, without metadata.
async fn copy_sent(state: &Service, school: SchoolId, sent: SentPicture) -> Result<PictureCopy, Error> {
    if sent.is_cut {
        return Err(Error::Unprocessable(tr!(
            "The picture is larger than {most} MB: send a smaller one.",
            most = MOST_SENT_BYTES / 1_000_000
        )));
    }
    if sent.bytes.is_empty() {
        return Err(refuse(tr!("Choose a picture first.")));
    }
    copy_picture(state, school, &sent.bytes, false).await?.map_err(Error::Unprocessable)
}

/// Returns the names of the images in a draft's text.
fn list_named_pictures(document: &EditedDocument) -> Vec<String> {
    let rows = 0..document.count_rows("picture");
    rows.map(|row| document.written_at(&format!("picture[{row}].file"))).collect()
}

/// Returns an unused file name. The uploaded name is not used, because it may contain a person's
/// name.
fn name_picture(ending: &str, taken: &BTreeSet<&str>) -> String {
    let has = |number: &usize| taken.iter().any(|name| name.split('.').next() == Some(&format!("picture-{number}")));
    let number = (1..=taken.len() + 1).find(|number| !has(number)).unwrap_or_default();
    format!("picture-{number}.{ending}")
}

/// Appends a row for an image, with its alternative text in the document's own language.
fn add_row(document: &mut EditedDocument, name: &str, alt: &str) {
    let row = document.count_rows("picture");
    document.add_row("picture", &[("file", name)]);
    document.write_field(&format!("picture[{row}].alt"), FieldSort::Text, alt);
}

#[cfg(test)]
mod tests {
    //! An image's name must be free and must not reveal anything.

    use super::*;

    #[test]
    fn a_picture_gets_the_first_name_that_is_free_whatever_its_kind() {
        assert_eq!(name_picture("png", &BTreeSet::new()), "picture-1.png");
        let taken = BTreeSet::from(["picture-1.jpg", "picture-3.png", "sonogram-2.png"]);
        assert_eq!(name_picture("png", &taken), "picture-2.png");
    }

    #[test]
    fn its_row_stands_behind_those_of_before() {
        let text = "id = \"x\"\n\n[[picture]]\nfile = \"a-1.png\"\nalt = \"A\"\n";
        let mut document = EditedDocument::from_text(text).expect("TOML");
        add_row(&mut document, "picture-1.png", "B");
        assert_eq!(list_named_pictures(&document), ["a-1.png", "picture-1.png"]);
        let text = document.into_text();
        assert!(text.ends_with("alt = \"A\"\n\n[[picture]]\nfile = \"picture-1.png\"\nalt = \"B\"\n"), "{text}");
    }
}
