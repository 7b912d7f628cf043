//! The node positions: planes through the interfaces of the layers, with a square mesh in each.

use law::axial::{Domain, ParamError};

use super::LatticeError;
use super::calibration::HEIGHT_PER_WIDTH;
use super::lanes::LANES;
use crate::{ElasticLayer, Slab};

/// Maximum number of degrees of freedom: 6 million take 2 GB and a minute to relax, and nothing
/// shipped needs more.
pub const MAX_UNKNOWNS: usize = 6_000_000;

/// The computed part of the tissue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LatticeSymmetry {
    /// A quarter, between the planes x = 0 and y = 0: for loads that are symmetric about both.
    Quarter,
    /// The whole tissue.
    Full,
}

/// The part of the tissue that a lattice covers: a disc around the axis, held at its rim and base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatticePatch {
    /// Horizontal distance of neighbouring nodes, in m.
    pub spacing_m: f64,
    /// Radius of the held rim, in m. Rounded to a multiple of the spacing.
    pub radius_m: f64,
    /// Depth of the held base, in m. Rounded up to a plane of nodes and limited to the tissue.
    pub depth_m: f64,
    /// The computed part.
    pub symmetry: LatticeSymmetry,
}

/// A slice of cells between two planes of nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Storey {
    /// Index of its layer in the slab.
    pub(super) layer: usize,
    /// Height, in m.
    pub(super) height_m: f64,
}

/// The nodes of a lattice, in rows along x, ordered along y and then downwards.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Grid {
    pub(super) spacing_m: f64,
    pub(super) symmetry: LatticeSymmetry,
    /// Nodes from the axis to the rim.
    pub(super) reach: usize,
    /// Nodes along x, and along y.
    pub(super) side: usize,
    pub(super) storeys: Vec<Storey>,
    /// Depth of each plane of nodes, in m.
    pub(super) depths_m: Vec<f64>,
}

impl Grid {
    pub(super) fn new(slab: &Slab, patch: &LatticePatch) -> Result<Self, LatticeError> {
        slab.check()?;
        Domain::Positive.check("spacing_m", patch.spacing_m, "m")?;
        Domain::Positive.check("patch.radius_m", patch.radius_m, "m")?;
        Domain::Positive.check("patch.depth_m", patch.depth_m, "m")?;
        let reach = (patch.radius_m.min(slab.radius_m) / patch.spacing_m).round();
        if reach < 1.0 {
            let allowed = "must be at least half the spacing of the lattice";
            let field = "patch.radius_m".into();
            return Err(ParamError { field, value: patch.radius_m, unit: "m", allowed }.into());
        }
        affordable(slab, patch)?;
        let reach = reach as usize;
        let side = if patch.symmetry == LatticeSymmetry::Full { 2 * reach + 1 } else { reach + 1 };
        let storeys = storeys(slab, patch)?;
        let mut depths_m = vec![0.0];
        // A layer's planes are counted from its top, so that sums of heights do not drift from its
        // interfaces.
        let tops_m = slab.boundaries_m();
        for (at, storey) in storeys.iter().enumerate() {
            let above = storeys[..at].iter().rev().take_while(|s| s.layer == storey.layer).count();
            depths_m.push(tops_m[storey.layer] + storey.height_m * (above + 1) as f64);
        }
        let (spacing_m, symmetry) = (patch.spacing_m, patch.symmetry);
        Ok(Self { spacing_m, symmetry, reach, side, storeys, depths_m })
    }

    /// Depth of the held base, in m.
    pub(super) fn depth_m(&self) -> f64 {
        self.depths_m[self.storeys.len()]
    }

    /// Column or row of the axis.
    pub(super) fn centre(&self) -> usize {
        if self.symmetry == LatticeSymmetry::Full { self.reach } else { 0 }
    }

    /// Number of places in a plane, a multiple of the lanes.
    pub(super) fn plane(&self) -> usize {
        (self.side * self.side).next_multiple_of(LANES)
    }

    /// Number of places of all nodes, plus one more plane and row: the kernel reads beyond the
    /// last, with a spring constant of 0.
    pub(super) fn places(&self) -> usize {
        self.plane() * (self.depths_m.len() + 1) + self.side + LANES
    }

    pub(super) fn place(&self, [i, j, k]: [usize; 3]) -> usize {
        k * self.plane() + j * self.side + i
    }

    /// All nodes, in the order of their places.
    pub(super) fn nodes(&self) -> impl Iterator<Item = [usize; 3]> + use<> {
        let (side, planes) = (self.side, self.depths_m.len());
        (0..planes).flat_map(move |k| (0..side).flat_map(move |j| (0..side).map(move |i| [i, j, k])))
    }

    /// Position of a node in the patient's frame, in m: z is up and 0 on the skin.
    pub(super) fn position_m(&self, [i, j, k]: [usize; 3]) -> [f64; 3] {
        let across_m = |at: usize| (at as f64 - self.centre() as f64) * self.spacing_m;
        [across_m(i), across_m(j), -self.depths_m[k]]
    }

    /// Whether a node moves: it is neither on the rim or beyond, nor on the base.
    pub(super) fn moves(&self, [i, j, k]: [usize; 3]) -> bool {
        let (x, y) = (i.abs_diff(self.centre()), j.abs_diff(self.centre()));
        x * x + y * y < self.reach * self.reach && k + 1 < self.depths_m.len()
    }

