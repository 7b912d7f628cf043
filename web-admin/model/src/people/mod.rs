//! People of a school.

pub mod directory;
pub mod email;
pub mod person;
pub mod roster;
pub mod scim;
