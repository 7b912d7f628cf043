//! Pictures of a briefing, as displayed.

use documents::{Exercise, ExercisePicture};

/// An available picture of a revision or a draft.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PictureAtHand {
    /// File name in the exercise.
    pub name: String,
    /// Address of the file.
    pub src: String,
    /// Width and height, in pixels.
    pub size: [u32; 2],
}

/// A picture as displayed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShownPicture {
    /// Address of the file.
    pub src: String,
    /// Alternative text.
    pub alt: String,
    /// Caption; may be empty.
    pub caption: String,
    /// Width and height, in pixels.
    pub size: [u32; 2],
}

/// Returns the address of a picture below a page, by its position or name. It contains the hash of
/// the picture, so that browsers may cache it.
#[must_use]
pub fn picture_address(page: &str, picture: &str, sha256: &str) -> String {
    format!("{page}/pictures/{picture}?v={}", picture_version(sha256))
}

/// Returns the part of a picture's hash that its address contains.
#[must_use]
pub fn picture_version(sha256: &str) -> &str {
    sha256.get(..16).unwrap_or(sha256)
}

/// Returns the available pictures of an exercise, in the order of its briefing and in the reader's
/// language.
#[must_use]
pub fn show_pictures(exercise: &Exercise, at_hand: &[PictureAtHand]) -> Vec<ShownPicture> {
    let language = words::current().code();
    let shown = |named: &ExercisePicture| {
        let known = at_hand.iter().find(|known| known.name == named.file)?;
        Some(ShownPicture {
            src: known.src.clone(),
            alt: named.alt.in_language(language).to_owned(),
            caption: named.caption.as_ref().map_or_else(String::new, |said| said.in_language(language).to_owned()),
            size: known.size,
        })
    };
    exercise.pictures.iter().filter_map(shown).collect()
}
