//! The recorder: repeats each tick of the servo with the same law, and writes the recording.
//!
//! The servo passes on its inputs bit for bit, so the recorder computes the same forces; unlike the
//! servo it can take its time, allocate and wait for the disk. All ticks stay in memory until they
//! are saved, so that a disk error loses nothing.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{BufReader, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use assessment::Coach;
use attempt::run::{RecordedArm, Run, Sent, Simulated};
use attempt::tick::TickInput;
use documents::Channel;
use haptics::safety;
use haptics::servo::{Ended, Record, Records, Report, flags as servo_flags};
use recording::recover::recover;
use recording::sample::flags;
use recording::{CArmControls, EventKind, Fluoroscopy, Writer};

use super::faults::Faults;
use super::shown::AttemptView;
use super::{LiveTrial, lock};
use crate::exit::Failure;
use crate::maker;
use crate::new_file::NewFile;
use crate::picture::Look;

/// Name of the metadata record with the servo's statistics.
const SERVO_RECORD: &str = "stylet.servo";
/// Extension of a recording that is being written. Not `part`, which other programs use.
const UNFINISHED: &str = "stylet-part";
/// Interval at which the recorder polls for new ticks.
const EVERY: Duration = Duration::from_millis(2);

/// A finished recording on disk.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// Its path.
    pub path: PathBuf,
    /// Summary of the attempt.
    pub simulated: Simulated,
}

/// An attempt that could not be written to disk, complete in memory.
pub struct Unsaved {
    /// The error.
    pub why: String,
    trial: Arc<LiveTrial>,
    records: Vec<Record>,
    /// The controls of the C-arm.
    controls: Fluoroscopy,
    epilogue: Epilogue,
}

/// Data that are known only after the servo has stopped.
#[derive(Clone, Debug, Default)]
struct Epilogue {
    /// The servo's statistics, as stored in a recording.
    servo: BTreeMap<String, String>,
    /// Reason for the end, if neither the trainee nor the exercise ended the attempt.
    interrupted: Option<String>,
}

/// Handle of the recorder's thread.
pub struct Recorder {
    shown: Arc<Mutex<AttemptView>>,
    report: Sender<Epilogue>,
    thread: JoinHandle<Result<Kept, Box<Unsaved>>>,
}

/// A recording that is being written, under its unfinished name.
type Draft = Writer<BufWriter<File>>;

/// Starts the recording of an attempt with all data known beforehand, so that a full disk is
/// noticed before the needle moves.
///
/// # Errors
/// If the unfinished file already exists or cannot be written.
pub fn begin(trial: &LiveTrial, path: &Path) -> Result<Draft, Failure> {
    let unfinished = unfinished(path);
    let file = File::create_new(&unfinished)
        .map_err(|error| Failure::refused(&unfinished, format_args!("cannot be created: {error}")))?;
    // `recover_left_behind` skips locked files.
    file.lock().map_err(|error| Failure::refused(&unfinished, error))?;
    maker::begin_recording(file, &trial.session, &trial.bundle, path)
}

fn unfinished(path: &Path) -> PathBuf {
    path.with_added_extension(UNFINISHED)
}

impl Recorder {
    /// Starts the thread that records ticks.
    ///
    /// # Errors
    /// If the thread cannot be started.
    pub fn start(trial: Arc<LiveTrial>, records: Records, draft: Draft) -> Result<Self, Failure> {
        let shown = Arc::new(Mutex::new(AttemptView::new(&trial)));
        let (report, awaited) = mpsc::channel();
        let theirs = Arc::clone(&shown);
        let thread = thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || {
                let ticks = Ticks { trial: &trial, records, taken: Vec::new(), controls: Fluoroscopy::default() };
                record(&trial, ticks, draft, &theirs, &awaited)
            })
            .map_err(|error| Failure::work(format_args!("the recorder's thread cannot be started: {error}")))?;
        Ok(Self { shown, report, thread })
    }

    /// Returns the view for the window.
    pub fn shown(&self) -> &Arc<Mutex<AttemptView>> {
        &self.shown
    }

    /// Finishes the recording after the servo has stopped.
    pub fn finish(self, report: Option<&Report>) -> Result<Kept, Box<Unsaved>> {
        // Sending fails only if the thread has ended; `join` below passes on its panic.
        let _ = self.report.send(report.map_or_else(Epilogue::of_a_defect, Epilogue::new));
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

/// A tick of the servo, with the controls of the C-arm.
type OperatedTick = (Record, Option<CArmControls>);

/// Incoming ticks, all of them kept.
struct Ticks<'t> {
    trial: &'t LiveTrial,
    records: Records,
    taken: Vec<Record>,
    controls: Fluoroscopy,
}

