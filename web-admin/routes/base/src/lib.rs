//! Shared code of all routes: the state of a handler, authentication, errors as responses, forms,
//! the list of routes.
//!
//! Functions that query the database fail when the database does; `# Errors` sections list only the
//! other causes.

#[macro_use(tr)]
extern crate words;

pub mod addresses;
pub mod auth;
pub mod authoring;
pub mod caching;
pub mod column_names;
pub mod error;
mod examining;
pub mod export;
pub mod forms;
pub mod language;
mod listed;
pub mod operations;
pub mod recordings;
pub mod refusals;
pub mod startup;
pub mod surveys;

pub use examining::examine_draft;
pub use listed::{Routes, get, post};
pub use startup::AppState;
