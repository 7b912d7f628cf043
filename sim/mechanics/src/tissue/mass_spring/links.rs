//! The nine directions in which a node has springs, each with one neighbour: three edges and six face diagonals.

use super::real::Real;

/// A direction of springs. A spring joins an end A to an end B, both given as steps along x, y and down from the node
/// at which the spring is kept; no step is negative.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Class {
    pub(super) a: [usize; 3],
    pub(super) b: [usize; 3],
}

/// All directions.
pub(super) const CLASSES: [Class; 9] = [
    Class { a: [0, 0, 0], b: [1, 0, 0] },
    Class { a: [0, 0, 0], b: [0, 1, 0] },
    Class { a: [0, 0, 0], b: [0, 0, 1] },
    Class { a: [0, 0, 0], b: [1, 1, 0] },
    Class { a: [1, 0, 0], b: [0, 1, 0] },
    Class { a: [0, 0, 0], b: [1, 0, 1] },
    Class { a: [1, 0, 0], b: [0, 0, 1] },
    Class { a: [0, 0, 0], b: [0, 1, 1] },
    Class { a: [0, 1, 0], b: [0, 0, 1] },
];

impl Class {
    /// The axes along which the spring reaches, and the others.
    pub(super) fn axes(self) -> (&'static [usize], &'static [usize]) {
        match [0, 1, 2].map(|axis| self.a[axis] != self.b[axis]) {
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
        let step = |axis: usize| (class.b[axis] as f64 - class.a[axis] as f64) * sides_m[axis];
        let rest_m = [step(0), step(1), -step(2)];
        Self { rest_m, length_m: rest_m.iter().map(|e| e * e).sum::<f64>().sqrt() }
    }

    /// The same in another precision.
    #[inline(always)]
    pub(super) fn rounded<T: Real>(&self) -> Link<T> {
        let [x, y, z] = self.rest_m;
        Link { rest_m: [T::of(x), T::of(y), T::of(z)], length_m: T::of(self.length_m) }
    }
}
