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
//! # An oblique needle
//!
//! The field is that of a perpendicular needle that meets the boundaries at the same depths. Under a needle at an angle the push
//! has a part across the normal, and along the needle the boundary gives way by another amount: on the training scene between
//! 2.2 % less and 1.1 % more at 15°, 5.0 % less and 3.1 % more at 25°, by the volumetric model at each boundary's own load. On
//! a half-space it would be more by [`tilt_excess`], which is above these in size. Loads, recoil and signs are exact at
//! any angle; so is everything at 0°.

mod coupling;
mod field;
mod responses;
mod spec;
mod state;

pub use coupling::{HandOver, Insertion, RateError, hand_over, rate_errors};
pub use field::{FIELD_HZ, Field, FieldPlan, FollowError};
pub use responses::{Fit, Responses};
pub use spec::{TissueSpec, recoil_time_s, tilt_excess};
pub use state::{FollowParams, FollowState, step};
