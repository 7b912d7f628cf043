//! A copy of a picture that somebody sends: its pixels alone, in a size that a briefing may have.

use std::io::Cursor;

use image::codecs::jpeg::JpegEncoder;
use image::{DynamicImage, ImageError, ImageFormat, Rgb, RgbImage};
use phrase::{Phrase, phrase};

use super::{MOST_BYTES, PictureKind, decode_within, shrink_to_side};

/// Most bytes of a picture that is sent: what a telephone takes fits.
pub const MOST_SENT_BYTES: usize = 12 * 1024 * 1024;
/// Most pixels of a picture that is sent.
const MOST_SENT_PIXELS: u64 = 25_000_000;
/// How long a side of the copy may be, in pixels, from the best to the least.
const SIDES: [u32; 3] = [2000, 1400, 900];
/// How long a side of a logo may be, in pixels: sharp on paper, too.
const LOGO_SIDE: u32 = 480;
/// How good a JPEG is, of 100.
const QUALITIES: [u8; 2] = [88, 70];

/// A copy of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PictureCopy {
    /// What it is.
    pub kind: PictureKind,
    /// Width and height, in pixels.
    pub size: [u32; 2],
    /// What is in it.
    pub bytes: Vec<u8>,
}

/// Copies the pixels of a picture, upright, and nothing else: not where, when and by whom it was taken, which Exif can tell. Made smaller
/// where it is larger than a picture of a briefing may be. May take long.
///
/// # Errors
/// What is wrong with it, in words.
pub fn copy_picture(bytes: &[u8]) -> Result<PictureCopy, Phrase> {
    copy_to_sides(bytes, &SIDES)
}

/// Copies a logo as [`copy_picture`] does, no larger than the head of a page needs it.
///
/// # Errors
/// What is wrong with it, in words.
pub fn copy_logo(bytes: &[u8]) -> Result<PictureCopy, Phrase> {
    copy_to_sides(bytes, &[LOGO_SIDE])
}

fn copy_to_sides(bytes: &[u8], sides: &[u32]) -> Result<PictureCopy, Phrase> {
    let kind = PictureKind::of_bytes(bytes).ok_or_else(|| {
        phrase!("this is neither PNG nor JPEG; some telephones take HEIC pictures, which must be saved as JPEG first")
    })?;
    let mut picture = decode_within(kind, bytes, MOST_SENT_PIXELS).map_err(|why| {
        phrase!(
            "{why}; allowed: a whole PNG or JPEG picture of at most {pixels} pixels",
            why = why,
            pixels = MOST_SENT_PIXELS
        )
    })?;
    for side in sides {
        picture = shrink_to_side(picture, *side);
        if let Some(copy) = encode_within(kind, &picture).map_err(Phrase::data)? {
            return Ok(copy);
        }
    }
    Err(phrase!("a picture that does not become small enough; send a smaller one"))
}

/// The picture in a file that is small enough; nothing where there is none.
fn encode_within(kind: PictureKind, picture: &DynamicImage) -> Result<Option<PictureCopy>, ImageError> {
    let size = [picture.width(), picture.height()];
    if kind == PictureKind::Png {
        let mut file = Cursor::new(Vec::new());
        plain_depth(picture).write_to(&mut file, ImageFormat::Png)?;
        let bytes = file.into_inner();
        if bytes.len() <= MOST_BYTES {
            return Ok(Some(PictureCopy { kind, size, bytes }));
        }
    }
    let opaque = lay_on_white(picture);
    for quality in QUALITIES {
        let mut bytes = Vec::new();
        JpegEncoder::new_with_quality(&mut bytes, quality).encode_image(&opaque)?;
        if bytes.len() <= MOST_BYTES {
            return Ok(Some(PictureCopy { kind: PictureKind::Jpeg, size, bytes }));
        }
    }
    Ok(None)
}

/// The picture with a byte for each of its colours.
fn plain_depth(picture: &DynamicImage) -> DynamicImage {
    match (picture.color().has_alpha(), picture.color().has_color()) {
        (true, _) => picture.to_rgba8().into(),
        (false, true) => picture.to_rgb8().into(),
        (false, false) => picture.to_luma8().into(),
    }
}

/// The picture on white paper, where it can be seen through.
fn lay_on_white(picture: &DynamicImage) -> RgbImage {
    if !picture.color().has_alpha() {
        return picture.to_rgb8();
    }
    let seen_through = picture.to_rgba8();
    RgbImage::from_fn(seen_through.width(), seen_through.height(), |x, y| {
        let [red, green, blue, opaque] = seen_through.get_pixel(x, y).0.map(u16::from);
        // At most 255: each is a mean of two bytes.
        Rgb([red, green, blue].map(|colour| ((colour * opaque + 255 * (255 - opaque)) / 255) as u8))
    })
}
