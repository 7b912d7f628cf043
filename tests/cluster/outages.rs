//! `cluster outages`: what the services stand on is taken away under load, and given back.

use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::SeqCst;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use anyhow::ensure;
use clap::Args;
use platform::clock;
use tests::endings::say;

use crate::check;
use crate::client::{Outcome, Proxy, Request};
use crate::fleet::{Replica, ports, start_four};
use crate::ledger::{Act, Ledger};
use crate::load::Load;
use crate::postgres::Stop;
use crate::relay::Weather;
use crate::school::{School, SchoolArgs};

/// Longest that anybody waits for an answer, whatever is away, in s.
const LONGEST_ANSWER_S: f64 = 45.0;
/// Longest until all is as before, in s, once what was away is back.
const LONGEST_RECOVERY_S: f64 = 30.0;
/// Longest that a service may need to say that it lives, in s. Two cores are shared by all that runs here.
const LONGEST_HEALTH_S: f64 = 3.0;
/// How often a service is asked how it is.
const PROBE_EVERY: Duration = Duration::from_millis(500);

/// How to take things away
#[derive(Debug, Args)]
pub struct OutagesArgs {
    #[command(flatten)]
    school: SchoolArgs,
    /// How long each outage lasts, in s
    #[arg(long, value_name = "S", default_value_t = 15, value_parser = clap::value_parser!(u64).range(10..=600))]
    seconds: u64,
    /// One outage alone, by its name
    #[arg(long, value_name = "NAME")]
    only: Option<String>,
}

/// What is taken away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outage {
    Stopped(Stop),
    Database(Weather),
    Store(Weather),
    StoreFull,
}

/// Each outage by its name.
const OUTAGES: [(&str, Outage); 9] = [
    ("database-stopped", Outage::Stopped(Stop::Fast)),
    ("database-crashed", Outage::Stopped(Stop::Immediate)),
    ("database-cut", Outage::Database(Weather::Cut)),
    ("database-silent", Outage::Database(Weather::Silent)),
    ("database-slow", Outage::Database(Weather::Slow(Duration::from_millis(30)))),
    ("store-cut", Outage::Store(Weather::Cut)),
    ("store-silent", Outage::Store(Weather::Silent)),
    ("store-slow", Outage::Store(Weather::Slow(Duration::from_millis(200)))),
    ("store-full", Outage::StoreFull),
];

impl Outage {
    fn begin(self, school: &School) -> anyhow::Result<()> {
        match self {
            Self::Stopped(how) => school.database.lock().unwrap_or_else(PoisonError::into_inner).stop(how)?,
            Self::Database(weather) => school.database_network.turn(weather),
            Self::Store(weather) => school.store_network.turn(weather),
            Self::StoreFull => school.store.fill()?,
        }
        Ok(())
    }

    fn end(self, school: &School) -> anyhow::Result<()> {
        match self {
            Self::Stopped(_) => school.database.lock().unwrap_or_else(PoisonError::into_inner).start_again()?,
            Self::Database(_) => school.database_network.turn(Weather::Fair),
            Self::Store(_) => school.store_network.turn(Weather::Fair),
            Self::StoreFull => school.store.mend()?,
        }
        Ok(())
    }

    /// Whether nothing at all can be written while it lasts.
    const fn stops_the_database(self) -> bool {
        matches!(self, Self::Stopped(_) | Self::Database(Weather::Cut | Weather::Silent))
    }
}

/// What services say of themselves, asked all the time.
struct Probes {
    over: Arc<AtomicBool>,
    seen: Arc<Mutex<Seen>>,
    asking: JoinHandle<anyhow::Result<()>>,
}

/// What was seen of all services together.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    /// Answers of `/healthz` that were late, or none.
    unhealthy: usize,
    /// Answers of `/readyz` that said yes, and no.
    ready: usize,
    unready: usize,
}

impl Probes {
    fn begin(proxy: &Arc<Proxy>, ports: Vec<u16>) -> Self {
        let (over, seen) = (Arc::new(AtomicBool::new(false)), Arc::new(Mutex::new(Seen::default())));
        let (proxy, until, noted) = (Arc::clone(proxy), Arc::clone(&over), Arc::clone(&seen));
        let asking = thread::spawn(move || {
            while !until.load(SeqCst) {
                for port in &ports {
                    let health = proxy.ask(*port, &Request::get("health", "/healthz"), &[])?;
                    let ready = is_ready(&proxy, *port)?;
                    let mut seen = noted.lock().unwrap_or_else(PoisonError::into_inner);
                    let is_well = matches!(&health, Outcome::Answered(answer) if answer.status == 200 && answer.seconds < LONGEST_HEALTH_S);
                    seen.unhealthy += usize::from(!is_well);
                    seen.ready += usize::from(ready);
                    seen.unready += usize::from(!ready);
                }
                thread::sleep(PROBE_EVERY);
            }
            Ok(())
        });
        Self { over, seen, asking }
    }

