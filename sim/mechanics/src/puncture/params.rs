//! What a puncture is made of, and the check that it makes sense.

use crate::axial::{AxialParams, AxialSpec, Domain, ParamError};
use crate::beam::{Beam, Bend};
use crate::soundness::{self, Unsound};
use crate::structures::{Structure, StructureSpec};
use crate::tissue::follow::{Field, FollowError, TissueSpec};

/// What [`PunctureParams`] is made of, unchecked.
#[derive(Clone, Debug)]
pub struct PunctureSpec {
    /// The axial law.
    pub axial: AxialSpec,
    /// Lateral foundation per inserted metre, in N/m² (default 10 000).
    pub lateral_stiffness_n_per_m2: f64,
    /// Needle length from tip to hub, in m.
    pub needle_length_m: f64,
    /// Bending stiffness EI of a needle that bends, in N·m²; none for a rigid one.
    pub needle_bending_n_m2: Option<f64>,
    /// Structures in the patient frame.
    pub structures: Vec<StructureSpec>,
    /// The tissue that follows the needle; none where nobody looks.
    pub tissue: Option<TissueSpec>,
}

/// Why there is no puncture.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PunctureError {
    /// A parameter is out of range.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// The tissue cannot be followed.
    #[error("tissue: {0}")]
    Field(#[from] FollowError),
    /// With the stiffnesses that the field gives the boundaries, a rupture would create force or energy.
    #[error("tissue.coupling = \"field\": {0}")]
    Unsound(Unsound),
}

/// Checked parameters, constant for an attempt.
#[derive(Debug)]
pub struct PunctureParams {
    spec: PunctureSpec,
    pub(super) axial: AxialParams,
    pub(super) structures: Vec<Structure>,
    beam: Option<Beam>,
    field: Option<Field>,
}

impl PunctureParams {
    /// Checks and freezes a specification, and makes its field. Where the tissue is coupled, each boundary takes the field's
    /// stiffness.
    ///
    /// # Errors
    /// The first parameter that is non-finite or out of range, the first mesh that is not closed, a tissue that no model can be
    /// had of, or the first rupture that is unsound with the field's stiffnesses.
    pub fn new(mut spec: PunctureSpec) -> Result<Self, PunctureError> {
        let field = spec.tissue.as_ref().map(Field::new).transpose()?;
        if let (Some(TissueSpec { coupled: true, .. }), Some(field)) = (&spec.tissue, &field) {
            couple(&mut spec.axial, field)?;
        }
        let axial = AxialParams::new(spec.axial.clone())?;
        Domain::NotNegative.check("lateral_stiffness_n_per_m2", spec.lateral_stiffness_n_per_m2, "N/m²")?;
        Domain::Positive.check("needle_length_m", spec.needle_length_m, "m")?;
        let beam = spec
            .needle_bending_n_m2
            .map(|bending| Beam::new(bending, spec.needle_length_m, spec.lateral_stiffness_n_per_m2))
            .transpose()?;
        let structures = spec
            .structures
            .iter()
            .enumerate()
            .map(|(index, spec)| Structure::new(index, spec))
            .collect::<Result<_, ParamError>>()?;
        Ok(Self { spec, axial, structures, beam, field })
    }

    /// The specification these parameters were made from, with the stiffnesses that the law uses.
    #[must_use]
    pub fn spec(&self) -> &PunctureSpec {
        &self.spec
    }

    /// The field that follows the needle, if the scene has one.
    #[must_use]
    pub fn field(&self) -> Option<&Field> {
        self.field.as_ref()
    }

    /// What the needle does sideways when inserted by a length, in m.
    pub(super) fn bend(&self, inserted_m: f64) -> Bend {
        let rigid = || Bend::rigid(self.spec.lateral_stiffness_n_per_m2, inserted_m);
        self.beam.as_ref().map_or_else(rigid, |beam| beam.bend(inserted_m))
    }
}

/// Gives every boundary the field's stiffness, if that is sound.
fn couple(axial: &mut AxialSpec, field: &Field) -> Result<(), PunctureError> {
    field.couple(axial);
    // Checked first: what is not a number has no closed form.
    AxialParams::new(axial.clone())?;
    match soundness::check(axial).into_iter().next() {
        Some(unsound) => Err(PunctureError::Unsound(unsound)),
        None => Ok(()),
    }
}
