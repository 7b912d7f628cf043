//! Pictures of a briefing: read where they are what they say, refused with their row where they are not, and no part of what is judged.
//!
//! Would fail if a file that harms whoever opens it were taken for a picture, if a photograph told where it was taken, or if a picture changed a
//! score.

use std::io::Cursor;

use documents::load::Document;
use documents::picture::{MOST_PICTURES, PictureKind, copy_picture, decode_picture};
use documents::{DocumentError, ExerciseBundle};
use image::{DynamicImage, ImageFormat, Rgb, RgbImage};
use tempfile::TempDir;

use crate::support::{EXERCISE, folder, read_text, write};

/// A picture with a light and a dark half, left and right.
fn halves(width: u32, height: u32, format: ImageFormat) -> Vec<u8> {
    let pixel = |x, _| if 2 * x < width { Rgb([250, 250, 250]) } else { Rgb([20, 40, 60]) };
    let mut file = Cursor::new(Vec::new());
    DynamicImage::from(RgbImage::from_fn(width, height, pixel)).write_to(&mut file, format).unwrap();
    file.into_inner()
}

/// A picture in which no pixel tells of its neighbours.
fn noise(side: u32) -> Vec<u8> {
    let mut state = 1_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    let mut file = Cursor::new(Vec::new());
    let pixels = RgbImage::from_fn(side, side, |_, _| Rgb([next(), next(), next()]));
    DynamicImage::from(pixels).write_to(&mut file, ImageFormat::Png).unwrap();
    file.into_inner()
}

/// A chunk of a PNG.
fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let crc = kind.iter().chain(data).fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 })
    });
    [&(data.len() as u32).to_be_bytes()[..], kind, data, &(!crc).to_be_bytes()].concat()
}

/// A PNG with another chunk behind its header.
fn with_chunk(png: &[u8], kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    [&png[..33], &chunk(kind, data), &png[33..]].concat()
}

/// A JPEG with Exif that says how it is to be turned, and where it was taken.
fn with_exif(jpeg: &[u8], orientation: u8) -> Vec<u8> {
    let entry = |tag: u8, value: u8| [1, tag, 0, 3, 0, 0, 0, 1, 0, value, 0, 0];
    let mut tiff = b"MM\0\x2a\0\0\0\x08\0\x01".to_vec();
    tiff.extend(entry(0x12, orientation));
    tiff.extend(b"\0\0\0\0Ward 3, Frau Beispiel");
    let length = (8 + tiff.len() as u16).to_be_bytes();
    [&jpeg[..2], &[0xff, 0xe1], &length, b"Exif\0\0", &tiff, &jpeg[2..]].concat()
}

fn png() -> Vec<u8> {
    halves(40, 20, ImageFormat::Png)
}

fn jpeg() -> Vec<u8> {
    halves(40, 20, ImageFormat::Jpeg)
}

/// The exercise with rows behind it.
fn with_rows(rows: &str) -> String {
    format!("{EXERCISE}\n{rows}")
}

/// The row of a picture.
fn row(file: &str) -> String {
    format!("[[picture]]\nfile = \"{file}\"\nalt = \"A half\"\n\n")
}

fn read(folder: &TempDir, rows: &str) -> Result<ExerciseBundle, DocumentError> {
    match read_text(folder, &with_rows(rows))? {
        Document::Exercise(bundle) => Ok(*bundle),
        other => panic!("not an exercise: {other:?}"),
    }
}

/// What is said of a file that an exercise names.
fn refusal(name: &str, bytes: &[u8]) -> String {
    let folder = folder();
    write(&folder, name, bytes);
    read(&folder, &row(name)).expect_err(name).to_string()
}

#[test]
fn pictures_are_read_in_order_with_their_texts() {
    let folder = folder();
    write(&folder, "a.png", png());
    write(&folder, "B-2.jpg", jpeg());
    let rows = row("B-2.jpg") + &row("a.png") + "caption = { en = \"Below\", de = \"Darunter\" }\n";
    let text = with_rows(&rows).replace("title = \"One\"", "title = \"One\"\nlanguages = [\"en\", \"de\"]");
    let Document::Exercise(bundle) = read_text(&folder, &text).unwrap() else { panic!("an exercise") };
    let files: Vec<_> = bundle.pictures.iter().map(|picture| (picture.name.as_str(), picture.size)).collect();
    assert_eq!(files, [("B-2.jpg", [40, 20]), ("a.png", [40, 20])]);
    assert_eq!(bundle.pictures[1].bytes, png(), "byte for byte");
    let [first, second] = bundle.exercise.pictures.as_slice() else { panic!("two") };
    assert_eq!((first.alt.own(), &first.caption), ("A half", &None));
    assert_eq!(second.caption.as_ref().unwrap().in_language("de"), "Darunter");
}

