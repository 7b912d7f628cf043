//! Launches from learning platforms (LTI 1.3).

pub mod deep_linking;
pub mod launches;
pub mod platforms;
pub mod services;
