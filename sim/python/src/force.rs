//! `stylet.force`: the force law without device or recording.

use std::convert::Infallible;

use attempt::LoneNeedle;
use attempt::trajectory::{AxialSample, NumberColumn, check_columns};
use pyo3::buffer::PyBuffer;
use pyo3::prelude::*;
use pyo3::types::PyByteArray;

use crate::errors::{refuse_file, refuse_input, refuse_trajectory};

/// Number of result columns, in this order: speed, total force, tip, rim, viscous, friction,
/// cutting, depth.
const COLUMNS: usize = 8;

/// A rupture: row of the trajectory, contactor, boundary counted from the surface down.
type RuptureRow = (usize, &'static str, usize);

/// Evaluates the law on a trajectory. Returns the columns as bytes, the ruptures, and the reasons
/// why the scene is unsound.
#[pyfunction]
pub fn compute_force<'py>(
    py: Python<'py>,
    name: &str,
    json: &str,
    t_s: &Bound<'py, PyAny>,
    x_m: &Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyByteArray>, Vec<RuptureRow>, Vec<String>)> {
    let (t_s, x_m) = (read_column(t_s)?, read_column(x_m)?);
    let answer = py.detach(|| -> PyResult<_> {
        let case = documents::force_case::parse(name, json).map_err(refuse_input)?;
        let needle = LoneNeedle::new(case).map_err(|error| refuse_file(name, error))?;
        let named = |name, unit, values| NumberColumn { name, unit, values };
        check_columns(&[named("t", " s", &t_s), named("x", " m", &x_m)]).map_err(|error| refuse_trajectory(&error))?;
        let unsound = needle.find_unsound_ruptures().iter().map(ToString::to_string).collect();
        let (columns, ruptures) = run_law(&needle, &t_s, &x_m);
        Ok((columns, ruptures, unsound))
    });
    let (columns, ruptures, unsound) = answer?;
    Ok((PyByteArray::new(py, bytemuck::cast_slice(&columns)), ruptures, unsound))
}

/// Returns the result columns and the ruptures.
fn run_law(needle: &LoneNeedle, t_s: &[f64], x_m: &[f64]) -> (Vec<f64>, Vec<RuptureRow>) {
    let rows = t_s.len();
    let (mut columns, mut ruptures, mut row) = (vec![0.0; COLUMNS * rows], Vec::new(), 0);
    let trajectory = t_s.iter().zip(x_m).map(|(&t_s, &x_m)| AxialSample { t_s, x_m });
    let ran = needle.push_along(trajectory, |_, output, opened| {
        let values = [
            output.v_m_per_s,
            output.total_n(),
            output.tip_n,
            output.rim_n,
            output.viscous_n,
            output.friction_n,
            output.cutting_n,
            output.depth_m,
        ];
        for (column, value) in values.into_iter().enumerate() {
            columns[column * rows + row] = value;
        }
        ruptures.extend(opened.iter().map(|rupture| (row, rupture.contactor.name(), rupture.boundary)));
        row += 1;
        Ok::<_, Infallible>(())
    });
    match ran {
        Ok(()) => (columns, ruptures),
    }
}

/// Copies a column of an array: contiguous doubles, which the Python half guarantees.
pub fn read_column(array: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    PyBuffer::<f64>::get(array)?.to_vec(array.py())
}
