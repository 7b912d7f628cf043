//! `stylet.read`: a recording, its tables and its score.

use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use assessment::{AssessError, VoidAnswer};
use documents::ExerciseBundle;
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes, PyDict, PyList};
use recording::{ReadError, Recording, Session};
use time::format_description::well_known::Rfc3339;

use crate::errors::{open_file, refuse_file, refuse_input, report_disk};
use crate::rows::{Packed, PackedRows};

/// Columns (name, format, offset), bytes per row, number of rows, and the data.
type PackedTable<'py> = (Vec<(String, &'static str, usize)>, usize, usize, Bound<'py, PyByteArray>);

/// A recording in memory.
#[pyclass(frozen, module = "stylet._native")]
pub struct NativeRecording {
    /// Name in error messages.
    pub name: String,
    /// The recording.
    pub recording: Recording,
    /// The file's content, if it was simulated here.
    pub file: Option<Vec<u8>>,
    /// The reasons why its scene is unsound, if it was simulated here.
    pub unsound: Vec<String>,
}

/// Reads a complete or truncated recording.
#[pyfunction]
pub fn read_recording(py: Python<'_>, path: PathBuf) -> PyResult<NativeRecording> {
    py.detach(|| {
        let (name, file) = (path.display().to_string(), open_file(&path)?);
        let recording = Recording::read(BufReader::new(file)).map_err(|error| refuse_recording(&name, &error))?;
        Ok(NativeRecording { name, recording, file: None, unsound: Vec::new() })
    })
}

/// Creates the exception for a refused or unreadable recording.
pub fn refuse_recording(name: &str, error: &ReadError) -> PyErr {
    match error {
        ReadError::Io(error) => report_disk(name, error),
        _ => refuse_file(name, error),
    }
}

#[pymethods]
impl NativeRecording {
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    #[getter]
    fn complete(&self) -> bool {
        self.recording.complete
    }

    #[getter]
    fn unsound(&self) -> Vec<String> {
        self.unsound.clone()
    }

    /// Returns the file's content, if it was simulated here.
    fn content<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyBytes>> {
        self.file.as_ref().map(|file| PyBytes::new(py, file))
    }

    fn samples<'py>(&self, py: Python<'py>) -> PyResult<PackedTable<'py>> {
        self.pack_table(py, "samples", &self.recording.samples)
    }

    fn tents<'py>(&self, py: Python<'py>) -> PyResult<PackedTable<'py>> {
        self.pack_table(py, "tents", &self.recording.tents)
    }

    fn energies<'py>(&self, py: Python<'py>) -> PyResult<PackedTable<'py>> {
        self.pack_table(py, "energy", &self.recording.energies)
    }

    /// Returns the columns of the events; an absent boundary, track or structure is −1.
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (columns, events) = (PyDict::new(py), &self.recording.events);
        let index = |index: Option<u32>| index.map_or(-1, i64::from);
        columns.set_item("t_s", PyList::new(py, events.iter().map(|event| event.t_s))?)?;
        columns.set_item("kind", PyList::new(py, events.iter().map(|event| event.kind.name()))?)?;
        columns.set_item("boundary", PyList::new(py, events.iter().map(|event| index(event.boundary)))?)?;
        columns.set_item("x_m", PyList::new(py, events.iter().map(|event| event.x_m))?)?;
        for (at, name) in ["position_x_m", "position_y_m", "position_z_m"].into_iter().enumerate() {
            columns.set_item(name, PyList::new(py, events.iter().map(|event| event.position_m[at]))?)?;
        }
        columns.set_item("force_n", PyList::new(py, events.iter().map(|event| event.force_n))?)?;
        columns.set_item("dissipated_j", PyList::new(py, events.iter().map(|event| event.dissipated_j))?)?;
        columns.set_item("track", PyList::new(py, events.iter().map(|event| index(event.track)))?)?;
        columns.set_item("structure", PyList::new(py, events.iter().map(|event| index(event.structure)))?)?;
        columns.set_item("text", PyList::new(py, events.iter().map(|event| &event.text))?)?;
        Ok(columns)
    }

    /// Returns the metadata under the names used in the file.
    fn session<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (told, session) = (PyDict::new(py), &self.recording.session);
        let Session { session_id, exercise_id, exercise_sha256, scene_sha256, simulator_version, .. } = session;
        told.set_item("session_id", session_id.to_string())?;
        told.set_item("exercise_id", exercise_id)?;
        told.set_item("exercise_sha256", exercise_sha256)?;
        told.set_item("scene_sha256", scene_sha256)?;
        told.set_item("simulator_version", simulator_version)?;
        told.set_item("git", &session.git)?;
        told.set_item("device", &session.device)?;
        told.set_item("device_max_force_n", session.device_max_force_n)?;
        told.set_item("law", u32::from(session.law))?;
        told.set_item("tick_hz", session.tick_hz)?;
        told.set_item("seed", session.seed)?;
        told.set_item("trainee", &session.trainee)?;
        told.set_item("started_at", session.started_at.format(&Rfc3339).map_err(|error| self.refuse(error))?)?;
        told.set_item("patient_thickness_mm", &session.patient_thickness_mm)?;
        Ok(told)
    }

    /// Returns the attached files by name.
    fn attachments<'py>(&self, py: Python<'py>) -> BTreeMap<String, Bound<'py, PyBytes>> {
        let attachments = self.recording.attachments.iter();
        attachments.map(|attached| (attached.name.clone(), PyBytes::new(py, &attached.data))).collect()
    }

    /// Returns the output of `stylet score --json`.
    fn score(&self, py: Python<'_>, exercise: Option<PathBuf>) -> PyResult<String> {
        py.detach(|| {
            let bundle = match exercise {
                Some(path) => read_exercise(&path)?,
                None => assessment::own_exercise(&self.recording).map_err(|error| self.refuse(error))?,
            };
            match assessment::assess(&self.recording, &bundle) {
                Ok(judged) => self.write_json(&judged),
                Err(AssessError::Void(why)) => self.write_json(&VoidAnswer::from(&why)),
                Err(error) => Err(self.refuse(error)),
            }
        })
    }

    /// Returns the output of `stylet verify --json`.
    fn verify(&self, py: Python<'_>) -> PyResult<String> {
        py.detach(|| {
            let verification = assessment::verify_own(&self.recording).map_err(|error| self.refuse(error))?;
            self.write_json(&verification)
        })
    }
}

impl NativeRecording {
    fn refuse(&self, why: impl std::fmt::Display) -> PyErr {
        refuse_file(&self.name, why)
    }

    fn write_json(&self, value: &impl serde::Serialize) -> PyResult<String> {
        serde_json::to_string(value).map_err(|error| self.refuse(error))
    }

    fn pack_table<'py, T: Packed + Default + Sync>(
        &self,
        py: Python<'py>,
        table: &str,
        items: &[T],
    ) -> PyResult<PackedTable<'py>> {
        let packed = py.detach(|| PackedRows::pack(table, items))?;
        Ok(packed.tell(py))
    }
}

/// Reads an exercise with its scene and meshes.
pub fn read_exercise(path: &Path) -> PyResult<ExerciseBundle> {
    drop(open_file(path)?);
    ExerciseBundle::read(path).map_err(refuse_input)
}
