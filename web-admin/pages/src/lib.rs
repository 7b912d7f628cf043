//! Web pages: one struct per template, which takes plain data and renders HTML.

#[macro_use(sentence, tr, trn)]
extern crate words;

pub mod account;
pub mod addresses;
pub mod admin;
pub mod anatomy;
pub mod assets;
pub mod assignments;
pub mod audit;
pub mod authoring;
pub mod backups;
pub mod certificate;
pub mod charts;
pub mod cohort;
pub mod concern;
pub mod consent;
pub mod curricula;
pub mod deed;
pub mod diff;
pub mod draft;
pub mod erasing;
pub mod error;
pub mod exercise;
pub mod experts;
#[cfg(test)]
mod forgotten;
pub mod form;
pub mod format;
pub mod gradebook;
pub mod instructor;
pub mod judgement;
pub mod letters;
pub mod links;
pub mod listed;
pub mod login;
#[cfg(test)]
mod markup;
pub mod measured;
pub mod metric;
pub mod moments;
pub mod news;
pub mod origins;
pub mod passkeys;
pub mod people;
pub mod pictures;
pub mod progress;
pub mod proving;
pub mod qr;
pub mod rating;
pub mod regrading;
pub mod replay;
pub mod retention;
pub mod review;
pub mod revisions;
pub mod roster;
#[cfg(test)]
mod samples;
pub mod school_time;
pub mod second_factor;
pub mod segments;
pub mod service;
pub mod session;
pub mod settings;
pub mod shell;
pub mod status;
pub mod study;
pub mod survey;
pub mod tokens;
pub mod trainee;
pub mod transcript;

pub use shell::{NavPlace, Shell};
pub use status::StatusWord;
