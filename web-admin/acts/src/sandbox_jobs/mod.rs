//! Jobs on untrusted or expensive input, above all scoring recordings. The service runs them in a
//! helper: this program as a separate process with limits on memory and time, so that a crash does
//! no harm. Commands and tests run them in their own process.

mod arrival;
mod draft;
pub mod previews;
pub(crate) mod recording_files;
mod replay_writing;

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
use model::authoring::draft::{DraftRemark, DraftVerdict};
use model::count_i64;
use model::people::roster::{Unreadable, WorkbookSheet};
use platform::files::hash_file;
use platform::helper::PermittedPaths;
use recording::annotate::Annotation;
use recording::{ReadError, Recording};
use serde::{Deserialize, Serialize};
use store::authoring::exercises::RevisionBytes;
use store::recordings::sessions::Verified;
use tissue::Specimen;
use words::Language;

/// A job for the helper.
#[derive(Debug, Serialize, Deserialize)]
pub enum SandboxRequest {
    /// Scores or replays a stored recording.
    Recording(Brief),
    /// Reads the metadata of an uploaded recording.
    Arrival(PathBuf),
    /// Examines an exercise draft.
    Draft(Box<DraftQuestion>),
    /// Reads the first sheet of a workbook, given in base64.
    Workbook(String),
    /// Copies the pixels of an image.
    Picture(PictureQuestion),
    /// Writes annotations into a copy of a recording.
    Annotate(AnnotationQuestion),
}

impl SandboxRequest {
    /// Returns the files that the job uses.
    #[must_use]
    pub fn permitted_paths(&self) -> PermittedPaths {
        let folder_of = |path: &Path| path.parent().unwrap_or(path).to_owned();
        let (read, write) = match self {
            Self::Recording(brief) => (vec![brief.recording.clone()], vec![folder_of(&brief.replay)]),
            Self::Arrival(recording) => (vec![recording.clone()], Vec::new()),
            Self::Annotate(question) => (vec![question.recording.clone()], vec![folder_of(&question.copy)]),
            Self::Draft(_) | Self::Workbook(_) | Self::Picture(_) => (Vec::new(), Vec::new()),
        };
        PermittedPaths { read, write }
    }
}

/// An uploaded image.
#[derive(Debug, Serialize, Deserialize)]
pub struct PictureQuestion {
    /// Its bytes in base64.
    pub base64: String,
    /// Whether it becomes a logo; otherwise it illustrates a briefing.
    pub is_logo: bool,
    /// Language code of the error message.
    pub language: String,
}

/// A recording and the annotations to write into a copy of it.
#[derive(Debug, Serialize, Deserialize)]
pub struct AnnotationQuestion {
    /// The recording.
    pub recording: PathBuf,
    /// Path of the copy, which must not exist yet.
    pub copy: PathBuf,
    /// The annotations.
    pub remarks: Vec<Annotation>,
}

/// A copy of an image.
#[derive(Debug, Serialize, Deserialize)]
pub struct CopiedPicture {
    /// Width and height, in pixels.
    pub size: [u32; 2],
    /// Its bytes in base64.
    pub base64: String,
}

/// A job on a stored recording.
#[derive(Debug, Serialize, Deserialize)]
pub struct Brief {
    /// The recording.
    pub recording: PathBuf,
    /// SHA-256 of the uploaded bytes, lower-case hexadecimal.
    pub sha256: String,
    /// Folder for the replay files.
    pub replay: PathBuf,
    /// Task.
    pub task: JudgingTask,
}

/// What to compute from a recording.
#[derive(Debug, Serialize, Deserialize)]
pub enum JudgingTask {
    /// Score, re-simulation and replay. Uses this revision, or the exercise embedded in the
    /// recording if `None`.
    Judge(Option<RevisionBytes>),
    /// The score alone, by the rubric of this revision and otherwise the exercise embedded in the
    /// recording.
    Regrade(RevisionBytes),
    /// The replay only.
    Replay,
}

/// Results computed from a recording.
#[derive(Debug, Serialize, Deserialize)]
pub struct JudgingOutcome {
    /// Metrics and score.
    pub assessment: Assessment,
    /// Result of the re-simulation.
    pub verified: Verified,
    /// Curves drawn on the session page.
    pub curve: AttemptCurve,
}

/// Response of a job.
#[derive(Debug, Serialize, Deserialize)]
pub enum SandboxResponse {
    /// The recording was scored.
    Judged(Box<JudgingOutcome>),
    /// The recording was scored by another rubric.
    Regraded(Box<Assessment>),
    /// The replay has been written.
    Replayed,
    /// Metadata of the uploaded recording.
    Metadata(Box<ReportedRecording>),
    /// Verdict on the draft.
    Examined(Box<DraftVerdict>),
    /// The sheet, or why the workbook is rejected.
    Sheet(Result<WorkbookSheet, Unreadable>),
    /// The copy of the image, or why it is rejected.
    Copied(Result<CopiedPicture, String>),
    /// The annotated copy has been written.
    Annotated,
    /// Permanent error: a retry cannot succeed.
    Permanent(String),
    /// Transient error: a retry may succeed.
    Passing(String),
    /// The helper crashed, timed out or ran out of memory.
    Died(String),
}

/// Examines a draft. It is a parameter because a verdict contains rendered fragments of pages,
/// which this crate does not know.
pub type DraftExaminer = fn(&DraftQuestion) -> DraftVerdict;

/// A [`DraftExaminer`] for programs that do not examine drafts; it returns a problem.
#[must_use]
pub fn leave_unexamined(_: &DraftQuestion) -> DraftVerdict {
    DraftVerdict {
        problems: vec![DraftRemark::on_all("draft", "nobody looks at drafts here".to_owned())],
        ..DraftVerdict::default()
    }
}

