//! Judging a recording: where its death harms nobody. The service asks a helper, this very program in a process of its own with limits
//! on memory and time; commands and tests, whose own work it is, judge in their own process.

mod arrival;
mod draft;

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

pub use arrival::{RecordingFacts, ReportedRecording};
use assessment::{Assessment, assess, find_needless_attachment, own_exercise};
use attempt::AttemptCurve;
use attempt::verify::verify_recording;
use data_encoding::BASE64;
use documents::picture::{self, PictureCopy};
use documents::{ExerciseBundle, Patient};
pub use draft::{DraftQuestion, publishable, same_id};
use model::count_i64;
use model::draft::{DraftRemark, DraftVerdict};
use model::roster::{Unreadable, WorkbookSheet};
use recording::annotate::Annotation;
use recording::{ReadError, Recording};
use serde::{Deserialize, Serialize};
use store::exercises::RevisionBytes;
use store::sessions::Verified;
use tissue::Specimen;
use words::Language;

use crate::{recording_files, replay_files};

/// What whoever judges can be asked.
#[derive(Debug, Serialize, Deserialize)]
pub enum JudgeQuestion {
    /// What is made of a recording that is kept.
    Recording(Brief),
    /// What a recording says of itself that has just arrived.
    Arrival(PathBuf),
    /// What a draft of an exercise comes to.
    Draft(Box<DraftQuestion>),
    /// The first sheet of a workbook, in base64.
    Workbook(String),
    /// A copy of a picture.
    Picture(PictureQuestion),
    /// A copy of a recording with remarks in it.
    Annotate(AnnotationQuestion),
}

/// An uploaded picture.
#[derive(Debug, Serialize, Deserialize)]
pub struct PictureQuestion {
    /// Its bytes in base64.
    pub base64: String,
    /// It becomes a logo, else a picture of a briefing.
    pub is_logo: bool,
    /// Code of the language in which it is refused.
    pub language: String,
}

/// A recording, and the remarks to write into a copy of it.
#[derive(Debug, Serialize, Deserialize)]
pub struct AnnotationQuestion {
    /// The recording.
    pub recording: PathBuf,
    /// The copy, which is not there yet.
    pub copy: PathBuf,
    /// The remarks.
    pub remarks: Vec<Annotation>,
}

/// A copy of a picture.
#[derive(Debug, Serialize, Deserialize)]
pub struct CopiedPicture {
    /// Width and height, in pixels.
    pub size: [u32; 2],
    /// Its bytes in base64.
    pub base64: String,
}

/// What is to be made of a recording.
#[derive(Debug, Serialize, Deserialize)]
pub struct Brief {
    /// The recording.
    pub recording: PathBuf,
    /// SHA-256 of the bytes that were read when it arrived, lower-case hexadecimal.
    pub sha256: String,
    /// Where its replay goes.
    pub replay: PathBuf,
    /// What else is asked.
    pub task: JudgingTask,
}

/// What is asked of a recording.
#[derive(Debug, Serialize, Deserialize)]
pub enum JudgingTask {
    /// Its score and its re-simulation, by this revision or else by its own exercise; and its replay.
    Judge(Option<RevisionBytes>),
    /// Its replay alone.
    Replay,
}

/// What was made of a recording.
#[derive(Debug, Serialize, Deserialize)]
pub struct JudgingOutcome {
    /// Metrics and score.
    pub assessment: Assessment,
    /// The re-simulation.
    pub verified: Verified,
    /// What the session's page draws.
    pub curve: AttemptCurve,
}

/// How a question was answered.
#[derive(Debug, Serialize, Deserialize)]
pub enum JudgeAnswer {
    /// The recording was judged.
    Judged(Box<JudgingOutcome>),
    /// Its replay is where it was wanted.
    Replayed,
    /// What arrived says this of itself.
    Told(Box<ReportedRecording>),
    /// The draft comes to this.
    Examined(Box<DraftVerdict>),
    /// The sheet, or why the workbook is refused.
    Sheet(Result<WorkbookSheet, Unreadable>),
    /// The copy of the picture, or why it is refused.
    Copied(Result<CopiedPicture, String>),
    /// The copy with remarks is where it was wanted.
    Annotated,
    /// It never will be answered.
    Permanent(String),
    /// It may be, later.
    Passing(String),
    /// Whoever worked on it has died of it, or lacked the memory.
    Died(String),
}

/// Looks at a draft: what it comes to is drawn as pages draw it, which whoever judges does not know.
pub type DraftExaminer = fn(&DraftQuestion) -> DraftVerdict;

/// For whoever looks at no drafts.
#[must_use]
pub fn leave_unexamined(_: &DraftQuestion) -> DraftVerdict {
    DraftVerdict {
        problems: vec![DraftRemark::on_all("draft", "nobody looks at drafts here".to_owned())],
        ..DraftVerdict::default()
    }
}

