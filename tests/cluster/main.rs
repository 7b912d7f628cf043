//! `cluster`: several services on one PostgreSQL and one bucket, under load, while they are killed, cut off, counted and replaced. What
//! clients were told is held against what is there in the end; exit 1 where anything is amiss.

mod check;
mod client;
mod fleet;
mod kill;
mod ledger;
mod load;
mod outages;
mod postgres;
mod processor;
mod queueing;
mod relay;
mod school;
mod scoring;
mod smtp;
mod store;
mod update;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use tests::endings::conclude;

/// Tries several services on one database
#[derive(Debug, Parser)]
struct Args {
    #[command(subcommand)]
    test: Test,
}

#[derive(Debug, Subcommand)]
enum Test {
    /// Kills services at random, and counts what is left of what was acknowledged
    Kill(kill::KillArgs),
    /// Takes database and store away, and gives them back
    Outages(outages::OutagesArgs),
    /// Measures how fast several workers score
    Scoring(scoring::ScoringArgs),
    /// Replaces the services of one program by those of another, one by one
    Update(update::UpdateArgs),
}

fn main() -> ExitCode {
    conclude(match Args::parse().test {
        Test::Kill(args) => kill::run(&args),
        Test::Outages(args) => outages::run(&args),
        Test::Scoring(args) => scoring::run(&args),
        Test::Update(args) => update::run(&args),
    })
}
