//! The recorder: takes what the servo did, asks the same law again, and writes it down.
//!
//! The servo hands over its inputs to the bit, so the recorder comes to the same forces; it can take its time, allocate and wait
//! for the disk. Whatever the disk says, the ticks themselves are kept in memory until they are saved.

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
use attempt::run::{Run, Sent, Simulated};
use attempt::tick::TickInput;
use documents::Channel;
use haptics::safety;
use haptics::servo::{Ended, Record, Records, Report, flags as servo_flags};
use recording::recover::recover;
use recording::sample::flags;
use recording::{EventKind, Writer};

use super::faults::Faults;
use super::shown::AttemptView;
use super::{LiveTrial, lock};
use crate::exit::Failure;
use crate::maker;
use crate::new_file::NewFile;

/// Name of the metadata record that says how the servo did.
const SERVO_RECORD: &str = "stylet.servo";
/// What a recording is called while it is being written: other programs have files that end in `part`.
const UNFINISHED: &str = "stylet-part";
/// The recorder looks for new ticks this often.
const EVERY: Duration = Duration::from_millis(2);

/// A recording on disk.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// Where it is.
    pub path: PathBuf,
    /// What it came to.
    pub simulated: Simulated,
}

/// An attempt that the disk refused: all of it, in memory.
pub struct Unsaved {
    /// Why.
    pub why: String,
    trial: Arc<LiveTrial>,
    records: Vec<Record>,
    epilogue: Epilogue,
}

/// What there is to say when the servo has stopped.
#[derive(Clone, Debug, Default)]
struct Epilogue {
    /// How the servo did, as a recording keeps it.
    servo: BTreeMap<String, String>,
    /// Why it ended, where neither the person nor the exercise ended it.
    interrupted: Option<String>,
}

/// The recorder's thread.
pub struct Recorder {
    shown: Arc<Mutex<AttemptView>>,
    report: Sender<Epilogue>,
    thread: JoinHandle<Result<Kept, Box<Unsaved>>>,
}

/// A recording that is being written, under its unfinished name.
type Draft = Writer<BufWriter<File>>;

/// Starts the recording of an attempt at a path, with all that can be said beforehand: a full disk is noticed before the needle
/// moves.
///
/// # Errors
/// When the disk refuses, or the recording exists.
pub fn begin(trial: &LiveTrial, path: &Path) -> Result<Draft, Failure> {
    let unfinished = unfinished(path);
    let file = File::create_new(&unfinished)
        .map_err(|error| Failure::refused(&unfinished, format_args!("cannot be created: {error}")))?;
    // As long as it is locked it is not left behind.
    file.lock().map_err(|error| Failure::refused(&unfinished, error))?;
    maker::begin_recording(file, &trial.session, &trial.bundle, path)
}

fn unfinished(path: &Path) -> PathBuf {
    path.with_added_extension(UNFINISHED)
}

