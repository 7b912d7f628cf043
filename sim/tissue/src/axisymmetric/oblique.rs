//! An oblique needle in flat layers: two harmonics in (r, z) about the vertical through the load.
//!
//! A push along the needle is cos θ of one into the body, which has the vertical for its axis, and sin θ of one along the
//! skin, which is a first harmonic about it. Both are exact in flat layers. A drag leans: of each strip of the mesh it is
//! carried by several stations, each on its own vertical with its share of the strip, as Lagrange's polynomials interpolate
//! between them.

use super::assembly::ElementGrid;
use super::load::{AxisStation, across, stations};
use super::mesh::Spans;
use super::{AxisymmetricError, MeshSpec, Side, element, sideways};
use crate::multifrontal::Cholesky;
use crate::volumetric::Problem3;
use crate::{FieldModel, Load, Model};

/// An oblique load on flat layers, solved for 1 N. Displacements are those of the plane of the needle: at a place x along the
/// skin, towards which the needle leans, and a depth.
#[derive(Clone, Debug)]
pub struct Oblique {
    lean: Lean,
    /// Depth at which the needle meets the vertical of each station, in m.
    stations_m: Vec<f64>,
    into: Harmonic<2>,
    along: Harmonic<3>,
    force_n: f64,
}

/// Of the angle to the normal.
#[derive(Clone, Copy, Debug)]
struct Lean {
    sine: f64,
    cosine: f64,
    tangent: f64,
}

impl Lean {
    fn new(tilt_rad: f64) -> Self {
        Self { sine: libm::sin(tilt_rad), cosine: libm::cos(tilt_rad), tangent: libm::tan(tilt_rad) }
    }
}

/// One harmonic's answer to 1 N at each station, in m.
#[derive(Clone, Debug)]
struct Harmonic<const N: usize> {
    grid: ElementGrid<N>,
    solutions: Vec<Vec<f64>>,
}

impl<const N: usize> Harmonic<N> {
    /// Solves a load of `newtons` on a component at each station.
    fn new(
        grid: ElementGrid<N>,
        factor: &Cholesky,
        component: usize,
        across: &[f64],
        stations: &[AxisStation],
    ) -> Self {
        let mut scratch = vec![0.0; factor.scratch_len()];
        let mut solve = |station: &AxisStation| {
            let mut solution = grid.load(component, across, &station.along);
            factor.solve(&mut solution, &mut scratch);
            solution
        };
        let solutions = stations.iter().map(&mut solve).collect();
        Self { grid, solutions }
    }

    fn bytes(&self) -> usize {
        self.grid.bytes() + self.solutions.len() * self.grid.unknowns * size_of::<f64>()
    }
}

impl Oblique {
    /// Meshes and solves a question of flat layers; a drag with so many stations in each strip.
    ///
    /// # Errors
    /// The first number out of range, a mesh that does not fit the layers, or contrasts beyond double precision.
    pub fn new(question: &Problem3, mesh: &MeshSpec, each_strip: usize) -> Result<Self, AxisymmetricError> {
        Ok(SharedMesh::new(question, mesh, each_strip)?.under(&question.flat.load))
    }

    /// Leans the needle by another angle to the normal, in rad. Nothing is solved anew: neither harmonic knows the angle, which only
    /// says how much there is of each and where.
    pub(super) fn lean(&mut self, tilt_rad: f64) {
        self.lean = Lean::new(tilt_rad);
    }
}

/// A mesh for several loads of one needle, factorised once.
pub(super) struct SharedMesh {
    tilt_rad: f64,
    each_strip: usize,
    into: ElementGrid<2>,
    along: ElementGrid<3>,
    factors: [Cholesky; 2],
    /// Forces of 1 N across the radius, for either harmonic.
    across: [Vec<f64>; 2],
}

impl SharedMesh {
    /// Meshes and factorises a question of flat layers, whose own load only tells the radius.
    pub fn new(question: &Problem3, mesh: &MeshSpec, each_strip: usize) -> Result<Self, AxisymmetricError> {
        question.check()?;
        mesh.check(&question.flat)?;
        let slab = question.flat.slab.solid();
        let [radial, axial] = [&mesh.radial, &mesh.axial].map(|strips| Spans::new(strips));
        let once = across(question.flat.load.radius_m, &radial);
        // The stiffness is one per π, the load one per radian: a push on s is twice as much of the former.
        let twice = once.iter().map(|force| 2.0 * force).collect();
        let into = ElementGrid::straight(radial.clone(), axial.clone(), Side::Clamped);
        let along = ElementGrid::sideways(radial, axial);
        let factors = [into.factorise(&slab, element::stiffness)?, along.factorise(&slab, sideways::stiffness)?];
        Ok(Self { tilt_rad: question.tilt_rad, each_strip, into, along, factors, across: [once, twice] })
    }

    /// The answer to a load. Where it ends the mesh has a line.
    pub fn under(&self, load: &Load) -> Oblique {
        let stations = stations(load, &self.into.axial, self.each_strip);
        let ([into, along], [once, twice]) = (&self.factors, &self.across);
        Oblique {
            lean: Lean::new(self.tilt_rad),
            stations_m: stations.iter().map(|station| station.depth_m).collect(),
            into: Harmonic::new(self.into.clone(), into, 1, once, &stations),
            along: Harmonic::new(self.along.clone(), along, 0, twice, &stations),
            force_n: 1.0,
        }
    }
}

impl FieldModel for Oblique {
    fn model(&self) -> Model {
        Model::Axisymmetric
    }

    fn unknowns(&self) -> usize {
        self.into.grid.unknowns + self.along.grid.unknowns
    }

    fn bytes(&self) -> usize {
        self.into.bytes() + self.along.bytes() + size_of_val(&self.stations_m[..])
    }

    /// What is not a number, or infinite, leaves the last answer.
    fn solve(&mut self, force_n: f64) {
        if force_n.is_finite() {
            self.force_n = force_n;
        }
    }

    fn displacement_m(&self, x_m: f64, depth_m: f64) -> [f64; 2] {
        let Lean { sine, cosine, tangent } = self.lean;
        let [mut down_m, mut along_m] = [0.0; 2];
        let solutions = self.into.solutions.iter().zip(&self.along.solutions);
        for (&depth_of_station_m, (into, along)) in self.stations_m.iter().zip(solutions) {
            let station_m = depth_of_station_m * tangent;
            let (r_m, side) = ((x_m - station_m).abs(), if x_m < station_m { -1.0 } else { 1.0 });
            let [u_r, u_z] = self.into.grid.at(into, r_m, depth_m);
            let [s, t, q] = self.along.grid.at(along, r_m, depth_m);
            down_m += cosine * u_z + sine * side * q;
            along_m += cosine * side * u_r + sine * (s + t);
        }
        [0.0 - down_m * self.force_n, along_m * self.force_n]
    }
}
