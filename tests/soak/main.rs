//! `soak`: a school whose service and stations are killed, and whose network is cut or falls silent, at random; at the end a table of what
//! was acknowledged and what of it is there. Exit 1 where anything is amiss.

mod lab;
mod network;
mod station;
mod verdict;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::Ordering::SeqCst;
use std::sync::atomic::{AtomicBool, AtomicUsize};
use std::thread;
use std::time::Duration;

use anyhow::Context;
use clap::Parser;
use lab::{Lab, Serving};
use network::Network;
use platform::clock;
use station::Station;
use tests::dice::Dice;
use tests::endings::{conclude, say};

/// Kills a service and its stations at random, and counts what is left
#[derive(Debug, Parser)]
struct Args {
    /// How long, in s
    #[arg(default_value_t = 3600, value_parser = clap::value_parser!(u64).range(1..))]
    seconds: u64,
    /// Stations that send at once
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..=32))]
    stations: u16,
    /// Decides what happens; not when, which the machine does, too
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Empty folder for everything, which is left there [default: one that goes with the soak]
    #[arg(long, value_name = "DIR")]
    folder: Option<PathBuf>,
}

/// What was done to whom.
#[derive(Debug, Default)]
pub struct Harm {
    services: AtomicUsize,
    clients: AtomicUsize,
    cuts: AtomicUsize,
    silences: AtomicUsize,
    ended: AtomicBool,
}

impl Harm {
    fn is_over(&self) -> bool {
        self.ended.load(SeqCst)
    }
}

/// Longest that a service lives, in ms.
const LONGEST_LIFE_MS: u64 = 9000;

fn main() -> ExitCode {
    conclude(soak(&Args::parse()))
}

fn soak(args: &Args) -> anyhow::Result<bool> {
    let scratch = tempfile::tempdir()?;
    let folder = args.folder.clone().unwrap_or_else(|| scratch.path().to_owned());
    let lab = Arc::new(Lab::found(&folder)?);
    let harm = Arc::new(Harm::default());
    let network = Network::before(lab.port, args.seed, Arc::clone(&harm))?;
    let mut stations = Vec::new();
    for number in 0..args.stations {
        stations.push(Station::new(&lab, number, network.port, args.seed)?);
    }
    say(&format!("soaking for {} s in {}", args.seconds, folder.display()));
    let (keeper_lab, keeper_harm, dice) = (Arc::clone(&lab), Arc::clone(&harm), Dice::new(args.seed));
    let keeper = thread::spawn(move || keep_killing(&keeper_lab, &keeper_harm, dice));
    let work = |mut station: Station| {
        let harm = Arc::clone(&harm);
        thread::spawn(move || station.work(&harm).map(|()| station))
    };
    let working: Vec<_> = stations.into_iter().map(work).collect();
    wait(&harm, args.seconds, || keeper.is_finished() || working.iter().any(thread::JoinHandle::is_finished));
    let mut stations = Vec::new();
    for station in working {
        stations.push(station.join().map_err(|_| anyhow::anyhow!("a station has panicked"))??);
    }
    let service = keeper.join().map_err(|_| anyhow::anyhow!("the keeper has panicked"))??;
    say("the harm is over; what waits is delivered and scored");
    // What two deaths of the service happened to hit is tried again when somebody asks for it.
    lab.end(service)?;
    lab.web_admin(&["retry"])?;
    let service = lab.serve()?;
    for station in &mut stations {
        station.deliver_rest()?;
    }
    verdict::await_scores(&lab)?;
    lab.end(service)?;
    let made = stations.iter().flat_map(|station| station.made.values().cloned()).collect();
    let verdict = verdict::pass(&lab, made)?;
    say(&verdict.table(&harm));
    Ok(verdict.is_good())
}

/// Waits until the time is over, or the service or a station cannot go on.
fn wait(harm: &Harm, seconds: u64, is_stuck: impl Fn() -> bool) {
    let begun = clock::instant();
    while begun.elapsed() < Duration::from_secs(seconds) && !is_stuck() {
        thread::sleep(Duration::from_millis(100));
    }
    harm.ended.store(true, SeqCst);
}

/// Starts the service, kills it, and so on; the last is left alive.
fn keep_killing(lab: &Lab, harm: &Harm, mut dice: Dice) -> anyhow::Result<Serving> {
    loop {
        let mut service = lab.serve().context("the service does not start again")?;
        let (begun, life) = (clock::instant(), Duration::from_millis(dice.below(LONGEST_LIFE_MS)));
        while begun.elapsed() < life {
            if harm.is_over() {
                return Ok(service);
            }
            anyhow::ensure!(service.0.try_wait()?.is_none(), "the service has died by itself");
            thread::sleep(Duration::from_millis(10));
        }
        drop(service);
        harm.services.fetch_add(1, SeqCst);
    }
}
