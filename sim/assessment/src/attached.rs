//! Converts between an attempt's documents and a recording's attachments.

use std::path::Path;

use attempt::fluoroscopy::{Fluoroscope, count_pulse_differences};
use attempt::verify::{Verification, verify_recording};
use documents::{ExerciseBundle, Patient};
use recording::session::{EXERCISE_ATTACHMENT, MESH_PREFIX, SCENE_ATTACHMENT};
use recording::{Attachment, Recording};
use tissue::Specimen;

use crate::error::AssessError;

/// Returns every document that an attempt depends on, byte for byte, as attachments of a recording.
#[must_use]
pub fn attachments(bundle: &ExerciseBundle) -> Vec<Attachment> {
    let attachment = |name: String, media_type: &str, data: &[u8]| Attachment {
        name,
        media_type: media_type.to_owned(),
        data: data.to_vec(),
    };
    let documents = [(EXERCISE_ATTACHMENT, &bundle.exercise_bytes), (SCENE_ATTACHMENT, &bundle.scene_bytes)];
    let meshes = bundle.meshes.iter();
    documents
        .into_iter()
        .map(|(name, bytes)| attachment(name.to_owned(), "application/toml", bytes))
        .chain(meshes.map(|(name, bytes)| attachment(format!("{MESH_PREFIX}{name}"), media_type(name), bytes)))
        .collect()
}

/// Returns the media type of a mesh by its file extension.
fn media_type(file: &str) -> &'static str {
    let extension = Path::new(file).extension();
    if extension.is_some_and(|e| e.eq_ignore_ascii_case("obj")) { "model/obj" } else { "model/stl" }
}

/// Re-simulates a recording's input with its own exercise, scene and patient, and compares the
/// results.
///
/// # Errors
/// If an attachment is missing or refused.
pub fn verify_own(recording: &Recording) -> Result<Verification, AssessError> {
    let bundle = own_exercise(recording)?;
    let patient = Patient { thickness_mm: recording.session.patient_thickness_mm.clone() };
    let (drawn, layers) = (patient.thickness_mm.len(), bundle.scene.layers.len());
    if drawn != layers {
        let why = format!("patient_thickness_mm has {drawn} values; allowed: {layers}, one per layer");
        return Err(AssessError::Document(why));
    }
    let specimen = Specimen::new(bundle.recorded_spec(&patient, recording.session.judging));
    let specimen = specimen.map_err(|error| AssessError::Document(error.to_string()))?;
    // Without controls there is no pulse to compute, and the body is not needed.
    let is_used = !recording.fluoroscopy.controls.is_empty();
    let fluoroscope = is_used.then(|| Fluoroscope::new(&bundle)).transpose();
    let fluoroscope = fluoroscope.map_err(|why| AssessError::Document(why.to_string()))?.flatten();
    let pulse_differences = count_pulse_differences(recording, fluoroscope);
    Ok(Verification { pulse_differences, ..verify_recording(recording, &specimen) })
}

/// Finds the first attachment that no document of the recording names, or a document that is too
/// large. Returns the reason and the limit.
#[must_use]
pub fn find_needless_attachment(recording: &Recording) -> Option<String> {
    let named = documents::list_named_texts(recording.attachment(SCENE_ATTACHMENT).unwrap_or_default());
    recording.attachments.iter().find_map(|attachment| {
        let Attachment { name, data, .. } = attachment;
        match (name.as_str(), name.strip_prefix(MESH_PREFIX)) {
            (EXERCISE_ATTACHMENT | SCENE_ATTACHMENT, _) if data.len() <= documents::MOST_BYTES => None,
            (EXERCISE_ATTACHMENT | SCENE_ATTACHMENT, _) => {
                Some(format!("attachment {name}: {} bytes; allowed: at most {}", data.len(), documents::MOST_BYTES))
            }
            (_, Some(mesh)) if named.contains(mesh) => None,
            _ => Some(format!(
                "attachment {name}: no document refers to it; allowed: {EXERCISE_ATTACHMENT}, {SCENE_ATTACHMENT} and \
                 the scene's meshes"
            )),
        }
    })
}

/// Reads the exercise attached to a recording.
///
/// # Errors
/// If an attachment is missing or refused, or if the scene's force law differs from that in the
/// metadata.
pub fn own_exercise(recording: &Recording) -> Result<ExerciseBundle, AssessError> {
    let attached = |name: &str| {
        let missing =
            || AssessError::Document(format!("attachment {name}: missing; a recording must contain its exercise"));
        recording.attachment(name).ok_or_else(missing)
    };
    let mesh = |a: &Attachment| a.name.strip_prefix(MESH_PREFIX).map(|name| (name.to_owned(), a.data.clone()));
    let meshes: Vec<(String, Vec<u8>)> = recording.attachments.iter().filter_map(mesh).collect();
    let bundle = ExerciseBundle::from_parts(attached(EXERCISE_ATTACHMENT)?, attached(SCENE_ATTACHMENT)?, &meshes)
        .map_err(|error| AssessError::Document(error.to_string()))?;
    let (said, is) = (u32::from(recording.session.law), u32::from(bundle.scene.law));
    if said != is {
        let message = format!("metadata stylet.session: law = {said}, but {SCENE_ATTACHMENT} has law = {is}");
        return Err(AssessError::Document(message));
    }
    Ok(bundle)
}
