//! The order of elimination: elements are bisected geometrically, and unknowns are eliminated as
//! soon as no other part contains them.

use super::{Connectivity, FIXED};

/// A part of the elements with at most this many degrees of freedom is one front: smaller ones cost
/// more than they save.
const LEAF: usize = 32;

/// A dense part of the factor.
#[derive(Clone, Debug)]
pub(super) struct DenseFront {
    /// Position of its first own unknown in the order of elimination.
    pub start: usize,
    /// Number of unknowns eliminated here.
    pub own: usize,
    /// Positions of the unknowns that are eliminated later, ascending.
    pub rows: Vec<u32>,
}

impl DenseFront {
    /// Number of rows of its dense matrix.
    pub fn size(&self) -> usize {
        self.own + self.rows.len()
    }

    /// Number of entries in its columns, from the diagonal down.
    pub fn nonzeros(&self) -> usize {
        self.own * self.size() - self.own * self.own.saturating_sub(1) / 2
    }
}

/// Fronts in the order of elimination, and their inputs.
pub(super) struct Dissection {
    pub fronts: Vec<DenseFront>,
    /// Elements assembled in each front.
    pub leaves: Vec<Vec<usize>>,
    /// Fronts whose Schur complement is assembled in each front.
    pub children: Vec<Vec<usize>>,
    /// Position of each unknown in the order of elimination.
    pub place: Vec<u32>,
}

/// An unknown, and the number of elements of a part that contain it.
type Known = Vec<(u32, u32)>;

struct Builder<'a> {
    connectivity: &'a Connectivity<'a>,
    /// Number of elements that contain each unknown.
    everywhere: Vec<u32>,
    done: Dissection,
    next: u32,
}

impl Dissection {
    pub fn new(connectivity: &Connectivity<'_>) -> Self {
        let mut everywhere = vec![0; connectivity.unknowns];
        for &unknown in connectivity.elements.iter().flatten().filter(|&&unknown| unknown != FIXED) {
            everywhere[unknown as usize] += 1;
        }
        let empty = Self {
            fronts: Vec::new(),
            leaves: Vec::new(),
            children: Vec::new(),
            place: vec![FIXED; connectivity.unknowns],
        };
        let mut builder = Builder { connectivity, everywhere, done: empty, next: 0 };
        let mut all: Vec<usize> = (0..connectivity.elements.len()).collect();
        builder.part(&mut all);
        let Builder { mut done, .. } = builder;
        for front in &mut done.fronts {
            for row in &mut front.rows {
                *row = done.place[*row as usize];
            }
            front.rows.sort_unstable();
        }
        done
    }

    pub fn nonzeros(&self) -> usize {
        self.fronts.iter().map(DenseFront::nonzeros).sum()
    }
}

impl Builder<'_> {
    /// Orders a part of the elements. Returns its front, and the unknowns left to eliminate
    /// outside.
    fn part(&mut self, elements: &mut [usize]) -> (usize, Known) {
        let degrees: usize = elements.iter().map(|&e| self.connectivity.elements[e].len()).sum();
        if elements.len() <= 1 || degrees <= LEAF {
            let mut known: Known = elements
                .iter()
                .flat_map(|&e| &self.connectivity.elements[e])
                .filter(|&&unknown| unknown != FIXED)
                .map(|&unknown| (unknown, 1))
                .collect();
            known.sort_unstable();
            return self.front(elements.to_vec(), Vec::new(), &merged(&known));
        }
        let (one, other) = self.halve(elements);
        let (first, mut known) = self.part(one);
        let (second, also) = self.part(other);
        known.extend(also);
        known.sort_unstable();
        self.front(Vec::new(), vec![first, second], &merged(&known))
    }

    /// Halves a part across its longest extent.
    fn halve<'e>(&self, elements: &'e mut [usize]) -> (&'e mut [usize], &'e mut [usize]) {
        let centroids = self.connectivity.centroids_m;
        let extent = |axis: usize| {
            let along = elements.iter().map(|&e| centroids[e][axis]);
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| (l.min(c), h.max(c)));
            high - low
        };
        let axis = (0..3).max_by(|&a, &b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
        elements.sort_by(|&a, &b| centroids[a][axis].total_cmp(&centroids[b][axis]));
        elements.split_at_mut(elements.len() / 2)
    }

    /// Adds a front that eliminates the unknowns contained in this part only.
    fn front(&mut self, leaf: Vec<usize>, children: Vec<usize>, known: &Known) -> (usize, Known) {
        let (own, outside): (Known, Known) =
            known.iter().partition(|&&(u, count)| self.everywhere[u as usize] == count);
        let start = self.next as usize;
        for &(unknown, _) in &own {
            self.done.place[unknown as usize] = self.next;
            self.next += 1;
        }
        let rows = outside.iter().map(|&(unknown, _)| unknown).collect();
        self.done.fronts.push(DenseFront { start, own: own.len(), rows });
        self.done.leaves.push(leaf);
        self.done.children.push(children);
        (self.done.fronts.len() - 1, outside)
    }
}

/// Sums the counts of equal unknowns; the input is sorted.
fn merged(known: &Known) -> Known {
    let mut merged = Known::with_capacity(known.len());
    for &(unknown, count) in known {
        match merged.last_mut() {
            Some((last, sum)) if *last == unknown => *sum += count,
            _ => merged.push((unknown, count)),
        }
    }
    merged
}
