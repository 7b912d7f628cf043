//! Periodic maintenance of the service, also run at start-up.

use store::auth::{account_links, rate_limits, webauthn_challenges};
use store::people::rosters;
use store::recordings::parse_attempts;
use store::scoring::regradings;

use crate::auth::federation::client_keys;
use crate::auth::signing_in::note_unknown_sign_ins;
use crate::error::Error;
use crate::people::roster_import::DRAFT_LIFETIME_S;
use crate::scoring::regrading::exercise::PREVIEW_LIFETIME_S;
use crate::service::Service;

/// How long a crash while reading a recording counts against it, in s.
const READING_LIFETIME_S: i64 = 90 * 24 * 3600;

/// Writes the counted sign-in attempts with unknown addresses to the audit log, and removes expired
/// links, rate limits, passkey challenges and records of crashes, and unconfirmed rosters and
/// re-gradings; renews the keys of this service.
pub async fn forget_expired(service: &Service) -> Result<(), Error> {
    note_unknown_sign_ins(service).await?;
    client_keys::renew_keys(service).await?;
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    account_links::forget_expired(&mut tx, now).await?;
    rosters::forget_before(&mut tx, now.plus_s(-DRAFT_LIFETIME_S)).await?;
    parse_attempts::forget_readings(&mut tx, now.plus_s(-READING_LIFETIME_S)).await?;
    regradings::forget_before(&mut tx, now.plus_s(-PREVIEW_LIFETIME_S)).await?;
    rate_limits::forget_brakes(&mut tx, now).await?;
    webauthn_challenges::forget_ceremonies(&mut tx, now).await?;
    Ok(tx.commit().await?)
}

/// Releases everything from quarantine, and returns the number of items.
pub async fn forgive_deaths(service: &Service) -> Result<u64, Error> {
    let mut tx = service.db.write().await?;
    let until = service.clock.now().plus_s(service.config.upload_lifetime_s);
    let forgiven = parse_attempts::forgive_deaths(&mut tx, until).await?;
    tx.commit().await?;
    Ok(forgiven)
}
