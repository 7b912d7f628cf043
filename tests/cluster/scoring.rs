//! `cluster scoring`: how fast several workers score, what it takes of the processor, and by queueing theory what more workers would do.

use std::cmp::Ordering;
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::SeqCst;
use std::thread;
use std::time::Duration;

use anyhow::{Context, anyhow, ensure};
use clap::Args;
use platform::clock;
use platform::clock::Clock;
use tests::endings::say;
use tests::processes::free_port;

use crate::client::{Client, Proxy, Request};
use crate::fleet::{Post, Replica};
use crate::ledger::Ledger;
use crate::processor::{MachineTime, name_processor, sum_processor_time};
use crate::queueing::AttemptTimes;
use crate::school::{Recorded, SPEED_MM_S, School, SchoolArgs};

/// Whose attempts they are, in turn: what is summed up for somebody is done anew with each of their attempts.
const TRAINEES: usize = 16;
/// How long the work is put off while workers start, in s.
const PUT_OFF_S: i64 = 300;
/// Longest until a worker looks for what has become due, in s.
const LISTENING_S: i64 = 2;
/// How long between two looks at the lock, in s: of one worker, by which others are computed, and of several, who have no time to spare for
/// whoever looks on.
const PAUSES_S: [f64; 2] = [0.02, 0.2];
/// Most workers that are computed.
const MOST: u32 = 256;
/// Where the report goes within a folder.
const REPORT: &str = "cluster.md";

/// Looks now and then how often the writer's lock is held, for so long: what is shared is the lock of those who serve.
const PROBE: &str = "CREATE SCHEMA probe;
    CREATE FUNCTION probe.busy(seconds FLOAT8, pause FLOAT8) RETURNS FLOAT8 LANGUAGE plpgsql AS $$
    DECLARE looks INT := 0; held INT := 0; until TIMESTAMPTZ := clock_timestamp() + seconds * INTERVAL '1 s';
    BEGIN
        WHILE clock_timestamp() < until LOOP
            looks := looks + 1;
            held := held + (SELECT count(*) FROM pg_locks WHERE locktype = 'advisory' AND mode = 'ExclusiveLock' AND granted);
            PERFORM pg_sleep(pause);
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
    /// How fast the needle goes, in mm/s: 8 makes attempts of 9 s, 0.6 of 95 s
    #[arg(long, value_name = "MM_S", default_value_t = SPEED_MM_S)]
    speed: f64,
    /// Numbers of workers, separated by commas, each measured by itself; the first must be 1
    #[arg(long, value_name = "N", value_delimiter = ',', default_values_t = [1, 2, 4], value_parser = clap::value_parser!(u16).range(1..=256))]
    workers: Vec<u16>,
    /// How often each number of workers is measured, in turn with the others: a machine that is shared is never as fast as just before
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..=100))]
    rounds: u16,
    /// Folder for the report, cluster.md [default: it is printed alone]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// What a number of workers did.
#[derive(Clone, Copy, Debug)]
struct Measured {
    workers: u16,
    /// Attempts per s.
    rate: f64,
    /// Its share of so many times what one worker did in the same round.
    efficiency: f64,
    /// Share of the time that somebody held the writer's lock.
    busy: f64,
    /// Share of the threads' time that whoever runs this machine gave to others.
    stolen: f64,
    /// What an attempt took of the processor.
    each: ProcessorTime,
}

/// What programs have had of the processor, in s.
#[derive(Clone, Copy, Debug)]
struct ProcessorTime {
    workers: f64,
    database: f64,
    store: f64,
    /// This program, which looks on.
    onlooker: f64,
}

impl ProcessorTime {
    fn look(school: &School, fleet: &[Replica]) -> anyhow::Result<Self> {
        let mut workers = 0.0;
        for worker in fleet {
            workers += sum_processor_time(worker.process_id().context("a worker that lives")?)?;
        }
        let (database, store) = (school.database_processor_time()?, sum_processor_time(school.store.process_id())?);
        let everything = sum_processor_time(std::process::id())?;
        Ok(Self { workers, database, store, onlooker: everything - workers - database - store })
    }

