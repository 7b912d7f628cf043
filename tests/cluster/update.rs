//! `cluster update`: the services of one program are replaced by those of another, one by one, under load.

use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use anyhow::{Context, ensure};
use clap::Args;
use tests::endings::say;

use crate::check;
use crate::client::Proxy;
use crate::fleet::{Post, Replica, ports, start_four};
use crate::ledger::{BROKEN, Ledger};
use crate::load::Load;
use crate::school::{School, SchoolArgs, beside_us};

/// How long all is left as it is between two steps.
const PEACE: Duration = Duration::from_secs(4);
/// What an older program says of a database that it does not know any more.
const NEWER: &str = "newer than this program";

/// What to replace by what
#[derive(Debug, Args)]
pub struct UpdateArgs {
    #[command(flatten)]
    school: SchoolArgs,
    /// The `web-admin` that serves at first
    #[arg(long, value_name = "FILE")]
    old: PathBuf,
    /// The one that comes in its place [default: the one beside this program]
    #[arg(long, value_name = "FILE")]
    new: Option<PathBuf>,
}

/// Replaces each; whether all is well in the end.
pub fn run(args: &UpdateArgs) -> anyhow::Result<bool> {
    let new = args.new.clone().map_or_else(|| beside_us("web-admin"), Ok)?;
    let new = new.canonicalize().with_context(|| new.display().to_string())?;
    let school = Arc::new(School::found(&SchoolArgs { program: Some(args.old.clone()), ..args.school.clone() })?);
    let mut fleet = start_four(&school)?;
    let (proxy, ledger) = (Arc::new(Proxy::before(ports(&fleet))), Arc::new(Ledger::default()));
    let mut load = Load::begin(&school, &proxy, &ledger, 3)?;
    thread::sleep(PEACE);
    let before = newest_step(&school)?;
    for number in 0..fleet.len() {
        fleet[number].leave()?;
        fleet[number].program.clone_from(&new);
        fleet[number].start()?;
        say(&format!("{} is replaced", fleet[number].name));
        if number == 0 && newest_step(&school)? != before {
            refuse_old(&school)?;
            say("an old program that is started now says that the database is newer");
        }
        thread::sleep(PEACE);
        load.look_after()?;
        fleet.iter_mut().try_for_each(Replica::look_after)?;
    }
    load.end()?;
    check::await_queues(&school)?;
    let tallies = ledger.tallies();
    check::tell_requests(&tallies);
    let mut verdict = check::pass(&school, &proxy, &ledger)?;
    verdict.count("steps of the schema before", before as usize);
    verdict.count("steps of the schema since", newest_step(&school)? as usize);
    let mut failed = Vec::new();
    for (what, tally) in &tallies {
        for (status, of) in tally.by_status.iter().filter(|(status, _)| **status >= 500 || **status == BROKEN) {
            failed.push(format!("{what} came to {status} ({} times): {}", of.count, tally.latest));
        }
    }
    verdict.blame("requests that failed, but for connections that were not taken", failed);
    say(&verdict.table());
    fleet.iter_mut().try_for_each(Replica::leave)?;
    Ok(verdict.is_good())
}

/// The newest migration that the database has had.
fn newest_step(school: &School) -> anyhow::Result<u64> {
    school.count("SELECT max(version) FROM _sqlx_migrations")
}

/// An old program that is started now must say why it does not serve.
fn refuse_old(school: &Arc<School>) -> anyhow::Result<()> {
    let mut late = Replica::new(school, Post::Work, "late".to_owned());
    let Err(refused) = late.start() else { anyhow::bail!("an old program serves a database that is newer than it") };
    let said = format!("{refused:#}");
    ensure!(said.contains(NEWER), "an old program does not say that the database is newer: {said}");
    Ok(())
}
