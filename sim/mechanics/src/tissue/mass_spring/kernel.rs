//! One pass over all springs: what each pulls, added to its ends.
//!
//! Numbers along x are contiguous, and a row of springs of one direction is computed [`WIDTH`] at a time. A pull is added to one end and subtracted from the other:
//! the sum of all forces stays 0 to rounding.

use super::lattice::Lattice;
use super::laws::energy_j;
use super::links::{CLASSES, Link};
use super::real::Real;

/// A vector at every node.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Field<T = f64> {
    pub(super) axes: [Vec<T>; 3],
}

impl<T: Real> Field<T> {
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

impl Field {
    pub(super) fn copy_from(&mut self, other: &Self) {
        for (mine, theirs) in self.axes.iter_mut().zip(&other.axes) {
            mine.copy_from_slice(theirs);
        }
    }

    /// Σ over nodes and axes of the product.
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

/// A sum in a fixed order, several terms side by side.
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

/// What a spring pulls, given N fields.
pub(super) trait Law<T, const N: usize> {
    /// The pull on end A, in N; that on end B is opposite. `differences` are those of the fields, B less A.
    fn pull(&self, link: &Link<T>, constant: T, differences: [[T; 3]; N]) -> [T; 3];
}

/// Springs that are computed together: few enough for their pulls to stay in the first cache.
const LONGEST: usize = 256;

/// Pulls of springs in a run.
type Pulls<T> = [[T; LONGEST]; 3];

/// Springs of one direction at places that follow each other, and the places of their first ends. Rows of nodes follow
/// each other too: a spring that would leave its row has a constant of 0.
struct Run<'a> {
    link: &'a Link<f64>,
    constants: &'a [f32],
    ends: [usize; 2],
}

/// Calls with every run of springs kept in plane `k`.
#[inline(always)]
fn each_run(lattice: &Lattice, k: usize, mut call: impl FnMut(&Run<'_>)) {
    for &[begin, end] in &lattice.runs {
        for (class, (link, constants)) in CLASSES.iter().zip(lattice.links[k].iter().zip(&lattice.constants)) {
            if k + class.b[2] < lattice.links.len() {
                let ends = [class.a, class.b].map(|[i, j, down]| begin + lattice.grid.place([i, j, k + down]));
                let first = lattice.grid.place([0, 0, k]);
                call(&Run { link, constants: &constants[first + begin..first + end], ends });
            }
        }
    }
}

/// Stretches of a plane in which there are springs, none longer than a run, short gaps included.
pub(super) fn runs(has_springs: &[bool]) -> Vec<[usize; 2]> {
    /// A gap is cheaper to compute than to skip below this.
    const GAP: usize = 24;
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for place in (0..has_springs.len()).filter(|&place| has_springs[place]) {
        match runs.last_mut() {
            Some([begin, end]) if place < *end + GAP && place < *begin + LONGEST => *end = place + 1,
            _ => runs.push([place, place + 1]),
        }
    }
    runs
}

/// Adds the pulls of the springs kept in plane `k` to `forces`.
pub(super) fn pull_plane<T: Real, const N: usize>(
    lattice: &Lattice,
    law: &impl Law<T, N>,
    fields: [&Field<T>; N],
    (k, forces): (usize, &mut Field<T>),
) {
    let mut pulls = [[T::default(); LONGEST]; 3];
    each_run(lattice, k, |run| {
        pull_run(law, run, fields, &mut pulls);
        for (pulls, forces) in pulls.iter().zip(&mut forces.axes) {
            for (force, &pull) in forces[run.ends[0]..].iter_mut().zip(&pulls[..run.constants.len()]) {
                *force += pull;
            }
            for (force, &pull) in forces[run.ends[1]..].iter_mut().zip(&pulls[..run.constants.len()]) {
                *force -= pull;
            }
        }
    });
}

/// Adds the pulls of all springs to `forces`.
pub(super) fn pull_all<T: Real, const N: usize>(
    lattice: &Lattice,
    law: &impl Law<T, N>,
    fields: [&Field<T>; N],
    forces: &mut Field<T>,
) {
    for k in 0..lattice.links.len() {
        pull_plane(lattice, law, fields, (k, forces));
    }
}

#[inline(always)]
fn pull_run<T: Real, const N: usize>(
    law: &impl Law<T, N>,
    run: &Run<'_>,
    fields: [&Field<T>; N],
    pulls: &mut Pulls<T>,
) {
    let count = run.constants.len().min(LONGEST);
    let mut ends = [Ends::NONE; N];
    for (ends, field) in ends.iter_mut().zip(fields) {
        *ends = Ends::new(field, run.ends, count);
    }
    let link = run.link.rounded();
    let constants = &run.constants[..count];
    let [x, y, z] = pulls;
    let (x, y, z) = (&mut x[..count], &mut y[..count], &mut z[..count]);
    for i in 0..count {
        let mut differences = [[T::default(); 3]; N];
        for n in 0..N {
            differences[n] = ends[n].difference(i);
        }
        [x[i], y[i], z[i]] = law.pull(&link, T::of_single(constants[i]), differences);
    }
}

/// Energy of the springs kept in plane `k`, in J; of the computed part only.
pub(super) fn energy_of_plane_j(lattice: &Lattice, k: usize, displacement_m: &Field) -> f64 {
    let mut sum_j = 0.0;
    each_run(lattice, k, |run| {
        let ends = Ends::new(displacement_m, run.ends, run.constants.len());
        for (i, &constant) in run.constants.iter().enumerate() {
            sum_j += energy_j(run.link, f64::from(constant), ends.difference(i));
        }
    });
    sum_j
}

/// A field at both ends of a run of springs.
#[derive(Clone, Copy)]
struct Ends<'a, T> {
    ax: &'a [T],
    ay: &'a [T],
    az: &'a [T],
    bx: &'a [T],
    by: &'a [T],
    bz: &'a [T],
}

impl<'a, T: Real> Ends<'a, T> {
    const NONE: Self = Self { ax: &[], ay: &[], az: &[], bx: &[], by: &[], bz: &[] };

    #[inline(always)]
    fn new(field: &'a Field<T>, [a, b]: [usize; 2], count: usize) -> Self {
        let [x, y, z] = &field.axes;
        let (ax, ay, az) = (&x[a..a + count], &y[a..a + count], &z[a..a + count]);
        let (bx, by, bz) = (&x[b..b + count], &y[b..b + count], &z[b..b + count]);
        Self { ax, ay, az, bx, by, bz }
    }

    /// B less A of a spring.
    #[inline(always)]
    fn difference(&self, i: usize) -> [T; 3] {
        [self.bx[i] - self.ax[i], self.by[i] - self.ay[i], self.bz[i] - self.az[i]]
    }
}
