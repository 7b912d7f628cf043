//! The messages in wire format, and their conversion from and to plain data.
//!
//! The plain types are separate because Protobuf makes every submessage optional; the force law
//! should not have to handle an `Option`.

use law::ledger::{LayerEnergy, Ledger};

use crate::event::{Event, EventKind};
use crate::fluoroscopy::{CArmControls, FluoroscopyPulse};
use crate::generated::stylet as generated;
pub(crate) use crate::generated::stylet::event::Kind;
pub(crate) use crate::generated::stylet::{
    CArmControls as CArmMessage, EnergyLedger, Event as EventMessage, FluoroscopyPulse as PulseMessage, NeedleSample,
    NeedleSummary, Range, TissueTent,
};
use crate::sample::{Energy, Sample};
use crate::tent::{Follows, Tent};

/// The `FileDescriptorSet` that every `stylet.*` schema carries.
pub(crate) const DESCRIPTORS: &[u8] = include_bytes!("../proto/stylet.bin");

impl From<[f64; 3]> for generated::Vector3 {
    fn from([x, y, z]: [f64; 3]) -> Self {
        Self { x, y, z }
    }
}

impl From<[f32; 3]> for generated::Vector3f {
    fn from([x, y, z]: [f32; 3]) -> Self {
        Self { x, y, z }
    }
}

/// Protobuf omits a submessage of zeros, so an absent one is zero.
fn components(vector: Option<generated::Vector3>) -> [f64; 3] {
    vector.map_or([0.0; 3], |v| [v.x, v.y, v.z])
}

fn components_f32(vector: Option<generated::Vector3f>) -> [f32; 3] {
    vector.map_or([0.0; 3], |v| [v.x, v.y, v.z])
}

impl From<&Sample> for NeedleSample {
    fn from(s: &Sample) -> Self {
        let [x, y, z, w] = s.orientation;
        Self {
            t_s: s.t_s,
            position_m: Some(s.position_m.into()),
            orientation: Some(generated::Quaternion { x, y, z, w }),
            velocity_m_per_s: Some(s.velocity_m_per_s.into()),
            x_m: s.x_m,
            depth_m: s.depth_m,
            force_n: Some(s.force_n.into()),
            tip_n: s.tip_n,
            rim_n: s.rim_n,
            viscous_n: s.viscous_n,
            friction_n: s.friction_n,
            cutting_n: s.cutting_n,
            lateral_n: Some(s.lateral_n.into()),
            device_n: Some(s.device_n.into()),
            flags: s.flags,
            lateness_us: s.lateness_us,
            bend_m: s.bend_m.iter().any(|c| *c != 0.0).then(|| s.bend_m.into()),
        }
    }
}

impl From<NeedleSample> for Sample {
    fn from(s: NeedleSample) -> Self {
        Self {
            t_s: s.t_s,
            position_m: components(s.position_m),
            orientation: s.orientation.map_or([0.0; 4], |q| [q.x, q.y, q.z, q.w]),
            velocity_m_per_s: components_f32(s.velocity_m_per_s),
            x_m: s.x_m,
            depth_m: s.depth_m,
            force_n: components_f32(s.force_n),
            tip_n: s.tip_n,
            rim_n: s.rim_n,
            viscous_n: s.viscous_n,
            friction_n: s.friction_n,
            cutting_n: s.cutting_n,
            lateral_n: components_f32(s.lateral_n),
            device_n: components_f32(s.device_n),
            flags: s.flags,
            lateness_us: s.lateness_us,
            bend_m: components_f32(s.bend_m),
        }
    }
}

impl From<&Tent> for TissueTent {
    fn from(tent: &Tent) -> Self {
        let Tent { t_s, tent_m, contactor_n, drag_n, linear_n, follows } = tent.clone();
        let [follows_needle, follows_secant] = [Follows::Needle, Follows::Secant].map(|least| follows >= least);
        Self { t_s, tent_m, contactor_n, drag_n, follows_needle, linear_n, follows_secant }
    }
}

impl From<TissueTent> for Tent {
    fn from(tent: TissueTent) -> Self {
        let TissueTent { t_s, tent_m, contactor_n, drag_n, follows_needle, linear_n, follows_secant } = tent;
        let follows = match (follows_needle, follows_secant) {
            (_, true) => Follows::Secant,
            (true, false) => Follows::Needle,
            (false, false) => Follows::Forces,
        };
        Self { t_s, tent_m, contactor_n, drag_n, linear_n, follows }
    }
}

impl From<EventKind> for Kind {
    fn from(kind: EventKind) -> Self {
        match kind {
            EventKind::Contact => Self::Contact,
            EventKind::TipRupture => Self::TipRupture,
            EventKind::RimRupture => Self::RimRupture,
            EventKind::StructureHit => Self::StructureHit,
            EventKind::HubContact => Self::HubContact,
            EventKind::SkinExit => Self::SkinExit,
            EventKind::Confirm => Self::Confirm,
            EventKind::Coaching => Self::Coaching,
            EventKind::Fault => Self::Fault,
            EventKind::Interrupted => Self::Interrupted,
        }
    }
}

