//! What every route of the service needs: the state of a handler, who is asking, errors as answers, forms, the list of routes.
//!
//! Whatever asks the database fails when the database does; a function says only what else it refuses.

#[macro_use(tr)]
extern crate words;

pub mod addresses;
pub mod auth;
pub mod column_names;
pub mod error;
mod examining;
pub mod exercises;
pub mod export;
pub mod forms;
pub mod language;
mod listed;
pub mod monitoring;
pub mod pictures;
pub mod refusals;
pub mod startup;
pub mod stored_files;
pub mod surveys;

pub use examining::examine_draft;
pub use listed::{Routes, get, post};
pub use startup::AppState;
