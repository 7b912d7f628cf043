//! `cluster scoring`: how fast 1, 2 and 4 workers score, and by queueing theory what more would do.

use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use acts::clock::{self, Clock};
use anyhow::{Context, ensure};
use clap::Args;
use tests::endings::say;
use tests::processes::free_port;

use crate::client::{Client, Proxy, Request};
use crate::fleet::{Post, Replica};
use crate::ledger::Ledger;
use crate::queueing::AttemptTimes;
use crate::school::{School, SchoolArgs};

/// Numbers of workers that are measured.
const WORKERS: [usize; 3] = [1, 2, 4];
/// Most workers that are computed.
const MOST: u32 = 256;
/// Where the report goes within a folder.
const REPORT: &str = "cluster.md";

/// Looks how often the writer's lock is held, every 5 ms for so long: what is shared is the lock of those who serve.
const PROBE: &str = "CREATE SCHEMA probe;
    CREATE FUNCTION probe.busy(seconds FLOAT8) RETURNS FLOAT8 LANGUAGE plpgsql AS $$
    DECLARE looks INT := 0; held INT := 0; until TIMESTAMPTZ := clock_timestamp() + seconds * INTERVAL '1 s';
    BEGIN
        WHILE clock_timestamp() < until LOOP
            looks := looks + 1;
            held := held + (SELECT count(*) FROM pg_locks WHERE locktype = 'advisory' AND mode = 'ExclusiveLock' AND granted);
            PERFORM pg_sleep(0.005);
        END LOOP;
        RETURN held::FLOAT8 / looks;
    END $$";

/// How to measure
#[derive(Debug, Args)]
pub struct ScoringArgs {
    #[command(flatten)]
    school: SchoolArgs,
    /// Attempts that each number of workers scores
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u16).range(8..))]
    attempts: u16,
    /// Folder for the report, cluster.md [default: it is printed alone]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// What a number of workers did.
#[derive(Clone, Copy, Debug)]
struct Measured {
    workers: usize,
    /// Attempts per s.
    rate: f64,
    /// Share of the time that somebody held the writer's lock.
    busy: f64,
}

/// Measures, computes, and tells.
pub fn run(args: &ScoringArgs) -> anyhow::Result<bool> {
    let school = Arc::new(School::found(&args.school)?);
    school.query(PROBE)?;
    let mut serving = Replica::new(&school, Post::Serve { port: free_port()? }, "serve".to_owned());
    serving.start()?;
    let Post::Serve { port } = serving.post else { anyhow::bail!("who serves has a port") };
    let mut client = Client::new(&Arc::new(Proxy::before(vec![port])), &Arc::new(Ledger::default()), 0);
    client.token = Some(school.add_person("trainee", "ada@example.org")?);
    let mut measured = Vec::new();
    for workers in WORKERS {
        for _ in 0..args.attempts {
            upload(&school, &mut client)?;
        }
        measured.push(measure(&school, workers, u64::from(args.attempts))?);
        say(&format!("{:?}", measured.last()));
    }
    serving.leave()?;
    let report = write_report(args.attempts, &measured)?;
    say(&report);
    if let Some(folder) = &args.out {
        std::fs::write(folder.join(REPORT), report).with_context(|| folder.display().to_string())?;
    }
    Ok(true)
}

fn upload(school: &School, client: &mut Client) -> anyhow::Result<()> {
    let recorded = school.record()?;
    let headers = vec![("content-type", "application/octet-stream".to_owned())];
    let path = "/api/v1/sessions";
    let answer = client.ask(&Request {
        what: "upload",
        method: "POST",
        path,
        headers,
        body: &recorded.bytes,
        repeatable: true,
    })?;
    let answer = answer.context("an upload may be sent again")?;
    ensure!(answer.status == 201, "an upload: {} {}", answer.status, answer.text());
    Ok(())
}

