//! Real-time priority of the servo's thread, and advice on how to allow it.

use std::{fmt, io, thread};

/// The priority that a thread has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Priority {
    /// Real time: ordinary threads cannot delay it.
    RealTime,
    /// The ticks run in the device's own thread; its driver sets the priority.
    Device,
    /// Ordinary priority: the system refused real time.
    Ordinary,
}

impl Priority {
    /// Advice for the user; empty if there is nothing to do.
    #[must_use]
    pub fn advice(self) -> &'static str {
        match self {
            Self::RealTime | Self::Device => "",
            Self::Ordinary if cfg!(target_os = "linux") => {
                "allow real-time priority: add the line `@audio - rtprio 95` to /etc/security/limits.conf, \
                 join the group audio, and log in again"
            }
            Self::Ordinary if cfg!(windows) => {
                "start the service Multimedia Class Scheduler: as administrator, sc start MMCSS"
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
            Self::Ordinary => "normal priority: real-time priority was denied",
        })
    }
}

/// The servo's level: above other real-time programs, below the system's own threads.
pub(crate) const SERVO: u8 = 80;
/// The level of a driver that communicates with its device in a thread of its own: below the servo,
/// above all ordinary threads.
pub(crate) const DRIVER: u8 = 70;

/// Raises the current thread to a level, if the system allows it.
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

/// Raises the current thread to a level, if the system allows it.
#[cfg(windows)]
pub(crate) fn raise(level: u8) -> Priority {
    if super::multimedia::raise(level >= SERVO) { Priority::RealTime } else { Priority::Ordinary }
}

/// Returns the priority that the system grants to the servo's thread.
///
/// # Errors
/// If a thread cannot be created.
pub fn granted() -> io::Result<Priority> {
    let asking = thread::Builder::new().name("priority".to_owned()).spawn(|| raise(SERVO))?;
    asking.join().map_err(|_| io::Error::other("it was stopped by a defect"))
}