/// Answers a question. Blocks.
#[must_use]
pub fn answer(question: JudgeQuestion, examine_draft: DraftExaminer) -> JudgeAnswer {
    match question {
        JudgeQuestion::Recording(brief) => make_of(brief),
        JudgeQuestion::Arrival(path) => match recording_files::read(&path) {
            Ok(recording) => tell_of(recording),
            Err(ReadError::Io(error)) => JudgeAnswer::Passing(error.to_string()),
            Err(scarce @ ReadError::OutOfMemory) => JudgeAnswer::Died(scarce.to_string()),
            Err(unreadable) => JudgeAnswer::Permanent(unreadable.to_string()),
        },
        JudgeQuestion::Draft(question) => JudgeAnswer::Examined(Box::new(examine_draft(&question))),
        JudgeQuestion::Workbook(base64) => match BASE64.decode(base64.as_bytes()) {
            Ok(bytes) => JudgeAnswer::Sheet(WorkbookSheet::read(&bytes)),
            Err(error) => JudgeAnswer::Permanent(error.to_string()),
        },
        JudgeQuestion::Picture(question) => match BASE64.decode(question.base64.as_bytes()) {
            Ok(bytes) => JudgeAnswer::Copied(copy_picture(&bytes, &question)),
            Err(error) => JudgeAnswer::Permanent(error.to_string()),
        },
        JudgeQuestion::Annotate(question) => match annotate(&question) {
            Ok(()) => JudgeAnswer::Annotated,
            Err(error) => JudgeAnswer::Passing(format!("{error:#}")),
        },
    }
}

fn copy_picture(bytes: &[u8], question: &PictureQuestion) -> Result<CopiedPicture, String> {
    let copied = if question.is_logo { picture::copy_logo(bytes) } else { picture::copy_picture(bytes) };
    let language = Language::named(&question.language).unwrap_or(Language::ENGLISH);
    let PictureCopy { size, bytes, .. } = copied.map_err(|why| words::within(language, || words::phrase(&why)))?;
    Ok(CopiedPicture { size, base64: BASE64.encode(&bytes) })
}

fn annotate(question: &AnnotationQuestion) -> anyhow::Result<()> {
    let sink = BufWriter::new(File::create_new(&question.copy)?);
    let mut copy = recording::annotate::annotate(&std::fs::read(&question.recording)?, sink, &question.remarks)?;
    Ok(copy.flush()?)
}

/// Returns the facts of an uploaded recording, or the reason for refusing it.
fn tell_of(recording: Recording) -> JudgeAnswer {
    if let Some(why) = find_needless_attachment(&recording) {
        return JudgeAnswer::Permanent(why);
    }
    match ReportedRecording::try_from(&RecordingFacts::from(recording)) {
        Ok(reported) => JudgeAnswer::Told(Box::new(reported)),
        Err(error) => JudgeAnswer::Permanent(format!("{error:#}")),
    }
}

/// Makes of a recording what a brief asks for.
fn make_of(brief: Brief) -> JudgeAnswer {
    let recording = match recording_files::read(&brief.recording) {
        Ok(recording) => recording,
        Err(unreadable) => return not_read(&brief, unreadable),
    };
    match brief.task {
        JudgingTask::Judge(published) => match judge(&recording, published) {
            Ok(outcome) => {
                keep_replay(&brief.replay, &recording);
                JudgeAnswer::Judged(Box::new(outcome))
            }
            Err(why) => JudgeAnswer::Permanent(why),
        },
        JudgingTask::Replay => match replay_files::make(&brief.replay, &recording) {
            Ok(()) => JudgeAnswer::Replayed,
            Err(error) => JudgeAnswer::Passing(format!("{error:#}")),
        },
    }
}

/// Why a recording that is kept was not read. These very bytes were read when they arrived: then it is we who lack something, and no
/// recording is refused for that.
fn not_read(brief: &Brief, unreadable: ReadError) -> JudgeAnswer {
    match (unreadable, recording_files::hash_file(&brief.recording)) {
        (ReadError::Io(error), _) | (_, Err(error)) => JudgeAnswer::Passing(error.to_string()),
        (scarce @ ReadError::OutOfMemory, _) => JudgeAnswer::Died(scarce.to_string()),
        (unreadable, Ok((sha256, _))) if sha256 == brief.sha256 => {
            JudgeAnswer::Died(format!("it was read when it arrived, and is not now: {unreadable}"))
        }
        (unreadable, Ok(_)) => JudgeAnswer::Permanent(format!("it is not what has arrived: {unreadable}")),
    }
}

/// A failure is no reason not to score: it is noted, and the replay made when somebody wants to watch.
fn keep_replay(folder: &Path, recording: &Recording) {
    if let Err(error) = replay_files::make(folder, recording) {
        tracing::warn!(session = %recording.session.session_id, cause = format!("{error:#}"), "no replay was kept");
    }
}

/// Scores and re-simulates. The published exercise judges; the recording's own only where the school has none like it.
fn judge(recording: &Recording, published: Option<RevisionBytes>) -> Result<JudgingOutcome, String> {
    let bundle = match published {
        Some(bytes) => ExerciseBundle::from_parts(&bytes.exercise, &bytes.scene, &bytes.meshes)
            .map_err(|refused| refused.to_string())?,
        None => own_exercise(recording).map_err(|error| error.to_string())?,
    };
    let assessment = assess(recording, &bundle).map_err(|error| error.to_string())?;
    let verified = resimulate(recording, &bundle)?;
    Ok(JudgingOutcome { assessment, verified, curve: AttemptCurve::draw(recording, &bundle) })
}

fn resimulate(recording: &Recording, bundle: &ExerciseBundle) -> Result<Verified, String> {
    let patient = Patient { thickness_mm: recording.session.patient_thickness_mm.clone() };
    let (told, layers) = (patient.thickness_mm.len(), bundle.scene.layers.len());
    if told != layers {
        return Err(format!("patient_thickness_mm: {told} layers; the scene has {layers}"));
    }
    let params = Specimen::new(bundle.recorded_spec(&patient, recording.session.judging))
        .map_err(|error| format!("the recorded patient: {error}"))?;
    let found = verify_recording(recording, &params);
    Ok(Verified {
        deviation_n: found.largest_deviation_n,
        event_differences: count_i64(found.count_differences()),
        exact: found.exact(),
    })
}
