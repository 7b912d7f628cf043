//! Launches from learning platforms.

pub mod content_choices;
pub mod courses;
pub mod launches;
pub mod platforms;

use model::auth::lti::NumberClaim;

crate::engine::read_natively!(Text: NumberClaim);
