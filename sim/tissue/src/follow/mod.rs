//! The field follows the needle: the force law's loads, with recoil, on unit responses that were computed once.
//!
//! The tissue is linear and a needle loads it at known places: a contactor at each boundary, the shaft's drag along each layer.
//! So a model of the tissue is asked once for the answer to 1 N at each of them ([`Responses`]), and a step of the field is a
//! handful of load amplitudes ([`FollowState`]): any displacement is their sum.
//!
//! The field runs beside the force law and takes its latest loads without waiting, at whatever rate it can. A load that
//! rises is followed at once, for the tissue moves with the needle that pushes it. A contactor's load falls no faster than the
//! tissue comes back: after a rupture it decays with the time constant of the boundary's layer. Drag sticks to the shaft and
//! is followed both ways, so that a withdrawal pulls the tissue out.
//!
//! A boundary that tip or rim presses on stands where they are: the load on it is the one that brings the field there ([`press_loads`]),
//! and what the needle has passed, or has not met yet, is kept on its side of it ([`law::stance::settle`]).
//!
//! # An oblique needle
//!
//! The loads push along the needle and the responses are along it, at the angle at which it went in; a boundary is
//! where such a needle meets it. The planner's model of flat layers has a harmonic for the push into the body and one for the
//! push along the skin, both exact, and neither knows the angle: what it makes of them is told at a few angles and lies on a polynomial
//! between ([`AngledResponses`]). Another model answers for the angle of the exercise.

mod angles;
mod asked;
mod coupling;
mod field;
mod press;
mod profile;
mod responses;
mod spec;
mod state;
mod unevenness;

pub use angles::{AngledResponses, FLATTEST_RAD};
pub use asked::AttemptLoad;
pub use coupling::{HandOver, RateError, StraightInsertion, hand_over, rate_errors};
pub use field::{FIELD_HZ, Field, FieldPlan, FollowError};
pub use press::press_loads;
pub use profile::Profiles;
pub use responses::{Fit, Responses};
pub use spec::{TissueSpec, recoil_time_s};
pub use state::{FollowParams, FollowState, step};
