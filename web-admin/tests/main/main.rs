//! The service through its front door: the router in process, a real database file per test, one client per role.

#![expect(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on says so and stops"
)]

/// Ends a test here where the tests are run on the other engine: it is about this one alone, for this reason.
macro_rules! only_on {
    ($engine:ident, $why:literal) => {
        if crate::support::database::engine() != store::EngineKind::$engine {
            return;
        }
    };
}

mod api;
mod audit;
mod auth;
mod authoring;
mod described;
mod doors;
mod every_route;
mod flash_messages;
mod letters;
mod nonsense;
mod operations;
mod other_programs;
mod pages;
mod people;
mod privacy;
mod recordings;
mod refusals;
mod scoring;
mod stations;
mod studies;
mod support;
mod surveys;
mod training;
mod words;
