//! The axial force law: two contactors, ruptures, viscosity, presliding friction and cutting.
//!
//! The law follows "Tissue and Force Modelling on Multi-layered Needle Puncture for Percutaneous
//! Surgery Training" (below: the paper), extended by a second contactor, thresholds, friction and
//! cutting. With a single contactor (`tip_to_rim_m` = 0), no friction and no cutting it is the
//! paper's law. For layer i with proximal boundary at D_i = Σ_{j<i} d_j and y = x − D_i:
//!
//! ```text
//! before boundary i ruptures   F = k_i y + v Σ_{j<i} b_j d_j
//! after                        F = v (b_i min(y, d_i) + Σ_{j<i} b_j d_j)
//! ```
//!
//! # Errata of the paper
//!
//! Three layers (skin s, fat f, muscle m), each before and after its rupture, make six cells; five
//! formulas are printed for them. Their assignment, and the corrections needed for the dimensions
//! to agree:
//!
//! | cell | taken from | corrected |
//! |---|---|---|
//! | skin before | the first formula | nothing: k_s y |
//! | skin after | the second | nothing: v b_s y |
//! | fat before | the third | the damping of the skin passed carries b_s, not b_f: k_f y_f + v b_s d_s |
//! | fat after | the fourth | b_s on the skin's part, and the fat's part is y_f alone, not y_f on top of y: v (b_f y_f + b_s d_s) |
//! | muscle before | missing | written by analogy with fat before: k_m y_m + v (b_s d_s + b_f d_f) |
//! | muscle after | the fifth | b_m multiplies y_m (printed y_f), and y_m stops at d_m: v (b_m y_m + b_s d_s + b_f d_f) |
//!
//! The paper gives no rupture threshold, its second table's damping lacks a velocity, and its pop
//! force is a constant that is never reset. Here a pop is an event: a threshold of each contactor,
//! and the force that vanishes with the boundary.
//!
//! # Versions
//!
//! A scene names the version of the law for which it was made ([`ForceLaw`]). Versions 1 and 2
//! differ in cutting, in the measurement of speed and in the accuracy of the energy balance; a
//! scene without cutting and window is bit-identical in both.
//!
//! ```text
//! version 1   F_cutting = f_j in a tick with Δx > 0, s > deepest s so far and no tented boundary; else 0
//! version 2   F_cutting = clip(k_pre (x − x_cut), 0, f_j); at the cap x_cut ← x − f_j/k_pre; x_cut = x when the skin opens
//! ```
//!
//! Version 1 depends on whether the tip moved in the tick. On an encoder in steps of 55 µm at 2
//! mm/s it does in one tick of 27, so its force rattled and was too small. Version 2 depends on the
//! distance of the tip from the cutting front.
//!
//! Up to version 4 F_viscous = v Σ b_j l_j, with v over the scene's window: a lagging force, which
//! feeds energy to a free handle. Version 5 puts a spring in series with each dashpot instead
//! ([`damping`]), and no force depends on v.
//!
//! # Order within a tick
//!
//! Ruptures first (every tip rupture in boundary order, then every rim rupture in boundary order:
//! the tip does not depend on the rim, and the rim may use what the tip has just opened), then the
//! material depth and the inserted lengths, then the forces, all with the state after the ruptures.
//! Products and sums are evaluated as written, never fused, so that the same input gives the same
//! bits on every machine.

mod adhesion;
mod book;
mod damping;
mod loads;
mod maxwell;
mod options;
mod params;
mod path;
mod relaxation;
mod speed_window;
mod springs;
mod state;
mod step;

pub(crate) use book::book_lateral;
pub use loads::write_loads;
pub use options::{
    Breakaway, FibrousSheet, LayerOptions, MAX_BRANCHES, MaxwellBranch, PLAIN_EDGE, RuptureCriterion,
    tense_stiffness_n_per_m,
};
pub use params::{
    AxialParams, AxialSpec, Domain, ForceLaw, Layer, MAX_LAYERS, ParamError, RateDependence, UnknownForceLaw,
};
pub(crate) use path::{Open, Path, lay_boundaries};
pub use state::{AxialInput, AxialOutput, AxialScratch, AxialStanding, AxialState, Contactor, PiercingStage, Rupture};
pub use step::{forecast_standing, step};
