//! The punctured body: the force law, and the field that follows it if the scene has one.

use std::sync::Arc;

use law::axial::{AxialParams, AxialSpec, ParamError};
use law::puncture::{PunctureParams, PunctureSpec};
use law::soundness::{self, Unsound};

use crate::follow::{Field, FollowError, Profiles, TissueSpec};

/// Specification of a [`Specimen`], unchecked.
#[derive(Clone, Debug)]
pub struct SpecimenSpec {
    /// The puncture, with the stiffnesses of the scene.
    pub puncture: PunctureSpec,
    /// The tissue that follows the needle; `None` if it is not displayed.
    pub tissue: Option<TissueSpec>,
}

/// Why a specimen cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SpecimenError {
    /// A parameter is out of range.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// The field cannot be computed.
    #[error("tissue: {0}")]
    Field(#[from] FollowError),
    /// With the field's stiffnesses at the boundaries, a rupture would create force or energy.
    #[error("tissue.coupling = \"field\": {0}")]
    Unsound(Unsound),
}

/// A body to puncture, constant for an attempt: the parameters of the force law, which alone
/// determine the felt force, and the field.
#[derive(Debug)]
pub struct Specimen {
    // Shared, because the servo's thread steps the law while the recorder's thread steps law and
    // field.
    law: Arc<PunctureParams>,
    tissue: Option<TissueSpec>,
    field: Option<Field>,
}

impl Specimen {
    /// Checks and freezes a specification, and computes its field. If the tissue is coupled, each
    /// boundary takes the field's stiffness.
    ///
    /// # Errors
    /// The first parameter that is not finite or out of range, the first mesh that is not closed, a
    /// tissue that no model can represent, or the first rupture that is unsound with the field's
    /// stiffnesses.
    pub fn new(spec: SpecimenSpec) -> Result<Self, SpecimenError> {
        let SpecimenSpec { mut puncture, tissue } = spec;
        let field = tissue.as_ref().map(Field::new).transpose()?;
        if let (Some(TissueSpec { coupled: true, .. }), Some(field)) = (&tissue, &field) {
            couple(&mut puncture.axial, field)?;
        }
        Ok(Self { law: Arc::new(PunctureParams::new(puncture)?), tissue, field })
    }

    /// The parameters of the force law.
    #[must_use]
    pub fn law(&self) -> &Arc<PunctureParams> {
        &self.law
    }

    /// The puncture's specification, with the stiffnesses that the law uses.
    #[must_use]
    pub fn spec(&self) -> &PunctureSpec {
        self.law.spec()
    }

    /// The field that follows the needle, if the scene has one.
    #[must_use]
    pub fn field(&self) -> Option<&Field> {
        self.field.as_ref()
    }

    /// Displacement profiles of its boundaries around the needle; `None` without a field.
    ///
    /// # Errors
    /// If no model of the tissue can be made.
    pub fn profiles(&self) -> Result<Option<Profiles>, FollowError> {
        self.field.as_ref().zip(self.tissue.as_ref()).map(|(field, tissue)| field.profiles(tissue)).transpose()
    }
}

/// Gives every boundary the field's stiffness, if the result is sound.
fn couple(axial: &mut AxialSpec, field: &Field) -> Result<(), SpecimenError> {
    field.couple(axial);
    // Checked first: invalid parameters have no closed form.
    AxialParams::new(axial.clone())?;
    match soundness::find_unsound_ruptures(axial).into_iter().next() {
        Some(unsound) => Err(SpecimenError::Unsound(unsound)),
        None => Ok(()),
    }
}
