//! Superposition of several loads at points that are known beforehand, from their responses to 1 N.

use crate::FieldModel;

/// Responses of several loads at the same points. The tissue is linear, so a tick sums them.
#[derive(Clone, Debug)]
pub struct Superposed {
    points: usize,
    /// Axial and radial displacement of every point in m/N, ordered by load.
    responses: Vec<[f64; 2]>,
}

impl Superposed {
    /// Solves each load for 1 N and stores the displacements at these points, (r, depth) in m.
    pub fn new(loads: &mut [&mut dyn FieldModel], points_m: &[[f64; 2]]) -> Self {
        let mut responses = Vec::with_capacity(loads.len() * points_m.len());
        for load in loads {
            load.solve(1.0);
            responses.extend(points_m.iter().map(|&[r_m, depth_m]| load.displacement_m(r_m, depth_m)));
        }
        Self { points: points_m.len(), responses }
    }

    /// Writes the axial and radial displacement of every point, in m, under these forces, in N, one
    /// for each load. Never allocates.
    pub fn answer(&self, forces_n: &[f64], displacements_m: &mut [[f64; 2]]) {
        displacements_m.fill([0.0; 2]);
        for (&force_n, responses) in forces_n.iter().zip(self.responses.chunks_exact(self.points.max(1))) {
            for (to, response) in displacements_m.iter_mut().zip(responses) {
                to[0] += force_n * response[0];
                to[1] += force_n * response[1];
            }
        }
    }

    /// Memory of the responses, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&self.responses[..])
    }
}
