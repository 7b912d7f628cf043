//! The adapter that the tests share, and measures of what it drew.

use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use glam::Vec3;
use image::{Rgba, RgbaImage};
use render::frame::{Frame, Stage};
use render::{Headless, Quality};

/// The adapter, opened once: compiling shaders takes longer than drawing.
pub fn painter() -> MutexGuard<'static, Headless> {
    static PAINTER: OnceLock<Mutex<Headless>> = OnceLock::new();
    let opened = || Mutex::new(Headless::new(Quality::Full).expect("an adapter: deploy/test installs a software one"));
    PAINTER.get_or_init(opened).lock().unwrap_or_else(PoisonError::into_inner)
}

/// A picture of a frame.
pub fn picture(stage: &Stage, frame: &Frame, size: [u32; 2]) -> RgbaImage {
    painter().picture(stage, frame, size).expect("a picture")
}

/// Where a point (m) comes to lie in a picture, in pixels.
pub fn pixel_of(stage: &Stage, frame: &Frame, (point_m, size): ([f32; 3], [u32; 2])) -> [f32; 2] {
    let mut painter = painter();
    painter.picture(stage, frame, size).expect("a picture");
    painter.renderer().camera(frame).pixel(Vec3::from(point_m), size)
}

/// Largest difference of a channel, in levels.
pub fn apart(a: Rgba<u8>, b: Rgba<u8>) -> u8 {
    (0..3).map(|channel| a.0[channel].abs_diff(b.0[channel])).max().unwrap_or(0)
}

/// Pixels of one picture that are not the same in another.
pub fn changed(a: &RgbaImage, b: &RgbaImage, levels: u8) -> Vec<[u32; 2]> {
    let pairs = a.enumerate_pixels().zip(b.pixels());
    pairs.filter(|((_, _, a), b)| apart(**a, **b) > levels).map(|((x, y, _), _)| [x, y]).collect()
}
