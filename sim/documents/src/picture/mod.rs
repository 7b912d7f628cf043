//! Pictures of a briefing: file requirements, decoding, and sanitised copies without metadata.

mod clean;
mod marks;

use std::io::Cursor;

pub use clean::{MOST_SENT_BYTES, PictureCopy, copy_logo, copy_picture};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use phrase::{Phrase, phrase};

/// Maximum number of pictures of an exercise.
pub const MOST_PICTURES: usize = 6;
/// Maximum file size, in bytes.
pub const MOST_BYTES: usize = 1024 * 1024;
/// Maximum number of pixels.
pub const MOST_PIXELS: u64 = 4_000_000;
/// Maximum memory for decoding a picture, in bytes.
const MOST_MEMORY: u64 = 256 * 1024 * 1024;

/// Supported file formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureKind {
    /// PNG.
    Png,
    /// JPEG.
    Jpeg,
}

/// A picture of a briefing, verified by decoding it completely.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PictureFile {
    /// File name as the exercise gives it.
    pub name: String,
    /// Width and height, in pixels.
    pub size: [u32; 2],
    /// Content, byte for byte.
    pub bytes: Vec<u8>,
}

/// The pixels of a picture, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PicturePixels {
    /// Width and height, in pixels.
    pub size: [u32; 2],
    /// Red, green, blue and alpha, one byte each.
    pub rgba: Vec<u8>,
}

impl PictureKind {
    /// Returns the format for a file name's extension.
    #[must_use]
    pub fn of_name(name: &str) -> Option<Self> {
        match name.rsplit_once('.')?.1 {
            "png" => Some(Self::Png),
            "jpg" => Some(Self::Jpeg),
            _ => None,
        }
    }

    /// Returns the format for a file's first bytes.
    #[must_use]
    pub fn of_bytes(bytes: &[u8]) -> Option<Self> {
        if bytes.starts_with(marks::PNG_SIGNATURE) {
            Some(Self::Png)
        } else if bytes.starts_with(&[0xff, 0xd8, 0xff]) {
            Some(Self::Jpeg)
        } else {
            None
        }
    }

    /// Returns the file name extension.
    #[must_use]
    pub const fn ending(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Jpeg => "jpg",
        }
    }

    /// Returns the media type.
    #[must_use]
    pub const fn media_type(self) -> &'static str {
        match self {
            Self::Png => "image/png",
            Self::Jpeg => "image/jpeg",
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
        }
    }

    const fn format(self) -> ImageFormat {
        match self {
            Self::Png => ImageFormat::Png,
            Self::Jpeg => ImageFormat::Jpeg,
        }
    }
}

/// Describes the requirements on a picture.
pub(crate) fn allowed_picture() -> Phrase {
    phrase!(
        "allowed: a PNG (.png) or JPEG (.jpg) picture in the folder of the document, at most {bytes} bytes and \
         {pixels} pixels, without Exif or XMP, and nothing after its end",
        bytes = MOST_BYTES,
        pixels = MOST_PIXELS
    )
}

/// Describes the requirements on a picture's name.
pub(crate) fn allowed_name() -> Phrase {
    phrase!("allowed: a name that ends in .png or .jpg, in lower case")
}

/// Reads a picture and decodes it completely.
///
/// # Errors
/// The reason for refusing the picture, in words.
pub(crate) fn read_picture(name: &str, bytes: Vec<u8>) -> Result<PictureFile, Phrase> {
    if bytes.len() > MOST_BYTES {
        return Err(phrase!("{count} bytes", count = bytes.len()));
    }
    let kind =
        PictureKind::of_bytes(&bytes).ok_or_else(|| phrase!("neither PNG nor JPEG, despite its file extension"))?;
    if PictureKind::of_name(name) != Some(kind) {
        return Err(phrase!("a {kind} picture with another file extension", kind = kind.name()));
    }
    marks::check_marks(kind, &bytes)?;
    let decoded = decode_within(kind, &bytes, MOST_PIXELS)?;
    Ok(PictureFile { name: name.to_owned(), size: [decoded.width(), decoded.height()], bytes })
}

/// Decodes a picture that was read before; scales it down if a side is longer than `most_side`
/// pixels.
///
/// # Errors
/// The reason for refusing the picture, in words.
pub fn decode_picture(bytes: &[u8], most_side: u32) -> Result<PicturePixels, Phrase> {
    let kind =
        PictureKind::of_bytes(bytes).ok_or_else(|| phrase!("neither PNG nor JPEG, despite its file extension"))?;
    let decoded = shrink_to_side(decode_within(kind, bytes, MOST_PIXELS)?, most_side).into_rgba8();
    Ok(PicturePixels { size: [decoded.width(), decoded.height()], rgba: decoded.into_raw() })
}

/// Scales a picture down if a side is longer than `most_side` pixels.
fn shrink_to_side(picture: DynamicImage, most_side: u32) -> DynamicImage {
    if picture.width().max(picture.height()) > most_side { picture.thumbnail(most_side, most_side) } else { picture }
}

/// Decodes a picture of at most `most_pixels` pixels and applies its orientation. Reads the size
/// from the header before allocating memory for the pixels.
fn decode_within(kind: PictureKind, bytes: &[u8], most_pixels: u64) -> Result<DynamicImage, Phrase> {
    let unreadable =
        |why: image::ImageError| phrase!("unreadable as {kind} ({why})", kind = kind.name(), why = Phrase::data(why));
    let mut limits = Limits::default();
    limits.max_alloc = Some(MOST_MEMORY);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), kind.format());
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(unreadable)?;
    let (width, height) = decoder.dimensions();
    if u64::from(width) * u64::from(height) > most_pixels {
        return Err(phrase!("{width} × {height} pixels", width = u64::from(width), height = u64::from(height)));
    }
    let orientation = decoder.orientation().map_err(unreadable)?;
    let mut picture = DynamicImage::from_decoder(decoder).map_err(unreadable)?;
    picture.apply_orientation(orientation);
    Ok(picture)
}