    /// Forgets what was seen so far; what it was.
    fn take(&self) -> Seen {
        std::mem::take(&mut *self.seen.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn end(self) -> anyhow::Result<()> {
        self.over.store(true, SeqCst);
        self.asking.join().map_err(|_| anyhow::anyhow!("who asks for health has panicked"))?
    }
}

fn is_ready(proxy: &Proxy, port: u16) -> anyhow::Result<bool> {
    let outcome = proxy.ask(port, &Request::get("ready", "/readyz"), &[])?;
    Ok(matches!(outcome, Outcome::Answered(answer) if answer.status == 200))
}

/// Takes away one after the other; whether all is well in the end.
pub fn run(args: &OutagesArgs) -> anyhow::Result<bool> {
    let chosen: Vec<_> =
        OUTAGES.iter().filter(|(name, _)| args.only.as_deref().is_none_or(|only| only == *name)).collect();
    let names: Vec<&str> = OUTAGES.iter().map(|(name, _)| *name).collect();
    ensure!(
        !chosen.is_empty(),
        "--only {}: allowed is one of {}",
        args.only.as_deref().unwrap_or_default(),
        names.join(", ")
    );
    let school = Arc::new(School::found(&args.school)?);
    let mut fleet = start_four(&school)?;
    let serving = ports(&fleet);
    let (proxy, ledger) = (Arc::new(Proxy::before(serving.clone())), Arc::new(Ledger::default()));
    let mut load = Load::begin(&school, &proxy, &ledger, 3)?;
    let probes = Probes::begin(&proxy, serving.clone());
    thread::sleep(Duration::from_secs(5));
    let mut amiss = Vec::new();
    for (name, outage) in chosen {
        let (mut faults, recovery_s) = go_through(
            *outage,
            args.seconds,
            &school,
            &Witnesses { proxy: &proxy, ledger: &ledger, probes: &probes, serving: &serving },
        )?;
        load.look_after()?;
        fleet.iter_mut().try_for_each(Replica::look_after)?;
        say(&format!("{name}: as before {recovery_s:.1} s after its end; {} amiss", faults.len()));
        faults.iter_mut().for_each(|fault| fault.insert_str(0, &format!("{name}: ")));
        amiss.append(&mut faults);
    }
    load.end()?;
    probes.end()?;
    check::await_queues(&school)?;
    let mut verdict = check::pass(&school, &proxy, &ledger)?;
    verdict.blame("amiss while something was away", amiss);
    say(&verdict.table());
    fleet.iter_mut().try_for_each(Replica::leave)?;
    Ok(verdict.is_good())
}

/// Who sees how services are.
struct Witnesses<'a> {
    proxy: &'a Arc<Proxy>,
    ledger: &'a Ledger,
    probes: &'a Probes,
    serving: &'a [u16],
}

/// An outage from its begin to its end: what was amiss, and how long it took afterwards until all was as before, in s.
fn go_through(
    outage: Outage,
    seconds: u64,
    school: &School,
    witnesses: &Witnesses<'_>,
) -> anyhow::Result<(Vec<String>, f64)> {
    let Witnesses { proxy, ledger, probes, serving } = witnesses;
    // What was before is of no interest.
    drop(ledger.turn_page());
    probes.take();
    outage.begin(school)?;
    thread::sleep(Duration::from_secs(seconds));
    let seen = probes.take();
    outage.end(school)?;
    let recovery_s = await_recovery(proxy, ledger, serving)?;
    let tallies = ledger.turn_page();
    check::tell_requests(&tallies);
    let mut amiss = Vec::new();
    for (what, tally) in &tallies {
        for (status, of) in &tally.by_status {
            if *status >= 500 && !matches!(status, 503 | 507) || *status == 408 {
                amiss.push(format!("{what} is answered {status} ({} times): {}", of.count, tally.latest));
            }
            if of.longest_s > LONGEST_ANSWER_S {
                amiss.push(format!("{what} is answered {status} after {:.0} s", of.longest_s));
            }
        }
        if tally.without_time > 0 {
            amiss.push(format!(
                "{what} is answered 503 without Retry-After ({} times): {}",
                tally.without_time, tally.latest
            ));
        }
    }
    if seen.unhealthy > 0 {
        amiss.push(format!("/healthz did not answer in time ({} times)", seen.unhealthy));
    }
    // The first answers may be those of a moment before.
    let few = serving.len() * 10;
    if outage.stops_the_database() && (seen.unready == 0 || seen.ready > few) {
        amiss.push(format!("/readyz said {} times yes and {} times no", seen.ready, seen.unready));
    }
    if recovery_s > LONGEST_RECOVERY_S {
        amiss.push(format!("all was as before only after {recovery_s:.0} s"));
    }
    Ok((amiss, recovery_s))
}

/// Waits until every service is ready, and somebody has uploaded, commented and added a person since; how long that took, in s.
fn await_recovery(proxy: &Proxy, ledger: &Ledger, serving: &[u16]) -> anyhow::Result<f64> {
    let begun = clock::instant();
    let before = acknowledged(ledger);
    loop {
        let mut ready = true;
        for port in serving {
            ready &= is_ready(proxy, *port)?;
        }
        let seconds = begun.elapsed().as_secs_f64();
        let moved = acknowledged(ledger).iter().zip(&before).all(|(now, then)| now > then);
        if ready && moved || seconds > 3.0 * LONGEST_RECOVERY_S {
            return Ok(seconds);
        }
        thread::sleep(Duration::from_millis(200));
    }
}

/// How much was acknowledged of each kind.
fn acknowledged(ledger: &Ledger) -> [usize; 3] {
    let count = |act| ledger.entries(act).iter().filter(|entry| entry.acknowledged).count();
    [count(Act::Upload) + count(Act::UploadInPieces), count(Act::Comment) + count(Act::Regrade), count(Act::Person)]
}
