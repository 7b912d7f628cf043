//! People of a school.

pub mod accounts;
pub mod admin_commands;
pub mod bulk;
pub mod course_rosters;
pub mod provisioning;
pub mod roster_import;
