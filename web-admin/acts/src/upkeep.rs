//! What the service does for itself, when it starts and now and then.

pub use store::tries::SetAside;
use store::{account_links, regradings, rosters, tries};

use crate::error::Error;
use crate::regrading::exercise::PREVIEW_LIFETIME_S;
use crate::roster_import::DRAFT_LIFETIME_S;
use crate::service::Service;

/// How long it is kept that a recording was fatal to whoever read it, in s.
const READING_LIFETIME_S: i64 = 90 * 24 * 3600;

/// Throws away links that are no longer good, and rosters and re-gradings that nobody confirmed.
pub async fn forget_expired(service: &Service) -> Result<(), Error> {
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    account_links::forget_expired(&mut tx, now).await?;
    rosters::forget_before(&mut tx, now.plus_s(-DRAFT_LIFETIME_S)).await?;
    tries::forget_readings(&mut tx, now.plus_s(-READING_LIFETIME_S)).await?;
    regradings::forget_before(&mut tx, now.plus_s(-PREVIEW_LIFETIME_S)).await?;
    Ok(tx.commit().await?)
}

/// Counts, at the start, what was begun and never ended as a death; what is tried no more, for it was fatal twice.
pub async fn count_deaths(service: &Service) -> Result<Vec<SetAside>, Error> {
    let mut tx = service.db.write().await?;
    let set_aside = tries::count_deaths(&mut tx).await?;
    tx.commit().await?;
    Ok(set_aside)
}

/// Takes back, at the end, what was begun: what is cut off now was fatal to nobody.
pub async fn take_back_begun(service: &Service) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    tries::take_back_tries(&mut tx).await?;
    Ok(tx.commit().await?)
}

/// Lets what was set aside be tried again; how many there are.
pub async fn forgive_deaths(service: &Service) -> Result<u64, Error> {
    let mut tx = service.db.write().await?;
    let until = service.clock.now().plus_s(service.config.upload_lifetime_s);
    let forgiven = tries::forgive_deaths(&mut tx, until).await?;
    tx.commit().await?;
    Ok(forgiven)
}
