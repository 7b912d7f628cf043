//! Cholesky factorisation of a stiffness matrix given by its elements: multifrontal, with geometric
//! nested dissection.
//!
//! The elements are bisected recursively across their longest extent. Unknowns shared by two halves
//! are eliminated after both, so each half is a small dense matrix of its own (Duff and Reid 1983;
//! George 1973). Unknowns of a single element, such as those inside a high-order element, are
//! eliminated first, by themselves: static condensation.
//!
//! Sums run in one fixed order and nothing is fused, so a factor has the same bits everywhere.

mod dense;
mod dissection;

use dissection::{DenseFront, Dissection};

/// The elements of a matrix: the unknowns and the position of each.
pub struct Connectivity<'a> {
    /// Number of unknowns.
    pub unknowns: usize,
    /// The unknowns of each element, in the order of its matrix, without duplicates. [`FIXED`]
    /// marks a clamped degree of freedom.
    pub elements: &'a [Vec<u32>],
    /// A point inside each element, in m.
    pub centroids_m: &'a [[f64; 3]],
}

/// A clamped degree of freedom, which is omitted from the matrix.
pub const FIXED: u32 = u32::MAX;

/// A pivot below this fraction of its original diagonal is lost in rounding.
const LOST_PIVOT: f64 = 1e-14;

/// The matrix is not positive definite: something can move without resistance.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the stiffness matrix is not positive definite at unknown {unknown}: its pivot is {pivot}")]
pub struct NotPositiveDefinite {
    /// The unknown whose pivot is not positive.
    pub unknown: usize,
    /// The pivot.
    pub pivot: f64,
}

/// A factorised symmetric positive definite matrix.
#[derive(Clone, Debug)]
pub struct Cholesky {
    /// Fronts in the order of elimination.
    fronts: Vec<DenseFront>,
    /// Position of each unknown in the order of elimination.
    place: Vec<u32>,
    /// Columns of all fronts: for each the reciprocal of its diagonal, then the entries below.
    values: Vec<f64>,
    /// Size of the largest front.
    largest: usize,
}

impl Cholesky {
    /// Factorises the sum of the elements' matrices. `stiffness(element, matrix)` fills a dense
    /// symmetric matrix, initially zero, with as many rows as the element has degrees of freedom,
    /// clamped ones included, in column-major order.
    ///
    /// # Errors
    /// If the sum is not positive definite.
    pub fn factorise(
        connectivity: &Connectivity<'_>,
        mut stiffness: impl FnMut(usize, &mut [f64]),
    ) -> Result<Self, NotPositiveDefinite> {
        let dissection = Dissection::new(connectivity);
        if let Some(unknown) = dissection.place.iter().position(|&place| place == FIXED) {
            return Err(NotPositiveDefinite { unknown, pivot: 0.0 });
        }
        let mut factor = Self {
            values: Vec::with_capacity(dissection.nonzeros()),
            largest: dissection.fronts.iter().map(DenseFront::size).max().unwrap_or(0),
            place: dissection.place,
            fronts: dissection.fronts,
        };
        let mut assembly = Assembly::new(connectivity.unknowns);
        for (at, leaf) in dissection.leaves.iter().enumerate() {
            assembly.begin(&factor.fronts[at]);
            for &element in leaf {
                assembly.add_element(&factor.place, &connectivity.elements[element], |m| stiffness(element, m));
            }
            for &child in &dissection.children[at] {
                assembly.add_child(child, &factor.fronts[child]);
            }
            let lost = assembly.finish(at, &factor.fronts[at], &mut factor.values);
            lost.map_or(Ok(()), |(column, pivot)| {
                let place = factor.fronts[at].start + column;
                let unknown = factor.place.iter().position(|&p| p as usize == place).unwrap_or_default();
                Err(NotPositiveDefinite { unknown, pivot })
            })?;
        }
        Ok(factor)
    }

    /// Solves in place: `b` is the right-hand side and becomes the solution. `scratch` has at least
    /// [`Self::scratch_len`] numbers.
    pub fn solve(&self, b: &mut [f64], scratch: &mut [f64]) {
        let (x, t) = scratch.split_at_mut(self.place.len());
        for (&place, &value) in self.place.iter().zip(b.iter()) {
            x[place as usize] = value;
        }
        let mut values = &self.values[..];
        for front in &self.fronts {
            let (columns, rest) = values.split_at(front.nonzeros());
            values = rest;
            let t = &mut t[..front.size()];
            t[..front.own].copy_from_slice(&x[front.start..][..front.own]);
            t[front.own..].fill(0.0);
            dense::forward(columns, front.own, t);
            x[front.start..][..front.own].copy_from_slice(&t[..front.own]);
            for (&row, &change) in front.rows.iter().zip(&t[front.own..]) {
                x[row as usize] += change;
            }
        }
        let mut values = &self.values[..];
        for front in self.fronts.iter().rev() {
            let (rest, columns) = values.split_at(values.len() - front.nonzeros());
            values = rest;
            let t = &mut t[..front.size()];
            t[..front.own].copy_from_slice(&x[front.start..][..front.own]);
            for (&row, value) in front.rows.iter().zip(&mut t[front.own..]) {
                *value = x[row as usize];
            }
            dense::backward(columns, front.own, t);
            x[front.start..][..front.own].copy_from_slice(&t[..front.own]);
        }
        for (&place, value) in self.place.iter().zip(b) {
            *value = x[place as usize];
        }
    }