/// Returns the kind of an event, or an error for an unknown number.
fn event_kind(number: i32) -> Result<EventKind, String> {
    let unknown = || format!("event of kind {number}; allowed: 1 to 10");
    Ok(match Kind::try_from(number).map_err(|_| unknown())? {
        Kind::Unspecified => return Err(unknown()),
        Kind::Contact => EventKind::Contact,
        Kind::TipRupture => EventKind::TipRupture,
        Kind::RimRupture => EventKind::RimRupture,
        Kind::StructureHit => EventKind::StructureHit,
        Kind::HubContact => EventKind::HubContact,
        Kind::SkinExit => EventKind::SkinExit,
        Kind::Confirm => EventKind::Confirm,
        Kind::Coaching => EventKind::Coaching,
        Kind::Fault => EventKind::Fault,
        Kind::Interrupted => EventKind::Interrupted,
    })
}

impl From<&Event> for EventMessage {
    fn from(e: &Event) -> Self {
        Self {
            t_s: e.t_s,
            kind: Kind::from(e.kind).into(),
            boundary: e.boundary,
            x_m: e.x_m,
            position_m: Some(e.position_m.into()),
            force_n: e.force_n,
            dissipated_j: e.dissipated_j,
            track: e.track,
            structure: e.structure,
            text: e.text.clone(),
        }
    }
}

impl TryFrom<EventMessage> for Event {
    type Error = String;

    fn try_from(e: EventMessage) -> Result<Self, String> {
        Ok(Self {
            t_s: e.t_s,
            kind: event_kind(e.kind)?,
            boundary: e.boundary,
            x_m: e.x_m,
            position_m: components(e.position_m),
            force_n: e.force_n,
            dissipated_j: e.dissipated_j,
            track: e.track,
            structure: e.structure,
            text: e.text,
        })
    }
}

impl From<&LayerEnergy> for generated::LayerEnergy {
    fn from(layer: &LayerEnergy) -> Self {
        let &LayerEnergy { elastic_j, rupture_j, viscous_j, friction_j, cutting_j, lateral_j } = layer;
        Self { elastic_j, rupture_j, viscous_j, friction_j, cutting_j, lateral_j }
    }
}

impl From<generated::LayerEnergy> for LayerEnergy {
    fn from(layer: generated::LayerEnergy) -> Self {
        let generated::LayerEnergy { elastic_j, rupture_j, viscous_j, friction_j, cutting_j, lateral_j } = layer;
        Self { elastic_j, rupture_j, viscous_j, friction_j, cutting_j, lateral_j }
    }
}

impl From<&Energy> for EnergyLedger {
    fn from(energy: &Energy) -> Self {
        let ledger = &energy.ledger;
        Self {
            t_s: energy.t_s,
            input_j: ledger.input_j,
            returned_j: ledger.returned_j,
            presliding_j: ledger.presliding_j,
            lagged_j: ledger.lagged_j,
            layers: ledger.layers.iter().map(Into::into).collect(),
        }
    }
}

impl From<EnergyLedger> for Energy {
    fn from(energy: EnergyLedger) -> Self {
        Self {
            t_s: energy.t_s,
            ledger: Ledger {
                input_j: energy.input_j,
                returned_j: energy.returned_j,
                presliding_j: energy.presliding_j,
                lagged_j: energy.lagged_j,
                layers: energy.layers.into_iter().map(Into::into).collect(),
            },
        }
    }
}

impl From<&CArmControls> for CArmMessage {
    fn from(controls: &CArmControls) -> Self {
        let CArmControls { t_s, orbital_rad, tilt_rad, field_m, pedal, shots, contrast_ml } = *controls;
        Self { t_s, orbital_rad, tilt_rad, field_m, pedal, shots, contrast_ml }
    }
}

impl From<CArmMessage> for CArmControls {
    fn from(message: CArmMessage) -> Self {
        let CArmMessage { t_s, orbital_rad, tilt_rad, field_m, pedal, shots, contrast_ml } = message;
        Self { t_s, orbital_rad, tilt_rad, field_m, pedal, shots, contrast_ml }
    }
}

impl From<&FluoroscopyPulse> for PulseMessage {
    fn from(pulse: &FluoroscopyPulse) -> Self {
        let FluoroscopyPulse { t_s, index, shot, load_mas, mean_transmission, kerma_mgy, kerma_area_gycm2 } = *pulse;
        Self { t_s, index, shot, load_mas, mean_transmission, kerma_mgy, kerma_area_gycm2 }
    }
}

impl From<PulseMessage> for FluoroscopyPulse {
    fn from(message: PulseMessage) -> Self {
        let PulseMessage { t_s, index, shot, load_mas, mean_transmission, kerma_mgy, kerma_area_gycm2 } = message;
        Self { t_s, index, shot, load_mas, mean_transmission, kerma_mgy, kerma_area_gycm2 }
    }
}
