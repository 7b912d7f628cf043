//! Launches from learning platforms (LTI 1.3).

pub mod deep_linking;
pub mod launches;
pub mod members;
pub mod platforms;
pub mod registration;
pub mod services;
