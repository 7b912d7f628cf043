//! `stylet`, the native simulator of needle puncture: commands, wiring, upload.
//!
//! This crate contains no model of tissue: it reads files, calls the other crates, and reports the
//! results.

#![cfg_attr(not(feature = "window"), expect(dead_code, reason = "parts that the window alone uses"))]

#[cfg_attr(not(feature = "window"), expect(unused_imports, reason = "sentences that the window alone shows"))]
#[macro_use(sentence, tr, trn)]
extern crate words;

mod cli;
mod clock;
mod commands;
mod devices;
mod exit;
mod folders;
#[cfg(feature = "window")]
mod live;
mod machine;
mod maker;
mod motion;
mod new_file;
mod outbox;
mod output;
mod picture;
mod progress;
mod service;
#[cfg(feature = "window")]
mod settings;
mod shelf;
mod sources;
mod station;
#[cfg(feature = "window")]
mod window;

use std::process::ExitCode;

fn main() -> ExitCode {
    output::report_outcome(cli::parse(std::env::args_os()).and_then(|command| command.run()))
}