impl Ticks<'_> {
    /// Waits for the next tick; returns `None` when the servo has ended.
    fn next(&mut self) -> Option<OperatedTick> {
        loop {
            if let Some(record) = self.records.pop() {
                self.taken.push(record);
                let controls = self.trial.arm.as_ref().map(|arm| CArmControls { t_s: record.t_s, ..arm.controls() });
                let known = &mut self.controls.controls;
                known.extend(controls.filter(|new| known.last().is_none_or(|last| new.differ(last))));
                return Some((record, controls));
            }
            if self.records.is_over() {
                return None;
            }
            thread::sleep(EVERY);
        }
    }
}

/// The thread's body: records every tick until the servo ends.
fn record(
    trial: &Arc<LiveTrial>,
    mut ticks: Ticks<'_>,
    draft: Draft,
    shown: &Mutex<AttemptView>,
    report: &Receiver<Epilogue>,
) -> Result<Kept, Box<Unsaved>> {
    let mut epilogue = Epilogue::default();
    // A closed channel means that the attempt was dropped: its recording is finished nevertheless.
    let told = || report.recv().unwrap_or_default();
    let kept = write(trial, draft, &mut || ticks.next(), Some(shown), &mut || {
        epilogue = told();
        epilogue.clone()
    });
    kept.and_then(|simulated| name(&trial.path, simulated)).map_err(|why| {
        let Ticks { taken: records, controls, .. } = ticks;
        Box::new(Unsaved { why, trial: Arc::clone(trial), records, controls, epilogue })
    })
}

/// Writes every incoming tick and, at the end, the servo's statistics. After the first error
/// nothing more is written.
fn write(
    trial: &LiveTrial,
    mut draft: Draft,
    next: &mut dyn FnMut() -> Option<OperatedTick>,
    shown: Option<&Mutex<AttemptView>>,
    epilogue: &mut dyn FnMut() -> Epilogue,
) -> Result<Simulated, String> {
    let exercise = &trial.bundle.exercise;
    let arm = trial.arm.as_ref().map(|arm| RecordedArm::new(arm.fluoroscope()));
    let mut run = Run::new(&trial.specimen, &mut draft).with_arm(arm);
    let (mut coach, mut faults) = (Coach::new(exercise), Faults::default());
    let mut last = None;
    while let Some((record, controls)) = next() {
        let tick = run.tick(&input(&record), Some(&sent(&record)));
        let pulsed = controls.and_then(|controls| Some((run.operate(&controls)?, controls)));
        if let Some((pulse, _)) = &pulsed {
            coach.note_pulse(pulse);
        }
        let is_coached = exercise.feedback.gives(Channel::Coaching);
        let coached = if is_coached { coach.watch(&tick.sample, tick.hand_n) } else { Vec::new() };
        coached.iter().for_each(|text| run.note(EventKind::Coaching, &tick, text.own()));
        let faulty = faults.watch(&record);
        faulty.iter().for_each(|text| run.note(EventKind::Fault, &tick, text));
        if let Some(shown) = shown {
            let mut shown = lock(shown);
            shown.tell(&tick, &coached, &faulty);
            shown.refused = run.refused().map(ToString::to_string);
            if let (Some((pulse, controls)), Some(arm)) = (pulsed, &trial.arm) {
                let frame = shown.moment.frame(&Look::default(), exercise.target_depth_mm * 1e-3);
                arm.radiographer.expose(pulse, controls, frame);
            }
        }
        last = Some(tick);
    }
    let Epilogue { servo, interrupted } = epilogue();
    if let (Some(why), Some(tick)) = (interrupted, last) {
        run.note(EventKind::Interrupted, &tick, &why);
    }
    let simulated = run.finish().map_err(|error| error.to_string())?;
    draft.metadata(SERVO_RECORD, servo).map_err(|error| error.to_string())?;
    if let Some(signature) = trial.key.as_ref().and_then(|key| key.sign(&trial.session, &draft.hashes())) {
        draft.sign(&signature).map_err(|error| error.to_string())?;
    }
    let file = draft.finish().map_err(|error| error.to_string())?;
    let file = file.into_inner().map_err(|error| error.to_string())?;
    file.sync_all().map_err(|error| error.to_string())?;
    Ok(simulated)
}

