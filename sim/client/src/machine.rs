//! Name and free disk space of this machine.

use std::fs;
use std::path::Path;

/// Returns the host name, or `station` if it is unknown.
pub fn machine_name() -> String {
    let told = fs::read_to_string("/proc/sys/kernel/hostname").or_else(|_| fs::read_to_string("/etc/hostname")).ok();
    let told = told.or_else(|| std::env::var("COMPUTERNAME").ok());
    told.map(|name| name.trim().to_owned()).filter(|name| !name.is_empty()).unwrap_or_else(|| "station".to_owned())
}

/// Returns the bytes that an unprivileged user can still write to the file system of a folder;
/// `None` if unknown.
#[cfg(unix)]
pub fn free_bytes(folder: &Path) -> Option<u64> {
    let stat = rustix::fs::statvfs(folder).ok()?;
    Some(stat.f_bavail.saturating_mul(stat.f_frsize))
}

/// Returns the bytes that an unprivileged user can still write to the file system of a folder;
/// `None` if unknown.
#[cfg(not(unix))]
pub fn free_bytes(_folder: &Path) -> Option<u64> {
    None
}
