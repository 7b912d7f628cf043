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

/// The servo's level: above whatever else asks for real time, below the system's own threads.
pub(crate) const SERVO: u8 = 80;
/// The level of a driver that speaks with its device in a thread of its own: below the servo, above everything ordinary.
pub(crate) const DRIVER: u8 = 70;

/// Raises the current thread to a level, if that is allowed.
#[cfg(unix)]
pub(crate) fn raise(level: u8) -> Priority {
    use thread_priority::{
        RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
        set_thread_priority_and_policy, thread_native_id,
    };
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    let raised = ThreadPriorityValue::try_from(level).is_ok_and(|level| {
        set_thread_priority_and_policy(thread_native_id(), ThreadPriority::Crossplatform(level), policy).is_ok()
    });
    if raised { Priority::RealTime } else { Priority::Ordinary }
}

/// Raises the current thread as far as it is allowed; elsewhere there are no levels.
#[cfg(not(unix))]
pub(crate) fn raise(_level: u8) -> Priority {
    let raised = thread_priority::set_current_thread_priority(thread_priority::ThreadPriority::Max).is_ok();
    if raised { Priority::RealTime } else { Priority::Ordinary }
}