/// Renames a finished recording to its final name.
fn name(path: &Path, simulated: Simulated) -> Result<Kept, String> {
    let renamed = fs::rename(unfinished(path), path);
    renamed.map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(Kept { path: path.to_owned(), simulated })
}

impl Unsaved {
    /// Tries again, at the same path or another. If it fails again, returns `None` and updates
    /// `why`.
    pub fn save(&mut self, path: &Path) -> Option<Kept> {
        // All data in the file left by the previous try are written again now.
        let _ = fs::remove_file(unfinished(path));
        let again = begin(&self.trial, path).map_err(|failure| failure.to_string()).and_then(|draft| {
            let controls = |record: &Record| self.controls.controls_at(record.t_s).copied();
            let mut records = self.records.iter().map(|record| (*record, controls(record)));
            write(&self.trial, draft, &mut || records.next(), None, &mut || self.epilogue.clone())
        });
        match again.and_then(|simulated| name(path, simulated)) {
            Ok(kept) => {
                // After saving elsewhere, the next start must not find the unfinished file.
                self.discard();
                Some(kept)
            }
            Err(why) => {
                self.why = why;
                None
            }
        }
    }

    /// Discards the attempt and its unfinished file.
    pub fn discard(&self) {
        // If the file cannot be deleted, the next start recovers it, which does no harm.
        let _ = fs::remove_file(unfinished(self.path()));
    }

    /// Returns the intended path.
    pub fn path(&self) -> &Path {
        &self.trial.path
    }
}

/// Returns the exact input of the law.
fn input(record: &Record) -> TickInput {
    let Record { t_s, position_m, orientation, confirm, .. } = *record;
    TickInput { t_s, position_m, orientation, confirm }
}

fn sent(record: &Record) -> Sent {
    // The recorded flag covers scaling and every intervention of the safety chain.
    let scaled = record.flags & (servo_flags::SCALED | safety::flags::ALL) != 0;
    let scaled = if scaled { flags::SCALED } else { 0 };
    Sent { device_n: record.device_n, flags: record.flags | scaled, lateness_us: record.lateness_us }
}

impl Epilogue {
    fn new(report: &Report) -> Self {
        let interrupted = (report.ended != Ended::Stopped).then(|| report.ended.to_string());
        Self { servo: in_words(report), interrupted }
    }

    /// The epilogue of a servo whose thread panicked.
    fn of_a_defect() -> Self {
        Self { servo: BTreeMap::new(), interrupted: Some(Ended::Panicked.to_string()) }
    }
}

/// Formats the servo's statistics for the recording.
fn in_words(report: &Report) -> BTreeMap<String, String> {
    let Report { ended, counts, priority, lateness, compute } = report;
    let steps = |times: &haptics::servo::Times| {
        let step = |(us, share): &(f64, f64)| format!("{us} {share}");
        times.exceeded().iter().map(step).collect::<Vec<_>>().join("; ")
    };
    let told = [
        ("ended", ended.to_string()),
        ("priority", priority.to_string()),
        ("ticks", counts.ticks.to_string()),
        ("stalls", counts.stalls.to_string()),
        ("records_dropped", counts.dropped.to_string()),
        ("lateness", lateness.quantiles().to_string()),
        ("compute", compute.quantiles().to_string()),
        ("lateness_us_exceeded_by_share", steps(lateness)),
        ("compute_us_exceeded_by_share", steps(compute)),
    ];
    told.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

/// Recovers the recordings of interrupted attempts: each is renamed to its intended name, and its
/// unfinished file is deleted.
///
/// # Errors
/// If the folder cannot be read.
pub fn recover_left_behind(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let listed = fs::read_dir(folder).map_err(|error| Failure::refused(folder, error))?;
    let mut drafts: Vec<PathBuf> = listed.flatten().map(|entry| entry.path()).collect();
    drafts.retain(|path| path.extension() == Some(OsStr::new(UNFINISHED)));
    drafts.sort();
    Ok(drafts.iter().filter_map(|draft| recover_draft(draft)).collect())
}

/// Recovers one file; returns `None` if it has no samples, another process is still writing it, or
/// its name is taken.
fn recover_draft(draft: &Path) -> Option<PathBuf> {
    let path = draft.with_extension("");
    let file = File::open(draft).ok()?;
    file.try_lock().ok()?;
    let mut whole = NewFile::create(&path, false).ok()?;
    recover(BufReader::new(file), whole.file()).ok().filter(|recovered| recovered.samples > 0)?;
    whole.keep().ok()?;
    // If the file cannot be deleted, the next start finds its name taken and skips it.
    let _ = fs::remove_file(draft);
    Some(path)
}
