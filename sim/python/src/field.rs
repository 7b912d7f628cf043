//! `stylet.Field`: the tissue without a needle law.

use documents::field_case::{self, FieldCase};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyDict};
use tissue::answer::{self, CaseAnswer, CaseQuestion, FieldSolution};
use tissue::planner::PlanRequest;
use tissue::{Judging, Model};

use crate::errors::{refuse_file, refuse_input};

/// Allowed tolerances.
const TOLERANCES: std::ops::RangeInclusive<f64> = 1e-6..=1.0;

/// The models that can be selected by name.
const MODELS: [Model; 3] = [Model::Axisymmetric, Model::MassSpring, Model::Volumetric];

/// Solves a case. Arrays are returned as bytes, ordered by load, then depth, then radius.
#[pyfunction]
pub fn answer_field<'py>(
    py: Python<'py>,
    name: &str,
    json: &str,
    model: &str,
    tolerance: f64,
) -> PyResult<Bound<'py, PyDict>> {
    if !TOLERANCES.contains(&tolerance) {
        return Err(refuse_input(format_args!("tolerance = {tolerance}; allowed: 1e-6 to 1")));
    }
    let model = read_model(model)?;
    let (case, answer) = py.detach(|| -> PyResult<_> {
        let case: FieldCase = field_case::parse(name, json).map_err(refuse_input)?;
        let wish = PlanRequest { model, tolerance, judging: Judging::default() };
        let (problems, load_depths_m) = (&case.problems[..], &case.load_depths_m[..]);
        let question = CaseQuestion { problems, load_depths_m, force_n: case.force_n, wish };
        let answer = CaseAnswer::find(&question, |problem| answer::plan_flat(problem, &wish));
        let answer = answer.map_err(|error| refuse_file(name, error))?;
        Ok((case, answer))
    })?;
    tell_answer(py, &case, &answer)
}

fn read_model(name: &str) -> PyResult<Option<Model>> {
    match MODELS.into_iter().find(|model| model.name() == name) {
        None if name != "auto" => {
            let allowed = MODELS.map(Model::name).join("', '");
            Err(refuse_input(format_args!("model = '{name}'; allowed: 'auto', '{allowed}'")))
        }
        model => Ok(model),
    }
}

fn tell_answer<'py>(py: Python<'py>, case: &FieldCase, answer: &CaseAnswer) -> PyResult<Bound<'py, PyDict>> {
    let told = PyDict::new(py);
    told.set_item("model", answer.model.name())?;
    told.set_item("reason", &answer.reason)?;
    told.set_item("unknowns", answer.unknowns)?;
    told.set_item("bytes", answer.bytes)?;
    told.set_item("estimated_relative_error", answer.estimated_relative_error)?;
    told.set_item("met", answer.met)?;
    told.set_item("warning", answer.warning())?;
    told.set_item("force_n", case.force_n)?;
    told.set_item("load_depths_m", &case.load_depths_m)?;
    if let Some(problem) = case.problems.first() {
        told.set_item("sample_depth_m", &problem.sample_depth_m)?;
        told.set_item("sample_r_m", &problem.sample_r_m)?;
    }
    let solutions = &answer.solutions;
    told.set_item("u_axial_m", flatten_parts(py, solutions, |solution| &solution.u_axial_m))?;
    told.set_item("u_radial_m", flatten_parts(py, solutions, |solution| &solution.u_radial_m))?;
    Ok(told)
}

fn flatten_parts<'py>(
    py: Python<'py>,
    solutions: &[FieldSolution],
    part: fn(&FieldSolution) -> &Vec<Vec<f64>>,
) -> Bound<'py, PyByteArray> {
    let numbers: Vec<f64> = solutions.iter().flat_map(part).flatten().copied().collect();
    PyByteArray::new(py, bytemuck::cast_slice(&numbers))
}
