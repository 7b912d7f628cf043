//! Outcomes of training that a school defines, such as entrustable professional activities (EPAs),
//! and the levels of entrustment.

mod catalogue;

pub use catalogue::read_catalogue;

use crate::single_line_text::refusal;

/// Maximum number of outcomes of a school.
pub const MOST_OUTCOMES: usize = 2000;
/// Maximum length of a code, in characters.
pub const LONGEST_CODE: usize = 40;
/// Maximum length of a title, in characters.
pub const LONGEST_TITLE: usize = 300;
/// Maximum length of a description, in characters.
pub const LONGEST_DESCRIPTION: usize = 4000;
/// Maximum length of the note of a decision, in characters.
pub const LONGEST_NOTE: usize = 2000;
/// Maximum length of the name of a level, in characters.
pub const LONGEST_LEVEL: usize = 120;
/// Allowed numbers of levels.
pub const LEVELS: std::ops::RangeInclusive<usize> = 2..=10;

/// An outcome as entered in a form or read from a catalogue.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OutcomeText {
    /// Code, unique in the school, such as "EPA 3".
    pub code: String,
    /// Title.
    pub title: String,
    /// Description; may be empty.
    pub description: String,
    /// Identifier in a catalogue; empty if it was entered by hand.
    pub source: String,
}

impl OutcomeText {
    /// Removes surrounding spaces and checks the lengths.
    ///
    /// # Errors
    /// If code or title are empty, a text is too long, or contains a character that is not
    /// permitted; as a message.
    pub fn checked(self) -> Result<Self, String> {
        let trimmed = |text: &str| text.trim().to_owned();
        let of = Self {
            code: trimmed(&self.code),
            title: trimmed(&self.title),
            description: trimmed(&self.description),
            source: trimmed(&self.source),
        };
        check_length(tr!("code"), &of.code, 1, LONGEST_CODE)?;
        check_length(tr!("title"), &of.title, 1, LONGEST_TITLE)?;
        check_length(tr!("description"), &of.description, 0, LONGEST_DESCRIPTION)?;
        check_length(tr!("identifier"), &of.source, 0, LONGEST_TITLE)?;
        let refused = refusal(tr!("code"), &of.code).or_else(|| refusal(tr!("title"), &of.title));
        refused.map_or(Ok(of), Err)
    }
}

/// Checks the names of levels, one per line, lowest first.
///
/// # Errors
/// If their number is outside [`LEVELS`], or a name is too long or contains a character that is not
/// permitted; as a message.
pub fn read_levels(text: &str) -> Result<Vec<String>, String> {
    let names: Vec<String> = text.lines().map(str::trim).filter(|line| !line.is_empty()).map(str::to_owned).collect();
    if !LEVELS.contains(&names.len()) {
        let (least, most) = (LEVELS.start(), LEVELS.end());
        return Err(tr!(
            "levels: {count} names; allowed: {least} to {most}",
            count = names.len(),
            least = least,
            most = most
        ));
    }
    for name in &names {
        check_length(tr!("level"), name, 1, LONGEST_LEVEL)?;
        refusal(tr!("level"), name).map_or(Ok(()), Err)?;
    }
    Ok(names)
}

/// Checks the length of a text, in characters.
///
/// # Errors
/// If it is shorter than `least` or longer than `most`; as a message.
pub fn check_length(field: &str, text: &str, least: usize, most: usize) -> Result<(), String> {
    let count = text.chars().count();
    match (least..=most).contains(&count) {
        true => Ok(()),
        false => Err(tr!(
            "{field}: {count} characters; allowed: {least} to {most}",
            field = field,
            count = count,
            least = least,
            most = most
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outcomes_have_a_code_and_a_bounded_title() {
        let text = |code: &str, title: &str| OutcomeText {
            code: code.to_owned(),
            title: title.to_owned(),
            ..OutcomeText::default()
        };
        assert_eq!(text(" EPA 3 ", "Puncture").checked(), Ok(text("EPA 3", "Puncture")));
        let long = "ä".repeat(LONGEST_TITLE);
        assert!(text("1", &long).checked().is_ok() && text("1", &format!("{long}x")).checked().is_err());
        for refused in [text("", "x"), text("1", " "), text("a\u{202e}", "x"), text(&"x".repeat(41), "x")] {
            assert!(refused.checked().is_err());
        }
    }

    #[test]
    fn levels_are_two_to_ten_bounded_names() {
        assert_eq!(read_levels("Observes\r\n\r\n Acts \n"), Ok(vec!["Observes".to_owned(), "Acts".to_owned()]));
        assert!(read_levels("Observes").is_err() && read_levels(&"x\n".repeat(11)).is_err());
        assert!(read_levels(&"x\n".repeat(10)).is_ok() && read_levels(&format!("a\n{}", "x".repeat(121))).is_err());
    }
}
