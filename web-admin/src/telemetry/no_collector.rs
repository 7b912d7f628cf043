//! A program built without the feature `replicas` exports no telemetry, and refuses to start if a
//! collector is named.

use std::convert::Infallible;

use anyhow::bail;
use tracing_subscriber::layer::Identity;

use super::name_collectors;
use crate::AppState;

/// The exporters of spans and metrics, which do not exist in this build.
pub(crate) struct Telemetry(Infallible);

impl Telemetry {
    /// Returns `None`.
    ///
    /// # Errors
    /// When the environment names a collector.
    pub(crate) fn of_environment() -> anyhow::Result<Option<Self>> {
        let named = name_collectors();
        if named.is_empty() {
            return Ok(None);
        }
        bail!(
            "{}: this program is built without collector support; build with `cargo build --release -p web-admin --features replicas`",
            named.join(", ")
        )
    }

    pub(crate) fn layer(&self) -> Identity {
        match self.0 {}
    }

    pub(crate) fn send_figures(&self, _state: AppState) -> std::future::Ready<()> {
        match self.0 {}
    }

    pub(crate) fn end(self) {
        match self.0 {}
    }
}
