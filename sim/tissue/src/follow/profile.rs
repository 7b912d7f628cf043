//! Displacement of boundaries around the needle, which a display of the tissue needs beyond the
//! axis.

use super::field::{Field, FollowError};
use super::responses::Responses;
use super::spec::TissueSpec;
use crate::planner::{self, PlanRequest, cut_patch};

/// Axial displacement of every boundary at some distances from the needle under 1 N of each load of
/// [`TissueSpec::loads`], for display: those of a perpendicular needle.
#[derive(Clone, Debug, PartialEq)]
pub struct Profiles {
    /// Distances from the needle's axis, ascending from 0, in m.
    pub radii_m: Vec<f64>,
    /// Number of loads.
    pub loads: usize,
    /// Displacement into the body, in m/N, ordered by boundary, then load, then radius.
    pub axial_m_per_n: Vec<f64>,
}

impl Field {
    /// The profiles of the tissue, on the patch and within the tolerance of the field itself.
    ///
    /// # Errors
    /// Those of [`Field::new`].
    pub fn profiles(&self, tissue: &TissueSpec) -> Result<Profiles, FollowError> {
        let radius_m = self.reach_m()?;
        let radii_m = radii_m(tissue.load_radius_m, radius_m);
        let deepest_m = tissue.deepest_m();
        let patched =
            TissueSpec { slab: cut_patch(&tissue.slab.layers, deepest_m, radius_m), tilt_rad: 0.0, ..tissue.leveled() };
        let boundaries_m = || patched.boundaries_m.iter().take(patched.layers());
        let points_m: Vec<_> =
            boundaries_m().flat_map(|&depth_m| radii_m.iter().map(move |&r_m| [r_m, depth_m])).collect();
        let wish = PlanRequest { model: tissue.model, tolerance: tissue.tolerance, judging: tissue.judging };
        let responses = Responses::new(&patched, &points_m, &mut |question| Ok(planner::plan(question, &wish)?.field))?;
        Ok(table(&responses, radii_m, patched.layers()))
    }
}

/// Number of steps from the needle outwards: finest at the needle's edge, where the tissue bends
/// most.
const STEPS: u32 = 24;

/// Distances from the axis to the patch's edge: the axis, half a needle's radius, and from there a
/// geometric sequence.
fn radii_m(needle_radius_m: f64, patch_radius_m: f64) -> Vec<f64> {
    let first_m = 0.5 * needle_radius_m;
    let factor = libm::pow(patch_radius_m / first_m, 1.0 / f64::from(STEPS - 1));
    let beyond = (0..STEPS).scan(first_m, |next_m, _| {
        let here_m = *next_m;
        *next_m *= factor;
        Some(here_m.min(patch_radius_m))
    });
    std::iter::once(0.0).chain(beyond).collect()
}

fn table(responses: &Responses, radii_m: Vec<f64>, boundaries: usize) -> Profiles {
    let loads = 2 * boundaries;
    let mut axial_m_per_n = Vec::with_capacity(boundaries * loads * radii_m.len());
    for boundary in 0..boundaries {
        for load in 0..loads {
            let mut unit_n = vec![0.0; loads];
            unit_n[load] = 1.0;
            let points = (0..radii_m.len()).map(|at| boundary * radii_m.len() + at);
            axial_m_per_n.extend(points.map(|point| responses.axial_m(point, &unit_n)));
        }
    }
    Profiles { radii_m, loads, axial_m_per_n }
}
