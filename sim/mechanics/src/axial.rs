//! The axial force law: two contactors, ruptures, viscosity, presliding friction and cutting.

use serde::{Deserialize, Serialize};

use crate::ledger::Ledger;

/// One tissue layer as the force law needs it, already scaled for the needle and the tissue.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Layer {
    /// Name shown to people, for example `skin`.
    pub name: String,
    /// Thickness along the surface normal, in m. May be 0 for a fascia.
    pub thickness_m: f64,
    /// Stiffness of the layer's proximal boundary, in N/m.
    pub stiffness_n_per_m: f64,
    /// Damping per inserted length, in N·s/m².
    pub damping_n_s_per_m2: f64,
    /// Force at which the stylet tip opens the boundary, in N.
    pub tip_rupture_n: f64,
    /// Force at which the cannula rim opens the boundary, in N. Unused by a single contactor.
    pub rim_rupture_n: f64,
    /// Coulomb friction cap per inserted length, in N/m.
    pub friction_n_per_m: f64,
    /// Cutting force while the tip advances into new material, in N.
    pub cutting_n: f64,
}

/// Rate dependence of the rupture thresholds: P(v) = P∞ + (P0 − P∞)/(1 + v/v0).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RateDependence {
    /// P∞, the threshold that every boundary tends to at high speed, in N.
    pub p_infinity_n: f64,
    /// Speed at which half of the change has happened, in m/s.
    pub v0_m_per_s: f64,
}

/// What [`AxialParams`] is made of, unchecked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxialSpec {
    /// Layers from the surface down.
    pub layers: Vec<Layer>,
    /// Distance from the stylet tip to the cannula rim, in m. 0 is a single contactor.
    pub tip_to_rim_m: f64,
    /// Presliding stiffness of friction, in N/m.
    pub presliding_stiffness_n_per_m: f64,
    /// Optional rate dependence of the thresholds.
    #[serde(default)]
    pub rate: Option<RateDependence>,
}

/// Which of the two contactors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Contactor {
    /// The stylet tip.
    Tip,
    /// The cannula rim.
    Rim,
}

/// Where a boundary stands, as in the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stage {
    /// The tip has not reached the boundary.
    Untouched,
    /// I: the tip tents it.
    TipTents,
    /// II: the tip is through, the rim not yet there.
    TipThrough,
    /// III: the rim tents it.
    RimTents,
    /// IV: the rim is through.
    RimThrough,
}

/// One rupture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rupture {
    /// Which contactor went through.
    pub contactor: Contactor,
    /// Which boundary, from 0 at the surface.
    pub boundary: usize,
    /// The contactor's own elastic force just before, in N.
    pub force_n: f64,
    /// Axial displacement of the tip, in m.
    pub x_m: f64,
    /// Elastic energy dissipated by this rupture, in J.
    pub dissipated_j: f64,
}

/// One sample of motion along the needle's axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxialInput {
    /// Time, in s. Must increase.
    pub t_s: f64,
    /// Axial displacement of the tip from the skin, in m.
    pub x_m: f64,
    /// 1/cos θ, the factor on every thickness for an oblique path; 1 for a perpendicular one.
    pub path_factor: f64,
}

/// The force and its parts after one step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AxialOutput {
    /// Backward difference of x, in m/s.
    pub v_m_per_s: f64,
    /// Elastic force of the boundary the tip tents, in N.
    pub tip_n: f64,
    /// Elastic force of the boundary the rim tents, in N.
    pub rim_n: f64,
    /// Viscous force, in N.
    pub viscous_n: f64,
    /// Friction, in N.
    pub friction_n: f64,
    /// Cutting force, in N.
    pub cutting_n: f64,
    /// Material depth of the tip, in m, ≥ 0.
    pub depth_m: f64,
    /// A bad input (non-finite, or time not increasing) was held: forces are those of the last good sample's state.
    pub held: bool,
}

/// Checked parameters of the axial law, constant for an attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct AxialParams {
    spec: AxialSpec,
}

/// A parameter outside its domain.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{field} = {value} {unit}: {allowed}")]
pub struct ParamError {
    /// Which parameter, for example `layers[1].thickness_m`.
    pub field: String,
    /// The value found.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
    /// What is allowed, in words.
    pub allowed: &'static str,
}

/// All that must be saved to continue: one puncture track and the last sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxialState {
    /// How many boundaries the tip has opened on this track; they open in order.
    pub tip_open: usize,
    /// How many boundaries the rim has opened on this track.
    pub rim_open: usize,
    /// Deepest axial displacement that the tip has cut to on this track, in m.
    pub deepest_m: f64,
    /// Energy so far.
    pub ledger: Ledger,
}

/// Reused between steps, never saved.
#[derive(Clone, Debug, Default)]
pub struct AxialScratch {
    /// Ruptures of the last step, in the order resolved. Capacity for every boundary twice, so a step never allocates.
    pub ruptures: Vec<Rupture>,
}

impl AxialParams {
    /// Checks and freezes a specification.
    ///
    /// # Errors
    /// A [`ParamError`] naming the first parameter that is non-finite or out of range.
    pub fn new(spec: AxialSpec) -> Result<Self, ParamError> {
        Ok(Self { spec })
    }

    /// The specification these parameters were made from.
    #[must_use]
    pub fn spec(&self) -> &AxialSpec {
        &self.spec
    }
}

impl AxialState {
    /// A needle that has touched nothing.
    #[must_use]
    pub fn new(_params: &AxialParams) -> Self {
        unimplemented!()
    }
}

impl AxialScratch {
    /// Scratch large enough for `params`.
    #[must_use]
    pub fn new(_params: &AxialParams) -> Self {
        unimplemented!()
    }
}

/// One step of the axial law.
pub fn step(
    _params: &AxialParams,
    _state: &mut AxialState,
    _scratch: &mut AxialScratch,
    _input: &AxialInput,
) -> AxialOutput {
    unimplemented!()
}

impl AxialOutput {
    /// The axial force, in N: the sum of the parts in the order tip, rim, viscous, friction, cutting.
    #[must_use]
    pub fn total_n(&self) -> f64 {
        self.tip_n + self.rim_n + self.viscous_n + self.friction_n + self.cutting_n
    }
}
