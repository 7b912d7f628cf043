//! Measurements that others have published, and what a scene gives beside each: inside, outside, or not to be compared, and why.
//!
//! Nothing is tuned here. A figure stays in the list whether a scene agrees with it or not, and says whether its source was read or
//! recalled. Everything is in SI units unless a name says otherwise.

mod compare;
mod figures;
mod insertion;
mod sources;

pub use compare::{Agreement, DossierLine, Incomparable, TOLD_APART, compare_scene};
pub use figures::{FIGURES, MeasuredQuantity, PublishedFigure, PublishedRange};
pub use sources::{HowKnown, MeasurementSource};
