//! The documents that an attempt carries: into the recording, and out of it again.

use std::path::Path;

use documents::ExerciseBundle;
use recording::session::{EXERCISE_ATTACHMENT, MESH_PREFIX, SCENE_ATTACHMENT};
use recording::{Attachment, Recording};

use crate::error::AssessError;

/// Every document that an attempt depends on, byte for byte, as a recording attaches it.
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

/// The media type of a mesh, by its file's extension.
fn media_type(file: &str) -> &'static str {
    let extension = Path::new(file).extension();
    if extension.is_some_and(|e| e.eq_ignore_ascii_case("obj")) { "model/obj" } else { "model/stl" }
}

/// The exercise that a recording carries.
///
/// # Errors
/// When an attachment is missing or refused, or the scene is of another force law than the recording says.
pub fn own_exercise(recording: &Recording) -> Result<ExerciseBundle, AssessError> {
    let attached = |name: &str| {
        let missing =
            || AssessError::Document(format!("attachment {name}: missing; a recording carries its own exercise"));
        recording.attachment(name).ok_or_else(missing)
    };
    let mesh = |a: &Attachment| a.name.strip_prefix(MESH_PREFIX).map(|name| (name.to_owned(), a.data.clone()));
    let meshes: Vec<(String, Vec<u8>)> = recording.attachments.iter().filter_map(mesh).collect();
    let bundle = ExerciseBundle::from_parts(attached(EXERCISE_ATTACHMENT)?, attached(SCENE_ATTACHMENT)?, &meshes)
        .map_err(|error| AssessError::Document(error.to_string()))?;
    let (said, is) = (u32::from(recording.session.law), u32::from(bundle.scene.law));
    if said != is {
        let message = format!("metadata stylet.session: law = {said}, but {SCENE_ATTACHMENT} is of law {is}");
        return Err(AssessError::Document(message));
    }
    Ok(bundle)
}
