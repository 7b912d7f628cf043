//! Reads files named on the command line; errors name the file.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use documents::{ExerciseBundle, Patient};
use recording::Recording;
use tissue::Specimen;

use crate::exit::Failure;
use crate::output;
use crate::progress::Progress;

/// Maximum size of a text file, in bytes: a larger one is neither a scene nor a token, or has no
/// end.
const LARGEST_TEXT_BYTES: u64 = 16 << 20;

/// Reads a text file named on the command line.
pub fn read_text(path: &Path) -> Result<String, Failure> {
    let mut text = String::new();
    let read = open(path)?.take(LARGEST_TEXT_BYTES + 1).read_to_string(&mut text);
    match read {
        Ok(length) if length as u64 <= LARGEST_TEXT_BYTES => Ok(text),
        Ok(_) => Err(Failure::refused(path, "larger than 16 MiB; allowed: a document of at most 16 MiB")),
        Err(error) => Err(Failure::refused(path, format_args!("cannot be read: {error}"))),
    }
}

/// Opens a file named on the command line.
pub fn open(path: &Path) -> Result<File, Failure> {
    let file = File::open(path).map_err(|error| Failure::refused(path, format_args!("cannot be read: {error}")))?;
    match file.metadata() {
        Ok(metadata) if metadata.is_dir() => Err(Failure::refused(path, "is a folder; allowed: a file")),
        _ => Ok(file),
    }
}

/// Reads a recording. A truncated one causes a warning and is used as far as it goes.
pub fn read_recording(path: &Path) -> Result<Recording, Failure> {
    let file = open(path)?;
    let progress = Progress::new(file.metadata().map_or(0, |metadata| metadata.len()), "reading");
    let source = BufReader::new(progress.watch(file));
    let recording = Recording::read(source).map_err(|error| Failure::refused(path, error))?;
    drop(progress);
    if !recording.complete {
        warn_of_cut(path);
    }
    Ok(recording)
}

/// Warns that a recording is truncated.
pub fn warn_of_cut(path: &Path) {
    let name = path.display();
    output::print_warning(format_args!(
        "{name}: the recording is truncated; its complete part is used (stylet recover repairs it)"
    ));
}

/// Returns the exercise that a recording contains.
pub fn own_exercise(path: &Path, recording: &Recording) -> Result<ExerciseBundle, Failure> {
    assessment::own_exercise(recording).map_err(|error| Failure::refused(path, error))
}

/// Prepares the tissue of an exercise: a patient of its scene.
pub fn prepare_specimen(file: &Path, bundle: &ExerciseBundle, patient: &Patient) -> Result<Specimen, Failure> {
    Specimen::new(bundle.specimen_spec(patient)).map_err(|error| Failure::refused(file, error))
}
