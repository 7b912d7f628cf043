//! Devices that need no vendor driver.

#[cfg(feature = "gamepad")]
pub mod gamepad;
pub mod hand;
pub mod operator;
pub mod scripted;
pub mod trajectory;
