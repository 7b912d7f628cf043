//! Errors of opening the device.

/// Why an Inverse3 could not be opened.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Inverse3Error {
    /// No program listens at the address, or the address is invalid.
    #[error("service not reached: {url}: {why}")]
    Unreachable {
        /// Address of the service.
        url: String,
        /// The system's message.
        why: String,
    },
    /// The program at the address does not use the WebSocket protocol.
    #[error("not an Inverse Service: {url}: {why}")]
    NotTheService {
        /// Address of the service.
        url: String,
        /// The failure.
        why: String,
    },
    /// The service has a version with an incompatible protocol.
    #[error("wrong service version: {found}; 3.0 or later is needed")]
    WrongVersion {
        /// The version that it reports.
        found: String,
    },
    /// The service accepted the connection and sends nothing.
    #[error("service silent: {url} sent no state within {seconds} s")]
    Silent {
        /// Address of the service.
        url: String,
        /// Time waited, in s.
        seconds: u64,
    },
    /// The service's message cannot be parsed.
    #[error("service not understood: {url} sent {start:?}")]
    NotUnderstood {
        /// Address of the service.
        url: String,
        /// Beginning of the message.
        start: String,
    },
    /// The service does not list the device.
    #[error("device not found: {wanted}; the service lists {found}")]
    NoDevice {
        /// The requested device.
        wanted: String,
        /// The available devices.
        found: String,
    },
    /// The device accepts no force.
    #[error("device not ready: {device_id} is {why}")]
    NotReady {
        /// The device.
        device_id: String,
        /// The missing condition.
        why: &'static str,
    },
}

impl Inverse3Error {
    /// Advice for the user.
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
