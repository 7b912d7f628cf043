//! Input, output and state of a step.

use phrase::{Phrase, phrase};
use serde::{Deserialize, Serialize};

use super::adhesion::Adhesion;
use super::options::PLAIN_EDGE;
use super::params::AxialParams;
use super::path::Open;
use super::relaxation::HeldBranches;
use super::speed_window::SpeedWindow;
use crate::ledger::Ledger;
use crate::skin::Incidence;

/// Samples closer than this count as the same instant, in s: recordings count nanoseconds, and a
/// velocity over less is noise.
const MIN_TICK_S: f64 = 1e-9;

/// One of the two contactors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Contactor {
    /// The stylet tip.
    Tip,
    /// The cannula rim.
    Rim,
}

impl Contactor {
    /// Name in ids and files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Tip => "tip",
            Self::Rim => "rim",
        }
    }

    /// Describes a pop by the layer that the contactor entered. The ruptured boundary is that
    /// layer's upper one, so messages must name the layer below it, not the one that was left.
    #[must_use]
    pub fn into_layer(self, layer: impl Into<Phrase>) -> Phrase {
        let layer: Phrase = layer.into();
        match self {
            Self::Tip => phrase!("tip into {layer}", layer = layer),
            Self::Rim => phrase!("rim into {layer}", layer = layer),
        }
    }
}

/// Stage of a boundary, as in the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PiercingStage {
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
    /// The contactor that passed.
    pub contactor: Contactor,
    /// Index of the boundary, from 0 at the surface.
    pub boundary: usize,
    /// The contactor's own elastic force just before, in N.
    pub force_n: f64,
    /// Axial displacement of the tip, in m.
    pub x_m: f64,
    /// Drop of the total elastic energy at this rupture, U_before − U_after, in J. Within a cascade
    /// one member may be negative: the next boundary was tented deeper than the ruptured one.
    pub dissipated_j: f64,
}

/// One sample of motion along the needle's axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxialInput {
    /// Time, in s. Must increase.
    pub t_s: f64,
    /// Axial displacement of the tip from the skin, in m.
    pub x_m: f64,
    /// Incidence of the needle's line on the layers.
    pub incidence: Incidence,
}

/// The force and its parts after one step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AxialOutput {
    /// Speed of x over the scene's window, in m/s; without a window the backward difference.
    pub v_m_per_s: f64,
    /// Force of the boundary tented by the tip, in N: of its spring and of its branches.
    pub tip_n: f64,
    /// Force of the boundary tented by the rim, in N: of its spring and of its branches.
    pub rim_n: f64,
    /// Viscous force, in N.
    pub viscous_n: f64,
    /// Friction, in N.
    pub friction_n: f64,
    /// Cutting force, in N.
    pub cutting_n: f64,
    /// Material depth of the tip, in m, ≥ 0.
    pub depth_m: f64,
    /// Whether an invalid input (non-finite, or time not increasing) was ignored: forces are those
    /// of the last good sample's state.
    pub held: bool,
}

/// The last good sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LastSample {
    pub t_s: f64,
    pub x_m: f64,
    pub output: AxialOutput,
}

/// The complete state, sufficient to continue: one puncture track and the last sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxialState {
    /// Number of boundaries that the tip has opened on this track; they open in order.
    pub tip_open: usize,
    /// Number of boundaries that the rim has opened on this track. Stays 0 for a single contactor.
    pub rim_open: usize,
    /// Maximum material depth of the tip on this track, in m along the path. Version 1 cuts below
    /// it.
    pub deepest_m: f64,
    /// Cutting front x_cut of this track, in m along the path; `None` before the skin is open.
    /// Version 2 cuts in front of it.
    #[serde(default)]
    pub front_m: Option<f64>,
    /// Energies so far.
    pub ledger: Ledger,
    /// The last good sample; `None` before the first.
    pub(super) last: Option<LastSample>,
    /// Earlier samples from which speed is measured.
    #[serde(default)]
    pub(super) window: SpeedWindow,
    /// Forces of the branches of the tents. Version 3.
    #[serde(default)]
    pub(super) held: HeldBranches,
    /// State between static and kinetic friction. Version 3.
    #[serde(default)]
    pub(super) adhesion: Adhesion,
    /// Σ b_j l_j at the last good sample, in N·s/m. Version 5.
    #[serde(default)]
    pub(super) damping_n_s_per_m: f64,
    /// Direction of the needle's edge in the plane of the skin, of unit length: latched with its
    /// axis. Version 3.
    #[serde(default = "plain_edge")]
    pub edge: [f64; 2],
}

fn plain_edge() -> [f64; 2] {
    PLAIN_EDGE
}

/// State of the law: open boundaries and forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxialStanding {
    /// Number of boundaries that the tip has opened.
    pub tip_open: usize,
    /// Number of boundaries that the rim has opened.
    pub rim_open: usize,
    /// The forces.
    pub output: AxialOutput,
}

/// Reused between steps, never saved.
#[derive(Clone, Debug, Default)]
pub struct AxialScratch {
    /// Ruptures of the last step, in the order resolved. Capacity for every boundary twice, so a
    /// step never allocates.
    pub ruptures: Vec<Rupture>,
    /// D_i along the path of the current step, in m.
    pub(super) boundaries_m: Vec<f64>,
    /// Incidence on the layers in the current step.
    pub(super) incidence: Incidence,
}

impl AxialState {
    /// The state before any contact.
    #[must_use]
    pub fn new(params: &AxialParams) -> Self {
        let layers = params.spec().layers.len();
        Self {
            tip_open: 0,
            rim_open: 0,
            deepest_m: 0.0,
            front_m: None,
            ledger: Ledger::new(layers),
            last: None,
            window: SpeedWindow::new(params.spec().speed_window_s),
            held: HeldBranches::default(),
            adhesion: Adhesion::default(),
            damping_n_s_per_m: 0.0,
            edge: PLAIN_EDGE,
        }
    }

    /// The output of the last good sample; zeros before the first.
    #[must_use]
    pub fn last_output(&self) -> AxialOutput {
        self.last.map_or_else(AxialOutput::default, |last| last.output)
    }

    /// State of the law at the last good sample.
    #[must_use]
    pub fn standing(&self) -> AxialStanding {
        AxialStanding { tip_open: self.tip_open, rim_open: self.rim_open, output: self.last_output() }
    }

    /// Whether a sample at this time would be a new one.
    #[must_use]
    pub fn is_later(&self, t_s: f64) -> bool {
        t_s.is_finite() && self.last.as_ref().is_none_or(|last| t_s - last.t_s >= MIN_TICK_S)
    }

    pub(crate) fn open(&self) -> Open {
        Open { tip: self.tip_open, rim: self.rim_open }
    }
}

impl AxialScratch {
    /// Scratch large enough for `params`.
    #[must_use]
    pub fn new(params: &AxialParams) -> Self {
        let layers = params.spec().layers.len();
        Self {
            ruptures: Vec::with_capacity(2 * layers),
            boundaries_m: Vec::with_capacity(layers + 1),
            incidence: Incidence::UPRIGHT,
        }
    }

    /// Resting positions of the boundaries along the path of the last step, and of the far side, in
    /// m. Empty before the first step.
    #[must_use]
    pub fn boundaries_m(&self) -> &[f64] {
        &self.boundaries_m
    }
}

impl AxialOutput {
    /// The axial force, in N: the sum of the parts in the order tip, rim, viscous, friction,
    /// cutting.
    #[must_use]
    pub fn total_n(&self) -> f64 {
        self.tip_n + self.rim_n + self.viscous_n + self.friction_n + self.cutting_n
    }
}
