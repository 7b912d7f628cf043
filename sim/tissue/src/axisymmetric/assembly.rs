//! The unknowns of each element, and the factorised sum of the elements.

use super::basis::basis;
use super::element::{AxialIntegrals, RadialIntegrals};
use super::mesh::Spans;
use super::{AxisymmetricError, Side};
use crate::multifrontal::{Cholesky, Connectivity, FIXED};
use crate::{ElasticLayer, Slab};

/// The nodes of a mesh: a column of them at each radius, column after column from the axis.
#[derive(Clone, Debug)]
pub(super) struct ElementGrid<const N: usize> {
    pub radial: Spans,
    pub axial: Spans,
    /// The unknowns of each node.
    nodes: Vec<[u32; N]>,
    /// Number of unknowns.
    pub unknowns: usize,
}

/// The edges of the tissue that a node lies on.
struct Edges {
    axis: bool,
    side: bool,
    base: bool,
}

/// Fills the stiffness of an element, as `element::stiffness` does.
pub(super) type Stiffness = fn(&ElasticLayer, &RadialIntegrals, &AxialIntegrals, &mut [f64]);

impl ElementGrid<2> {
    /// The nodes of an axisymmetric problem: (u_r, u_z) at each, u_z along the depth.
    pub fn straight(radial: Spans, axial: Spans, side: Side) -> Self {
        Self::new(radial, axial, |at| {
            let slides = !at.side || side == Side::Sliding;
            [!at.axis && !at.side && !at.base, !at.base && slides]
        })
    }
}

impl ElementGrid<3> {
    /// The nodes of the first harmonic: (s, t, q) at each, as in [`super::sideways`].
    pub fn sideways(radial: Spans, axial: Spans) -> Self {
        Self::new(radial, axial, |at| {
            let free = !at.side && !at.base;
            [free, free && !at.axis, free && !at.axis]
        })
    }
}

impl<const N: usize> ElementGrid<N> {
    fn new(radial: Spans, axial: Spans, free: impl Fn(&Edges) -> [bool; N]) -> Self {
        let (columns, rows) = (radial.nodes(), axial.nodes());
        let mut next = 0;
        let mut take = |free: bool| {
            let unknown = if free { next } else { FIXED };
            next += u32::from(free);
            unknown
        };
        let nodes = (0..columns * rows).map(|node| {
            let base = node % rows + 1 == rows;
            free(&Edges { axis: node < rows, side: node / rows + 1 == columns, base }).map(&mut take)
        });
        let nodes = nodes.collect();
        Self { radial, axial, nodes, unknowns: next as usize }
    }

    /// Sums and factorises the elements' stiffnesses.
    pub fn factorise(&self, slab: &Slab, stiffness: Stiffness) -> Result<Cholesky, AxisymmetricError> {
        let radial: Vec<_> = self.radial.all().iter().map(RadialIntegrals::new).collect();
        let axial: Vec<_> = self.axial.all().iter().map(AxialIntegrals::new).collect();
        let layers = self.layers(slab);
        let (elements, centroids_m) = self.elements();
        let connectivity = Connectivity { unknowns: self.unknowns, elements: &elements, centroids_m: &centroids_m };
        let rows = axial.len();
        Ok(Cholesky::factorise(&connectivity, |element, matrix| {
            stiffness(layers[element % rows], &radial[element / rows], &axial[element % rows], matrix);
        })?)
    }

    /// Forces on the unknowns: on one component of each node, the weight of its column times that
    /// of its row.
    pub fn load(&self, component: usize, across: &[f64], along: &[f64]) -> Vec<f64> {
        let mut load = vec![0.0; self.unknowns];
        let unknowns = self.nodes.iter().map(|node| node[component]).enumerate();
        for (node, unknown) in unknowns.filter(|&(_, unknown)| unknown != FIXED) {
            load[unknown as usize] = across[node / along.len()] * along[node % along.len()];
        }
        load
    }

    /// Every component of a solution at a radius and a depth in m; zero outside the tissue.
    pub fn at(&self, solution: &[f64], r_m: f64, depth_m: f64) -> [f64; N] {
        let mut found = [0.0; N];
        let (Some((across, x)), Some((along, y))) = (self.radial.find(r_m), self.axial.find(depth_m)) else {
            return found;
        };
        let (phi, psi) = (basis(across.order).values(x), basis(along.order).values(y));
        for (column, phi) in phi[..=across.order].iter().enumerate() {
            let first = (across.first + column) * self.axial.nodes() + along.first;
            for (unknowns, psi) in self.nodes[first..=first + along.order].iter().zip(psi) {
                for (sum, &unknown) in found.iter_mut().zip(unknowns) {
                    *sum += phi * psi * solution.get(unknown as usize).copied().unwrap_or(0.0);
                }
            }
        }
        found
    }

    /// Memory of the nodes, in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..])
    }

    /// The layer of each axial strip.
    fn layers<'a>(&self, slab: &'a Slab) -> Vec<&'a ElasticLayer> {
        let boundaries_m = slab.boundaries_m();
        let last = slab.layers.len() - 1;
        let below = |depth_m: f64| boundaries_m[1..=last].partition_point(|&boundary| boundary < depth_m);
        self.axial.all().iter().map(|span| &slab.layers[below(span.middle_m())]).collect()
    }

    /// The unknowns and the middle of each element, ordered by columns of elements.
    fn elements(&self) -> (Vec<Vec<u32>>, Vec<[f64; 3]>) {
        let rows = self.axial.nodes();
        let pairs =
            self.radial.all().iter().flat_map(|across| self.axial.all().iter().map(move |along| (across, along)));
        let element = pairs.map(|(across, along)| {
            let columns = across.first..=across.first + across.order;
            let in_column = |column: usize| &self.nodes[column * rows + along.first..][..=along.order];
            let unknowns = columns.flat_map(in_column).flatten().copied().collect();
            (unknowns, [across.middle_m(), 0.0, along.middle_m()])
        });
        element.unzip()
    }
}
