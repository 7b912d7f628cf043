//! The servo: lateness and computing time of its ticks, next to the field, the recorder and the
//! rendering.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Duration;
use std::{fmt, thread};

use ::render::frame::Frame;
use ::render::{Headless, Quality};
use attempt::simulate::MotionSource;
use documents::ExerciseBundle;
use haptics::device::Reading;
use haptics::devices::trajectory::Trajectory;
use haptics::servo::{self, Priority, Report, Times};
use law::operator::Felt;
use tissue::Specimen;

use super::chart::{Chart, ChartCurve};
use super::motion::Rehearsal;
use super::render::SIZE;
use super::sheet::{self, ReportSheet};
use super::{DeviceAttempt, OngoingAttempt, Program, Subject, measured_on, quantile, specimen};
use crate::clock;
use crate::error::BenchError;
use crate::progress::MeasurementProgress;

const TICK_HZ: f64 = 1000.0;
/// Duration of the measurement, in s; a shortened one lasts just long enough to pass the safety
/// chain's gate.
const LENGTH_S: f64 = 60.0;
const QUICK_S: f64 = 2.0;
/// Target with real-time priority: p99 of lateness and p99.9 of computing time, in µs.
const BAR_US: f64 = 50.0;
/// Target for the latency from a motion of the needle to the picture that shows it, in frames.
const BAR_FRAMES: u32 = 2;

/// Measures and writes `servo.{csv,md,svg}`; returns the files written.
///
/// # Errors
/// On an I/O error, or if no thread can be created.
pub fn measure(out: &Path, quick: bool, program: &dyn Program) -> Result<Vec<PathBuf>, BenchError> {
    let bundle = specimen::read_training_exercise()?;
    let scratch = tempfile::tempdir_in(out).map_err(|error| BenchError::refused(out, error))?;
    let file = scratch.path().join("attempt.mcap");
    let length_s = if quick { QUICK_S } else { LENGTH_S };
    let measured = run(&bundle, length_s, &file, program)?;
    report(out, &measured_on(Subject::Servo, quick), &measured)
}

/// Measurements of the servo while pictures are drawn.
struct MeasuredServo {
    servo: Report,
    /// Lateness of an idle thread: the limit set by the machine.
    bare: Times,
    /// The pictures, or the error that stopped them.
    picture: Result<Picture, BenchError>,
}

/// Runs an attempt with a duration in s in real time, recorded and drawn like any other, then the
/// same number of idle ticks.
fn run(
    bundle: &ExerciseBundle,
    length_s: f64,
    file: &Path,
    program: &dyn Program,
) -> Result<MeasuredServo, BenchError> {
    let specimen = specimen::make_nominal_specimen(bundle)?;
    let mut picture = Picture::new(bundle, &specimen, program);
    let device = Trajectory::new("operator:bench", readings(bundle, length_s), TICK_HZ);
    let done = device.done();
    let session = specimen::make_session(bundle, TICK_HZ);
    let attempt = DeviceAttempt { bundle: bundle.clone(), specimen, session, path: file.to_owned() };
    let mut live = program.begin(attempt, Box::new(device))?;
    let progress = MeasurementProgress::new((length_s * TICK_HZ) as u64, "servo");
    while !done.load(Ordering::Relaxed) && !live.has_ended() {
        look(&mut picture, |picture| picture.show(live.as_mut()));
        progress.set(live.latest().map_or(0, |(_, ticks)| ticks));
    }
    let servo = live.stop()?;
    let bare = beside(&mut picture, || servo::bare(TICK_HZ, (length_s * TICK_HZ) as u32));
    Ok(MeasuredServo { servo, bare: bare.map_err(BenchError::work)?, picture })
}

