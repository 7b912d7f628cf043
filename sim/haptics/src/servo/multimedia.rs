//! Priority of a thread on Windows, from the Multimedia Class Scheduler: its task "Pro Audio" runs
//! above all ordinary threads, without administrator rights.

#![expect(unsafe_code, reason = "calls of the Windows API")]

use windows_sys::Win32::System::Threading::{
    AVRT_PRIORITY_CRITICAL, AVRT_PRIORITY_HIGH, AvSetMmThreadCharacteristicsW, AvSetMmThreadPriority, GetCurrentThread,
    SetThreadPriority, THREAD_PRIORITY_TIME_CRITICAL,
};
use windows_sys::w;

/// Raises the current thread until it ends: `first` above other threads of the task. Returns
/// whether the scheduler has accepted it; otherwise the thread has the highest ordinary priority.
pub(super) fn raise(first: bool) -> bool {
    let level = if first { AVRT_PRIORITY_CRITICAL } else { AVRT_PRIORITY_HIGH };
    let mut task = 0;
    // SAFETY: the name is a constant that ends with a zero, and the task's number can be written.
    let registered = unsafe { AvSetMmThreadCharacteristicsW(w!("Pro Audio"), &raw mut task) };
    // SAFETY: the handle was just returned for this thread.
    if !registered.is_null() && unsafe { AvSetMmThreadPriority(registered, level) } != 0 {
        return true;
    }
    // SAFETY: the current thread always has a handle. A refusal leaves the thread as it is.
    unsafe { SetThreadPriority(GetCurrentThread(), THREAD_PRIORITY_TIME_CRITICAL) };
    false
}
