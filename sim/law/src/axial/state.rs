//! What goes in and out of a step, and what lasts between steps.

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

/// Samples closer than this are the same instant, in s: recordings count nanoseconds, and a velocity over less is noise.
const MIN_TICK_S: f64 = 1e-9;

/// Which of the two contactors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Contactor {
    /// The stylet tip.
    Tip,
    /// The cannula rim.
    Rim,
}

impl Contactor {
    /// As ids and files have it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Tip => "tip",
            Self::Rim => "rim",
        }
    }

    /// What a pop is called everywhere: by the layer that the contactor has got into. The boundary that gave way is that layer's upper one, so
    /// whoever is told of it must hear the name of what lies under it, not of what was left.
    #[must_use]
    pub fn into_layer(self, layer: impl Into<Phrase>) -> Phrase {
        let layer: Phrase = layer.into();
        match self {
            Self::Tip => phrase!("tip into {layer}", layer = layer),
            Self::Rim => phrase!("rim into {layer}", layer = layer),
        }
    }
}

/// Where a boundary stands, as in the paper.
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
    /// Which contactor went through.
    pub contactor: Contactor,
    /// Which boundary, from 0 at the surface.
    pub boundary: usize,
    /// The contactor's own elastic force just before, in N.
    pub force_n: f64,
    /// Axial displacement of the tip, in m.
    pub x_m: f64,
    /// Drop of the total elastic energy at this rupture, U_before − U_after, in J. Within a cascade one member may
    /// be negative: what takes over was tented deeper than what gave way.
    pub dissipated_j: f64,
}

/// One sample of motion along the needle's axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxialInput {
    /// Time, in s. Must increase.
    pub t_s: f64,
    /// Axial displacement of the tip from the skin, in m.
    pub x_m: f64,
    /// How the needle's line meets the layers.
    pub incidence: Incidence,
}

/// The force and its parts after one step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AxialOutput {
    /// Speed of x over the scene's window, in m/s; without a window the backward difference.
    pub v_m_per_s: f64,
    /// Force of the boundary the tip tents, in N: of its spring and of its branches.
    pub tip_n: f64,
    /// Force of the boundary the rim tents, in N, likewise.
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

/// The last good sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LastSample {
    pub t_s: f64,
    pub x_m: f64,
    pub output: AxialOutput,
}

/// All that must be saved to continue: one puncture track and the last sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxialState {
    /// How many boundaries the tip has opened on this track; they open in order.
    pub tip_open: usize,
    /// How many boundaries the rim has opened on this track. Stays 0 for a single contactor.
    pub rim_open: usize,
    /// Deepest material depth that the tip has reached on this track, in m along the path. Version 1 cuts below it.
    pub deepest_m: f64,
    /// Cutting front x_cut of this track, in m along the path; none before the skin is open. Version 2 cuts in front of it.
    #[serde(default)]
    pub front_m: Option<f64>,
    /// Energy so far.
    pub ledger: Ledger,
    /// The last good sample; none before the first.
    pub(super) last: Option<LastSample>,
    /// Earlier samples that speed is measured from.
    #[serde(default)]
    pub(super) window: SpeedWindow,
    /// Forces of the branches beside the tents. Version 3.
    #[serde(default)]
    pub(super) held: HeldBranches,
    /// Where the shaft is between static and kinetic friction. Version 3.
    #[serde(default)]
    pub(super) adhesion: Adhesion,
    /// Σ b_j l_j at the last good sample, in N·s/m. Version 5.
    #[serde(default)]
    pub(super) damping_n_s_per_m: f64,
    /// Direction of the needle's edge in the plane of the skin, of unit length: latched with its axis. Version 3.
    #[serde(default = "plain_edge")]
    pub edge: [f64; 2],
}

fn plain_edge() -> [f64; 2] {
    PLAIN_EDGE
}

/// Where the law stands: what is open, and the forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxialStanding {
    /// How many boundaries the tip has opened.
    pub tip_open: usize,
    /// How many boundaries the rim has opened.
    pub rim_open: usize,
    /// The forces.
    pub output: AxialOutput,
}

/// Reused between steps, never saved.
#[derive(Clone, Debug, Default)]
pub struct AxialScratch {
    /// Ruptures of the last step, in the order resolved. Capacity for every boundary twice, so a step never allocates.
    pub ruptures: Vec<Rupture>,
    /// D_i along the path of the current step, in m.
    pub(super) boundaries_m: Vec<f64>,
    /// How the layers were met in the current step.
    pub(super) incidence: Incidence,
}

impl AxialState {
    /// A needle that has touched nothing.
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

    /// Where the law stands at the last good sample.
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

    /// Where each boundary rests along the path of the last step, and the far side, in m. Empty before the first step.
    #[must_use]
    pub fn boundaries_m(&self) -> &[f64] {
        &self.boundaries_m
    }
}

impl AxialOutput {
    /// The axial force, in N: the sum of the parts in the order tip, rim, viscous, friction, cutting.
    #[must_use]
    pub fn total_n(&self) -> f64 {
        self.tip_n + self.rim_n + self.viscous_n + self.friction_n + self.cutting_n
    }
}
