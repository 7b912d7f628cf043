//! The servo: how late its ticks begin and what they take, beside the field, the recorder and the picture.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use ::recording::simulate::MotionSource;
use haptics::device::Reading;
use haptics::devices::trajectory::Trajectory;
use haptics::mapping::Mapping;
use haptics::servo::{self, Driven, Priority, Report, Running, Times};
use nalgebra::Vector3;
use scene::{ExerciseBundle, Patient};

use super::chart::{Chart, Curve, SeriesLabelPosition};
use super::motion::Rehearsal;
use super::sheet::{self, Sheet};
use super::{measured_on, render, specimen};
use crate::commands;
use crate::exit::Failure;
use crate::live::{Finished, Live, Trial};
use crate::progress::Progress;

const TICK_HZ: f64 = 1000.0;
/// Length of the measurement, in s; a shortened one is as long as it takes to be let in by the safety chain's gate.
const LENGTH_S: f64 = 60.0;
const QUICK_S: f64 = 2.0;
/// What is promised, with real-time priority: p99 of lateness and p99.9 of compute time, in µs.
const BAR_US: f64 = 50.0;

/// Measures, and writes `servo.{csv,md,svg}`; returns the files written.
///
/// # Errors
/// When the disk refuses, or the system gives no thread.
pub fn measure(out: &Path, quick: bool) -> Result<Vec<PathBuf>, Failure> {
    let bundle = specimen::training()?;
    let scratch = tempfile::tempdir_in(out).map_err(|error| Failure::refused(out, error))?;
    let file = scratch.path().join("attempt.mcap");
    let length_s = if quick { QUICK_S } else { LENGTH_S };
    let measured = run(&bundle, length_s, &file)?;
    report(out, &measured_on(quick), &measured)
}

/// What was measured beside one picture.
struct Measured {
    servo: Report,
    /// How late a thread is that does nothing: what the machine gives.
    bare: Times,
    /// What drew.
    drawn: String,
}

/// Runs an attempt of a length in s on the clock, recorded as any is and drawn, then as many ticks of nothing.
fn run(bundle: &ExerciseBundle, length_s: f64, file: &Path) -> Result<Measured, Failure> {
    let params = Arc::new(commands::puncture_params(file, bundle, &Patient::nominal(&bundle.scene))?);
    let device = Trajectory::new("operator:bench", readings(bundle, length_s), TICK_HZ);
    let done = device.done();
    let session = specimen::session(bundle, TICK_HZ);
    let trial = Trial { bundle: bundle.clone(), params, session, path: file.to_owned() };
    let live = Live::start(trial, Mapping::in_patient_frame(), Driven::ByTimer(Box::new(device)))?;
    let defect = |who: &str| Failure::work(format_args!("the {who} was stopped by a defect"));
    let enough = AtomicBool::new(false);
    thread::scope(|scope| {
        let picture = scope.spawn(|| render::draw_until(&enough));
        wait(&done, live.servo(), length_s);
        let (_, Finished { report, kept }) = live.stop();
        let bare = servo::bare(TICK_HZ, (length_s * TICK_HZ) as u32);
        enough.store(true, Ordering::Relaxed);
        let drawn = picture.join().map_err(|_| defect("picture"))?;
        kept.map_err(|unsaved| Failure::work(&unsaved.why))?;
        Ok(Measured { servo: report.ok_or_else(|| defect("servo"))?, bare: bare.map_err(Failure::work)?, drawn })
    })
}

/// The motion, tick by tick.
fn readings(bundle: &ExerciseBundle, length_s: f64) -> Vec<Reading> {
    let mut hand = Rehearsal::new(bundle.exercise.plan(), length_s);
    let ticks = (length_s * TICK_HZ) as u32;
    let reading = |_| {
        let pose = hand.step(1.0 / TICK_HZ, &Vector3::zeros()).patient_from_needle;
        Reading { t_s: 0.0, position_m: pose.translation.vector, orientation: pose.rotation, buttons: 0 }
    };
    (0..ticks).map(reading).collect()
}

