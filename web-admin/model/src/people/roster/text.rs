//! Decoding of a file to text: the variants of "CSV" that spreadsheets and student systems write.

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};

/// Possible separators.
const SEPARATORS: [u8; 4] = *b";,\t|";

/// A decoded file and the separator of its fields.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct RosterText {
    /// Text without byte order mark and separator line; lines end in LF.
    pub body: String,
    /// Separator of the fields.
    pub separator: u8,
    /// Number of lines removed from the start.
    pub skipped: u64,
}

/// Decodes UTF-8 and UTF-16 by their byte order marks, UTF-16 without one by its zero bytes, and
/// everything else that is not UTF-8 as Windows-1252, which German and French Excel still write.
pub(super) fn read(bytes: &[u8]) -> RosterText {
    let (decoded, _) = encoding(bytes).decode_with_bom_removal(bytes);
    // With CR LF line ends, the csv crate would report line numbers that are one too small.
    let body = decoded.replace("\r\n", "\n").replace('\r', "\n");
    // Excel writes and recognizes a first line that names the separator.
    let (head, rest) = body.split_once('\n').unwrap_or((body.as_str(), ""));
    if let Some(separator) = head.trim_end().strip_prefix("sep=").and_then(|s| s.bytes().next()) {
        return RosterText { body: rest.to_owned(), separator, skipped: 1 };
    }
    RosterText { separator: separator(head), body, skipped: 0 }
}

fn encoding(bytes: &[u8]) -> &'static Encoding {
    if let Some((marked, _)) = Encoding::for_bom(bytes) {
        return marked;
    }
    match bytes {
        [0, _, ..] => UTF_16BE,
        [_, 0, ..] => UTF_16LE,
        _ if std::str::from_utf8(bytes).is_ok() => UTF_8,
        _ => WINDOWS_1252,
    }
}

/// Returns the most frequent separator in the headings, outside quotes.
fn separator(heading: &str) -> u8 {
    let count = |separator: u8| {
        let mut quoted = false;
        let outside = heading.bytes().filter(|byte| {
            quoted ^= *byte == b'"';
            *byte == separator && !quoted
        });
        outside.count()
    };
    // Ties go to the first separator, for example if there is only one column.
    SEPARATORS.into_iter().rev().max_by_key(|separator| count(*separator)).unwrap_or(b',')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_encoding_that_registrars_send_is_read() {
        let text = "Name;E-Mail\r\nJürgen;j@example.org\r\n";
        let utf16 = |mark: &[u8], bytes: fn(u16) -> [u8; 2]| {
            mark.iter().copied().chain(text.encode_utf16().flat_map(bytes)).collect::<Vec<u8>>()
        };
        let western: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
        for bytes in [
            text.as_bytes().to_vec(),
            [b"\xEF\xBB\xBF".as_slice(), text.as_bytes()].concat(),
            utf16(b"\xFF\xFE", u16::to_le_bytes),
            utf16(b"\xFE\xFF", u16::to_be_bytes),
            utf16(b"", u16::to_le_bytes),
            western,
        ] {
            assert_eq!(
                read(&bytes),
                RosterText { body: text.replace('\r', ""), separator: b';', skipped: 0 },
                "{bytes:?}"
            );
        }
    }

    #[test]
    fn the_separator_is_the_headings_own() {
        let separator = |text: &str| char::from(read(text.as_bytes()).separator);
        assert_eq!(separator("a,b;c,d"), ',');
        assert_eq!(separator("a\tb\tc"), '\t');
        assert_eq!(separator("\"a,b,c\";d"), ';');
        assert_eq!(separator("email"), ';');
        assert_eq!(read(b"sep=|\r\na|b"), RosterText { body: "a|b".to_owned(), separator: b'|', skipped: 1 });
    }
}