    /// Whether a node can move along an axis: on a plane of symmetry it stays in the plane.
    pub(super) fn is_free(&self, node: [usize; 3], axis: usize) -> bool {
        let on_plane = self.symmetry == LatticeSymmetry::Quarter && axis < 2 && node[axis] == 0;
        self.moves(node) && !on_plane
    }

    /// Whether a cell, identified by its first node, is part of the lattice: one of its nodes
    /// moves.
    pub(super) fn has_cell(&self, [i, j, k]: [usize; 3]) -> bool {
        [[0, 0], [1, 0], [0, 1], [1, 1]].iter().any(|[p, q]| self.moves([i + p, j + q, k]))
    }

    /// The plane of nodes at or next above a depth, in m, and the distance of the depth below it,
    /// from 0 to 1 storey.
    pub(super) fn storey_at(&self, depth_m: f64) -> (usize, f64) {
        let below = self.depths_m.partition_point(|&plane| plane <= depth_m);
        let upper = below.saturating_sub(1).min(self.storeys.len() - 1);
        (upper, ((depth_m - self.depths_m[upper]) / self.storeys[upper].height_m).clamp(0.0, 1.0))
    }
}

impl LatticePatch {
    /// Approximate number of degrees of freedom of a lattice on this patch of a slab, to a few
    /// percent.
    pub(super) fn unknowns(&self, slab: &Slab) -> f64 {
        let part = if self.symmetry == LatticeSymmetry::Full { 4.0 } else { 1.0 };
        let reach = self.radius_m.min(slab.radius_m) / self.spacing_m;
        let whole_m: f64 = slab.layers.iter().map(|layer| layer.thickness_m).sum();
        3.0 * part * std::f64::consts::FRAC_PI_4 * reach * reach * (self.depth_m.min(whole_m) / self.spacing_m)
    }
}

/// Rejects a lattice that is too large, with the cause and the nearest feasible spacing.
fn affordable(slab: &Slab, patch: &LatticePatch) -> Result<(), LatticeError> {
    let (unknowns, limit) = (patch.unknowns(slab), MAX_UNKNOWNS as f64);
    if unknowns <= limit {
        return Ok(());
    }
    let nearest_m = patch.spacing_m * libm::cbrt(unknowns / limit);
    Err(LatticeError::TooLarge { spacing_m: patch.spacing_m, unknowns, nearest_m })
}

/// The layers with a thickness that begin above a depth, in m, each with its index and the depth of
/// its top, in m. A layer without a thickness bears no load.
fn reached(slab: &Slab, depth_m: f64) -> impl Iterator<Item = (usize, f64, &ElasticLayer)> {
    let layers = slab.boundaries_m().into_iter().zip(&slab.layers).enumerate();
    let layers = layers.map(|(at, (top_m, layer))| (at, top_m, layer));
    layers.filter(move |(_, top_m, layer)| *top_m < depth_m * (1.0 - 1e-9) && layer.thickness_m > 0.0)
}

/// Splits the layers down to the patch's depth into storeys whose height suits the spacing.
fn storeys(slab: &Slab, patch: &LatticePatch) -> Result<Vec<Storey>, LatticeError> {
    let mut storeys = Vec::new();
    for (layer, top_m, part) in reached(slab, patch.depth_m) {
        let thickness_m = part.thickness_m;
        let count = storey_count(thickness_m, patch.spacing_m).ok_or_else(|| LatticeError::Spacing {
            layer,
            thickness_m,
            nearest_m: nearest_spacing_m(slab, patch),
        })?;
        let height_m = thickness_m / count;
        let wanted = ((patch.depth_m - top_m) / height_m * (1.0 - 1e-9)).ceil().min(count);
        storeys.extend((0..wanted as usize).map(|_| Storey { layer, height_m }));
    }
    Ok(storeys)
}

/// Number of storeys, near to cubes, of a layer; `None` if no whole number gives only attractive
/// springs.
fn storey_count(thickness_m: f64, spacing_m: f64) -> Option<f64> {
    let [low, tall] = HEIGHT_PER_WIDTH.map(|height| thickness_m / (height * spacing_m));
    // The nearest to a cube within the limits, inclusive.
    let count = (thickness_m / spacing_m).round().max((tall * (1.0 - 1e-9)).ceil()).max(1.0);
    let count = if count <= low * (1.0 + 1e-9) { count } else { (low * (1.0 + 1e-9)).floor() };
    (count >= 1.0 && count >= tall * (1.0 - 1e-9)).then_some(count)
}

/// The thinnest layer that begins above a depth in m, in m.
pub(super) fn thinnest_m(slab: &Slab, depth_m: f64) -> f64 {
    reached(slab, depth_m).fold(f64::INFINITY, |least, (.., layer)| least.min(layer.thickness_m))
}

/// The widest spacing up to the patch's at which every layer within the patch can be split, in m.
pub(super) fn nearest_spacing_m(slab: &Slab, patch: &LatticePatch) -> f64 {
    let thinnest_m = thinnest_m(slab, patch.depth_m);
    // From two storeys on there is a number of storeys for every spacing, so the last candidate
    // always fits.
    let always_m = thinnest_m * std::f64::consts::FRAC_1_SQRT_2;
    let widest_m = patch.spacing_m.min(thinnest_m * std::f64::consts::SQRT_2);
    let mut steps = (0..=100).map(|step| widest_m + (always_m.min(widest_m) - widest_m) * f64::from(step) / 100.0);
    let layers = || reached(slab, patch.depth_m);
    let fits = |&spacing_m: &f64| layers().all(|(.., layer)| storey_count(layer.thickness_m, spacing_m).is_some());
    steps.find(fits).unwrap_or(always_m)
}
