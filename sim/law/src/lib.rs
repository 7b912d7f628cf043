//! The law of a puncture: forces, tracks, lateral foundation, bending needle, structures, energy
//! ledger, virtual operators. It must never fail: a tick has no error to return.
//!
//! Pure: data in, data out. No clock, thread, file, socket or log; randomness only from a given
//! seed. Everything is in SI units. `+` axial force pushes the needle out of the body; `+`
//! displacement goes in.
//!
//! Frames. *Patient*: origin on the skin, `+z` out of the body, so tissue lies at z < 0 and the
//! skin is the plane z = 0 or touches it ([`Skin`]). *Needle*: origin at the stylet tip, `+z` from
//! the hub towards the tip.

pub mod axial;
pub mod beam;
pub mod closed_form;
pub mod fracture;
mod hold;
pub mod inertia;
mod judging;
pub mod ledger;
pub mod operator;
pub mod puncture;
pub mod quasistatic;
mod skin;
pub mod soundness;
pub mod stance;
pub mod structures;

pub use judging::Judging;
pub use skin::{Incidence, Skin};
