//! The field follows the needle: the force law's loads, with recoil, on unit responses that were
//! computed once.
//!
//! The tissue is linear and a needle loads it at known places: a contactor at each boundary, the
//! shaft's drag along each layer. So a model of the tissue is solved once for 1 N at each of them
//! ([`Responses`]), and a step of the field is a handful of load amplitudes ([`FollowState`]): any
//! displacement is their weighted sum.
//!
//! The field runs alongside the force law and takes its latest loads without waiting, at any rate.
//! An increasing load is followed at once, because the tissue moves with the needle that pushes it.
//! A contactor's load falls no faster than the tissue recoils: after a rupture it decays with the
//! time constant of the boundary's layer. Drag sticks to the shaft and is followed in both
//! directions, so that a withdrawal pulls the tissue out.
//!
//! A boundary pressed by the tip or the rim stays in contact with them: its load is the one that
//! brings the field there, and boundaries that the needle has passed, or has not
//! met yet, are kept on their side of it ([`law::stance::settle_dents`]).
//!
//! Where the law of a layer stiffens or relaxes, a drag acts on its secant stiffness. [`Follower`]
//! puts these together, as each version of a recording does ([`law::stance::Follows`]).
//!
//! # An oblique needle
//!
//! The loads push along the needle and the responses are along it, at its angle of insertion; the
//! position of a boundary is where such a needle meets it. The planner's model of flat layers has
//! one harmonic for the push into the body and one for the push along the skin, both exact and
//! independent of the angle: their combination is evaluated at a few angles and interpolated by a
//! polynomial ([`AngledResponses`]). Any other model is solved for the angle of the exercise.

mod angles;
mod asked;
mod coupling;
mod field;
mod follower;
mod press;
mod profile;
mod responses;
mod secant;
mod spec;
mod state;
mod unevenness;

pub use angles::{AngledResponses, FLATTEST_RAD};
pub use asked::AttemptLoad;
pub use coupling::{HandOver, RateError, StraightInsertion, hand_over, rate_errors};
pub use field::{FIELD_HZ, Field, FieldPlan, FollowError};
pub use follower::Follower;
pub use profile::Profiles;
pub use responses::{Fit, Responses};
pub use spec::{TissueSpec, recoil_time_s};
pub use state::{FollowParams, FollowState, step};
