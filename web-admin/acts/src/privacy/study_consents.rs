//! The terms of a study, and consent to them at a station.

use data_encoding::HEXLOWER;
use model::Moment;
use model::ids::PersonId;
use serde_json::json;
use sha2::{Digest, Sha256};
use store::Connection;
use store::audit::{Actor, AuditEntry};
use store::studies::{self, Study};

use crate::error::Error;

/// Returns the revision of a study's terms: the hexadecimal SHA-256 of consent text, data
/// controller, contact and retention period.
#[must_use]
pub fn revision_of_terms(study: &Study) -> String {
    let months = study.kept_months.to_string();
    let mut hash = Sha256::new();
    for part in [&study.consent, &study.controller, &study.contact, &months] {
        // With its length, so that different texts cannot concatenate to the same bytes.
        hash.update(part.len().to_be_bytes());
        hash.update(part.as_bytes());
    }
    HEXLOWER.encode(&hash.finalize())
}

/// Records a guest's consent at a station, with the time and the revision of the terms.
pub(crate) async fn consent_at_station(
    writer: &mut Connection,
    station: &str,
    study: &Study,
    guest: PersonId,
    now: Moment,
) -> Result<(), Error> {
    if !studies::note_consent(writer, study, guest, now).await? {
        return Err(Error::NotFound);
    }
    let details = json!({ "person": guest, "terms_sha256": revision_of_terms(study), "consent": study.consent });
    let entry = AuditEntry::new(study.school_id, Actor::Station(station.to_owned()), "study.consented", study.id);
    Ok(entry.with(details).append(writer, now).await?)
}
