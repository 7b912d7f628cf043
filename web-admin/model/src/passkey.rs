//! What a browser is to ask a passkey.

use crate::ids::CeremonyId;

/// What a browser is to ask a passkey, and the id by which its answer is taken.
#[derive(Clone, Debug)]
pub struct PasskeyQuestion {
    /// Id; it stays in the session.
    pub id: CeremonyId,
    /// What the browser is told, in JSON.
    pub options: String,
    /// The origin that passkeys answer to.
    pub origin: String,
}