#[test]
fn invalid_picture_row_is_rejected_at_its_place() {
    let folder = folder();
    write(&folder, "a.png", png());
    let said = |rows: &str| read(&folder, rows).expect_err(rows).to_string();
    for (rows, parts) in [
        ("[[picture]]\nfile = \"a.png\"\n".to_owned(), ["picture[0].alt: missing", "1 to 300 characters"]),
        (row("a.png") + &row("a.png"), ["picture[1].file: \"a.png\"", "picture[0] already has it"]),
        (row("b.png"), ["picture[0].file: \"b.png\": ", "in the folder of the document"]),
        (row("a.gif"), ["picture[0].file: \"a.gif\"", "ends in .png or .jpg"]),
        (row("a.PNG"), ["picture[0].file: \"a.PNG\"", "in lower case"]),
        (row("../a.png"), ["picture[0].file: \"../a.png\"", "letters, digits, dots"]),
        (row("/etc/a.png"), ["picture[0].file: \"/etc/a.png\"", "letters, digits, dots"]),
        (row("a.png") + "title = \"x\"\n", ["picture[0].title: unknown key", "did you mean"]),
        ((0..=MOST_PICTURES).map(|n| row(&format!("p{n}.png"))).collect(), ["picture: 7 tables", "0 to 6 tables"]),
        (row("a.png").replace("\"A half\"", "{ en = \"x\" }"), ["picture[0].alt: a text in several", "no languages"]),
    ] {
        let said = said(&rows);
        assert!(parts.iter().all(|part| said.contains(part)), "{parts:?} is not said by {said}");
    }
}

#[test]
fn a_file_that_is_not_the_picture_its_name_says_is_refused() {
    let (png, jpeg) = (png(), jpeg());
    let tail = [png.as_slice(), b"PK\x03\x04<script>alert(1)</script>"].concat();
    let jpeg_tail = [jpeg.as_slice(), b"PK\x03\x04", &[0xff, 0xd9]].concat();
    let broken = [&png[..60], &[0; 8], &png[68..]].concat();
    let xmp = with_chunk(&png, b"iTXt", b"XML:com.adobe.xmp\0\0\0\0\0<x/>");
    for (name, bytes, found) in [
        ("a.png", jpeg.as_slice(), "a JPEG picture with another file extension"),
        ("a.jpg", png.as_slice(), "a PNG picture with another file extension"),
        ("a.png", b"<svg xmlns=\"http://www.w3.org/2000/svg\"><script/></svg>", "neither PNG nor JPEG"),
        ("a.png", b"", "neither PNG nor JPEG"),
        ("a.jpg", b"GIF89a............", "neither PNG nor JPEG"),
        ("a.png", &png[..png.len() - 20], "a truncated picture"),
        ("a.png", &png[..8], "a truncated picture"),
        ("a.jpg", &jpeg[..jpeg.len() / 2], "a truncated picture"),
        ("a.jpg", &jpeg[..jpeg.len() - 2], "a truncated picture"),
        ("a.png", &tail, "29 bytes after its end"),
        ("a.jpg", &jpeg_tail, "6 bytes after its end"),
        ("a.png", &broken, "unreadable as PNG"),
        ("a.jpg", &with_exif(&jpeg, 6), "Exif, which can contain names of people and places"),
        ("a.png", &with_chunk(&png, b"eXIf", b"MM\0\x2a"), "Exif, which can contain names of people and places"),
        ("a.png", &xmp, "XMP, which can contain names of people and places"),
        ("a.png", &with_chunk(&png, b"acTL", &[0, 0, 0, 1, 0, 0, 0, 0]), "an animated picture"),
        ("a.png", &noise(700), " bytes"),
    ] {
        let said = refusal(name, bytes);
        let is_said = said.contains(found) || found.ends_with(" bytes") && said.contains(" bytes; allowed");
        assert!(is_said && said.contains("picture[0].file: \"a."), "{found:?} is not said by {said}");
        assert!(said.contains("at most 1048576 bytes and 4000000 pixels"), "{said}");
    }
}