/// Shows how far it has come until it is done.
fn wait(done: &AtomicBool, running: &Running, length_s: f64) {
    const LOOK_MS: u64 = 50;
    let progress = Progress::new((length_s * 1e3) as u64, "servo");
    let mut waited_ms = 0;
    while !done.load(Ordering::Relaxed) && running.ended().is_none() {
        thread::sleep(Duration::from_millis(LOOK_MS));
        waited_ms += LOOK_MS;
        progress.set(waited_ms);
    }
}

fn report(out: &Path, measured_on: &str, measured: &Measured) -> Result<Vec<PathBuf>, Failure> {
    let sheet = sheet(measured);
    let (table, plot) = (out.join("servo.csv"), out.join("servo.svg"));
    sheet.write_csv(&table)?;
    chart(measured).draw(&plot)?;
    let Measured { servo, drawn, .. } = measured;
    let priority = match servo.priority {
        Priority::Ordinary => format!("**{}: {}.**", servo.priority, servo.priority.advice()),
        priority => format!("The thread has {priority}."),
    };
    let text = format!(
        "# Servo\n\n{measured_on}\n\nThe training scene at 1 kHz, in and out of the body every 15 s. Beside it the recorder \
         steps law and field again and writes the recording, and a thread draws as fast as it can: {drawn}. {priority} Lateness is from the due time of a tick to its \
         beginning; compute is the whole tick: device, force law, safety chain, ring and picture's cell. A tick that begins \
         more than a period late is a stall: counted, flagged in the recording, a gap in its times. The bare timer is the \
         machine's own part: as many ticks of a thread with the same priority that waits in the same way and does nothing, \
         beside the same picture, right after. A virtual host that takes its processors away does so to both.\n\n{}\n![how many ticks are later, or take longer, than a \
         time](servo.svg)\n",
        sheet.markdown()
    );
    Ok(vec![table, plot, sheet::write_text(out.join("servo.md"), &text)?])
}

fn sheet(Measured { servo, bare, .. }: &Measured) -> Sheet {
    let Report { counts, lateness, compute, .. } = servo;
    let mut sheet = Sheet::new(["what", "value", "unit", "bar"]);
    let bar = format!("≤ {BAR_US}");
    for (name, times, (p99_bar, p999_bar)) in [
        ("lateness", lateness, (&*bar, "")),
        ("bare timer, lateness", bare, ("", "")),
        ("compute", compute, ("", &*bar)),
    ] {
        let quantiles = times.quantiles();
        let mut row = |quantile: &str, value_us: f64, bar: &str| {
            sheet.row([&format!("{name}, {quantile}"), &format!("{value_us:.2}"), "µs", bar]);
        };
        row("p50", quantiles.p50_us, "");
        row("p99", quantiles.p99_us, p99_bar);
        row("p99.9", quantiles.p999_us, p999_bar);
        row("max", quantiles.max_us, "");
    }
    for (what, count, bar) in [
        ("ticks", counts.ticks, ""),
        ("stalls", counts.stalls, ""),
        ("bare timer, stalls", stalls(bare), ""),
        ("records dropped", counts.dropped, "0"),
    ] {
        sheet.row([what, &count.to_string(), "", bar]);
    }
    sheet
}

/// Ticks that begin more than a period late.
fn stalls(lateness: &Times) -> u64 {
    let late = |(time_us, _): &(f64, f64)| *time_us <= 1e6 / TICK_HZ;
    let share = lateness.exceeded().into_iter().take_while(late).last().map_or(1.0, |(_, share)| share);
    (share * lateness.count() as f64).round() as u64
}

/// How many ticks are later, or take longer, than a time.
fn chart(Measured { servo, bare, .. }: &Measured) -> Chart {
    let curve = |name: &str, times: &Times| Curve { name: name.to_owned(), points: times.exceeded() };
    let ring = |name: &str, share: f64| Curve { name: name.to_owned(), points: vec![(BAR_US, share)] };
    Chart {
        title: "Servo at 1 kHz".to_owned(),
        x: "time, µs".to_owned(),
        y: "share of ticks that exceed it".to_owned(),
        curves: vec![
            curve("lateness", &servo.lateness),
            curve("compute", &servo.compute),
            curve("bare timer, lateness", bare),
        ],
        legend: SeriesLabelPosition::LowerLeft,
        rings: vec![ring("lateness: the p99 promised", 0.01), ring("compute: the p99.9 promised", 0.001)],
    }
}
