//! Launches from learning platforms.

pub mod content_choices;
pub mod courses;
pub mod deliveries;
pub mod launches;
pub mod platforms;

use model::auth::grade_service::DeliveryState;
use model::auth::lti::NumberClaim;

crate::engine::read_natively!(Text: DeliveryState, Text: NumberClaim);
