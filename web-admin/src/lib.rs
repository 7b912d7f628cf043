//! The service of Stylet: takes recordings in, scores them, shows what trainees and instructors need to see.
//!
//! A library with a thin program around it, so that tests run the router in process.

#[macro_use]
pub mod words;

pub mod accounts;
pub mod anchoring;
pub mod assignments;
pub mod backup;
pub mod certificates;
pub mod cli;
pub mod clock;
pub mod config;
pub mod deadlines;
pub mod demo;
pub mod domain;
pub mod drafting;
pub mod erasing;
pub mod erasures;
pub mod error;
pub mod export;
pub mod intake;
pub mod judging;
pub mod keys;
pub mod killpoints;
pub mod lines;
pub mod locks;
pub mod mail;
mod motions;
pub mod passkeys;
pub mod passwords;
pub mod previews;
pub mod publishing;
pub mod ratings;
pub mod recordings;
pub mod regrading;
pub mod replays;
pub mod retention;
pub mod roster_import;
pub mod routes;
pub mod scanning;
pub mod sealing;
pub mod second_factor;
pub mod secret;
pub mod segments;
pub mod serving;
pub mod shares;
pub mod startup;
pub mod stations;
pub mod storage;
pub mod surveys;
pub mod tokens;
pub mod uploads;
pub mod verification;
pub mod views;
pub mod worker;

pub use startup::AppState;
