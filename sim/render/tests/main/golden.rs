//! Small pictures of every view against those committed beside this file, by what an eye would notice.
//!
//! It would fail on a material, a light or a shape that changed; and must not fail on another driver's rounding. To accept a
//! change, look at the pictures in `target/tmp/golden`, and copy them.

use std::path::{Path, PathBuf};

use image::RgbaImage;
use render::frame::{Frame, View};

use crate::painter::picture;
use crate::specimen::{at_depth, inside, stage, tenting};

const SIZE: [u32; 2] = [320, 180];
/// Pixels a side of what an eye takes in at once here.
const PATCH: u32 = 8;
/// Mean difference of all patches, and of the worst: shares of the range from black to white. Vulkan and GL differ by less than a
/// tenth of it; a tent of 3 mm, the smallest thing to be noticed, by more.
const MEAN: f32 = 0.006;
const WORST: f32 = 0.05;

/// Mean colour of every patch: luma, and two differences of colour at half the weight.
fn patches(picture: &RgbaImage) -> Vec<[f32; 3]> {
    let (columns, rows) = (picture.width() / PATCH, picture.height() / PATCH);
    let patch = |at: u32| {
        let (left, top) = (at % columns * PATCH, at / columns * PATCH);
        let mut sum = [0.0; 3];
        for (x, y) in (0..PATCH * PATCH).map(|i| (left + i % PATCH, top + i / PATCH)) {
            let [r, g, b] = [0, 1, 2].map(|channel| f32::from(picture.get_pixel(x, y).0[channel]) / 255.0);
            let luma = 0.2126 * r + 0.7152 * g + 0.0722 * b;
            [luma, 0.5 * (r - luma), 0.5 * (b - luma)].iter().zip(&mut sum).for_each(|(part, sum)| *sum += part);
        }
        sum.map(|sum| sum / (PATCH * PATCH) as f32)
    };
    (0..columns * rows).map(patch).collect()
}

/// Mean and largest difference of two pictures' patches.
fn difference(a: &RgbaImage, b: &RgbaImage) -> (f32, f32) {
    let pairs = patches(a).into_iter().zip(patches(b));
    let apart: Vec<f32> =
        pairs.map(|(a, b)| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt()).collect();
    (apart.iter().sum::<f32>() / apart.len() as f32, apart.iter().copied().fold(0.0, f32::max))
}

fn frames() -> [(&'static str, Frame); 4] {
    let faded = Frame { fade: 0.8, guide: true, ..inside(at_depth(0.026), 4, 0.8) };
    [
        ("whole", tenting(3, 0.0125, 0.5)),
        ("tip", Frame { view: View::Tip, ..tenting(0, 0.0029, 0.0) }),
        ("section", Frame { view: View::Section, guide: true, ..tenting(3, 0.0125, 0.5) }),
        ("faded", faded),
    ]
}

fn committed(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/main/golden/{name}.png"))
}

#[test]
fn every_view_looks_as_it_did() {
    let drawn_to = Path::new(env!("CARGO_TARGET_TMPDIR")).join("golden");
    std::fs::create_dir_all(&drawn_to).expect("a folder");
    let mut differ = Vec::new();
    for (name, frame) in frames() {
        let drawn = picture(&stage(), &frame, SIZE);
        let copy = drawn_to.join(format!("{name}.png"));
        drawn.save(&copy).expect("a picture written");
        let golden =
            image::open(committed(name)).map_or_else(|_| RgbaImage::new(SIZE[0], SIZE[1]), |golden| golden.to_rgba8());
        let (mean, worst) = difference(&drawn, &golden);
        if mean > MEAN || worst > WORST {
            differ.push(format!("{name}: mean {mean}, worst {worst}; look at {}", copy.display()));
        }
    }
    assert!(differ.is_empty(), "{}", differ.join("\n"));
}

#[test]
fn the_measure_notices_a_tent_and_passes_over_rounding() {
    let close = |frame: Frame| picture(&stage(), &Frame { view: View::Tip, ..frame }, SIZE);
    let tent = close(tenting(0, 0.0029, 0.0));
    let shallower = close(tenting(0, 0.0019, 0.0));
    let (mean, worst) = difference(&tent, &shallower);
    assert!(mean > MEAN || worst > WORST, "a millimetre less is noticed: mean {mean}, worst {worst}");
    let mut rounded = tent.clone();
    rounded.pixels_mut().enumerate().for_each(|(i, pixel)| pixel.0[i % 3] = pixel.0[i % 3].saturating_add(1));
    let (mean, worst) = difference(&tent, &rounded);
    assert!(mean < 0.5 * MEAN && worst < 0.5 * WORST, "a level of one channel is not: mean {mean}, worst {worst}");
}