    fn since(self, before: Self, attempts: usize) -> Self {
        let each = |now: f64, then: f64| (now - then) / attempts as f64;
        Self {
            workers: each(self.workers, before.workers),
            database: each(self.database, before.database),
            store: each(self.store, before.store),
            onlooker: each(self.onlooker, before.onlooker),
        }
    }
}

/// Measures, computes, and tells.
pub fn run(args: &ScoringArgs) -> anyhow::Result<bool> {
    ensure!(args.workers.first() == Some(&1), "--workers: the first number must be 1, with which others are compared");
    let mut school = School::found(&args.school)?;
    school.bypass_network();
    let school = Arc::new(school);
    school.query(PROBE)?;
    let mut serving = Replica::new(&school, Post::Serve { port: free_port()? }, "serve".to_owned());
    serving.start()?;
    let Post::Serve { port } = serving.post else { anyhow::bail!("who serves has a port") };
    let add = |number| school.add_person("trainee", &format!("trainee{number}@example.org"));
    let tokens = (0..TRAINEES).map(add).collect::<anyhow::Result<Vec<_>>>()?;
    let mut rounds = Vec::new();
    for _ in 0..args.rounds {
        let mut round: Vec<Measured> = Vec::new();
        for workers in args.workers.iter().copied() {
            upload_all(&school, port, &tokens, args)?;
            let mut measured = measure(&school, workers, u64::from(args.attempts))?;
            let alone = round.first().unwrap_or(&measured);
            measured.efficiency = measured.rate / (alone.rate * f64::from(workers));
            say(&format!("{measured:?}"));
            round.push(measured);
        }
        rounds.push(round);
    }
    serving.leave()?;
    let report = write_report(args, &choose_medians(&rounds))?;
    say(&report);
    if let Some(folder) = &args.out {
        let written = std::fs::create_dir_all(folder).and_then(|()| std::fs::write(folder.join(REPORT), report));
        written.with_context(|| folder.display().to_string())?;
    }
    Ok(true)
}

/// Records attempts of people in turn and uploads them, on all cores.
fn upload_all(school: &School, port: u16, tokens: &[String], args: &ScoringArgs) -> anyhow::Result<()> {
    let (left, ledger) = (AtomicUsize::new(args.attempts.into()), Arc::new(Ledger::default()));
    let upload_some = || {
        let mut client = Client::new(&Arc::new(Proxy::before(vec![port])), &ledger, 0);
        while let Ok(left) = left.fetch_update(SeqCst, SeqCst, |left| left.checked_sub(1)) {
            client.token = Some(tokens[left % tokens.len()].clone());
            upload(&school.record(args.speed)?, &mut client)?;
        }
        anyhow::Ok(())
    };
    let cores = thread::available_parallelism()?.get();
    thread::scope(|scope| {
        let uploading: Vec<_> = (0..cores).map(|_| scope.spawn(upload_some)).collect();
        uploading.into_iter().try_for_each(|thread| thread.join().map_err(|_panic| anyhow!("a thread panicked"))?)
    })
}

