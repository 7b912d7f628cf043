//! The parameters of a puncture, and their checks.

use crate::axial::{AxialParams, AxialSpec, Domain, ForceLaw, ParamError};
use crate::beam::{Beam, Bend};
use crate::skin::Skin;
use crate::structures::{Structure, StructureSpec};

/// Specification of [`PunctureParams`], unchecked.
#[derive(Clone, Debug)]
pub struct PunctureSpec {
    /// The axial law.
    pub axial: AxialSpec,
    /// Lateral foundation per inserted metre, in N/m² (default 10 000).
    pub lateral_stiffness_n_per_m2: f64,
    /// Length of the shaft from tip to hub, in m.
    pub needle_length_m: f64,
    /// Stiffness of the skin under the hub, in N/m; none for a needle whose hub meets nothing.
    pub hub_stiffness_n_per_m: Option<f64>,
    /// Bending stiffness EI of a needle that bends, in N·m²; none for a rigid one.
    pub needle_bending_n_m2: Option<f64>,
    /// Shape of the skin.
    pub skin: Skin,
    /// Structures in the patient frame.
    pub structures: Vec<StructureSpec>,
}

/// Checked parameters, constant for an attempt.
#[derive(Debug)]
pub struct PunctureParams {
    spec: PunctureSpec,
    pub(super) axial: AxialParams,
    pub(super) structures: Vec<Structure>,
    beam: Option<Beam>,
}

impl PunctureParams {
    /// Checks and freezes a specification.
    ///
    /// # Errors
    /// The first parameter that is non-finite or out of range, or the first mesh that is not
    /// closed.
    pub fn new(spec: PunctureSpec) -> Result<Self, ParamError> {
        let axial = AxialParams::new(spec.axial.clone())?;
        Domain::NotNegative.check("lateral_stiffness_n_per_m2", spec.lateral_stiffness_n_per_m2, "N/m²")?;
        Domain::Positive.check("needle_length_m", spec.needle_length_m, "m")?;
        if let Some(stiffness) = spec.hub_stiffness_n_per_m {
            Domain::Positive.check("hub_stiffness_n_per_m", stiffness, "N/m")?;
        }
        if let Some(radius_m) = spec.skin.radius_m() {
            Domain::Positive.check("skin.radius_m", radius_m, "m")?;
        }
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
        Ok(Self { spec, axial, structures, beam })
    }

    /// The specification these parameters were made from.
    #[must_use]
    pub fn spec(&self) -> &PunctureSpec {
        &self.spec
    }

    pub(super) fn skin(&self) -> &Skin {
        &self.spec.skin
    }

    /// Whether bone holds the tip on its surface.
    pub(super) fn bone_holds(&self) -> bool {
        self.axial.spec().law >= ForceLaw::Version4
    }

    /// How far the hub of a needle that is inserted by `x_m` presses into the skin, in m; negative while it is clear of it. None where the
    /// hub meets nothing.
    pub(super) fn hub_depth_m(&self, x_m: f64) -> Option<f64> {
        self.spec.hub_stiffness_n_per_m.map(|_| x_m - self.spec.needle_length_m)
    }

    /// Force of the skin on a hub that presses into it by a depth in m, in N.
    pub(super) fn hub_force_n(&self, depth_m: f64) -> f64 {
        self.spec.hub_stiffness_n_per_m.map_or(0.0, |stiffness| stiffness * depth_m.max(0.0))
    }

    /// What the needle does sideways when inserted by a length, in m.
    pub(super) fn bend(&self, inserted_m: f64) -> Bend {
        let rigid = || Bend::rigid(self.spec.lateral_stiffness_n_per_m2, inserted_m);
        self.beam.as_ref().map_or_else(rigid, |beam| beam.bend(inserted_m))
    }
}
