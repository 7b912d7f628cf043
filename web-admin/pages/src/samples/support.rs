//! Trainees at risk, and a message to one of them.

use model::Moment;
use model::ids::{PersonId, SupportNoteId};
use model::training::risk::Concern;
use model::training::support_note::{SupportKind, SupportNote};

use super::NOW;

/// The concerns about a trainee of the sample cohort.
pub(super) fn concerns_of(name: &str) -> Vec<Concern> {
    match name {
        "Ana Lindqvist" => vec![Concern::Inactive { days: 16 }],
        "Bruno Ferrari" => vec![Concern::Failing {
            exercise: "reach-the-muscle".to_owned(),
            title: "Reach the muscle".to_owned(),
            fails: 3,
            last_score: 41.0,
        }],
        _ => vec![],
    }
}

pub(super) fn message() -> SupportNote {
    SupportNote {
        id: SupportNoteId::nil(),
        person_id: PersonId::from_u128(4),
        by: "Dr Peter Osei".to_owned(),
        kind: SupportKind::Message,
        subject: Some("Practice on Thursday".to_owned()),
        body: "Station 2 is free from 14:00.".to_owned(),
        mailed: true,
        made_at: Moment::from(NOW),
    }
}
