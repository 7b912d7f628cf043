//! Checks of the quotation marks in a CSV file. The parser treats everything between two marks as
//! one field, so that a superfluous mark swallows lines.

use super::Unreadable;
use crate::people::email::{is_email, normalize_email};

/// Refuses a text in which a quoted field is not closed at its end, or contains another person's
/// line. `skipped` is the number of lines removed from the start of the text.
pub(super) fn check_quotes(text: &str, separator: u8, skipped: u64) -> Result<(), Unreadable> {
    let separator = char::from(separator);
    let (mut rest, mut line) = (text, 1 + skipped);
    // Each iteration consumes a field and its separator.
    while !rest.is_empty() {
        let end = if let Some(quoted) = rest.strip_prefix('"') {
            let (inside, after) = split_quoted(quoted).ok_or(Unreadable::OpenQuote { line })?;
            let tail = after.find([separator, '\n']).unwrap_or(after.len());
            // Within one line a wrong mark affects only this line, which is shown to the user, for
            // example a nickname in quotes within a name.
            let is_spoilt = !after[..tail].trim().is_empty() || swallows_a_line(inside, separator);
            if inside.contains('\n') && is_spoilt {
                return Err(Unreadable::OpenQuote { line });
            }
            line += inside.matches('\n').count() as u64;
            rest.len() - after.len() + tail
        } else {
            rest.find([separator, '\n']).unwrap_or(rest.len())
        };
        let mut left = rest[end..].chars();
        line += u64::from(left.next() == Some('\n'));
        rest = left.as_str();
    }
    Ok(())
}

/// Splits a text at the closing mark. A doubled mark represents one mark and does not close the
/// field.
fn split_quoted(text: &str) -> Option<(&str, &str)> {
    let mut from = 0;
    loop {
        let at = from + text[from..].find('"')?;
        if !text[at + 1..].starts_with('"') {
            return Some((&text[..at], &text[at + 1..]));
        }
        from = at + 2;
    }
}

/// Returns whether a multi-line field contains an email address as a separate field, which
/// indicates a missing mark before it.
fn swallows_a_line(inside: &str, separator: char) -> bool {
    let later = inside.split('\n').skip(1).filter(|line| line.contains(separator));
    later.flat_map(|line| line.split(separator)).any(|field| is_email(&normalize_email(field)))
}

#[cfg(test)]
mod tests {
    //! Checks that no mark swallows a person, and that correctly quoted fields are accepted.

    use proptest::prelude::*;

    use super::*;

    fn refused(text: &str) -> Option<u64> {
        match check_quotes(text, b',', 0) {
            Err(Unreadable::OpenQuote { line }) => Some(line),
            _ => None,
        }
    }

    #[test]
    fn a_mark_that_is_not_closed_is_named_with_its_line() {
        let file = |third: &str, fifth: &str| {
            format!("email,name,cohort\na@b.co,A,Q\nb@b.co,{third}\nc@b.co,C,Q\nd@b.co,{fifth}\n")
        };
        assert_eq!(refused(&file("B,Q", "D,Q")), None);
        assert_eq!(refused(&file("\"B,Q", "D,Q")), Some(3), "open to the end");
        assert_eq!(refused(&file("B,Q", "\"D,Q")), Some(5), "open in the last line");
        assert_eq!(refused(&file("\"B,Q", "\"D,Q")), Some(3), "closed by the next one that opens");
        assert_eq!(refused(&file("\"B,Q", "\"D\",Q")), Some(3));
        assert_eq!(refused(&file("\"B,Q", "D\",Q")), Some(3), "closed by a stray one at a field's end");
    }

    #[test]
    fn marks_that_are_right_are_left_alone() {
        for fine in [
            "email,name\na@b.co,\"Ek, Ana\"\n",
            "email,name\na@b.co,\"Ana \"\"Ann\"\" Ek\"\n",
            "email,name,note\na@b.co,Ana,\"first line\nsecond, line\"\nb@b.co,Bo,\n",
            "email,name\na@b.co,\"Ana\"  \nb@b.co,\"\"",
            "email,name\na@b.co,\"Jorg \"Joe\" Ek\"\nb@b.co,Bo\n",
            "email,name\na@b.co,5\" needle\nb@b.co,O\"Brien\n",
            "email,name,note\na@b.co,Ana,\"call\nor mail a@x.org, please\"\n",
        ] {
            assert_eq!(refused(fine), None, "{fine:?}");
        }
    }

    proptest! {
        #[test]
        fn whatever_a_writer_quotes_is_read(rows in prop::collection::vec(prop::collection::vec("[a-z\"\n, ]{0,8}", 3), 1..5)) {
            let mut writer = csv::Writer::from_writer(Vec::new());
            for row in &rows {
                writer.write_record(row).expect("three fields");
            }
            let text = String::from_utf8(writer.into_inner().expect("all written")).expect("text");
            prop_assert_eq!(refused(&text), None);
        }
    }
}
