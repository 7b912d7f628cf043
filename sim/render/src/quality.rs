//! Rendering quality in named steps, and the governor that lowers it to avoid stuttering.

use phrase::{Phrase, phrase, sentence};

/// A step of quality, best first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quality {
    /// Shadows of 2048², four samples a pixel, full resolution.
    #[default]
    Full,
    /// Shadows of 1024², four samples a pixel, full resolution.
    High,
    /// Shadows of 1024², one sample a pixel, full resolution.
    Medium,
    /// Shadows of 512², one sample a pixel, three quarters of the resolution.
    Low,
    /// No shadows, one sample a pixel, half the resolution.
    Least,
}

impl Quality {
    /// All steps, best first.
    pub const ALL: [Self; 5] = [Self::Full, Self::High, Self::Medium, Self::Low, Self::Least];

    /// Width of the shadow map in texels; 0 for no shadows.
    #[must_use]
    pub fn shadow_texels(self) -> u32 {
        [2048, 1024, 1024, 512, 0][self as usize]
    }

    /// Samples per pixel: 1 or 4.
    #[must_use]
    pub fn samples(self) -> u32 {
        [4, 4, 1, 1, 1][self as usize]
    }

    /// Rendering resolution, as a fraction of the image's.
    #[must_use]
    pub fn resolution(self) -> f32 {
        [1.0, 1.0, 1.0, 0.75, 0.5][self as usize]
    }

    /// The next lower step, if there is one.
    #[must_use]
    pub fn lower(self) -> Option<Self> {
        Self::ALL.get(self as usize + 1).copied()
    }

    /// The next higher step, if there is one.
    #[must_use]
    pub fn higher(self) -> Option<Self> {
        (self as usize).checked_sub(1).map(|at| Self::ALL[at])
    }

    /// One-word name for the user.
    #[must_use]
    pub fn name(self) -> &'static str {
        [sentence!("full"), sentence!("high"), sentence!("medium"), sentence!("low"), sentence!("least")][self as usize]
    }

    /// Description of the step for the user.
    #[must_use]
    pub fn in_words(self) -> String {
        self.phrase().to_string()
    }

    /// Description of the step as a translatable phrase.
    #[must_use]
    pub fn phrase(self) -> Phrase {
        let shadows = match self.shadow_texels() {
            0 => phrase!("no shadows"),
            texels => phrase!("shadows of {texels}²", texels = i64::from(texels)),
        };
        let samples = match self.samples() {
            1 => phrase!("1 sample per pixel"),
            samples => phrase!("{samples} samples per pixel", samples = i64::from(samples)),
        };
        let percent = Phrase::number(100.0 * f64::from(self.resolution()), 0);
        phrase!(
            "{shadows}, {samples}, {percent} % of the resolution",
            shadows = shadows,
            samples = samples,
            percent = percent
        )
    }
}

/// Number of frames in a window.
const WINDOW: u32 = 12;
/// Number of consecutive windows with time to spare before quality is raised: a change is visible,
/// and should not have to be undone.
const CALM: u32 = 20;
/// A window is too slow if its mean frame takes more than this fraction of the budget.
const OVER: f32 = 1.05;
/// A window has time to spare if its mean frame takes less than this fraction: a step up costs up
/// to twice as much.
const SPARE: f32 = 0.40;

/// Chooses the quality from frame times. Pure: the times are arguments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Governor {
    quality: Quality,
    best: Quality,
    budget_s: f32,
    frames: u32,
    total_s: f32,
    calm: u32,
}

impl Governor {
    /// Starts at a quality, which is also the highest that it returns to; `budget_s` is the allowed
    /// time per frame, in s.
    #[must_use]
    pub fn new(best: Quality, budget_s: f32) -> Self {
        Self { quality: best, best, budget_s, frames: 0, total_s: 0.0, calm: 0 }
    }

    /// The quality to draw at.
    #[must_use]
    pub fn quality(&self) -> Quality {
        self.quality
    }

    /// Records the time of a frame, in s. Returns the new quality if it changes. Ignores negative
    /// times and times that are not finite.
    pub fn took(&mut self, frame_s: f32) -> Option<Quality> {
        if !frame_s.is_finite() || frame_s < 0.0 {
            return None;
        }
        // A frame of a second is a stall of the machine, which no quality fixes: it counts as four
        // budgets.
        self.total_s += frame_s.min(4.0 * self.budget_s);
        self.frames += 1;
        if self.frames < WINDOW {
            return None;
        }
        let share = self.total_s / (self.frames as f32 * self.budget_s);
        (self.frames, self.total_s) = (0, 0.0);
        self.calm = if share < SPARE { self.calm + 1 } else { 0 };
        let next = match share {
            _ if share > OVER => self.quality.lower(),
            _ if self.calm >= CALM => self.quality.higher().filter(|higher| *higher >= self.best),
            _ => None,
        }?;
        self.quality = next;
        self.calm = 0;
        Some(next)
    }
}
