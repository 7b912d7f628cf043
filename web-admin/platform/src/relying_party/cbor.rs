//! A reader for the subset of CBOR (RFC 8949) that authenticators use: maps with integer and text
//! keys, definite lengths, and few levels of nesting.

use std::collections::BTreeMap;

/// Maximum nesting of containers: CTAP allows 4 levels, and the browser's object with a compound
/// statement has 5.
const DEEPEST: usize = 8;

/// A key or value of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum CborItem<'a> {
    /// An integer.
    Integer(i64),
    /// A byte string.
    Bytes(&'a [u8]),
    /// A text.
    Text(&'a str),
    /// Any other item: checked to be well-formed and skipped.
    Other,
}

/// A map, sorted by key.
pub(super) type CborMap<'a> = BTreeMap<CborItem<'a>, CborItem<'a>>;

/// Reads items in sequence. Methods return `None` if the bytes are not valid CBOR, end too early,
/// or nest too deeply.
#[derive(Clone, Debug)]
pub(super) struct CborReader<'a>(&'a [u8]);

impl<'a> CborReader<'a> {
    /// Creates a reader at the start of `bytes`.
    pub(super) const fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// Returns the bytes that have not been read.
    pub(super) const fn rest(&self) -> &'a [u8] {
        self.0
    }

    /// Reads a map with integer and text keys. A duplicate key is an error.
    pub(super) fn map(&mut self) -> Option<CborMap<'a>> {
        let (5, entries) = self.head()? else { return None };
        let mut map = CborMap::new();
        for _ in 0..entries {
            let key = self.item(0)?;
            let is_label = matches!(key, CborItem::Integer(_) | CborItem::Text(_));
            if !is_label || map.insert(key, self.item(DEEPEST - 1)?).is_some() {
                return None;
            }
        }
        Some(map)
    }

    /// Reads an item that may contain up to `levels` levels of containers.
    fn item(&mut self, levels: usize) -> Option<CborItem<'a>> {
        let (kind, value) = self.head()?;
        Some(match kind {
            0 => CborItem::Integer(i64::try_from(value).ok()?),
            1 => CborItem::Integer(-1 - i64::try_from(value).ok()?),
            2 => CborItem::Bytes(self.take(value)?),
            3 => CborItem::Text(std::str::from_utf8(self.take(value)?).ok()?),
            4 => self.items(value, levels)?,
            5 => self.items(value.checked_mul(2)?, levels)?,
            6 => self.items(1, levels)?,
            _ => CborItem::Other,
        })
    }

    /// Reads the items of an array or a map. A wrong count ends at the end of the input, since each
    /// item takes at least one byte.
    fn items(&mut self, count: u64, levels: usize) -> Option<CborItem<'a>> {
        let levels = levels.checked_sub(1)?;
        (0..count).try_for_each(|_| self.item(levels).map(drop)).map(|()| CborItem::Other)
    }

    /// Reads the head of an item: its major type and its argument, which is a value, a count or a
    /// length.
    fn head(&mut self) -> Option<(u8, u64)> {
        let first = *self.take(1)?.first()?;
        let value = match first & 0x1f {
            small @ 0..24 => u64::from(small),
            size @ 24..28 => self.take(1 << (size - 24))?.iter().fold(0, |value, byte| (value << 8) | u64::from(*byte)),
            // Reserved, or an item of indefinite length.
            _ => return None,
        };
        Some((first >> 5, value))
    }

    fn take(&mut self, count: u64) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(usize::try_from(count).ok()?)?;
        self.0 = rest;
        Some(taken)
    }
}

#[cfg(test)]
mod tests {
    //! The input is untrusted: malformed input (RFC 8949) must be rejected, and a short input must
    //! not cost much time or memory.

    use super::*;

    fn map(bytes: &[u8]) -> Option<CborMap<'_>> {
        let mut reader = CborReader::new(bytes);
        reader.map().filter(|_| reader.rest().is_empty())
    }

    #[test]
    fn a_map_is_read_by_its_keys() {
        // {1: 2, -257: h'0102', "fmt": "none", 24: [1.5, {"a": null}]}
        let bytes = b"\xa4\x01\x02\x39\x01\x00\x42\x01\x02\x63fmt\x64none\x18\x18\x82\xf9\x3e\x00\xa1\x61a\xf6";
        let expected = [
            (CborItem::Integer(1), CborItem::Integer(2)),
            (CborItem::Integer(-257), CborItem::Bytes(&[1, 2])),
            (CborItem::Text("fmt"), CborItem::Text("none")),
            (CborItem::Integer(24), CborItem::Other),
        ];
        assert_eq!(map(bytes), Some(expected.into()));
        for length in 0..bytes.len() {
            assert_eq!(map(&bytes[..length]), None, "the first {length} bytes");
        }
    }

    #[test]
    fn what_is_no_such_map_is_refused() {
        for (why, bytes) in [
            ("no map", b"\x80".as_slice()),
            ("a key twice", b"\xa2\x01\x02\x01\x03"),
            ("a key that is a map", b"\xa1\xa0\x01"),
            ("a key of bytes", b"\xa1\x41\x01\x01"),
            ("an indefinite length", b"\xbf\x01\x02\xff"),
            ("a reserved length", b"\xa1\x01\x1c"),
            ("a text that is not UTF-8", b"\xa1\x61\xff\x01"),
            ("a number beyond 63 bits", b"\xa1\x01\x1b\xff\xff\xff\xff\xff\xff\xff\xff"),
            ("bytes beyond the end", b"\xa1\x01\x5b\xff\xff\xff\xff\xff\xff\xff\xff\x00"),
            ("items beyond the end", b"\xa1\x01\x9b\xff\xff\xff\xff\xff\xff\xff\xff\x00"),
            ("pairs beyond any number", b"\xa1\x01\xbb\xff\xff\xff\xff\xff\xff\xff\xff\x00"),
            ("bytes after it", b"\xa0\x00"),
        ] {
            assert_eq!(map(bytes), None, "{why}");
        }
    }

    #[test]
    fn a_deep_item_ends_at_a_limit() {
        let nested = |levels: usize, open: &[u8]| [b"\xa1\x01".as_slice(), &open.repeat(levels), b"\x00"].concat();
        for open in [b"\x81".as_slice(), b"\xa1\x00", b"\xc1"] {
            assert!(map(&nested(DEEPEST - 1, open)).is_some());
            assert_eq!(map(&nested(DEEPEST, open)), None);
            assert_eq!(map(&nested(1_000_000, open)), None);
        }
    }
}
