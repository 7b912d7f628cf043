//! The ways in which a field's error was judged. The format of recordings names them, so they stand where the format can see them.

use serde::{Deserialize, Serialize};

/// How the error of a field's mesh is judged. A recording names the way it was made by, and re-simulates by it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Judging {
    /// Axial displacement alone, by the same mesh with higher orders; an attempt by a push on the skin. Recordings that name no
    /// way are of this one.
    First,
    /// Axial and radial displacement, by a mesh that shares nothing with what it judges; an attempt by every load, on the whole
    /// body.
    Second,
    /// As the second; and an attempt's field is that of the angle at which the needle goes in, not of the exercise's.
    Third,
    /// As the third; and under a skin that bends, the needle's footprint is measured on the bent body.
    #[default]
    Fourth,
}

impl Judging {
    /// The number that recordings name it by.
    #[must_use]
    pub fn number(self) -> u32 {
        match self {
            Self::First => 1,
            Self::Second => 2,
            Self::Third => 3,
            Self::Fourth => 4,
        }
    }

    /// The way of a number; none that is not known.
    #[must_use]
    pub fn of_number(number: u32) -> Option<Self> {
        [Self::First, Self::Second, Self::Third, Self::Fourth].into_iter().find(|judging| judging.number() == number)
    }
}