impl Recorder {
    /// Starts to take ticks.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(trial: Arc<LiveTrial>, records: Records, draft: Draft) -> Result<Self, Failure> {
        let shown = Arc::new(Mutex::new(AttemptView::new(&trial)));
        let (report, awaited) = mpsc::channel();
        let theirs = Arc::clone(&shown);
        let thread = thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || record(trial, Ticks { records, taken: Vec::new() }, draft, &theirs, &awaited))
            .map_err(|error| Failure::work(format_args!("no thread for the recorder: {error}")))?;
        Ok(Self { shown, report, thread })
    }

    /// What the window shows.
    pub fn shown(&self) -> &Arc<Mutex<AttemptView>> {
        &self.shown
    }

    /// Ends the recording, once the servo has stopped.
    pub fn finish(self, report: Option<&Report>) -> Result<Kept, Box<Unsaved>> {
        // A recorder that is gone needs no report; its panic is passed on below.
        let _ = self.report.send(report.map_or_else(Epilogue::of_a_defect, Epilogue::new));
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

/// Ticks as they come, all of them kept.
struct Ticks {
    records: Records,
    taken: Vec<Record>,
}

impl Ticks {
    /// The next tick; waits for it, and is `None` when the servo is gone.
    fn next(&mut self) -> Option<Record> {
        loop {
            if let Some(record) = self.records.pop() {
                self.taken.push(record);
                return Some(record);
            }
            if self.records.is_over() {
                return None;
            }
            thread::sleep(EVERY);
        }
    }
}

/// The thread: everything the servo does, until it is gone.
fn record(
    trial: Arc<LiveTrial>,
    mut ticks: Ticks,
    draft: Draft,
    shown: &Mutex<AttemptView>,
    report: &Receiver<Epilogue>,
) -> Result<Kept, Box<Unsaved>> {
    let mut epilogue = Epilogue::default();
    // Nobody left to report means that the attempt was dropped: what there is of it is kept all the same.
    let told = || report.recv().unwrap_or_default();
    let kept = write(&trial, draft, &mut || ticks.next(), Some(shown), &mut || {
        epilogue = told();
        epilogue.clone()
    });
    kept.and_then(|simulated| name(&trial.path, simulated))
        .map_err(|why| Box::new(Unsaved { why, trial, records: ticks.taken, epilogue }))
}

/// Writes every tick that comes, and at the end how the servo did. The disk is asked for nothing more once it has refused.
fn write(
    trial: &LiveTrial,
    mut draft: Draft,
    next: &mut dyn FnMut() -> Option<Record>,
    shown: Option<&Mutex<AttemptView>>,
    epilogue: &mut dyn FnMut() -> Epilogue,
) -> Result<Simulated, String> {
    let exercise = &trial.bundle.exercise;
    let (mut run, mut coach, mut faults) =
        (Run::new(&trial.specimen, &mut draft), Coach::new(exercise), Faults::default());
    let mut last = None;
    while let Some(record) = next() {
        let tick = run.tick(&input(&record), Some(&sent(&record)));
        let is_coached = exercise.feedback.gives(Channel::Coaching);
        let coached = if is_coached { coach.watch(&tick.sample, tick.hand_n) } else { Vec::new() };
        coached.iter().for_each(|text| run.note(EventKind::Coaching, &tick, text.own()));
        let faulty = faults.watch(&record);
        faulty.iter().for_each(|text| run.note(EventKind::Fault, &tick, text));
        if let Some(shown) = shown {
            let mut shown = lock(shown);
            shown.tell(&tick, &coached, &faulty);
            shown.refused = run.refused().map(ToString::to_string);
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

/// Gives a finished recording its name.
fn name(path: &Path, simulated: Simulated) -> Result<Kept, String> {
    let renamed = fs::rename(unfinished(path), path);
    renamed.map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(Kept { path: path.to_owned(), simulated })
}

impl Unsaved {
    /// Tries again, at the same place or another. `None` where the disk refuses again; why is said anew.
    pub fn save(&mut self, path: &Path) -> Option<Kept> {
        // What the first try has left behind is a part of what is written now.
        let _ = fs::remove_file(unfinished(path));
        let again = begin(&self.trial, path).map_err(|failure| failure.to_string()).and_then(|draft| {
            let mut records = self.records.iter().copied();
            write(&self.trial, draft, &mut || records.next(), None, &mut || self.epilogue.clone())
        });
        match again.and_then(|simulated| name(path, simulated)) {
            Ok(kept) => {
                // Saved elsewhere, it must not be found half written at the next start.
                self.discard();
                Some(kept)
            }
            Err(why) => {
                self.why = why;
                None
            }
        }
    }

    /// Gives it up, with what the disk had taken of it.
    pub fn discard(&self) {
        // A draft that stays is found at the next start: no harm is done.
        let _ = fs::remove_file(unfinished(self.path()));
    }

    /// Where it should have been.
    pub fn path(&self) -> &Path {
        &self.trial.path
    }
}

/// What the law was fed, to the bit.
fn input(record: &Record) -> TickInput {
    let Record { t_s, position_m, orientation, confirm, .. } = *record;
    TickInput { t_s, position_m, orientation, confirm }
}

fn sent(record: &Record) -> Sent {
    let scaled = record.flags & (servo_flags::SCALED | safety::flags::ALL) != 0;
    let scaled = if scaled { flags::SCALED } else { 0 };
    Sent { device_n: record.device_n, flags: record.flags | scaled, lateness_us: record.lateness_us }
}

impl Epilogue {
    fn new(report: &Report) -> Self {
        let interrupted = (report.ended != Ended::Stopped).then(|| report.ended.to_string());
        Self { servo: in_words(report), interrupted }
    }

    /// Of a servo whose thread was killed.
    fn of_a_defect() -> Self {
        Self { servo: BTreeMap::new(), interrupted: Some(Ended::Panicked.to_string()) }
    }
}

/// How the servo did, as a recording keeps it.
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

/// Recordings of attempts that were cut off, made whole: each gets the name it should have had, and its draft goes.
///
/// # Errors
/// When the folder cannot be read.
pub fn recover_left_behind(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let listed = fs::read_dir(folder).map_err(|error| Failure::refused(folder, error))?;
    let mut drafts: Vec<PathBuf> = listed.flatten().map(|entry| entry.path()).collect();
    drafts.retain(|path| path.extension() == Some(OsStr::new(UNFINISHED)));
    drafts.sort();
    Ok(drafts.iter().filter_map(|draft| recover_draft(draft)).collect())
}

/// One of them; none where there is nothing to be had, or somebody is still writing it.
fn recover_draft(draft: &Path) -> Option<PathBuf> {
    let path = draft.with_extension("");
    let file = File::open(draft).ok()?;
    file.try_lock().ok()?;
    let mut whole = NewFile::create(&path, false).ok()?;
    recover(BufReader::new(file), whole.file()).ok().filter(|recovered| recovered.samples > 0)?;
    whole.keep().ok()?;
    // A draft that stays is recovered again, to a name that is taken: no harm is done.
    let _ = fs::remove_file(draft);
    Some(path)
}
