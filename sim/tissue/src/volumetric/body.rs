//! An elastic body: elements, their material at every quadrature point, held directions, and nodal
//! masses.

use nalgebra::{Matrix3, Point3, Vector3};

use super::basis::Table;
use super::element::{BasisShape, stiffness};
use super::kernel::{self, zeros};
use super::locate::Locator;
use super::mesh::{HexMesh, ORDERS};
use super::rotation::nearest_rotation;
use super::{Material, Symmetry, VolumetricError};
use crate::multifrontal::{Cholesky, Connectivity, FIXED};

/// A quadrature point of an element at rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct MaterialPoint {
    /// Derivatives of ξ, η, ζ (rows) by x, y, z, in 1/m.
    pub inverse: Matrix3<f64>,
    /// Its volume times Lamé's λ, in J.
    pub lambda_j: f64,
    /// Its volume times Lamé's μ, in J.
    pub mu_j: f64,
}

/// One-dimensional polynomials of the body's order.
#[derive(Clone, Debug)]
enum OrderTables {
    Two(Box<Table<3>>),
    Three(Box<Table<4>>),
    Four(Box<Table<5>>),
}

/// Hexahedra of given materials, some of whose nodes are held.
#[derive(Clone, Debug)]
pub struct Body {
    mesh: HexMesh,
    locator: Locator,
    tables: OrderTables,
    /// For every element, (order + 1)³ points, the first direction fastest.
    points: Vec<MaterialPoint>,
    /// For every element, three unknowns per node; [`FIXED`] is held.
    unknowns: Vec<u32>,
    /// Lumped mass of each unknown, in kg.
    mass_kg: Vec<f64>,
}

impl Body {
    /// A body at rest. `material(element, point)` is called at every quadrature point, `held(node)`
    /// at every node for all directions.
    ///
    /// # Errors
    /// If an element is inverted, or the order is not supported.
    pub fn new(
        mesh: HexMesh,
        material: impl Fn(usize, &Point3<f64>) -> Material,
        held: impl Fn(usize) -> [bool; 3],
    ) -> Result<Self, VolumetricError> {
        let tables = match mesh.order {
            2 => OrderTables::Two(Box::new(Table::new())),
            3 => OrderTables::Three(Box::new(Table::new())),
            4 => OrderTables::Four(Box::new(Table::new())),
            order => return Err(VolumetricError::Order(order, *ORDERS.start(), *ORDERS.end())),
        };
        let (unknowns, count) = number(&mesh, held);
        let mut body = Self {
            locator: Locator::new(&mesh),
            mesh,
            tables,
            points: Vec::new(),
            unknowns,
            mass_kg: vec![0.0; count],
        };
        let shape = BasisShape::new(body.mesh.order);
        for element in 0..body.elements() {
            body.add_points(&shape, element, &material)?;
        }
        Ok(body)
    }

    /// Computes the quadrature points of an element and adds its mass to its nodes.
    fn add_points(
        &mut self,
        shape: &BasisShape,
        element: usize,
        material: &impl Fn(usize, &Point3<f64>) -> Material,
    ) -> Result<(), VolumetricError> {
        let nodes = &self.mesh.elements[element * shape.nodes..][..shape.nodes];
        for (at, weight) in shape.weights.iter().enumerate() {
            let (mut place, mut jacobian) = (Vector3::zeros(), Matrix3::zeros());
            for (node, (value, slope)) in nodes.iter().zip(shape.at(at)) {
                let rest = self.mesh.nodes_m[*node as usize].coords;
                place += rest * *value;
                jacobian += rest * slope.transpose();
            }
            let determinant = jacobian.determinant();
            let inverse = jacobian.try_inverse().filter(|_| determinant > 0.0);
            let inverse = inverse.ok_or(VolumetricError::Inverted { element, determinant })?;
            let found = material(element, &Point3::from(place));
            let volume_m3 = weight * determinant;
            let (lambda_pa, mu_pa) = found.lame_pa();
            self.points.push(MaterialPoint { inverse, lambda_j: volume_m3 * lambda_pa, mu_j: volume_m3 * mu_pa });
            let unknowns = &self.unknowns[3 * element * shape.nodes..][..3 * shape.nodes];
            for (unknowns, (value, _)) in unknowns.chunks_exact(3).zip(shape.at(at)) {
                for &unknown in unknowns.iter().filter(|&&unknown| unknown != FIXED) {
                    self.mass_kg[unknown as usize] += found.density_kg_per_m3 * volume_m3 * value;
                }
            }
        }
        Ok(())
    }

    /// Number of elements.
    #[must_use]
    pub fn elements(&self) -> usize {
        self.mesh.elements.len() / self.mesh.nodes_each()
    }

