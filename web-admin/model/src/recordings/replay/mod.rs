//! Data for the replay of a recording in the browser: the stage, which is constant, the moving
//! frames, and the pyramid for the plots.

mod coarse;
mod frames;
mod stage;

use attempt::AttemptCurve;
use documents::ExerciseBundle;
pub use frames::{COLUMNS, Frames};
use recording::Recording;
pub use stage::ReplayStage;

use crate::recordings::series::Pyramid;

/// Data for a replay.
#[derive(Clone, Debug)]
pub struct Replay {
    /// The constant part.
    pub stage: ReplayStage,
    /// The moving part.
    pub frames: Frames,
    /// The plotted signals.
    pub pyramid: Pyramid,
}

impl Replay {
    /// Prepares a recording; `bundle` is the exercise that it contains.
    #[must_use]
    pub fn of(recording: &Recording, bundle: &ExerciseBundle) -> Self {
        let frames = Frames::of(recording, bundle);
        let curve = AttemptCurve::draw(recording, bundle);
        Self { stage: ReplayStage::of(recording, bundle, curve, &frames), pyramid: Pyramid::of(recording), frames }
    }
}
