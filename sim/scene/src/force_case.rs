//! The JSON of `stylet force`: layers at their effective values, in SI.

use mechanics::axial::AxialSpec;

use crate::error::DocumentError;

/// A parsed case.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceCase {
    /// The axial law.
    pub spec: AxialSpec,
    /// Angle to the surface normal, in rad.
    pub angle_rad: f64,
}

/// Parses `SCENE.json`.
///
/// # Errors
/// Every issue found, with line and column.
pub fn parse(_file: &str, _json: &str) -> Result<ForceCase, DocumentError> {
    unimplemented!()
}
