//! Pushes at several depths, from which every load on a needle at any angle follows.

use super::load::{push, stretch};
use super::oblique::{HarmonicMeshes, Lean, SolvedStations};
use super::{AxisymmetricError, MeshSpec};
use crate::Load;
use crate::volumetric::Problem3;

/// Solutions for 1 N at each of several depths, into the body and along the skin.
pub(super) struct Pushes<'a> {
    meshes: HarmonicMeshes,
    depths_m: &'a [f64],
    solved: SolvedStations,
    factor_bytes: usize,
}

impl<'a> Pushes<'a> {
    /// Solves a push at each depth, in m, at each of which the mesh must have a line. Of the
    /// question's own load only the radius is used.
    pub fn new(question: &Problem3, mesh: &MeshSpec, depths_m: &'a [f64]) -> Result<Self, AxisymmetricError> {
        let meshes = HarmonicMeshes::new(question, mesh)?;
        let stations: Vec<_> = depths_m.iter().map(|&depth_m| push(depth_m, meshes.axial())).collect();
        let (solved, factor_bytes) = meshes.solve_each(&stations)?;
        Ok(Self { meshes, depths_m, solved, factor_bytes })
    }

    /// For each load the displacement along the needle at each depth, in m/N, ordered by angle, in
    /// rad.
    pub fn answer(&self, tilts_rad: &[f64], loads: &[Load]) -> Vec<Vec<f64>> {
        let leans: Vec<Lean> = tilts_rad.iter().map(|&tilt_rad| Lean::new(tilt_rad)).collect();
        let of_load = |load: &Load| {
            let stretch = stretch(load, self.meshes.axial());
            let under = |lean: &Lean, sample: usize| -> f64 {
                stretch.iter().map(|part| part.share * self.along_needle_m(sample, lean, part.depth_m)).sum()
            };
            let samples = 0..self.depths_m.len();
            leans
                .iter()
                .flat_map(|lean| samples.clone().map(move |sample| (lean, sample)))
                .map(|(l, s)| under(l, s))
                .collect()
        };
        loads.iter().map(of_load).collect()
    }

    /// Displacement along the needle at a depth, in m, under a push of 1 N along it at one of the
    /// solved depths.
    fn along_needle_m(&self, at: usize, lean: &Lean, depth_m: f64) -> f64 {
        let away_m = (depth_m - self.depths_m[at]) * lean.tangent;
        let [down_m, along_m] = self.solved.at(at, lean, away_m, depth_m);
        lean.cosine * down_m + lean.sine * along_m
    }

    /// Unknowns of both harmonics.
    pub fn unknowns(&self) -> usize {
        self.solved.unknowns()
    }

    /// Maximum memory held at a time, in bytes.
    pub fn bytes(&self) -> usize {
        self.solved.bytes() + self.factor_bytes
    }
}
