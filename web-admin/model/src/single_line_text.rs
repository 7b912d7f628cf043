//! Single-line texts that are shown to people: names, titles, labels. All share one rule on
//! characters.

use unicode_normalization::UnicodeNormalization;

/// Maximum length of a title, in characters.
const LONGEST_TITLE: usize = 200;

/// Returns the first invisible character that affects how the rest is displayed: it ends the line,
/// changes the text direction, or controls a terminal. Joiners and non-joiners of scripts are
/// permitted.
#[must_use]
pub fn strange_in(text: &str) -> Option<char> {
    text.chars().find(|c| is_strange(*c))
}

/// Returns whether a character is not permitted in a line.
#[must_use]
pub fn is_strange(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{061C}' | '\u{200E}' | '\u{200F}' | '\u{2028}'..='\u{202E}' | '\u{2066}'..='\u{2069}' | '\u{FEFF}'
        )
}

/// Returns whether a character is invisible (Unicode's `Default_Ignorable_Code_Point`): texts that
/// differ only in such characters look the same.
#[must_use]
pub const fn is_invisible(c: char) -> bool {
    matches!(
        c,
        '\u{00AD}' | '\u{034F}' | '\u{061C}' | '\u{115F}' | '\u{1160}' | '\u{17B4}' | '\u{17B5}' | '\u{180B}'..='\u{180F}'
            | '\u{200B}'..='\u{200F}' | '\u{202A}'..='\u{202E}' | '\u{2060}'..='\u{206F}' | '\u{3164}'
            | '\u{FE00}'..='\u{FE0F}' | '\u{FEFF}' | '\u{FFA0}' | '\u{FFF0}'..='\u{FFF8}' | '\u{E0000}'..='\u{E0FFF}'
    )
}

/// Returns the text of a field in its stored form: composed, with single plain spaces between
/// words, and without invisible characters left by word processors. Joiners are kept, because
/// scripts and emoji need them.
#[must_use]
pub fn tidy(text: &str) -> String {
    let seen = text.nfc().filter(|c| !matches!(c, '\u{00AD}' | '\u{200B}' | '\u{2060}' | '\u{FEFF}'));
    let mut tidy = String::with_capacity(text.len());
    for c in seen {
        match c {
            // Line ends are kept, so that the subsequent check can refuse them.
            c if c.is_whitespace() && !c.is_control() => {
                if !tidy.ends_with(' ') {
                    tidy.push(' ');
                }
            }
            c => tidy.push(c),
        }
    }
    tidy.trim().to_owned()
}

/// Returns the error message for a line that contains a character that is not permitted.
#[must_use]
pub fn refusal(field: &str, text: &str) -> Option<String> {
    let code = format!("{:04X}", u32::from(strange_in(text)?));
    Some(tr!(
        "{field}: contains the invisible character U+{code}, which changes how the text is displayed",
        field = field,
        code = code
    ))
}

/// Validates a title. Returns it without surrounding spaces.
///
/// # Errors
/// If it is empty, too long, or contains a character that is not permitted; as a message.
pub fn title(typed: &str) -> Result<&str, String> {
    let title = typed.trim();
    match title.chars().count() {
        1..=LONGEST_TITLE => refusal(tr!("title"), title).map_or(Ok(title), Err),
        count => Err(tr!("title: {count} characters; allowed: 1 to 200", count = count)),
    }
}

/// Replaces characters that are not permitted with spaces, for texts that an earlier version
/// accepted.
#[must_use]
pub fn on_one_line(text: &str) -> String {
    text.chars().map(|c| if is_strange(c) { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_that_look_the_same_are_tidied_into_one() {
        for other in ["Jo\u{308}rg Ek", " Jörg\u{a0} Ek", "\u{feff}Jörg\u{200b} Ek\u{ad}", "Jörg   Ek "] {
            assert_eq!(tidy(other), "Jörg Ek", "{other:?}");
        }
        assert_eq!(tidy("می\u{200c}خواهم"), "می\u{200c}خواهم", "a joiner of a script stays");
        assert!(tidy("Ana\nEk").contains('\n'), "a line's end is refused, not joined");
    }

    #[test]
    fn what_turns_a_line_around_or_ends_it_is_no_title() {
        for strange in ['\u{202E}', '\u{2066}', '\u{200F}', '\u{2028}', '\u{2029}', '\u{85}', '\n', '\0', '\u{1b}'] {
            let why = title(&format!("Spring {strange}2026")).unwrap_err();
            assert!(why.contains(&format!("U+{:04X}", u32::from(strange))), "{why}");
            assert_eq!(on_one_line(&format!("a{strange}b")), "a b");
        }
        for fine in ["Frühjahr “26”", "می‌خواهم", "עברית", "👩‍⚕️ evening"] {
            assert_eq!(title(fine), Ok(fine));
        }
        assert!(title(" ").is_err() && title(&"a".repeat(201)).is_err());
    }
}
