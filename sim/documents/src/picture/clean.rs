//! Sanitised copies of uploaded pictures: pixels only, in a size allowed in a briefing.

use std::io::Cursor;

use image::codecs::jpeg::JpegEncoder;
use image::{DynamicImage, ImageError, ImageFormat, Rgb, RgbImage};
use phrase::{Phrase, phrase};

use super::{MOST_BYTES, PictureKind, decode_within, shrink_to_side};

/// Largest upload, in bytes; enough for a photo taken with a telephone.
pub const MOST_SENT_BYTES: usize = 12 * 1024 * 1024;
/// Largest upload, in pixels.
const MOST_SENT_PIXELS: u64 = 25_000_000;
/// Maximum side lengths of the copy, in pixels, in order of preference.
const SIDES: [u32; 3] = [2000, 1400, 900];
/// Maximum side length of a logo, in pixels; also sharp in print.
const LOGO_SIDE: u32 = 480;
/// JPEG qualities, of 100, in order of preference.
const QUALITIES: [u8; 2] = [88, 70];

/// A copy of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PictureCopy {
    /// File format.
    pub kind: PictureKind,
    /// Width and height, in pixels.
    pub size: [u32; 2],
    /// Content.
    pub bytes: Vec<u8>,
}

/// Copies the pixels of a picture, upright, without metadata (Exif can contain place, time and
/// author). Scales the copy down if it is larger than a briefing's picture may be. May take long.
///
/// # Errors
/// The reason for refusing the picture, in words.
pub fn copy_picture(bytes: &[u8]) -> Result<PictureCopy, Phrase> {
    copy_to_sides(bytes, &SIDES)
}

/// Copies a logo as [`copy_picture`] does, at the size that a page header needs.
///
/// # Errors
/// The reason for refusing the picture, in words.
pub fn copy_logo(bytes: &[u8]) -> Result<PictureCopy, Phrase> {
    copy_to_sides(bytes, &[LOGO_SIDE])
}

fn copy_to_sides(bytes: &[u8], sides: &[u32]) -> Result<PictureCopy, Phrase> {
    let kind = PictureKind::of_bytes(bytes).ok_or_else(|| {
        phrase!("this is neither PNG nor JPEG; some telephones take HEIC pictures, which must be saved as JPEG first")
    })?;
    let mut picture = decode_within(kind, bytes, MOST_SENT_PIXELS).map_err(|why| {
        phrase!(
            "{why}; allowed: a complete PNG or JPEG picture of at most {pixels} pixels",
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
    Err(phrase!("a picture that cannot be made small enough; send a smaller one"))
}

/// Encodes a picture; `None` if the file would be too large.
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

/// Converts to 8 bits per channel.
fn plain_depth(picture: &DynamicImage) -> DynamicImage {
    match (picture.color().has_alpha(), picture.color().has_color()) {
        (true, _) => picture.to_rgba8().into(),
        (false, true) => picture.to_rgb8().into(),
        (false, false) => picture.to_luma8().into(),
    }
}

/// Blends a transparent picture with a white background.
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
