//! The reference cases, embedded in the program so that every copy measures the same, and the error
//! relative to them.

use documents::field_case;
use serde::Deserialize;
use tissue::{FieldModel, Problem, relative_distance};

use crate::error::BenchError;

/// Names of the cases.
pub const NAMES: [&str; 3] = ["homogeneous", "lower_back", "stiff_skin_soft_fat"];

const JSON: [&str; 3] = [
    include_str!("../../../../../tests/data/field/homogeneous.json"),
    include_str!("../../../../../tests/data/field/lower_back.json"),
    include_str!("../../../../../tests/data/field/stiff_skin_soft_fat.json"),
];

/// A load of a reference case with its reference solution.
pub struct ReferenceLoad {
    /// Name of its case.
    pub case: &'static str,
    /// Depth of the load, in m.
    pub depth_m: f64,
    /// Magnitude of the load, in N.
    pub force_n: f64,
    /// The problem.
    pub problem: Problem,
    /// Axial displacement at every sample, in m, ordered by depth, then radius.
    reference_m: Vec<f64>,
}

#[derive(Deserialize)]
struct Reference {
    solutions: Vec<ReferenceSolution>,
}

#[derive(Deserialize)]
struct ReferenceSolution {
    u_axial_m: Vec<Vec<f64>>,
}

/// Returns every load of every case.
///
/// # Errors
/// If an embedded case is refused; a test excludes this.
pub fn all() -> Result<Vec<ReferenceLoad>, BenchError> {
    let mut loads = Vec::new();
    for (case, json) in NAMES.into_iter().zip(JSON) {
        let parsed = field_case::parse(case, json)?;
        let reference: Reference = serde_json::from_str(json).map_err(BenchError::work)?;
        let asked = parsed.problems.into_iter().zip(parsed.load_depths_m).zip(reference.solutions);
        loads.extend(asked.map(|((problem, depth_m), solution)| ReferenceLoad {
            case,
            depth_m,
            force_n: parsed.force_n,
            problem,
            reference_m: solution.u_axial_m.concat(),
        }));
    }
    Ok(loads)
}

impl ReferenceLoad {
    /// Returns the relative L2 error of the axial displacement over all samples, for the field's
    /// last solution.
    pub fn error(&self, field: &dyn FieldModel) -> f64 {
        relative_distance(&self.problem.axial_m(field), &self.reference_m)
    }
}
