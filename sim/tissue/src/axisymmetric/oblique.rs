//! An oblique needle in flat layers: two harmonics in (r, z) about the vertical through the load.
//!
//! A push along the needle is the sum of cos θ times a push into the body, which is symmetric about
//! the vertical, and sin θ times a push along the skin, which is a first harmonic about it. Both
//! are exact in flat layers. An oblique drag is distributed over several stations in each strip of
//! the mesh, each on its own vertical with its share of the strip, with Lagrange interpolation
//! between them.

use super::assembly::{ElementGrid, Stiffness};
use super::load::{AxisStation, across, stations};
use super::mesh::Spans;
use super::{AxisymmetricError, MeshSpec, Side, element, sideways};
use crate::multifrontal::Cholesky;
use crate::volumetric::Problem3;
use crate::{FieldModel, Load, Model, Slab};

/// An oblique load on flat layers, solved for 1 N. Displacements are those in the plane of the
/// needle: at a distance x along the skin, in the direction of the needle's inclination, and a
/// depth.
#[derive(Clone, Debug)]
pub struct Oblique {
    lean: Lean,
    /// Depth at which the needle meets the vertical of each station, in m.
    stations_m: Vec<f64>,
    solved: SolvedStations,
    force_n: f64,
}

/// Functions of the angle to the normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lean {
    pub sine: f64,
    pub cosine: f64,
    pub tangent: f64,
}

impl Lean {
    pub fn new(tilt_rad: f64) -> Self {
        Self { sine: libm::sin(tilt_rad), cosine: libm::cos(tilt_rad), tangent: libm::tan(tilt_rad) }
    }
}

/// Solutions for 1 N into the body and 1 N along the skin, at each of some stations. Neither
/// depends on the angle, which only determines their proportions and positions.
#[derive(Clone, Debug)]
pub(super) struct SolvedStations {
    into: Harmonic<2>,
    along: Harmonic<3>,
}

/// One harmonic's solution for 1 N at each station, in m.
#[derive(Clone, Debug)]
struct Harmonic<const N: usize> {
    grid: ElementGrid<N>,
    solutions: Vec<Vec<f64>>,
}

/// The mesh of one harmonic, and the component on which a load acts.
struct HarmonicMesh<const N: usize> {
    grid: ElementGrid<N>,
    stiffness: Stiffness,
    component: usize,
    /// Forces across the radius.
    across: Vec<f64>,
}

impl<const N: usize> HarmonicMesh<N> {
    fn factorise(&self, slab: &Slab) -> Result<Cholesky, AxisymmetricError> {
        self.grid.factorise(slab, self.stiffness)
    }

    /// Solves 1 N at each station.
    fn solve(&self, factor: &Cholesky, stations: &[AxisStation]) -> Harmonic<N> {
        let mut scratch = vec![0.0; factor.scratch_len()];
        let mut solve = |station: &AxisStation| {
            let mut solution = self.grid.load(self.component, &self.across, &station.along);
            factor.solve(&mut solution, &mut scratch);
            solution
        };
        let solutions = stations.iter().map(&mut solve).collect();
        Harmonic { grid: self.grid.clone(), solutions }
    }
}

impl<const N: usize> Harmonic<N> {
    fn bytes(&self) -> usize {
        self.grid.bytes() + self.solutions.len() * self.grid.unknowns * size_of::<f64>()
    }
}

impl SolvedStations {
    /// Displacement down and along the skin under an oblique load of 1 N at a station, in m/N, at a
    /// distance from its vertical, in the direction of the needle's inclination, and a depth, both
    /// in m.
    pub fn at(&self, station: usize, lean: &Lean, away_m: f64, depth_m: f64) -> [f64; 2] {
        let (Some(into), Some(along)) = (self.into.solutions.get(station), self.along.solutions.get(station)) else {
            return [0.0; 2];
        };
        let &Lean { sine, cosine, .. } = lean;
        let (r_m, side) = (away_m.abs(), if away_m < 0.0 { -1.0 } else { 1.0 });
        let [u_r, u_z] = self.into.grid.at(into, r_m, depth_m);
        let [s, t, q] = self.along.grid.at(along, r_m, depth_m);
        [cosine * u_z + sine * side * q, cosine * side * u_r + sine * (s + t)]
    }

    pub fn unknowns(&self) -> usize {
        self.into.grid.unknowns + self.along.grid.unknowns
    }

    pub fn bytes(&self) -> usize {
        self.into.bytes() + self.along.bytes()
    }
}

