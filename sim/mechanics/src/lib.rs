//! The physics of a puncture: force law, tracks, lateral foundation, structures, energy ledger, virtual operators,
//! deforming tissue, and the fit of layers to a measured curve.
//!
//! Pure: data in, data out. No clock, thread, file, socket or log; randomness only from a seed it is given.
//! Everything is in SI units. `+` axial force pushes the needle out of the body; `+` displacement goes in.
//!
//! Frames. *Patient*: origin on the planned skin, `+z` out of the body, so tissue lies at z < 0 and the skin is
//! the plane z = 0. *Needle*: origin at the stylet tip, `+z` from the hub towards the tip.

pub mod axial;
pub mod beam;
pub mod calibrate;
pub mod closed_form;
pub mod ledger;
pub mod operator;
pub mod puncture;
pub mod soundness;
pub mod structures;
pub mod tissue;