/// Has so many workers score what waits. The time is from the first score after all of them are at work to the last, by the service's own
/// clock: how long programs take to start is another question.
fn measure(school: &Arc<School>, workers: usize, attempts: u64) -> anyhow::Result<Measured> {
    let before = school.count("SELECT count(*) FROM audit_log WHERE action = 'session.scored'")?;
    let mut fleet: Vec<Replica> =
        (0..workers).map(|number| Replica::new(school, Post::Work, format!("work-{workers}-{number}"))).collect();
    fleet.iter_mut().try_for_each(Replica::start)?;
    let all_at_work = Clock::system().now().micros();
    let (mut shares, begun) = (Vec::new(), clock::instant());
    while !school.are_queues_empty()? {
        let share = school.query("SELECT probe.busy(1)")?;
        shares.push(share[0][0].parse::<f64>()?);
        ensure!(begun.elapsed() < Duration::from_secs(3600), "{workers} workers are not done after an hour");
        fleet.iter_mut().try_for_each(Replica::look_after)?;
    }
    // The last look was partly after the end.
    shares.pop();
    let scored = school
        .query(&format!("SELECT at FROM audit_log WHERE action = 'session.scored' ORDER BY seq OFFSET {before}"))?;
    let times: Vec<i64> = scored.iter().flatten().map(|at| at.parse()).collect::<Result<_, _>>()?;
    ensure!(times.len() as u64 == attempts, "{} of {attempts} attempts are scored", times.len());
    fleet.iter_mut().try_for_each(Replica::leave)?;
    thread::sleep(Duration::from_secs(1));
    let times: Vec<i64> = times.into_iter().filter(|at| *at >= all_at_work).collect();
    ensure!(times.len() >= 4, "{} of {attempts} attempts were left when all were at work: take more", times.len());
    let (first, last) = (times[0], times[times.len() - 1]);
    let rate = (times.len() - 1) as f64 / ((last - first) as f64 * 1e-6);
    let busy = shares.iter().sum::<f64>() / shares.len().max(1) as f64;
    Ok(Measured { workers, rate, busy })
}

fn write_report(attempts: u16, measured: &[Measured]) -> anyhow::Result<String> {
    let (alone, cores) = (measured[0], thread::available_parallelism()?);
    ensure!(alone.busy > 0.0 && alone.busy < 1.0, "one worker held the lock {} of the time", alone.busy);
    let (whole_s, within_s) = (1.0 / alone.rate, alone.busy / alone.rate);
    let times = AttemptTimes { beside_s: whole_s - within_s, within_s };
    let mut report = format!(
        "# Several services\n\nMeasured by `cluster scoring --attempts {attempts} --out DIR` on {}, {cores} threads, {} {}: attempts of \
         {attempts} at a time, uploaded with the judges off and then scored by so many `web-admin work --judges 1`. All of them, \
         PostgreSQL and the store share the threads. Wanted is 90 % up to the threads.\n\n\
         | workers | attempts/s | efficiency | writer's lock held |\n|---|---|---|---|\n",
        processor(),
        std::env::consts::OS,
        std::env::consts::ARCH
    );
    for Measured { workers, rate, busy } in measured {
        let efficiency = rate / (alone.rate * *workers as f64);
        // A text takes whatever is written to it.
        let _ = writeln!(report, "| {workers} | {rate:.2} | {:.0} % | {:.1} % |", efficiency * 100.0, busy * 100.0);
    }
    let _ = write!(
        report,
        "\nOne worker alone takes {:.0} ms for an attempt, {:.1} ms of them within the writer's lock. By these times, with a core for each \
         worker (exact mean value analysis of a closed network):\n\n| workers | attempts/s | efficiency | writer's lock held |\n|---|---|---|---|\n",
        whole_s * 1e3,
        within_s * 1e3
    );
    for found in times.throughputs(MOST) {
        let (efficiency, busy) = (found.efficiency * 100.0, found.busy * 100.0);
        let _ = writeln!(report, "| {} | {:.1} | {efficiency:.0} % | {busy:.0} % |", found.workers, found.rate);
    }
    let _ = writeln!(
        report,
        "\nFrom {:.0} workers on the one writer's lock is the limit: {:.0} attempts/s.",
        times.limit(),
        1.0 / within_s
    );
    Ok(report)
}

/// The processor's name, as the system tells it.
fn processor() -> String {
    let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = told.lines().find_map(|line| line.strip_prefix("model name")?.split(": ").nth(1));
    name.unwrap_or("an unknown processor").to_owned()
}
