//! The mesh in plan view: a block around the needle, rings around the block, graded outwards.

use std::f64::consts::FRAC_PI_4;

use super::{Symmetry, number_node};

/// Half-width at the corner of the block, as a fraction of its half-width: between 1/√2, where a
/// corner of the block would be flat, and 1, where a corner of the ring would be sharp.
const CORNER: f64 = 0.8;

/// Quadrilaterals of some order in a disc around the origin.
pub(super) struct DiscPlan {
    /// Nodes x, y, in m.
    pub nodes_m: Vec<[f64; 2]>,
    /// Nodes of each cell, (order + 1)², outwards (along x in the block) fastest.
    pub cells: Vec<Vec<u32>>,
}

/// One quadrilateral, by the intervals of its parameters.
enum DiscCell {
    /// In the block −1 ≤ s, t ≤ 1.
    Block { s: [f64; 2], t: [f64; 2] },
    /// Between one radius and the next, between two multiples of 45°.
    Ring { ring: usize, eighths: [f64; 2] },
}

/// Parameters of a plan.
pub(super) struct Outline<'a> {
    /// Half the width of the block, then the outer radius of each ring, in m, ascending: at least
    /// two.
    pub radii_m: &'a [f64],
    /// The part that is meshed.
    pub symmetry: Symmetry,
    /// Cells along half a side of the block, and in 45°.
    pub around: usize,
}

impl DiscPlan {
    /// Places cells with nodes at these parameters, from 0 to 1, ends included.
    pub fn new(outline: &Outline<'_>, parameters: &[f64]) -> Self {
        let mut plan = Self { nodes_m: Vec::new(), cells: Vec::new() };
        let same_m = 1e-6 * outline.radii_m[0] / outline.around as f64;
        for cell in outline.cells() {
            let nodes = parameters.iter().flat_map(|&eta| parameters.iter().map(move |&xi| (xi, eta)));
            let nodes = nodes.map(|(xi, eta)| plan.node(outline.place(&cell, xi, eta), same_m)).collect();
            plan.cells.push(nodes);
        }
        plan
    }

    /// The node at a position: adjacent cells share their nodes.
    fn node(&mut self, place: [f64; 2], same_m: f64) -> u32 {
        let near = |node: &[f64; 2]| (node[0] - place[0]).abs() + (node[1] - place[1]).abs() < same_m;
        let found = self.nodes_m.iter().position(near).unwrap_or_else(|| {
            self.nodes_m.push(place);
            self.nodes_m.len() - 1
        });
        number_node(found)
    }
}

impl Outline<'_> {
    fn cells(&self) -> Vec<DiscCell> {
        let around = self.around as i32;
        let (left, below, eighths) = match self.symmetry {
            Symmetry::Quarter => (0, 0, 2),
            Symmetry::Half => (-around, 0, 4),
            Symmetry::Full => (-around, -around, 8),
        };
        let interval = |at: i32| [f64::from(at) / f64::from(around), f64::from(at + 1) / f64::from(around)];
        let mut cells = Vec::new();
        for t in below..around {
            cells.extend((left..around).map(|s| DiscCell::Block { s: interval(s), t: interval(t) }));
        }
        for ring in 0..self.radii_m.len() - 1 {
            cells.extend((0..eighths * around).map(|at| DiscCell::Ring { ring, eighths: interval(at) }));
        }
        cells
    }

    /// Position of a point of a cell, in m; `xi` and `eta` are from 0 to 1.
    fn place(&self, cell: &DiscCell, xi: f64, eta: f64) -> [f64; 2] {
        let between = |[a, b]: [f64; 2], u: f64| a + (b - a) * u;
        match *cell {
            DiscCell::Block { s, t } => block(self.radii_m[0], between(s, xi), between(t, eta)),
            DiscCell::Ring { ring, eighths } => {
                let eighth = between(eighths, eta);
                let outer = circle(self.radii_m[ring + 1], eighth);
                let inner = if ring == 0 { rim(self.radii_m[0], eighth) } else { circle(self.radii_m[ring], eighth) };
                [between([inner[0], outer[0]], xi), between([inner[1], outer[1]], xi)]
            }
        }
    }
}

/// A point of the block, whose sides are curved so that no corner is sharp.
fn block(half_m: f64, s: f64, t: f64) -> [f64; 2] {
    let narrowing = |u: f64| 1.0 - (1.0 - CORNER) * u * u;
    [half_m * s * narrowing(t), half_m * t * narrowing(s)]
}

/// The point of the block's rim at a multiple of 45°.
fn rim(half_m: f64, eighth: f64) -> [f64; 2] {
    let quarter = ((eighth + 1.0) / 2.0).floor();
    let [x, y] = block(half_m, 1.0, eighth - 2.0 * quarter);
    match quarter as i32 % 4 {
        0 => [x, y],
        1 => [-y, x],
        2 => [-x, -y],
        _ => [y, -x],
    }
}

fn circle(radius_m: f64, eighth: f64) -> [f64; 2] {
    let angle = FRAC_PI_4 * eighth;
    [radius_m * libm::cos(angle), radius_m * libm::sin(angle)]
}