#[test]
fn oversized_picture_is_rejected_before_it_allocates() {
    let mut header = 60_000_u32.to_be_bytes().repeat(2);
    header.extend([8, 2, 0, 0, 0]);
    let parts = [chunk(b"IHDR", &header), chunk(b"IDAT", b"\x78\x9c\x03\0\0\0\0\x01"), chunk(b"IEND", b"")];
    let bomb = [&png()[..8], &parts.concat()].concat();
    assert!(refusal("a.png", &bomb).contains("60000 × 60000 pixels"), "{}", refusal("a.png", &bomb));
    let mut wide = jpeg();
    let frame = wide.windows(2).position(|pair| pair == [0xff, 0xc0]).expect("its size");
    wide[frame + 5..frame + 9].copy_from_slice(&[0xff; 4]);
    assert!(refusal("a.jpg", &wide).contains("65535 × 65535 pixels"), "{}", refusal("a.jpg", &wide));
    assert!(copy_picture(&bomb).unwrap_err().to_string().contains("60000 × 60000 pixels"));
    let just_too_many = refusal("a.png", &halves(2001, 2000, ImageFormat::Png));
    assert!(just_too_many.contains("2001 × 2000 pixels"), "{just_too_many}");
}

#[test]
fn what_a_picture_shows_decides_nothing() {
    let folder = folder();
    write(&folder, "a.png", png());
    let (plain, shown) = (read(&folder, "").unwrap(), read(&folder, &row("a.png")).unwrap());
    assert_eq!(plain.exercise.rubric_sha256(), shown.exercise.rubric_sha256());
    write(&folder, "a.png", halves(40, 22, ImageFormat::Png));
    let other = read(&folder, &row("a.png")).unwrap();
    assert_eq!(other.exercise, shown.exercise);
    assert_ne!(other.pictures, shown.pictures);
}

#[test]
fn exercise_is_rebuilt_without_pictures_and_accepts_them_later() {
    let folder = folder();
    write(&folder, "a.png", png());
    let bundle = read(&folder, &row("a.png")).unwrap();
    let judged = ExerciseBundle::from_parts(&bundle.exercise_bytes, &bundle.scene_bytes, &[]).unwrap();
    assert!(judged.pictures.is_empty() && judged.exercise == bundle.exercise);
    assert_eq!(judged.clone().with_pictures(&[("a.png".to_owned(), png())]).unwrap(), bundle);
    let said = judged.clone().with_pictures(&[]).unwrap_err().to_string();
    assert!(said.contains(":14:8: picture[0].file: \"a.png\": not attached; allowed"), "{said}");
    assert!(judged.clone().with_pictures(&[("a.png".to_owned(), jpeg())]).is_err());
    assert_eq!(judged.list_missing_pictures(&["b.png".to_owned()])[0].field, "picture[0].file");
    assert!(judged.list_missing_pictures(&["a.png".to_owned()]).is_empty());
}

#[test]
fn a_copy_stands_upright_and_tells_nothing_but_its_pixels() {
    let photograph = with_exif(&jpeg(), 6);
    let copy = copy_picture(&photograph).unwrap();
    assert_eq!((copy.kind, copy.size), (PictureKind::Jpeg, [20, 40]), "turned a quarter");
    for told in [&b"Exif"[..], b"Beispiel"] {
        assert!(!copy.bytes.windows(told.len()).any(|part| part == told), "{told:?}");
    }
    let pixels = decode_picture(&copy.bytes, 4000).unwrap();
    assert!(pixels.rgba[0] > 200 && pixels.rgba[pixels.rgba.len() - 4] < 60, "the light half is above");
    let told = with_chunk(&png(), b"tEXt", b"Author\0Frau Beispiel");
    let copy = copy_picture(&[told.as_slice(), b"PK\x03\x04"].concat()).unwrap();
    assert_eq!((copy.kind, copy.bytes.windows(8).any(|part| part == b"Beispiel")), (PictureKind::Png, false));
    assert_eq!(decode_picture(&copy.bytes, 10).unwrap().size, [10, 5], "as small as is asked for");
}

#[test]
fn a_copy_of_a_large_picture_is_one_that_an_exercise_may_have() {
    for large in [halves(3000, 1500, ImageFormat::Jpeg), noise(1100)] {
        let copy = copy_picture(&large).unwrap();
        let name = format!("a.{}", copy.kind.ending());
        let folder = folder();
        write(&folder, &name, &copy.bytes);
        let bundle = read(&folder, &row(&name)).unwrap();
        assert_eq!(bundle.pictures[0].size, copy.size);
    }
    let refused = copy_picture(b"\0\0\0\x18ftypheic").unwrap_err().to_string();
    assert!(refused.contains("HEIC"), "{refused}");
    assert!(copy_picture(&halves(6000, 5000, ImageFormat::Png)).unwrap_err().to_string().contains("6000 × 5000"));
    assert!(copy_picture(b"").is_err());
}
