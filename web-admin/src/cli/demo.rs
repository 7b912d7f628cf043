//! `web-admin demo`: creates a demonstration school.

use std::thread;

use clap::{Args, value_parser};
use model::Role;
use platform::clock::Clock;
use platform::config::Config;
use platform::secret;

use super::{CommandFailure, StorageArgs, say_line};
use crate::demo::{DemoAccount, Demonstration};
use crate::{AppState, demo};

/// Options of `web-admin demo`.
#[derive(Debug, Args)]
pub struct DemoArgs {
    #[command(flatten)]
    storage: StorageArgs,
    /// Password of every account [default: a random one, printed]
    #[arg(long)]
    password: Option<String>,
    /// Weeks of practice before today
    #[arg(long, default_value_t = 6, value_parser = value_parser!(u32).range(1..=26))]
    weeks: u32,
    /// Adds this many generated trainees with a hundred attempts each, to measure pages on: figures
    /// without recordings
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = value_parser!(u32).range(0..=100_000))]
    crowd: u32,
    /// Seed of every simulated patient and every simulated hand
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

pub(super) async fn run_demo(args: &DemoArgs) -> Result<(), CommandFailure> {
    let password = args.password.clone().map_or_else(secret::random_password, Ok)?;
    let cores = thread::available_parallelism().map_or(1, Into::into);
    let config = Config { judges: cores, ..args.storage.config()? };
    let state = AppState::open(config, Clock::system()).await?;
    let wanted = Demonstration { weeks: args.weeks, password, seed: args.seed, crowd: args.crowd };
    let accounts = demo::make_demonstration(&state, &wanted).await?;
    state.db.close().await;
    say_line(
        "Demonstration school. The people are invented and the attempts simulated; the password of every account is",
    );
    say_line(format_args!("    {}", wanted.password));
    accounts.iter().for_each(|account| say_line(line_of_account(account)));
    Ok(())
}

fn line_of_account(DemoAccount { role, name, email }: &DemoAccount) -> String {
    let role = match role {
        Role::Administrator => "administrator",
        Role::Instructor => "instructor",
        Role::Trainee | Role::Guest => "trainee",
    };
    format!("    {role:<14} {email:<34} {name}")
}
