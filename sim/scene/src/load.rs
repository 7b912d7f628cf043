//! From files or attachments to checked documents.

use std::path::Path;

use crate::curriculum::Curriculum;
use crate::error::DocumentError;
use crate::exercise::Exercise;
use crate::model::Scene;

/// The kinds of document.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DocumentKind {
    /// A scene.
    Scene,
    /// An exercise.
    Exercise,
    /// A curriculum.
    Curriculum,
    /// An instrument (a questionnaire).
    Instrument,
}

/// A document of any kind.
#[derive(Clone, Debug, PartialEq)]
pub enum Document {
    /// A scene with the bytes of its meshes.
    Scene(Box<Scene>),
    /// An exercise with its scene.
    Exercise(Box<ExerciseBundle>),
    /// A curriculum with its exercises.
    Curriculum(Box<Curriculum>, Vec<ExerciseBundle>),
}

/// An exercise, its scene and every byte they were read from: what a recording attaches.
#[derive(Clone, Debug, PartialEq)]
pub struct ExerciseBundle {
    /// The exercise.
    pub exercise: Exercise,
    /// Its scene.
    pub scene: Scene,
    /// The exercise document, byte for byte.
    pub exercise_bytes: Vec<u8>,
    /// The scene document, byte for byte.
    pub scene_bytes: Vec<u8>,
    /// Each mesh: file name as the scene names it, and its bytes.
    pub meshes: Vec<(String, Vec<u8>)>,
}

impl ExerciseBundle {
    /// Reads an exercise and all it names from disk.
    ///
    /// # Errors
    /// Every issue found.
    pub fn read(_path: &Path) -> Result<Self, DocumentError> {
        unimplemented!()
    }

    /// Rebuilds it from a recording's attachments.
    ///
    /// # Errors
    /// Every issue found; a mesh that the scene names and `meshes` lacks is one.
    pub fn from_parts(_exercise: &[u8], _scene: &[u8], _meshes: &[(String, Vec<u8>)]) -> Result<Self, DocumentError> {
        unimplemented!()
    }
}

/// Reads a document of any kind, telling the kind from its keys.
///
/// # Errors
/// Every issue found.
pub fn read(_path: &Path) -> Result<Document, DocumentError> {
    unimplemented!()
}
