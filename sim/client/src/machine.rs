//! Name and free disk space of this machine.

#![cfg_attr(windows, expect(unsafe_code, reason = "a call of the Windows API"))]

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
#[cfg(windows)]
pub fn free_bytes(folder: &Path) -> Option<u64> {
    use std::os::windows::ffi::OsStrExt;
    use std::ptr;

    use windows_sys::Win32::Storage::FileSystem::GetDiskFreeSpaceExW;

    let folder: Vec<u16> = folder.as_os_str().encode_wide().chain([0]).collect();
    let mut bytes = 0;
    // SAFETY: the path ends with a zero and outlives the call; the number can be written, and the
    // other two are optional.
    let answered = unsafe { GetDiskFreeSpaceExW(folder.as_ptr(), &raw mut bytes, ptr::null_mut(), ptr::null_mut()) };
    (answered != 0).then_some(bytes)
}
