//! Sign-in with accounts of other systems.

pub mod flows;
pub mod identities;
pub mod providers;

use model::auth::federation::{FlowPurpose, IdentityKind, IdentityOrigin, LocalPasswords};

crate::engine::read_natively!(Text: FlowPurpose);
crate::engine::read_natively!(Text: IdentityKind);
crate::engine::read_natively!(Text: IdentityOrigin);
crate::engine::read_natively!(Text: LocalPasswords);
