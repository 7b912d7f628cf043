//! One file per command, and what several of them share.

pub mod anatomy;
pub mod bench;
pub mod calibrate;
pub mod check;
pub mod doctor;
pub mod export;
pub mod field;
pub mod force;
pub mod outbox;
pub mod pair;
pub mod play;
pub mod recover;
pub mod render;
pub mod replay;
pub mod schema;
pub mod score;
pub mod simulate;
pub mod upload;
pub mod validate;
pub mod verify;
