//! One pass over all springs: the pull of each is added to its ends.
//!
//! The springs stored at [`LANES`] neighbouring places are computed at once: their seven corners
//! are read once, and the pulls of the nine directions are summed before they are written. A pull
//! is added to one end and subtracted from the other, so that the sum of all forces stays 0 to
//! rounding.

use wide::f64x4;

use super::lanes::{LANES, Lanes};
use super::lattice::Lattice;
use super::links::{CLASSES, CORNERS, Link};

/// A vector at every node.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NodalField<T = f64> {
    pub(super) axes: [Vec<T>; 3],
}

impl<T: Copy + Default> NodalField<T> {
    pub(super) fn zeros(places: usize) -> Self {
        Self { axes: [(); 3].map(|()| vec![T::default(); places]) }
    }

    pub(super) fn clear(&mut self) {
        self.axes.iter_mut().for_each(|axis| axis.fill(T::default()));
    }

    pub(super) fn bytes(&self) -> usize {
        self.axes.iter().map(|axis| size_of_val(&axis[..])).sum()
    }
}

impl NodalField {
    pub(super) fn copy_from(&mut self, other: &Self) {
        for (mine, theirs) in self.axes.iter_mut().zip(&other.axes) {
            mine.copy_from_slice(theirs);
        }
    }

    /// Sum of the products over nodes and axes.
    pub(super) fn dot(&self, other: &Self) -> f64 {
        self.axes.iter().zip(&other.axes).map(|(a, b)| dot(a, b)).sum()
    }

    /// self ← self + factor · other.
    pub(super) fn add_scaled(&mut self, factor: f64, other: &Self) {
        for (mine, theirs) in self.axes.iter_mut().zip(&other.axes) {
            for (mine, theirs) in mine.iter_mut().zip(theirs) {
                *mine += factor * theirs;
            }
        }
    }

    pub(super) fn scale(&mut self, factor: f64) {
        for axis in &mut self.axes {
            axis.iter_mut().for_each(|value| *value *= factor);
        }
    }
}

/// A sum in a fixed order, with several partial sums.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.0.iter().zip(b.0) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let rest: f64 = a.1.iter().zip(b.1).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

/// The pull of a spring, given N fields.
pub(super) trait Law<T, const N: usize> {
    /// The pull on end A, in N; the pull on end B is opposite. `differences` are those of the
    /// fields, B minus A.
    fn pull(&self, link: &Link<T>, constant: T, differences: [[T; 3]; N]) -> [T; 3];
}

/// Stretches of a plane that contain springs, in whole [`LANES`], short gaps included.
pub(super) fn runs(has_springs: &[bool]) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for (at, _) in has_springs.chunks(LANES).enumerate().filter(|(_, lanes)| lanes.contains(&true)) {
        let (begin, end) = (at * LANES, (at + 1) * LANES);
        match runs.last_mut() {
            Some(run) if run[1] == begin => run[1] = end,
            _ => runs.push([begin, end]),
        }
    }
    runs
}

/// The springs stored at neighbouring places, while they are computed.
struct Corners<T, const N: usize> {
    /// The fields at each corner.
    fields: [[[T; 3]; CORNERS.len()]; N],
    /// Pull of the springs at each corner, in N.
    pulls: [[T; 3]; CORNERS.len()],
}

impl<T: Lanes, const N: usize> Corners<T, N> {
    /// Adds the pulls of one direction. A compile-time direction keeps all corners in registers.
    #[inline(always)]
    fn pull<const CLASS: usize>(&mut self, law: &impl Law<T, N>, springs: &Springs<'_, T>, at: usize) {
        let [a, b] = const { CLASSES[CLASS].ends };
        let mut differences = [[T::splat(0.0); 3]; N];
        for (difference, corners) in differences.iter_mut().zip(&self.fields) {
            *difference = with(corners[b], corners[a], |b, a| b - a);
        }
        let constant = T::load_single(&springs.constants[CLASS], at);
        let pull = law.pull(&springs.links[CLASS], constant, differences);
        self.pulls[a] = with(self.pulls[a], pull, |sum, pull| sum + pull);
        self.pulls[b] = with(self.pulls[b], pull, |sum, pull| sum - pull);
    }
}

/// The springs stored in a plane.
struct Springs<'a, T> {
    links: [Link<T>; CLASSES.len()],
    constants: &'a [Vec<f32>; CLASSES.len()],
}

/// Adds the pulls of the springs stored in plane `k` to `forces`.
pub(super) fn pull_plane<T: Lanes, const N: usize>(
    lattice: &Lattice,
    law: &impl Law<T, N>,
    fields: [&NodalField<T::Number>; N],
    k: usize,
    forces: &mut NodalField<T::Number>,
) {
    let springs = Springs { links: lattice.links[k].map(|link| link.in_lanes()), constants: &lattice.constants };
    let (first, steps) = (lattice.grid.place([0, 0, k]), CORNERS.map(|corner| lattice.grid.place(corner)));
    for &[begin, end] in &lattice.runs {
        for at in (first + begin..first + end).step_by(LANES) {
            let zero = [[T::splat(0.0); 3]; CORNERS.len()];
            let mut corners = Corners { fields: [zero; N], pulls: zero };
            for (corners, field) in corners.fields.iter_mut().zip(fields) {
                for (corner, step) in corners.iter_mut().zip(steps) {
                    *corner = [0, 1, 2].map(|axis| T::load(&field.axes[axis], at + step));
                }
            }
            corners.pull::<0>(law, &springs, at);
            corners.pull::<1>(law, &springs, at);
            corners.pull::<2>(law, &springs, at);
            corners.pull::<3>(law, &springs, at);
            corners.pull::<4>(law, &springs, at);
            corners.pull::<5>(law, &springs, at);
            corners.pull::<6>(law, &springs, at);
            corners.pull::<7>(law, &springs, at);
            corners.pull::<8>(law, &springs, at);
            // Neighbouring corners share places, so one is written before the next is read.
            for (pull, step) in corners.pulls.iter().zip(steps) {
                for (pull, forces) in pull.iter().zip(&mut forces.axes) {
                    (T::load(forces, at + step) + *pull).store(forces, at + step);
                }
            }
        }
    }
}

/// Adds the pulls of all springs to `forces`.
pub(super) fn pull_all<const N: usize>(
    lattice: &Lattice,
    law: &impl Law<f64x4, N>,
    fields: [&NodalField; N],
    forces: &mut NodalField,
) {
    for k in 0..lattice.links.len() {
        pull_plane(lattice, law, fields, k, forces);
    }
}

#[inline(always)]
fn with<T: Copy>(a: [T; 3], b: [T; 3], of: impl Fn(T, T) -> T) -> [T; 3] {
    [of(a[0], b[0]), of(a[1], b[1]), of(a[2], b[2])]
}