    /// Number of unknowns.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.mass_kg.len()
    }

    /// The mesh at rest.
    #[must_use]
    pub fn mesh(&self) -> &HexMesh {
        &self.mesh
    }

    pub(super) fn locator(&self) -> &Locator {
        &self.locator
    }

    /// Displacement, in m, of the point at `point` at rest; zero outside the mesh. Never allocates.
    #[must_use]
    pub fn displacement_m(&self, u_m: &[f64], point: &Point3<f64>) -> Vector3<f64> {
        let mut moved = Vector3::zeros();
        if let Some(place) = self.locator.find(&self.mesh, point) {
            let unknowns = self.unknowns_of(place.element);
            self.locator.each(&place.at, |node, value, _| {
                for (axis, &unknown) in unknowns[3 * node..][..3].iter().enumerate().filter(|&(_, &u)| u != FIXED) {
                    moved[axis] += value * u_m[unknown as usize];
                }
            });
        }
        moved
    }

    /// The displacement for a body of which only a part is meshed.
    pub(super) fn mirrored_m(&self, symmetry: Symmetry, u_m: &[f64], point: &Point3<f64>) -> Vector3<f64> {
        let flip_x = symmetry == Symmetry::Quarter && point.x < 0.0;
        let flip_y = symmetry != Symmetry::Full && point.y < 0.0;
        let signs = Vector3::new(if flip_x { -1.0 } else { 1.0 }, if flip_y { -1.0 } else { 1.0 }, 1.0);
        let mirrored = Point3::from(point.coords.component_mul(&signs));
        self.displacement_m(u_m, &mirrored).component_mul(&signs)
    }

    /// Lumped mass of each unknown, in kg: the row sums of the consistent mass.
    #[must_use]
    pub fn mass_kg(&self) -> &[f64] {
        &self.mass_kg
    }

    /// Unknowns of an element, three for each node.
    #[must_use]
    pub fn unknowns_of(&self, element: usize) -> &[u32] {
        let each = 3 * self.mesh.nodes_each();
        &self.unknowns[element * each..][..each]
    }

    /// Memory of the body, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.locator.bytes()
            + size_of_val(&self.mesh.nodes_m[..])
            + size_of_val(&self.mesh.elements[..])
            + size_of_val(&self.points[..])
            + size_of_val(&self.unknowns[..])
            + size_of_val(&self.mass_kg[..])
    }

    /// The values of the unknowns, in m, for a displacement field.
    #[must_use]
    pub fn interpolate_m(&self, displacement_m: impl Fn(&Point3<f64>) -> Vector3<f64>) -> Vec<f64> {
        let mut u_m = vec![0.0; self.unknowns()];
        for (unknowns, &node) in self.unknowns.chunks_exact(3).zip(&self.mesh.elements) {
            let value = displacement_m(&self.mesh.nodes_m[node as usize]);
            for (&unknown, value) in unknowns.iter().zip(&value).filter(|&(&unknown, _)| unknown != FIXED) {
                u_m[unknown as usize] = *value;
            }
        }
        u_m
    }

    /// Factorises the stiffness at rest plus `mass_per_s2`, in 1/s², times the mass.
    ///
    /// # Errors
    /// If a part of the body is free to move.
    pub fn factorise(&self, mass_per_s2: f64) -> Result<Cholesky, VolumetricError> {
        let each = self.mesh.nodes_each();
        let elements: Vec<Vec<u32>> = self.unknowns.chunks_exact(3 * each).map(<[u32]>::to_vec).collect();
        let centroids_m: Vec<[f64; 3]> = self.mesh.iter().map(|nodes| self.centroid_m(nodes)).collect();
        let connectivity = Connectivity { unknowns: self.unknowns(), elements: &elements, centroids_m: &centroids_m };
        let shape = BasisShape::new(self.mesh.order);
        // The lumped mass of a node is added once, with its first element.
        let mut left: Vec<f64> = self.mass_kg.iter().map(|mass| mass * mass_per_s2).collect();
        let factor = Cholesky::factorise(&connectivity, |element, matrix| {
            stiffness(&shape, &self.points[element * each..][..each], matrix);
            for (at, &unknown) in elements[element].iter().enumerate().filter(|&(_, &unknown)| unknown != FIXED) {
                matrix[at * (3 * each + 1)] += std::mem::take(&mut left[unknown as usize]);
            }
        })?;
        Ok(factor)
    }

    fn centroid_m(&self, nodes: &[u32]) -> [f64; 3] {
        let sum: Vector3<f64> = nodes.iter().map(|&node| self.mesh.nodes_m[node as usize].coords).sum();
        (sum / nodes.len() as f64).into()
    }

    /// Elastic energy, in J, of displacements in m. Adds its gradient, the force that holds the
    /// body there, to `force_n`, in N.
    ///
    /// Corotated elasticity: Ψ = μ ‖F − R‖² + λ/2 tr²(RᵀF − I) with R the rotation nearest to F, so
    /// that rotation costs no energy; dR does no work on the stress, hence P = 2μ (F − R) + λ
    /// tr(RᵀF − I) R (Sifakis and Barbič 2012, 3.4). R is evaluated at every quadrature point: with
    /// one rotation per element the force would not be a gradient, and a descent step could not be
    /// distinguished from an ascent.
    pub fn energy_j(&self, u_m: &[f64], force_n: &mut [f64]) -> f64 {
        match &self.tables {
            OrderTables::Two(table) => self.sum(table, u_m, force_n, corotated),
            OrderTables::Three(table) => self.sum(table, u_m, force_n, corotated),
            OrderTables::Four(table) => self.sum(table, u_m, force_n, corotated),
        }
    }

    /// The energy for small strains, ½ uᵀ K u: Ψ = μ ‖ε‖² + λ/2 tr² ε.
    pub fn linear_energy_j(&self, u_m: &[f64], force_n: &mut [f64]) -> f64 {
        match &self.tables {
            OrderTables::Two(table) => self.sum(table, u_m, force_n, linear),
            OrderTables::Three(table) => self.sum(table, u_m, force_n, linear),
            OrderTables::Four(table) => self.sum(table, u_m, force_n, linear),
        }
    }

    fn sum<const N: usize>(
        &self,
        table: &Table<N>,
        u_m: &[f64],
        force_n: &mut [f64],
        law: impl Fn(&MaterialPoint, &Matrix3<f64>) -> (f64, Matrix3<f64>),
    ) -> f64 {
        let mut energy_j = 0.0;
        let each = N * N * N;
        for (unknowns, points) in self.unknowns.chunks_exact(3 * each).zip(self.points.chunks_exact(each)) {
            let mut nodes = zeros::<N>();
            let values = nodes.as_flattened_mut().as_flattened_mut().as_flattened_mut();
            for (value, &unknown) in values.iter_mut().zip(unknowns).filter(|&(_, &unknown)| unknown != FIXED) {
                *value = u_m[unknown as usize];
            }
            let mut gradient = kernel::to_points(table, &nodes);
            let [xi, eta, zeta] = gradient.each_mut().map(|cube| cube.as_flattened_mut().as_flattened_mut());
            for (((point, xi), eta), zeta) in points.iter().zip(xi).zip(eta).zip(zeta) {
                let by_parameters = Matrix3::from_columns(&[(*xi).into(), (*eta).into(), (*zeta).into()]);
                let (energy, stress) = law(point, &(by_parameters * point.inverse));
                energy_j += energy;
                let back = stress * point.inverse.transpose();
                (*xi, *eta, *zeta) = (back.column(0).into(), back.column(1).into(), back.column(2).into());
            }
            let nodes = kernel::to_nodes(table, &gradient);
            let values = nodes.as_flattened().as_flattened().as_flattened();
            for (value, &unknown) in values.iter().zip(unknowns).filter(|&(_, &unknown)| unknown != FIXED) {
                force_n[unknown as usize] += value;
            }
        }
        energy_j
    }
}

