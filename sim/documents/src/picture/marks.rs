//! File structure of pictures: the end of the file and its metadata.
//!
//! A decoder stops at the last pixel and skips unknown segments. Data after the end would be
//! distributed with the picture unnoticed: another document, or a location.

use phrase::{Phrase, phrase};

use super::PictureKind;

/// The first bytes of every PNG.
pub(super) const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Checks that a file is exactly one complete, unanimated picture without location metadata.
///
/// # Errors
/// The reason for refusing the picture, in words.
pub(super) fn check_marks(kind: PictureKind, bytes: &[u8]) -> Result<(), Phrase> {
    let end = match kind {
        PictureKind::Png => walk_png(bytes)?,
        PictureKind::Jpeg => walk_jpeg(bytes)?,
    };
    match bytes.len() - end {
        0 => Ok(()),
        behind => Err(phrase!("{count} bytes after its end", count = behind)),
    }
}

fn cut_short() -> Phrase {
    phrase!("a truncated picture")
}

fn told_metadata(what: &str) -> Phrase {
    phrase!("{what}, which can contain names of people and places", what = what)
}

/// Returns `count` bytes from the offset `from`.
fn take(bytes: &[u8], from: usize, count: usize) -> Result<&[u8], Phrase> {
    from.checked_add(count).and_then(|end| bytes.get(from..end)).ok_or_else(cut_short)
}

/// Returns the end of a PNG, after its IEND chunk.
fn walk_png(bytes: &[u8]) -> Result<usize, Phrase> {
    let mut at = PNG_SIGNATURE.len();
    loop {
        let head = take(bytes, at, 8)?;
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let data = take(bytes, at + 8, length)?;
        // A four-byte checksum follows the data of a chunk.
        let end = at + 8 + take(bytes, at + 8, length + 4)?.len();
        match &head[4..] {
            b"IEND" => return Ok(end),
            b"eXIf" => return Err(told_metadata("Exif")),
            b"iTXt" if data.starts_with(b"XML:com.adobe.xmp\0") => return Err(told_metadata("XMP")),
            b"acTL" => return Err(phrase!("an animated picture")),
            _ => at = end,
        }
    }
}

/// Returns the end of a JPEG, after its EOI marker.
fn walk_jpeg(bytes: &[u8]) -> Result<usize, Phrase> {
    const SCAN: u8 = 0xda;
    let mut at = 2;
    loop {
        if take(bytes, at, 1)? != [0xff] {
            return Err(phrase!("a JPEG picture with gaps between its segments"));
        }
        let marker = take(bytes, at + 1, 1)?[0];
        at += match marker {
            // Any number of fill bytes may precede a marker.
            0xff => 1,
            0xd9 => return Ok(at + 2),
            0x01 | 0xd0..=0xd7 => 2,
            _ => {
                let length = take(bytes, at + 2, 2)?;
                let length = usize::from(u16::from_be_bytes([length[0], length[1]]));
                let data = take(bytes, at + 2, length)?;
                if marker == 0xe1 {
                    return Err(told_metadata(if data[2..].starts_with(b"Exif\0") { "Exif" } else { "XMP" }));
                }
                2 + length + if marker == SCAN { count_scanned(&bytes[at + 2 + length..]) } else { 0 }
            }
        };
    }
}

/// Returns the number of bytes of entropy-coded data before the next marker. Within the data, 0xff
/// is followed by 0 or belongs to a restart marker.
fn count_scanned(bytes: &[u8]) -> usize {
    let is_marker = |pair: &[u8]| pair[0] == 0xff && !matches!(pair[1], 0 | 0xd0..=0xd7);
    bytes.windows(2).position(is_marker).unwrap_or(bytes.len())
}
