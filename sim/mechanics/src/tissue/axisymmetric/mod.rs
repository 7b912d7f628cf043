//! Finite elements in (r, z): a perpendicular needle in flat layers, exactly in its dimension.
//!
//! Elements of high order on a tensor-product mesh, graded towards the load, every interface and the load's depth a line
//! of the mesh. Order 2 and more does not lock, so the Poisson ratio may come near one half. What is inside an element
//! is eliminated with it (`super::multifrontal`), and a re-solve is a back-substitution.

mod basis;
mod element;
mod fit;
mod grading;
mod load;
mod mesh;
mod superposed;

pub use basis::MAX_ORDER;
pub use fit::{Fitted, fit};
pub use mesh::{MeshSpec, Strip};
pub use superposed::Superposed;

use super::multifrontal::{Cholesky, Connectivity, FIXED, NotPositiveDefinite};
use super::{FieldModel, Model, Problem};
use crate::axial::ParamError;
use basis::basis;
use element::{AxialIntegrals, RadialIntegrals};
use mesh::Spans;

/// Why there is no model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AxisymmetricError {
    /// A number of the problem or of the mesh is out of its range.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// The contrasts are beyond what double precision resolves.
    #[error(transparent)]
    Singular(#[from] NotPositiveDefinite),
}

/// What the side r = R does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Nothing moves.
    Clamped,
    /// It slides along a smooth wall: a column in a tube.
    Sliding,
}

/// A load on layers, meshed and factorised.
#[derive(Clone, Debug)]
pub struct Axisymmetric {
    radial: Spans,
    axial: Spans,
    /// The unknowns (u_r, u_z) of each node, column of nodes after column.
    unknowns: Vec<[u32; 2]>,
    factor: Cholesky,
    load: Vec<f64>,
    solution: Vec<f64>,
    scratch: Vec<f64>,
}

impl Axisymmetric {
    /// Meshes and factorises a problem, and solves it for 1 N.
    ///
    /// # Errors
    /// The first number that is out of range, or contrasts beyond double precision.
    pub fn new(problem: &Problem, mesh: &MeshSpec) -> Result<Self, AxisymmetricError> {
        Self::with_side(problem, mesh, Side::Clamped)
    }

    /// The same with another side, for columns whose answer has a closed form.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_side(problem: &Problem, mesh: &MeshSpec, side: Side) -> Result<Self, AxisymmetricError> {
        problem.check()?;
        mesh.check(problem)?;
        let (radial, axial) = (Spans::new(&mesh.radial), Spans::new(&mesh.axial));
        let (unknowns, count) = number(&radial, &axial, side);
        let factor = factorise(problem, [&radial, &axial], (&unknowns, count))?;
        let across = load::across(problem.load.radius_m, &radial);
        let along = load::along(&problem.load, &axial);
        let mut load = vec![0.0; count];
        for (node, &[_, axial]) in unknowns.iter().enumerate().filter(|(_, u)| u[1] != FIXED) {
            load[axial as usize] = -across[node / along.len()] * along[node % along.len()];
        }
        let scratch = vec![0.0; factor.scratch_len()];
        let mut model = Self { radial, axial, unknowns, factor, solution: load.clone(), load, scratch };
        model.solve(1.0);
        Ok(model)
    }
}

fn number(radial: &Spans, axial: &Spans, side: Side) -> (Vec<[u32; 2]>, usize) {
    let (columns, rows) = (radial.nodes(), axial.nodes());
    let mut next = 0;
    let mut take = |free: bool| {
        let unknown = if free { next } else { FIXED };
        next += u32::from(free);
        unknown
    };
    let unknowns = (0..columns * rows)
        .map(|node| {
            let (i, j) = (node / rows, node % rows);
            let (at_side, at_base) = (i + 1 == columns, j + 1 == rows);
            [take(i > 0 && !at_side && !at_base), take(!at_base && (!at_side || side == Side::Sliding))]
        })
        .collect();
    (unknowns, next as usize)
}

fn factorise(
    problem: &Problem,
    [radial, axial]: [&Spans; 2],
    (unknowns, count): (&[[u32; 2]], usize),
) -> Result<Cholesky, AxisymmetricError> {
    let rows = axial.nodes();
    let r: Vec<_> = radial.all().iter().map(RadialIntegrals::new).collect();
    let z: Vec<_> = axial.all().iter().map(AxialIntegrals::new).collect();
    let boundaries = problem.slab.boundaries_m();
    let (mut elements, mut centroids_m) = (Vec::new(), Vec::new());
    for (across, along) in radial.all().iter().flat_map(|a| axial.all().iter().map(move |b| (a, b))) {
        let nodes = (across.first..=across.first + across.order)
            .flat_map(|i| (along.first..=along.first + along.order).map(move |j| i * rows + j));
        elements.push(nodes.flat_map(|node| unknowns[node]).collect::<Vec<u32>>());
        centroids_m.push([across.middle_m(), 0.0, along.middle_m()]);
    }
    let connectivity = Connectivity { unknowns: count, elements: &elements, centroids_m: &centroids_m };
    let layers = axial
        .all()
        .iter()
        .map(|span| {
            let at = boundaries[1..].partition_point(|&b| b < span.middle_m());
            &problem.slab.layers[at.min(problem.slab.layers.len() - 1)]
        })
        .collect::<Vec<_>>();
    let strips = z.len();
    Ok(Cholesky::factorise(&connectivity, |e, matrix| {
        element::stiffness(layers[e % strips], &r[e / strips], &z[e % strips], matrix);
    })?)
}

impl FieldModel for Axisymmetric {
    fn model(&self) -> Model {
        Model::Axisymmetric
    }

    fn unknowns(&self) -> usize {
        self.load.len()
    }

    fn bytes(&self) -> usize {
        let numbers = self.load.len() + self.solution.len() + self.scratch.len() + self.unknowns.len();
        self.factor.bytes() + 8 * numbers
    }

    fn solve(&mut self, force_n: f64) {
        for (value, load) in self.solution.iter_mut().zip(&self.load) {
            *value = load * force_n;
        }
        self.factor.solve(&mut self.solution, &mut self.scratch);
    }

    fn displacement_m(&self, r_m: f64, depth_m: f64) -> [f64; 2] {
        let (Some((across, x)), Some((along, y))) = (self.radial.find(r_m), self.axial.find(depth_m)) else {
            return [0.0; 2];
        };
        let (phi, psi) = (basis(across.order).values(x), basis(along.order).values(y));
        let rows = self.axial.nodes();
        let (mut axial_m, mut radial_m) = (0.0, 0.0);
        for (i, phi) in phi[..=across.order].iter().enumerate() {
            let first = (across.first + i) * rows + along.first;
            for (&[radial, axial], psi) in self.unknowns[first..=first + along.order].iter().zip(psi) {
                radial_m += phi * psi * self.solution.get(radial as usize).unwrap_or(&0.0);
                axial_m += phi * psi * self.solution.get(axial as usize).unwrap_or(&0.0);
            }
        }
        [axial_m, radial_m]
    }
}
