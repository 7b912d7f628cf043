//! The needle in space: contact, latched axis, tracks, lateral foundation and structures around the
//! axial law.
//!
//! The skin is the plane z = 0, or curves away from it ([`crate::Skin`]). Contact is the tip
//! crossing it inwards; the entry is the crossing of its path. From then on the needle's axis is
//! latched, x = (tip − entry)·axis, and the tip's offset from that line presses sideways on a
//! Winkler foundation: F⊥ = −k_lat s δ⊥, or the response of [`crate::beam`] if the needle bends:
//! structures and bone then meet the bent tip. The needle leaves when its tip is above the skin
//! again. A first sample inside the body enters along its axis.
//!
//! Each puncture runs in a track. Entering within 2 mm of a known track's entry resumes its open
//! boundaries and its deepest point; farther away begins a new one. A perpendicular straight path
//! gives exactly the bits of [`crate::axial::step`].
//!
//! Bone is a penalty of 2500 N/m on the tip's penetration; a vessel or an organ may have a wall that does the same until it gives
//! way. A structure is hit when the tip or the inserted shaft gets
//! inside it from outside, once until it has left again.
//!
//! The hub ends the shaft. Inserted by more than the needle's length, it presses into the skin: F = k (x − L), conservative like bone.
//! It meets an undented plane skin; where the needle is oblique its rim would touch a little earlier, by half its width times tan θ.

mod contact;
mod params;
mod state;
mod step;

pub use params::{PunctureParams, PunctureSpec};
pub use state::{PunctureEvent, PunctureInput, PunctureOutput, PunctureScratch, PunctureState};
pub use step::{held_incidence, measure_clearance_m, measure_intrusion, step, write_loads};