impl Oblique {
    /// Meshes and solves a question of flat layers, with `each_strip` stations of a drag in each
    /// strip.
    ///
    /// # Errors
    /// The first number out of range, a mesh that does not fit the layers, or contrasts beyond
    /// double precision.
    pub fn new(question: &Problem3, mesh: &MeshSpec, each_strip: usize) -> Result<Self, AxisymmetricError> {
        Ok(SharedMesh::new(question, mesh, each_strip)?.under(&question.flat.load))
    }
}

/// A mesh of both harmonics.
pub(super) struct HarmonicMeshes {
    slab: Slab,
    into: HarmonicMesh<2>,
    along: HarmonicMesh<3>,
}

impl HarmonicMeshes {
    /// Meshes a question of flat layers. Of its own load only the radius is used.
    pub fn new(question: &Problem3, mesh: &MeshSpec) -> Result<Self, AxisymmetricError> {
        question.check()?;
        mesh.check(&question.flat)?;
        let slab = question.flat.slab.solid();
        let [radial, axial] = [&mesh.radial, &mesh.axial].map(|strips| Spans::new(strips));
        let once = across(question.flat.load.radius_m, &radial);
        // The stiffness is per π, the load per radian: the load on s therefore counts twice.
        let twice = once.iter().map(|force| 2.0 * force).collect();
        let straight = ElementGrid::straight(radial.clone(), axial.clone(), Side::Clamped);
        let into = HarmonicMesh { grid: straight, stiffness: element::stiffness, component: 1, across: once };
        let sideways = ElementGrid::sideways(radial, axial);
        let along = HarmonicMesh { grid: sideways, stiffness: sideways::stiffness, component: 0, across: twice };
        Ok(Self { slab, into, along })
    }

    /// The strips along the depth.
    pub fn axial(&self) -> &Spans {
        &self.into.grid.axial
    }

    /// Solutions for 1 N at each station, and the maximum memory of a factor, in bytes: the
    /// harmonics are solved one after the other, so that both factors are never held together.
    pub fn solve_each(&self, stations: &[AxisStation]) -> Result<(SolvedStations, usize), AxisymmetricError> {
        let factor = self.into.factorise(&self.slab)?;
        let (into, bytes) = (self.into.solve(&factor, stations), factor.bytes());
        drop(factor);
        let factor = self.along.factorise(&self.slab)?;
        let along = self.along.solve(&factor, stations);
        Ok((SolvedStations { into, along }, bytes.max(factor.bytes())))
    }
}

/// A mesh for several loads of one needle, factorised once.
pub(super) struct SharedMesh {
    tilt_rad: f64,
    each_strip: usize,
    meshes: HarmonicMeshes,
    factors: [Cholesky; 2],
}

impl SharedMesh {
    /// Meshes and factorises a question of flat layers. Of its own load only the radius is used.
    pub fn new(question: &Problem3, mesh: &MeshSpec, each_strip: usize) -> Result<Self, AxisymmetricError> {
        let meshes = HarmonicMeshes::new(question, mesh)?;
        let factors = [meshes.into.factorise(&meshes.slab)?, meshes.along.factorise(&meshes.slab)?];
        Ok(Self { tilt_rad: question.tilt_rad, each_strip, meshes, factors })
    }

    /// The solution for a load. The mesh must have a line at each end of the load.
    pub fn under(&self, load: &Load) -> Oblique {
        let stations = stations(load, self.meshes.axial(), self.each_strip);
        let [into, along] = &self.factors;
        let into = self.meshes.into.solve(into, &stations);
        let along = self.meshes.along.solve(along, &stations);
        Oblique {
            lean: Lean::new(self.tilt_rad),
            stations_m: stations.iter().map(|station| station.depth_m).collect(),
            solved: SolvedStations { into, along },
            force_n: 1.0,
        }
    }
}

impl FieldModel for Oblique {
    fn model(&self) -> Model {
        Model::Axisymmetric
    }

    fn unknowns(&self) -> usize {
        self.solved.unknowns()
    }

    fn bytes(&self) -> usize {
        self.solved.bytes() + size_of_val(&self.stations_m[..])
    }

    /// A force that is not finite keeps the last solution.
    fn solve(&mut self, force_n: f64) {
        if force_n.is_finite() {
            self.force_n = force_n;
        }
    }

    fn displacement_m(&self, x_m: f64, depth_m: f64) -> [f64; 2] {
        let [mut down_m, mut along_m] = [0.0; 2];
        for (station, depth_of_station_m) in self.stations_m.iter().enumerate() {
            let away_m = x_m - depth_of_station_m * self.lean.tangent;
            let [down, along] = self.solved.at(station, &self.lean, away_m, depth_m);
            down_m += down;
            along_m += along;
        }
        [0.0 - down_m * self.force_n, along_m * self.force_n]
    }
}
