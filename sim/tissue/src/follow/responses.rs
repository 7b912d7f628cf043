//! Unit responses: the displacement at each point under 1 N at each place, computed once.

use super::field::FollowError;
use super::spec::TissueSpec;
use crate::volumetric::{Footprint, Problem3};
use crate::{FieldModel, Judging, Load, Problem};

/// Makes a model of one load; the caller chooses model and mesh.
pub type Fit<'f> = &'f mut dyn FnMut(&Problem3) -> Result<Box<dyn FieldModel>, FollowError>;

/// Displacement along the needle at each point under 1 N of each load.
#[derive(Clone, Debug, PartialEq)]
pub struct Responses {
    loads: usize,
    /// Ordered by point, with one entry per load, in m/N, positive into the body.
    axial_m_per_n: Vec<f64>,
}

impl Responses {
    /// Solves a model of each load of a tissue, in the order of [`law::axial::write_loads`], for
    /// the displacement at each point: a distance from the needle, in the direction of its
    /// inclination, and a depth, in m.
    ///
    /// # Errors
    /// If the tissue is invalid or a model cannot be made.
    pub fn new(tissue: &TissueSpec, points_m: &[[f64; 2]], fit: Fit<'_>) -> Result<Self, FollowError> {
        tissue.check()?;
        let loads = tissue.loads();
        let mut axial_m_per_n = vec![0.0; points_m.len() * loads.len()];
        for (at, load) in loads.iter().enumerate() {
            let Some(load) = load else { continue };
            let question = pose_question(tissue, *load, points_m);
            let mut model = fit(&question)?;
            model.solve(1.0);
            for (response, &[r_m, depth_m]) in axial_m_per_n.iter_mut().skip(at).step_by(loads.len()).zip(points_m) {
                *response = question.along_needle_m(model.as_ref(), r_m, depth_m);
            }
        }
        Ok(Self { loads: loads.len(), axial_m_per_n })
    }

    /// Responses on the needle at every boundary of the force law, from which the displayed tents
    /// are made.
    ///
    /// # Errors
    /// Those of [`Responses::new`].
    pub fn at_boundaries(tissue: &TissueSpec, fit: Fit<'_>) -> Result<Self, FollowError> {
        Self::new(tissue, &tissue.points_m(), fit)
    }

    /// From known answers: for each load, in m/N, the displacement along the needle at each point;
    /// zero for those without one.
    pub(super) fn of_answers(points: usize, loads: usize, answer_m: impl Fn(usize, usize) -> f64) -> Self {
        let of_point = |point: usize| (0..loads).map(move |load| (point, load));
        let axial_m_per_n = (0..points).flat_map(of_point).map(|(point, load)| answer_m(point, load)).collect();
        Self { loads, axial_m_per_n }
    }

    /// Sets all responses to zero.
    pub(super) fn clear(&mut self) {
        self.axial_m_per_n.fill(0.0);
    }

    /// Adds a multiple of other responses of the same tissue.
    pub(super) fn add(&mut self, share: f64, others: &Self) {
        for (own, other) in self.axial_m_per_n.iter_mut().zip(&others.axial_m_per_n) {
            *own += share * other;
        }
    }

    /// Displacement along the needle at a point under loads of these magnitudes, in m, positive
    /// into the body; 0 if there is no such point. Never allocates.
    #[must_use]
    pub fn axial_m(&self, point: usize, loads_n: &[f64]) -> f64 {
        let row = self.axial_m_per_n.chunks_exact(self.loads).nth(point).unwrap_or_default();
        row.iter().zip(loads_n).map(|(response, load_n)| response * load_n).sum()
    }

    /// Displacement along the needle at every point under 1 N of a load, in m.
    pub(super) fn under(&self, load: usize) -> Vec<f64> {
        self.axial_m_per_n.chunks_exact(self.loads).map(|row| row.get(load).copied().unwrap_or(0.0)).collect()
    }

    /// Response of a point to a load, in m/N; 0 if there is no such point or load. Never allocates.
    #[must_use]
    pub fn of_m_per_n(&self, point: usize, load: usize) -> f64 {
        if load < self.loads { self.axial_m_per_n.get(point * self.loads + load).copied().unwrap_or(0.0) } else { 0.0 }
    }

    /// Stiffness of each boundary in the field, in N/m: F/|u| on the needle under a contactor at
    /// that boundary, for the responses [`Responses::at_boundaries`]. Infinite at the clamped base.
    #[must_use]
    pub fn stiffnesses_n_per_m(&self) -> Vec<f64> {
        let rows = self.axial_m_per_n.chunks_exact(self.loads).enumerate();
        rows.map(|(at, row)| row.get(at).map_or(f64::INFINITY, |own| 1.0 / own.abs())).collect()
    }

    /// Memory, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of::<Self>() + size_of_val(self.axial_m_per_n.as_slice())
    }
}

impl TissueSpec {
    /// Every boundary on the needle: zero distance from it and a depth, in m.
    pub(super) fn points_m(&self) -> Vec<[f64; 2]> {
        self.boundaries_m.iter().take(self.layers()).map(|&depth_m| [0.0, depth_m]).collect()
    }
}

/// The question for a load: sampled at every distance and every depth of the points.
pub(super) fn pose_question(tissue: &TissueSpec, load: Load, points_m: &[[f64; 2]]) -> Problem3 {
    let sorted = |part: usize| {
        let mut values: Vec<f64> = points_m.iter().map(|point| point[part]).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let flat = Problem { slab: tissue.slab.clone(), load, sample_r_m: sorted(0), sample_depth_m: sorted(1) };
    let (skin, inclusions) = (tissue.skin, tissue.inclusions.clone());
    let footprint = if tissue.judging < Judging::Fourth { Footprint::Flat } else { Footprint::Bent };
    Problem3 { flat, tilt_rad: tissue.tilt_rad, skin, inclusions, footprint }
}
