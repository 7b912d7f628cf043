//! Texts of a roster that can be stored and shown.

use super::Refusal;
use crate::single_line_text::is_strange;

/// Maximum length of a name, number or cohort, in characters.
const MAX_CHARS: usize = 120;

/// Checks that a text is not a formula, which a spreadsheet would execute when it opens an export,
/// is not too long, and contains no characters that cannot be shown.
pub(super) fn check_text(text: &str) -> Result<(), Refusal> {
    if text.starts_with(['=', '+', '-', '@']) {
        return Err(Refusal::Formula(text.to_owned()));
    }
    if text.chars().count() > MAX_CHARS || text.contains(is_strange) {
        return Err(Refusal::BadText(text.chars().filter(|c| !is_strange(*c)).take(40).collect()));
    }
    Ok(())
}

/// Returns whether a text is permitted as a name.
#[must_use]
pub fn is_name(text: &str) -> bool {
    !text.trim().is_empty() && check_text(text).is_ok()
}
