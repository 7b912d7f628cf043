//! Devices without a vendor.

pub mod gamepad;
pub mod hand;
pub mod operator;
pub mod scripted;
pub mod trajectory;
