//! Why the device could not be opened.

/// Why an Inverse3 could not be opened.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Inverse3Error {
    /// Nobody listens there, or the address is none.
    #[error("service not reached: {url}: {why}")]
    Unreachable {
        /// Address of the service.
        url: String,
        /// The system's words.
        why: String,
    },
    /// Somebody listens there who does not speak WebSocket.
    #[error("not an Inverse Service: {url}: {why}")]
    NotTheService {
        /// Address of the service.
        url: String,
        /// What went wrong.
        why: String,
    },
    /// The service is of a version whose protocol is another.
    #[error("wrong service version: {found}; 3.0 or later is needed")]
    WrongVersion {
        /// Its version, as it says.
        found: String,
    },
    /// The service took the connection and says nothing.
    #[error("service silent: {url} sent no state within {seconds} s")]
    Silent {
        /// Address of the service.
        url: String,
        /// How long it was waited for, in s.
        seconds: u64,
    },
    /// What the service says is not understood.
    #[error("service not understood: {url} sent {start:?}")]
    NotUnderstood {
        /// Address of the service.
        url: String,
        /// How the text begins.
        start: String,
    },
    /// The service has no such device.
    #[error("device not found: {wanted}; the service lists {found}")]
    NoDevice {
        /// The device that was asked for.
        wanted: String,
        /// The devices that there are.
        found: String,
    },
    /// The device takes no force.
    #[error("device not ready: {device_id} is {why}")]
    NotReady {
        /// The device.
        device_id: String,
        /// What it is or is not.
        why: &'static str,
    },
}

impl Inverse3Error {
    /// What to do about it.
    #[must_use]
    pub fn advice(&self) -> &'static str {
        match self {
            Self::Unreachable { .. } => {
                "install and start the Haply Inverse Service, or give its address with --inverse3 ws://HOST:PORT"
            }
            Self::NotTheService { .. } => {
                "another program uses this port: give the service's with --inverse3 ws://HOST:PORT"
            }
            Self::WrongVersion { .. } => "update the Haply Inverse Service",
            Self::Silent { .. } | Self::NotUnderstood { .. } => "restart the Haply Inverse Service, and update it",
            Self::NoDevice { .. } => "connect the Inverse3 by USB, switch it on, and look for it in the Haply Hub",
            Self::NotReady { .. } => "connect its power supply, and follow the calibration in the Haply Hub",
        }
    }
}