    /// Number of scratch numbers that a solve needs.
    #[must_use]
    pub fn scratch_len(&self) -> usize {
        self.place.len() + self.largest
    }

    /// Number of nonzeros of the factor.
    #[must_use]
    pub fn nonzeros(&self) -> usize {
        self.values.len()
    }

    /// Memory of the factor, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let rows: usize = self.fronts.iter().map(|front| front.rows.len()).sum();
        size_of_val(&self.values[..]) + size_of_val(&self.place[..]) + size_of_val(&self.fronts[..]) + 4 * rows
    }
}

/// The dense matrix of the front being assembled, and the Schur complements of finished fronts.
struct Assembly {
    /// Position in the front of each position in the order of elimination.
    local: Vec<u32>,
    /// The front in column-major order; only the lower triangle counts.
    matrix: Vec<f64>,
    /// Number of its rows and columns.
    size: usize,
    /// An element's matrix.
    element: Vec<f64>,
    /// The degrees of freedom of an element that are not clamped: position in the element, position
    /// in the front.
    free: Vec<(usize, usize)>,
    /// Rows of a finished front in the one being assembled.
    rows: Vec<usize>,
    /// Schur complement of each front on its rows, column by column from the diagonal down, until
    /// its parent takes it.
    left: Vec<Vec<f64>>,
}

/// Converts a position within a front to `u32`. [`FIXED`] is not a position.
#[expect(clippy::expect_used, reason = "the unknowns of a connectivity are `u32`")]
fn number_place(place: usize) -> u32 {
    u32::try_from(place).expect("a front has fewer unknowns than the whole")
}

impl Assembly {
    fn new(unknowns: usize) -> Self {
        Self {
            local: vec![0; unknowns],
            matrix: Vec::new(),
            size: 0,
            element: Vec::new(),
            free: Vec::new(),
            rows: Vec::new(),
            left: Vec::new(),
        }
    }

    fn begin(&mut self, front: &DenseFront) {
        self.size = front.size();
        self.matrix.clear();
        self.matrix.resize(self.size * self.size, 0.0);
        let places = (front.start..front.start + front.own).chain(front.rows.iter().map(|&row| row as usize));
        for (local, place) in places.enumerate() {
            self.local[place] = number_place(local);
        }
    }

    fn add_element(&mut self, place: &[u32], unknowns: &[u32], fill: impl FnOnce(&mut [f64])) {
        let n = unknowns.len();
        self.element.clear();
        self.element.resize(n * n, 0.0);
        fill(&mut self.element);
        let free = unknowns.iter().enumerate().filter(|&(_, &unknown)| unknown != FIXED);
        self.free.clear();
        self.free.extend(free.map(|(at, &u)| (at, self.local[place[u as usize] as usize] as usize)));
        for &(column, to_column) in &self.free {
            let (from, to) = (&self.element[column * n..][..n], &mut self.matrix[to_column * self.size..][..self.size]);
            // Entries above the diagonal do not count; adding them is faster than branching.
            for &(row, to_row) in &self.free {
                to[to_row] += from[row];
            }
        }
    }

    fn add_child(&mut self, child: usize, front: &DenseFront) {
        let left = std::mem::take(&mut self.left[child]);
        let mut left = &left[..];
        self.rows.clear();
        self.rows.extend(front.rows.iter().map(|&place| self.local[place as usize] as usize));
        for (column, &to_column) in self.rows.iter().enumerate() {
            let (values, rest) = left.split_at(self.rows.len() - column);
            let to = &mut self.matrix[to_column * self.size..][..self.size];
            // Rows keep their order in every front, so entries below the diagonal stay below it.
            for (value, &to_row) in values.iter().zip(&self.rows[column..]) {
                to[to_row] += value;
            }
            left = rest;
        }
    }

    /// Eliminates the front's own unknowns, appends its columns to `values` and keeps the rest for
    /// the parent. Returns the first column whose pivot was lost, with the pivot.
    fn finish(&mut self, at: usize, front: &DenseFront, values: &mut Vec<f64>) -> Option<(usize, f64)> {
        let size = self.size;
        let lost = dense::eliminate(&mut self.matrix, size, front.own, LOST_PIVOT);
        for column in 0..front.own {
            let column = &self.matrix[column * size..][column..size];
            values.push(1.0 / column[0]);
            values.extend_from_slice(&column[1..]);
        }
        let rows = front.rows.len();
        let mut left = Vec::with_capacity(rows * (rows + 1) / 2);
        for column in front.own..size {
            left.extend_from_slice(&self.matrix[column * size..][column..size]);
        }
        self.left.resize(at + 1, Vec::new());
        self.left[at] = left;
        lost
    }
}
