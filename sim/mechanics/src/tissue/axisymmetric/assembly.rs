//! Which unknowns an element has, and the factorised sum of the elements.

use super::element::{AxialIntegrals, RadialIntegrals, stiffness};
use super::mesh::Spans;
use super::{AxisymmetricError, Side};
use crate::tissue::multifrontal::{Cholesky, Connectivity, FIXED};
use crate::tissue::{ElasticLayer, Slab};

/// The nodes of a mesh: a column of them at each radius, column after column from the axis.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub radial: Spans,
    pub axial: Spans,
    /// The unknowns (u_r, u_z) of each node, u_z along the depth.
    pub nodes: Vec<[u32; 2]>,
    /// How many unknowns there are.
    pub unknowns: usize,
}

impl Grid {
    pub fn new(radial: Spans, axial: Spans, side: Side) -> Self {
        let (columns, rows) = (radial.nodes(), axial.nodes());
        let mut next = 0;
        let mut take = |free: bool| {
            let unknown = if free { next } else { FIXED };
            next += u32::from(free);
            unknown
        };
        let nodes = (0..columns * rows).map(|node| {
            let (at_axis, at_side, at_base) = (node < rows, node / rows + 1 == columns, node % rows + 1 == rows);
            let slides = !at_side || side == Side::Sliding;
            [take(!at_axis && !at_side && !at_base), take(!at_base && slides)]
        });
        let nodes = nodes.collect();
        Self { radial, axial, nodes, unknowns: next as usize }
    }

    /// The elements' stiffnesses, summed and factorised.
    pub fn factorise(&self, slab: &Slab) -> Result<Cholesky, AxisymmetricError> {
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

    /// The layer of each axial strip.
    fn layers<'a>(&self, slab: &'a Slab) -> Vec<&'a ElasticLayer> {
        let boundaries_m = slab.boundaries_m();
        let last = slab.layers.len() - 1;
        let below = |depth_m: f64| boundaries_m[1..=last].partition_point(|&boundary| boundary < depth_m);
        self.axial.all().iter().map(|span| &slab.layers[below(span.middle_m())]).collect()
    }

    /// The unknowns and the middle of each element, a column of elements after the other.
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