/// Energy and stress of a displacement gradient, times the volume: corotated.
fn corotated(point: &MaterialPoint, gradient: &Matrix3<f64>) -> (f64, Matrix3<f64>) {
    let f = gradient + Matrix3::identity();
    let r = nearest_rotation(&f);
    let difference = f - r;
    let trace = r.dot(&difference);
    let energy = point.mu_j * difference.norm_squared() + 0.5 * point.lambda_j * trace * trace;
    (energy, difference * (2.0 * point.mu_j) + r * (point.lambda_j * trace))
}

/// Energy and stress of a displacement gradient, times the volume: small strains.
fn linear(point: &MaterialPoint, gradient: &Matrix3<f64>) -> (f64, Matrix3<f64>) {
    let strain = (gradient + gradient.transpose()) * 0.5;
    let trace = strain.trace();
    let energy = point.mu_j * strain.norm_squared() + 0.5 * point.lambda_j * trace * trace;
    (energy, strain * (2.0 * point.mu_j) + Matrix3::from_diagonal_element(point.lambda_j * trace))
}

/// Numbers the free directions of the nodes in use; returns three numbers for each node of each
/// element, and their count.
fn number(mesh: &HexMesh, held: impl Fn(usize) -> [bool; 3]) -> (Vec<u32>, usize) {
    let mut count = 0;
    let numbers: Vec<[u32; 3]> = mesh
        .nodes_m
        .iter()
        .enumerate()
        .map(|(node, _)| {
            held(node).map(|is_held| {
                count += u32::from(!is_held);
                if is_held { FIXED } else { count - 1 }
            })
        })
        .collect();
    let unknowns = mesh.elements.iter().flat_map(|&node| numbers[node as usize]).collect();
    (unknowns, count as usize)
}