fn upload(recorded: &Recorded, client: &mut Client) -> anyhow::Result<()> {
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

/// Has so many workers score what waits, once all of them have started and looked for it. The time is from the first score after that to the
/// last, by the service's own clock: how long programs take to start is another question.
fn measure(school: &Arc<School>, workers: u16, attempts: u64) -> anyhow::Result<Measured> {
    let before = school.count("SELECT count(*) FROM audit_log WHERE action = 'session.scored'")?;
    let put_off = Clock::system().now().plus_s(PUT_OFF_S).micros();
    school.query(&format!("UPDATE jobs SET next_run_at = {put_off}"))?;
    let mut fleet: Vec<Replica> =
        (0..workers).map(|number| Replica::new(school, Post::Work, format!("work-{workers}-{number}"))).collect();
    fleet.iter_mut().try_for_each(Replica::start)?;
    let due = Clock::system().now();
    school.query(&format!("UPDATE jobs SET next_run_at = {}", due.micros()))?;
    let all_at_work = due.plus_s(LISTENING_S).micros();
    let (used, machine) = (ProcessorTime::look(school, &fleet)?, MachineTime::look()?);
    let pause_s = PAUSES_S[usize::from(workers > 1)];
    let (mut shares, begun) = (Vec::new(), clock::instant());
    while !school.are_queues_empty()? {
        let share = school.query(&format!("SELECT probe.busy(1, {pause_s})"))?;
        shares.push(share[0][0].parse::<f64>()?);
        ensure!(begun.elapsed() < Duration::from_secs(3600), "{workers} workers are not done after an hour");
        fleet.iter_mut().try_for_each(Replica::look_after)?;
    }
    let stolen = MachineTime::look()?.share_stolen_since(machine);
    let used_since = ProcessorTime::look(school, &fleet)?;
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
    Ok(Measured { workers, rate, efficiency: 1.0, busy, stolen, each: used_since.since(used, attempts as usize) })
}

/// For each number of workers the round of their median efficiency, of one worker that of the median rate; of two in the middle the worse.
fn choose_medians(rounds: &[Vec<Measured>]) -> Vec<Measured> {
    let choose = |place: usize| {
        let mut measured: Vec<Measured> = rounds.iter().map(|round| round[place]).collect();
        measured.sort_by(|one, other| {
            (one.efficiency, one.rate).partial_cmp(&(other.efficiency, other.rate)).unwrap_or(Ordering::Equal)
        });
        measured[(measured.len() - 1) / 2]
    };
    (0..rounds[0].len()).map(choose).collect()
}

fn write_report(args: &ScoringArgs, measured: &[Measured]) -> anyhow::Result<String> {
    let (alone, cores, attempts, rounds, speed) =
        (measured[0], thread::available_parallelism()?, args.attempts, args.rounds, args.speed);
    ensure!(alone.busy > 0.0 && alone.busy < 1.0, "one worker held the lock {} of the time", alone.busy);
    let (whole_s, within_s) = (1.0 / alone.rate, alone.busy / alone.rate);
    let times = AttemptTimes { beside_s: whole_s - within_s, within_s };
    let numbers: Vec<String> = measured.iter().map(|measured| measured.workers.to_string()).collect();
    let mut report = format!(
        "# Several services\n\nMeasured by `cluster scoring --attempts {attempts} --speed {speed} --workers {} --rounds {rounds} --out DIR` on {}, {cores} threads, {} {}: \
         {attempts} attempts at a time, uploaded with the judges off and then scored by so many `web-admin work --judges 1`. Each number of \
         workers had its turn {rounds} times; its efficiency is held against one worker in the same round, and the round of the median is \
         shown. All of them, PostgreSQL and the store{} share the threads; what is stolen of them whoever runs the machine gave to others. Wanted is 90 % up to the threads.\n\n\
         | workers | attempts/s | efficiency | writer's lock held | processor, of an attempt: workers | PostgreSQL | store | onlooker | threads used | stolen |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
        numbers.join(","),
        name_processor(),
        std::env::consts::OS,
        std::env::consts::ARCH,
        if args.school.weed.is_some() { " (SeaweedFS)" } else { " (in Python)" }
    );
    for Measured { workers, rate, efficiency, busy, stolen, each } in measured {
        let [efficiency, busy, stolen] = [efficiency, busy, stolen].map(|share| share * 100.0);
        let ProcessorTime { workers: worked, database, store, onlooker } = each;
        let used = (worked + database + store + onlooker) * rate;
        let [worked, database, store, onlooker] =
            [worked, database, store, onlooker].map(|s| format!("{:.1} ms", s * 1e3));
        // A text takes whatever is written to it.
        let _ = writeln!(
            report,
            "| {workers} | {rate:.2} | {efficiency:.0} % | {busy:.1} % | {worked} | {database} | {store} | {onlooker} | {used:.1} | {stolen:.1} % |"
        );
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
