//! The commands, one file each, and code shared by several of them.

pub mod anatomy;
#[cfg(feature = "reports")]
pub mod bench;
pub mod calibrate;
pub mod check;
pub mod doctor;
pub mod export;
pub mod field;
pub mod force;
pub mod outbox;
pub mod pair;
#[cfg(feature = "window")]
pub mod play;
pub mod recover;
pub mod render;
#[cfg(feature = "window")]
pub mod replay;
pub mod schema;
pub mod score;
pub mod simulate;
pub mod upload;
pub mod validate;
pub mod verify;
