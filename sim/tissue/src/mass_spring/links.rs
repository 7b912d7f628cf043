//! The nine directions in which a place has springs: three edges and six face diagonals.

use super::lanes::Lanes;

/// The nodes joined by the springs stored at a place, as steps along x, y and down from it.
pub(super) const CORNERS: [[usize; 3]; 7] =
    [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, 0, 1], [0, 1, 1]];

/// A direction of springs: the corners at its ends A and B.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Class {
    pub(super) ends: [usize; 2],
}

/// All directions: along x, y and down, then across xy, across xz and across yz.
pub(super) const CLASSES: [Class; 9] = [
    Class { ends: [0, 1] },
    Class { ends: [0, 2] },
    Class { ends: [0, 3] },
    Class { ends: [0, 4] },
    Class { ends: [1, 2] },
    Class { ends: [0, 5] },
    Class { ends: [1, 3] },
    Class { ends: [0, 6] },
    Class { ends: [2, 3] },
];

impl Class {
    /// The axes in which the ends differ, and the others.
    pub(super) fn axes(self) -> (&'static [usize], &'static [usize]) {
        let [a, b] = self.ends.map(|end| CORNERS[end]);
        match [0, 1, 2].map(|axis| a[axis] != b[axis]) {
            [true, false, false] => (&[0], &[1, 2]),
            [false, true, false] => (&[1], &[0, 2]),
            [false, false, true] => (&[2], &[0, 1]),
            [true, true, false] => (&[0, 1], &[2]),
            [true, false, true] => (&[0, 2], &[1]),
            _ => (&[1, 2], &[0]),
        }
    }
}

/// A spring at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Link<T> {
    /// From A to B in the patient's frame (z up), in m.
    pub(super) rest_m: [T; 3],
    /// Rest length, in m.
    pub(super) length_m: T,
}

impl Link<f64> {
    pub(super) fn new(class: Class, sides_m: [f64; 3]) -> Self {
        let [a, b] = class.ends.map(|end| CORNERS[end]);
        let step = |axis: usize| (b[axis] as f64 - a[axis] as f64) * sides_m[axis];
        let rest_m = [step(0), step(1), -step(2)];
        Self { rest_m, length_m: rest_m.iter().map(|e| e * e).sum::<f64>().sqrt() }
    }

    /// The same spring in every lane.
    #[inline(always)]
    pub(super) fn in_lanes<T: Lanes>(&self) -> Link<T> {
        Link { rest_m: self.rest_m.map(T::splat), length_m: T::splat(self.length_m) }
    }
}
