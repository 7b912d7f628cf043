//! Web pages: one struct per template, which takes plain data and renders HTML.

#[macro_use(sentence, tr, trn)]
extern crate words;

pub mod anatomy;
pub mod assets;
pub mod audit;
pub mod auth;
pub mod authoring;
pub mod charts;
pub mod error;
pub mod flash_message;
pub mod form;
pub mod format;
pub mod letters;
pub mod metric;
pub mod operations;
pub mod people;
pub mod privacy;
pub mod recordings;
#[cfg(test)]
mod samples;
pub mod school_time;
pub mod scoring;
pub mod shell;
pub mod status;
pub mod studies;
pub mod surveys;
pub mod training;

pub use shell::{NavPlace, Shell};
pub use status::StatusWord;
