//! What a replay in the browser needs of a recording, made once: the stage, constant for the attempt, the frames that
//! move on it, and the pyramid of what is plotted.

mod coarse;
mod frames;
mod stage;

use attempt::AttemptCurve;
use documents::ExerciseBundle;
pub use frames::{COLUMNS, Frames};
use recording::Recording;
pub use stage::ReplayStage;

use super::series::Pyramid;

/// A recording, taken apart for the browser.
#[derive(Clone, Debug)]
pub struct Replay {
    /// What does not move.
    pub stage: ReplayStage,
    /// What moves.
    pub frames: Frames,
    /// What is plotted.
    pub pyramid: Pyramid,
}

impl Replay {
    /// Takes a recording apart; `bundle` is the exercise that it carries.
    #[must_use]
    pub fn of(recording: &Recording, bundle: &ExerciseBundle) -> Self {
        let frames = Frames::of(recording, bundle);
        let curve = AttemptCurve::draw(recording, bundle);
        Self { stage: ReplayStage::of(recording, bundle, curve, &frames), pyramid: Pyramid::of(recording), frames }
    }
}
