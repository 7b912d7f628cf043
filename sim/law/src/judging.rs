//! The ways in which a field's error was judged. They are defined here because the recording format
//! names them.

use serde::{Deserialize, Serialize};

/// How the error of a field's mesh is judged. A recording names the way by which it was made, and
/// is re-simulated with it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Judging {
    /// Axial displacement only, by the same mesh with higher orders; an attempt by a push on the
    /// skin. Used for recordings that name no way.
    First,
    /// Axial and radial displacement, by an independent mesh; an attempt by every load, on the
    /// whole body.
    Second,
    /// As the second; and an attempt's field is that of the angle at which the needle goes in, not of the exercise's.
    Third,
    /// As the third; and under a skin that bends, the needle's footprint is measured on the bent body.
    #[default]
    Fourth,
}

impl Judging {
    /// The number in recordings.
    #[must_use]
    pub fn number(self) -> u32 {
        match self {
            Self::First => 1,
            Self::Second => 2,
            Self::Third => 3,
            Self::Fourth => 4,
        }
    }

    /// The way with a number; `None` if unknown.
    #[must_use]
    pub fn of_number(number: u32) -> Option<Self> {
        [Self::First, Self::Second, Self::Third, Self::Fourth].into_iter().find(|judging| judging.number() == number)
    }
}
