//! The section of an exercise's form for the pictures of its briefing.

use documents::picture::MOST_PICTURES;

use super::{FieldInput, FormReader, FormRow, FormSection, RowMove, place_id};
use crate::authoring::pictures::{PictureAtHand, ShownPicture};

/// The pictures of a draft.
#[derive(Clone, Debug, Default)]
pub struct DraftPictures {
    /// Upload address.
    pub href: String,
    /// Uploaded pictures, including those the document no longer uses.
    pub at_hand: Vec<PictureAtHand>,
}

/// Controls that add a picture.
#[derive(Clone, Debug)]
pub struct PictureAdding {
    /// Upload address.
    pub href: String,
    /// Description entered for a refused upload; else empty.
    pub alt: String,
    /// Code of the description's language; empty if the document declares no languages.
    pub language: String,
    /// Name of that language, if the document has several; else empty.
    pub language_name: String,
    /// Problems with the upload, or with the number of pictures.
    pub problems: Vec<String>,
    /// Whether another picture can be added.
    pub is_open: bool,
}

impl FormReader<'_> {
    /// Builds the section of a briefing's pictures, with the controls that add one.
    pub(super) fn picture_section(&self, pictures: &DraftPictures) -> FormSection {
        let count = self.document.count_rows("picture");
        let languages = self.document.languages();
        FormSection {
            id: "f-picture",
            title: tr!("Pictures"),
            about: tr!("Shown below the briefing, here and at the stations. Pictures do not affect scoring."),
            rows: (0..count).map(|row| self.picture_row(row, count, pictures)).collect(),
            uploading: Some(PictureAdding {
                href: pictures.href.clone(),
                alt: String::new(),
                language: languages.first().cloned().unwrap_or_default(),
                language_name: if languages.len() > 1 {
                    words::own_name(&languages[0]).to_owned()
                } else {
                    String::new()
                },
                problems: self.problems_of("picture"),
                is_open: count < MOST_PICTURES,
            }),
            ..FormSection::default()
        }
    }

    fn picture_row(&self, row: usize, count: usize, pictures: &DraftPictures) -> FormRow {
        let at = |key: &str| format!("picture[{row}].{key}");
        let file = self.document.written_at(&at("file"));
        let alt =
            self.wording(&at("alt"), tr!("Description, for people who cannot see the picture"), &FieldInput::Line);
        let caption = self.wording(&at("caption"), tr!("Caption"), &FieldInput::Line);
        let known = pictures.at_hand.iter().find(|known| known.name == file);
        let up = (row > 0).then(|| RowMove { act: format!("up:picture[{row}]"), label: tr!("Up") });
        let down = (row + 1 < count).then(|| RowMove { act: format!("down:picture[{row}]"), label: tr!("Down") });
        FormRow {
            id: place_id(&format!("picture[{row}]")),
            title: format!("{}. {file}", row + 1),
            note: self.problems_of(&at("file")).join(" "),
            picture: known.map(|known| ShownPicture {
                src: known.src.clone(),
                alt: alt.first().map_or_else(String::new, |field| field.value.clone()),
                caption: String::new(),
                size: known.size,
            }),
            fields: alt
                .into_iter()
                .chain(caption.into_iter().map(|field| field.hinted(tr!("May be empty."))))
                .collect(),
            removal: format!("remove:picture[{row}]"),
            moves: up.into_iter().chain(down).collect(),
            ..FormRow::default()
        }
    }
}
