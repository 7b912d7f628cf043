//! From the bytes of a file to its text: what spreadsheets and student systems save as "CSV".

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};

/// Separators that are looked for.
const SEPARATORS: [u8; 4] = *b";,\t|";

/// A file as text, with the separator of its fields.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct RosterText {
    /// What stands in it, without mark of order or hint for spreadsheets; lines end in LF alone.
    pub body: String,
    /// Between fields.
    pub separator: u8,
    /// Lines that were taken off its head.
    pub skipped: u64,
}

/// Reads UTF-8 and UTF-16 by their marks, UTF-16 without one by its zeros, and anything that is none of them as Windows'
/// western code page, which German and French Excel still write.
pub(super) fn read(bytes: &[u8]) -> RosterText {
    let (decoded, _) = encoding(bytes).decode_with_bom_removal(bytes);
    // The reader of CSV counts a line that ends in CR LF when it reads on, so that every line is told one too early.
    let body = decoded.replace("\r\n", "\n").replace('\r', "\n");
    // Excel writes and obeys a first line that names the separator.
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

/// The separator that the heading has most of, outside quotes.
fn separator(heading: &str) -> u8 {
    let count = |separator: u8| {
        let mut quoted = false;
        let outside = heading.bytes().filter(|byte| {
            quoted ^= *byte == b'"';
            *byte == separator && !quoted
        });
        outside.count()
    };
    // The first of equals wins: a heading of one column has none of any.
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
