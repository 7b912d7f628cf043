//! Signing in.

pub mod deep_linking;
pub mod federation;
pub mod grade_service;
pub mod lti;
pub mod passkey;
pub mod password_refused;
pub mod platform_members;
pub mod platform_registration;
pub mod second_factor;
pub mod sign_in_refusal;
