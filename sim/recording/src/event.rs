//! Events of an attempt, topic `/events`.

use law::axial::Contactor;

/// Kind of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EventKind {
    /// The tip touched the skin.
    Contact,
    /// The tip opened a boundary.
    TipRupture,
    /// The rim opened a boundary.
    RimRupture,
    /// The needle hit a structure.
    StructureHit,
    /// The hub met the skin.
    HubContact,
    /// The tip left the skin.
    SkinExit,
    /// The trainee confirmed the position.
    Confirm,
    /// A coaching message was shown.
    Coaching,
    /// A fault occurred and was contained.
    Fault,
    /// The device or the program ended the attempt, not the trainee.
    Interrupted,
}

impl EventKind {
    /// Returns the name in files and on pages, for example `tip_rupture`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Contact => "contact",
            Self::TipRupture => "tip_rupture",
            Self::RimRupture => "rim_rupture",
            Self::StructureHit => "structure_hit",
            Self::HubContact => "hub_contact",
            Self::SkinExit => "skin_exit",
            Self::Confirm => "confirm",
            Self::Coaching => "coaching",
            Self::Fault => "fault",
            Self::Interrupted => "interrupted",
        }
    }

    /// Returns the contactor of a rupture.
    #[must_use]
    pub fn contactor(self) -> Option<Contactor> {
        match self {
            Self::TipRupture => Some(Contactor::Tip),
            Self::RimRupture => Some(Contactor::Rim),
            _ => None,
        }
    }
}

/// One event.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// Time since the start, in s.
    pub t_s: f64,
    /// Kind.
    pub kind: EventKind,
    /// Boundary of a rupture, from 0.
    pub boundary: Option<u32>,
    /// Axial displacement of the tip, in m.
    pub x_m: f64,
    /// Tip position, in m, patient frame. For a contact: the entry point.
    pub position_m: [f64; 3],
    /// Force just before, in N: the contactor's elastic force at a rupture, otherwise the layers' share of the axial force.
    pub force_n: f64,
    /// Energy dissipated by a rupture, in J.
    pub dissipated_j: f64,
    /// Track of a contact, from 0.
    pub track: Option<u32>,
    /// Structure of a hit: its index in the scene.
    pub structure: Option<u32>,
    /// Text: a layer's or structure's name, a coaching message, a fault.
    pub text: String,
}
