//! Pictures of a briefing, as a page shows them.

use documents::{Exercise, ExercisePicture};

/// A picture at hand: of a revision, or of a draft.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PictureAtHand {
    /// Its name, as the exercise names it.
    pub name: String,
    /// Where it is.
    pub src: String,
    /// Width and height, in pixels.
    pub size: [u32; 2],
}

/// A picture as a page shows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShownPicture {
    /// Where it is.
    pub src: String,
    /// What it shows, for whoever does not see it.
    pub alt: String,
    /// What is said below it; empty for nothing.
    pub caption: String,
    /// Width and height, in pixels.
    pub size: [u32; 2],
}

/// The address of a picture among those of a page, by its place or name. It changes with what is in it, so that a browser may keep it.
#[must_use]
pub fn picture_address(page: &str, picture: &str, sha256: &str) -> String {
    format!("{page}/pictures/{picture}?v={}", picture_version(sha256))
}

/// What of a picture's hash stands in its address.
#[must_use]
pub fn picture_version(sha256: &str) -> &str {
    sha256.get(..16).unwrap_or(sha256)
}

/// The pictures of an exercise that are at hand, in the order of its briefing and the reader's language.
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