/// Runs a job in this process. Blocks.
#[must_use]
pub fn answer(question: SandboxRequest, examine_draft: DraftExaminer) -> SandboxResponse {
    match question {
        SandboxRequest::Recording(brief) => make_of(brief),
        SandboxRequest::Arrival(path) => match recording_files::read(&path) {
            Ok(recording) => tell_of(recording),
            Err(ReadError::Io(error)) => SandboxResponse::Passing(error.to_string()),
            Err(scarce @ ReadError::OutOfMemory) => SandboxResponse::Died(scarce.to_string()),
            Err(unreadable) => SandboxResponse::Permanent(unreadable.to_string()),
        },
        SandboxRequest::Draft(question) => SandboxResponse::Examined(Box::new(examine_draft(&question))),
        SandboxRequest::Workbook(base64) => match BASE64.decode(base64.as_bytes()) {
            Ok(bytes) => SandboxResponse::Sheet(WorkbookSheet::read(&bytes)),
            Err(error) => SandboxResponse::Permanent(error.to_string()),
        },
        SandboxRequest::Picture(question) => match BASE64.decode(question.base64.as_bytes()) {
            Ok(bytes) => SandboxResponse::Copied(copy_picture(&bytes, &question)),
            Err(error) => SandboxResponse::Permanent(error.to_string()),
        },
        SandboxRequest::Annotate(question) => match annotate(&question) {
            Ok(()) => SandboxResponse::Annotated,
            Err(error) => SandboxResponse::Passing(format!("{error:#}")),
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
fn tell_of(recording: Recording) -> SandboxResponse {
    if let Some(why) = find_needless_attachment(&recording) {
        return SandboxResponse::Permanent(why);
    }
    match ReportedRecording::try_from(&RecordingFacts::from(recording)) {
        Ok(reported) => SandboxResponse::Metadata(Box::new(reported)),
        Err(error) => SandboxResponse::Permanent(format!("{error:#}")),
    }
}

/// Carries out a job on a stored recording.
fn make_of(brief: Brief) -> SandboxResponse {
    let recording = match recording_files::read(&brief.recording) {
        Ok(recording) => recording,
        Err(unreadable) => return not_read(&brief, unreadable),
    };
    match brief.task {
        JudgingTask::Judge(published) => match judge(&recording, published) {
            Ok(outcome) => {
                keep_replay(&brief.replay, &recording);
                SandboxResponse::Judged(Box::new(outcome))
            }
            Err(why) => SandboxResponse::Permanent(why),
        },
        JudgingTask::Regrade(rubric) => match regrade(&recording, &rubric) {
            Ok(assessment) => SandboxResponse::Regraded(Box::new(assessment)),
            Err(why) => SandboxResponse::Permanent(why),
        },
        JudgingTask::Replay => match replay_writing::write_replay(&brief.replay, &recording) {
            Ok(()) => SandboxResponse::Replayed,
            Err(error) => SandboxResponse::Passing(format!("{error:#}")),
        },
    }
}

/// Classifies a failure to read a stored recording. If its bytes are still those that could be read
/// when they arrived, the cause lies in this process, and the recording must not be rejected.
fn not_read(brief: &Brief, unreadable: ReadError) -> SandboxResponse {
    match (unreadable, hash_file(&brief.recording)) {
        (ReadError::Io(error), _) | (_, Err(error)) => SandboxResponse::Passing(error.to_string()),
        (scarce @ ReadError::OutOfMemory, _) => SandboxResponse::Died(scarce.to_string()),
        (unreadable, Ok((sha256, _))) if sha256 == brief.sha256 => {
            SandboxResponse::Died(format!("it was read when it arrived, and is not now: {unreadable}"))
        }
        (unreadable, Ok(_)) => SandboxResponse::Permanent(format!("it is not what has arrived: {unreadable}")),
    }
}

/// Writes the replay. A failure is only logged and does not prevent scoring: the replay is made on
/// demand.
fn keep_replay(folder: &Path, recording: &Recording) {
    if let Err(error) = replay_writing::write_replay(folder, recording) {
        tracing::warn!(session = %recording.session.session_id, cause = format!("{error:#}"), "replay not stored");
    }
}

/// Scores and re-simulates a recording with the published exercise, or with the embedded one if the
/// school has not published it.
fn judge(recording: &Recording, published: Option<RevisionBytes>) -> Result<JudgingOutcome, String> {
    let bundle = match published {
        Some(bytes) => read_bundle(&bytes)?,
        None => own_exercise(recording).map_err(|error| error.to_string())?,
    };
    let assessment = assess(recording, &bundle).map_err(|error| error.to_string())?;
    let verified = resimulate(recording, &bundle)?;
    Ok(JudgingOutcome { assessment, verified, curve: AttemptCurve::draw(recording, &bundle) })
}

fn read_bundle(bytes: &RevisionBytes) -> Result<ExerciseBundle, String> {
    ExerciseBundle::from_parts(&bytes.exercise, &bytes.scene, &bytes.meshes).map_err(|refused| refused.to_string())
}

/// Scores a recording by the rubric of another revision.
fn regrade(recording: &Recording, rubric: &RevisionBytes) -> Result<Assessment, String> {
    let mut bundle = own_exercise(recording).map_err(|error| error.to_string())?;
    bundle.exercise.judge_by(&read_bundle(rubric)?.exercise);
    assess(recording, &bundle).map_err(|error| error.to_string())
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
