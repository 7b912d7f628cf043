//! Free space on the disks: uploads leave a reserve free, and only the database may use the last of
//! the disk.

use std::path::Path;

use model::{PersonKey, count_i64};
use platform::config::UploadQuota;
use store::recordings::{sessions, uploads};

use crate::error::Error;
use crate::service::Service;

/// Bytes written between two checks of the free space.
pub(crate) const LOOK_BYTES: u64 = 8 << 20;
/// Period over which a person's attempts are counted, in s.
const DAY_S: i64 = 24 * 3600;

/// Rejects a file that would leave less than the reserve free, counting the announced bytes of
/// unfinished uploads.
///
/// # Errors
/// Returns [`Error::NoRoom`] if it would; fails if a disk or the database cannot be queried.
pub async fn ensure_room(state: &Service, wanted_bytes: u64) -> Result<(), Error> {
    let promised = uploads::sum_promised(state.db.reader(), state.clock.now()).await?.unsigned_abs();
    ensure_free(&state.config.recordings_dir, state.config.reserve_bytes, promised.saturating_add(wanted_bytes))?;
    ensure_database_room(state)
}

/// Rejects the continuation of an upload once the recordings' disk has only its reserve left.
///
/// # Errors
/// Returns [`Error::NoRoom`] then; fails if a disk cannot be queried.
pub fn ensure_reserve(state: &Service) -> Result<(), Error> {
    ensure_free(&state.config.recordings_dir, state.config.reserve_bytes, 0)?;
    ensure_database_room(state)
}

/// Rejects large files once only the database's reserve is left, which signing in and deleting
/// need.
///
/// # Errors
/// Returns [`Error::NoRoom`] then; fails if the disk cannot be queried.
pub fn ensure_database_room(state: &Service) -> Result<(), Error> {
    ensure_free(&state.config.data_dir, state.config.database_reserve_bytes, 0)
}

fn ensure_free(folder: &Path, reserve_bytes: u64, wanted_bytes: u64) -> Result<(), Error> {
    let disk = rustix::fs::statvfs(folder).map_err(std::io::Error::from)?;
    let free_bytes = disk.f_bavail.saturating_mul(disk.f_frsize);
    let needed_bytes = reserve_bytes.saturating_add(wanted_bytes);
    if free_bytes < needed_bytes {
        let cause = anyhow::anyhow!(
            "{free_bytes} bytes are free on the disk of {}; {needed_bytes} are needed, reserve included",
            folder.display()
        );
        return Err(Error::NoRoom(cause));
    }
    Ok(())
}

/// Rejects a recording beyond a person's quota: recordings in 24 hours, and bytes in total.
///
/// # Errors
/// Returns [`Error::OverQuota`] then; fails if the database fails.
pub async fn ensure_person_quota(
    executor: impl store::Executor<'_>,
    state: &Service,
    whose: PersonKey,
    size: u64,
) -> Result<(), Error> {
    let UploadQuota { uploads: most, bytes: most_bytes } = state.config.person_quota;
    let day_ago = state.clock.now().plus_s(-DAY_S);
    let kept = sessions::sum_kept_recordings(executor, whose, day_ago).await?;
    if kept.today >= count_i64(most) {
        return Err(Error::OverQuota(format!(
            "{} attempts of this trainee were uploaded within 24 hours; at most {most} are allowed",
            kept.today
        )));
    }
    if kept.bytes.unsigned_abs().saturating_add(size) > most_bytes {
        let bytes = kept.bytes;
        return Err(Error::OverQuota(format!(
            "this trainee's recordings have {bytes} bytes in total; with this one of {size} bytes they exceed the limit of {most_bytes}"
        )));
    }
    Ok(())
}
