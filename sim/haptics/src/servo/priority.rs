//! Real-time priority of the servo's thread, and how to allow it.

use std::fmt;

/// What the thread got.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Priority {
    /// Real time: nothing ordinary keeps it from a deadline.
    RealTime,
    /// The device's own thread ticks; its driver sets the priority.
    Device,
    /// As any other thread: the system refused.
    Ordinary,
}

impl Priority {
    /// What to do about it; empty when nothing.
    #[must_use]
    pub fn advice(self) -> &'static str {
        match self {
            Self::RealTime | Self::Device => "",
            Self::Ordinary if cfg!(target_os = "linux") => {
                "allow real-time priority: add the line `@audio - rtprio 95` to /etc/security/limits.conf, \
                 join the group audio, and log in again"
            }
            Self::Ordinary => "run with the right to raise a thread's priority",
        }
    }
}

impl fmt::Display for Priority {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::RealTime => "real-time priority",
            Self::Device => "the device's own thread",
            Self::Ordinary => "ordinary priority: refused real time",
        })
    }
}

/// Raises the current thread as far as it is allowed.
#[cfg(unix)]
pub(super) fn raise() -> Priority {
    use thread_priority::{
        RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
        set_thread_priority_and_policy, thread_native_id,
    };
    /// Above whatever else asks for real time, below the system's own threads.
    const LEVEL: u8 = 80;
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    let raised = ThreadPriorityValue::try_from(LEVEL).is_ok_and(|level| {
        set_thread_priority_and_policy(thread_native_id(), ThreadPriority::Crossplatform(level), policy).is_ok()
    });
    if raised { Priority::RealTime } else { Priority::Ordinary }
}

/// Raises the current thread as far as it is allowed.
#[cfg(not(unix))]
pub(super) fn raise() -> Priority {
    let raised = thread_priority::set_current_thread_priority(thread_priority::ThreadPriority::Max).is_ok();
    if raised { Priority::RealTime } else { Priority::Ordinary }
}
