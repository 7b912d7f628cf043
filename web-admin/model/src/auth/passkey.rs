//! WebAuthn challenges for the browser.

use crate::ids::CeremonyId;

/// A WebAuthn challenge for the browser, and the id for its response.
#[derive(Clone, Debug)]
pub struct PasskeyQuestion {
    /// Id, stored in the web session.
    pub id: CeremonyId,
    /// Options for the browser's WebAuthn API, as JSON.
    pub options: String,
    /// Origin for which the passkeys are valid.
    pub origin: String,
}