/// Runs a function while pictures are drawn as fast as possible.
fn beside<T: Send>(picture: &mut Result<Picture, BenchError>, run: impl FnOnce() -> T + Send) -> T {
    thread::scope(|scope| {
        let running = scope.spawn(run);
        while !running.is_finished() {
            look(picture, Picture::draw);
        }
        running.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

/// Draws a picture, or sleeps for a similar time without one. After a failure no more pictures
/// are drawn.
fn look(picture: &mut Result<Picture, BenchError>, show: impl FnOnce(&mut Picture) -> Result<(), BenchError>) {
    const ELSE: Duration = Duration::from_millis(50);
    let shown = match picture {
        Ok(picture) => show(picture),
        Err(_) => {
            thread::sleep(ELSE);
            Ok(())
        }
    };
    if let Err(failure) = shown {
        *picture = Err(failure);
    }
}

/// The pictures that a window would draw of the attempt.
struct Picture {
    headless: Headless,
    frame: Frame,
    /// Latency from a motion of the needle to the picture that shows it, and drawing time of a
    /// picture, in ms.
    behind_ms: Vec<f64>,
    takes_ms: Vec<f64>,
}

impl Picture {
    fn new(bundle: &ExerciseBundle, specimen: &Specimen, program: &dyn Program) -> Result<Self, BenchError> {
        let mut headless = Headless::new(Quality::Full).map_err(BenchError::work)?;
        let stage = program.stage(bundle, specimen)?;
        headless.set_stage(&stage).map_err(BenchError::work)?;
        let mut picture = Self { headless, frame: program.still(bundle), behind_ms: Vec::new(), takes_ms: Vec::new() };
        // The first picture may compile shaders and is not counted.
        picture.draw()?;
        picture.takes_ms.clear();
        Ok(picture)
    }

    /// Draws the current state of the attempt; by the time it is finished, the needle has moved on.
    fn show(&mut self, live: &mut dyn OngoingAttempt) -> Result<(), BenchError> {
        let (frame, shown_s) = live.frame();
        self.frame = frame;
        self.draw()?;
        let now_s = live.latest().map_or(shown_s, |(now_s, _)| now_s);
        self.behind_ms.push((now_s - shown_s) * 1e3);
        Ok(())
    }

    fn draw(&mut self) -> Result<(), BenchError> {
        let begun = clock::instant();
        self.headless.draw(&self.frame, SIZE).map_err(BenchError::work)?;
        self.takes_ms.push(begun.elapsed().as_secs_f64() * 1e3);
        Ok(())
    }
}

impl fmt::Display for Picture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (count, adapter) = (self.takes_ms.len(), self.headless.adapter());
        write!(f, "{count} pictures of {} × {} pixels by {adapter}", SIZE[0], SIZE[1])
    }
}

/// Returns the motion, tick by tick.
fn readings(bundle: &ExerciseBundle, length_s: f64) -> Vec<Reading> {
    let mut hand = Rehearsal::new(bundle.exercise.plan(), length_s);
    let ticks = (length_s * TICK_HZ) as u32;
    let reading = |_| {
        let pose = hand.step(1.0 / TICK_HZ, &Felt::default()).patient_from_needle;
        Reading {
            t_s: 0.0,
            position_m: pose.translation.vector,
            orientation: pose.rotation,
            buttons: 0,
            motor_heat: 0.0,
        }
    };
    (0..ticks).map(reading).collect()
}

fn report(out: &Path, measured_on: &str, measured: &MeasuredServo) -> Result<Vec<PathBuf>, BenchError> {
    let sheet = sheet(measured);
    let (table, plot) = (out.join("servo.csv"), out.join("servo.svg"));
    sheet.write_csv(&table)?;
    chart(measured).draw(&plot)?;
    let MeasuredServo { servo, picture, .. } = measured;
    let drawn = picture.as_ref().map_or_else(|none| format!("no picture: {none}"), ToString::to_string);
    let priority = match servo.priority {
        Priority::Ordinary => format!("**{}: {}.**", servo.priority, servo.priority.advice()),
        priority => format!("The thread has {priority}."),
    };
    let text = format!(
        "# Servo\n\n{measured_on}\n\nThe training scene at 1 kHz, in and out of the body every 15 s. In parallel, the recorder \
         steps law and field again and writes the recording, and the attempt is rendered as fast as possible: {drawn}. {priority} \
         Lateness is from the due time of a tick to its beginning; compute is the whole tick: device, force law, safety chain, \
         ring and picture's cell. A tick that begins more than a period late is a stall: counted, flagged in the recording, a gap \
         in its times. The bare timer is the machine's own part: as many ticks of a thread with the same priority that waits in \
         the same way and does nothing, next to the same rendering, right after. A virtual host that withdraws its processors \
         affects both.\n\n{}\n![how many ticks are later, or take longer, than a time](servo.svg)\n",
        sheet.markdown()
    );
    Ok(vec![table, plot, sheet::write_text(out.join("servo.md"), &text)?])
}

fn sheet(MeasuredServo { servo, bare, picture }: &MeasuredServo) -> ReportSheet {
    let Report { counts, lateness, compute, .. } = servo;
    let mut sheet = ReportSheet::new(["what", "value", "unit", "bar"]);
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
        ("bare timer, stalls", bare.longer_than_us(1e6 / TICK_HZ), ""),
        ("records dropped", counts.dropped, "0"),
    ] {
        sheet.row([what, &count.to_string(), "", bar]);
    }
    if let Ok(Picture { behind_ms, takes_ms, .. }) = picture {
        let frame_ms = quantile(takes_ms, 0.5);
        let mut row =
            |what: &str, value: f64, [unit, bar]: [&str; 2]| sheet.row([what, &format!("{value:.2}"), unit, bar]);
        row("picture, median", frame_ms, ["ms", ""]);
        row("motion to picture, p50", quantile(behind_ms, 0.5) / frame_ms, ["frames", ""]);
        row("motion to picture, p99", quantile(behind_ms, 0.99) / frame_ms, ["frames", &format!("≤ {BAR_FRAMES}")]);
    }
    sheet
}

/// Plots the share of ticks whose lateness or computing time exceeds a time.
fn chart(MeasuredServo { servo, bare, .. }: &MeasuredServo) -> Chart {
    let curve = |name: &str, times: &Times| ChartCurve { name: name.to_owned(), points: times.exceeded() };
    let ring = |name: &str, share: f64| ChartCurve { name: name.to_owned(), points: vec![(BAR_US, share)] };
    Chart {
        title: "Servo at 1 kHz".to_owned(),
        x: "time, µs".to_owned(),
        y: "share of ticks that exceed it".to_owned(),
        curves: vec![
            curve("lateness", &servo.lateness),
            curve("compute", &servo.compute),
            curve("bare timer, lateness", bare),
        ],
        rings: vec![ring("lateness: the p99 promised", 0.01), ring("compute: the p99.9 promised", 0.001)],
        ..Chart::default()
    }
}
