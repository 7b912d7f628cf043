//! Loads documents from files or attachments and checks them.

use std::io::Read;
use std::path::{Path, PathBuf};

use law::Judging;
use law::operator::Plan;
use phrase::{Phrase, phrase};
use tissue::SpecimenSpec;
use toml::de::DeTable;

use crate::curriculum::Curriculum;
use crate::describe::{measure, one_of};
use crate::error::{DocumentError, Issue, Remark};
use crate::exercise::Exercise;
use crate::instrument::Instrument;
use crate::model::Scene;
use crate::patient::Patient;
use crate::picture::{self, PictureFile};
use crate::planned::PlannedNeedle;
use crate::read_curriculum::{NamedExercise, read_curriculum};
use crate::read_exercise::{ExerciseParts, find_and_read, read_exercise};
use crate::read_instrument::read_instrument;
use crate::read_scene::{ReadScene, read_scene};
use crate::source::{Files, Find, Source};
use crate::walk::{self, NamedError};

/// Tolerances for an exercise's entry compared with that of its scene's anatomy, for which the
/// layers were measured: angle in degrees, position in mm.
const SAME_DEG: f64 = 0.5;
const SAME_MM: f64 = 0.5;

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
    /// A scene with its meshes.
    Scene(Box<Scene>),
    /// An exercise with its scene.
    Exercise(Box<ExerciseBundle>),
    /// A curriculum with its exercises.
    Curriculum(Box<Curriculum>, Vec<ExerciseBundle>),
    /// An instrument.
    Instrument(Box<Instrument>),
}

/// An exercise, its scene and all bytes that they were read from: the attachments of a recording.
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
    /// Each picture of the briefing, in order; empty if the exercise was rebuilt without them, as
    /// from a recording.
    pub pictures: Vec<PictureFile>,
}

/// A scene with all bytes that it was read from.
struct SceneParts {
    scene: Scene,
    bytes: Vec<u8>,
    meshes: Files,
    /// The planned needle for which an anatomy was expanded.
    planned: Option<PlannedNeedle>,
}

impl SceneParts {
    /// Collects a scene with the bytes to attach to a recording: those of the document, or of its
    /// expansion if it names an anatomy.
    fn new(read: ReadScene, bytes: Vec<u8>) -> Self {
        let ReadScene { scene, files, expanded } = read;
        let planned = expanded.as_ref().map(|expanded| expanded.planned);
        Self { scene, bytes: expanded.map_or(bytes, |expanded| expanded.bytes), meshes: files, planned }
    }
}

impl ExerciseBundle {
    /// Reads an exercise and the files it names from disk.
    ///
    /// # Errors
    /// Every issue found.
    pub fn read(path: &Path) -> Result<Self, DocumentError> {
        Self::from_disk(path, read_file(path)?)
    }

    /// Returns the specimen that simulates and verifies an attempt: the scene for a patient,
    /// entered at the exercise's angle.
    #[must_use]
    pub fn specimen_spec(&self, patient: &Patient) -> SpecimenSpec {
        self.scene.specimen_spec(patient, self.exercise.planned_needle())
    }

    /// Returns a virtual operator's plan for the exercise, with the scene's needle.
    #[must_use]
    pub fn plan(&self) -> Plan {
        Plan { reach_m: self.scene.needle.length_mm * 1e-3, ..self.exercise.plan() }
    }

    /// Returns the specimen that verifies a recording: its field is judged by the recorded method.
    #[must_use]
    pub fn recorded_spec(&self, patient: &Patient, judging: Judging) -> SpecimenSpec {
        let mut spec = self.specimen_spec(patient);
        spec.tissue.iter_mut().for_each(|tissue| tissue.judging = judging);
        spec
    }

    fn from_disk(path: &Path, bytes: Vec<u8>) -> Result<Self, DocumentError> {
        let find = |file: &str| read_at_most(&path_beside(path, file), picture::MOST_BYTES);
        Self::assemble(
            &path.display().to_string(),
            bytes,
            |scene| read_named(path, scene, scene_from_disk),
            Some(&find),
        )
    }

    /// Rebuilds an exercise from a recording's attachments, which do not include the pictures of
    /// its briefing.
    ///
    /// # Errors
    /// Every issue found, including a mesh that the scene names and `meshes` lacks, and a scene
    /// that names an anatomy.
    pub fn from_parts(exercise: &[u8], scene: &[u8], meshes: &[(String, Vec<u8>)]) -> Result<Self, DocumentError> {
        let find = |file: &str| {
            let found = meshes.iter().find(|(name, _)| name == file);
            found.map(|(_, bytes)| bytes.clone()).ok_or_else(|| phrase!("not attached"))
        };
        let read_scene = |_: &str| {
            let source = Source::new("attached scene", scene).map_err(NamedError::Refused)?;
            refuse_body(&source).map_err(NamedError::Refused)?;
            let read = read_scene(source, &find).map_err(NamedError::Refused)?;
            Ok(SceneParts::new(read, scene.to_vec()))
        };
        Self::assemble("attached exercise", exercise.to_vec(), read_scene, None)
    }

    /// Reads an exercise and its scene from texts. The scene may name an anatomy; there are no
    /// files next to either text.
    ///
    /// # Errors
    /// Every issue found, including any file that one of them names.
    pub fn from_texts(exercise: &str, scene: &str) -> Result<Self, DocumentError> {
        let read_scene =
            |_: &str| scene_from_disk(Path::new("scene"), scene.as_bytes().to_vec()).map_err(NamedError::Refused);
        Self::assemble("exercise", exercise.as_bytes().to_vec(), read_scene, None)
    }

    /// Adds the pictures of the briefing, found by name.
    ///
    /// # Errors
    /// Every picture that the briefing names and `files` lacks or that is invalid, at its place in
    /// the document.
    pub fn with_pictures(mut self, files: &[(String, Vec<u8>)]) -> Result<Self, DocumentError> {
        let find = |file: &str| {
            let found = files.iter().find(|(name, _)| name == file);
            found.map(|(_, bytes)| bytes.clone()).ok_or_else(|| phrase!("not attached"))
        };
        let mut remarks = Vec::new();
        self.pictures.clear();
        for (at, named) in self.exercise.pictures.iter().enumerate() {
            match find_and_read(&find, &named.file) {
                Ok(picture) => self.pictures.push(picture),
                Err(found) => remarks.push(refuse_picture(at, found)),
            }
        }
        let issues = self.place("attached exercise", &remarks)?;
        if issues.is_empty() { Ok(self) } else { Err(DocumentError { issues }) }
    }

    /// Returns a remark for each picture of the briefing that is not in `at_hand`.
    #[must_use]
    pub fn list_missing_pictures(&self, at_hand: &[String]) -> Vec<Remark> {
        let rows = self.exercise.pictures.iter().enumerate().filter(|(_, named)| !at_hand.contains(&named.file));
        let allowed = || if at_hand.is_empty() { phrase!("no picture has been added yet") } else { one_of(at_hand) };
        rows.map(|(at, named)| Remark {
            field: format!("picture[{at}].file"),
            found: Phrase::quoted(&named.file),
            allowed: allowed(),
        })
        .collect()
    }

    fn assemble(
        file: &str,
        exercise_bytes: Vec<u8>,
        read_scene: impl FnOnce(&str) -> Result<SceneParts, NamedError>,
        find_picture: Option<Find<'_>>,
    ) -> Result<Self, DocumentError> {
        let source = Source::new(file, &exercise_bytes)?;
        let ExerciseParts { exercise, scene, pictures } =
            read_exercise(source, read_scene, |parts: &SceneParts| &parts.scene, find_picture)?;
        let SceneParts { scene, bytes: scene_bytes, meshes, planned } = scene;
        let exercise = Exercise { skin_shape: scene.skin_shape, ..exercise };
        let bundle = Self { exercise, scene, exercise_bytes, scene_bytes, meshes, pictures };
        let strayed = planned.map(|planned| list_strayed(&bundle.exercise, &planned)).unwrap_or_default();
        let issues = bundle.place(file, &strayed)?;
        if issues.is_empty() { Ok(bundle) } else { Err(DocumentError { issues }) }
    }
}

/// Determines the kind of a document by its keys, without checking it and without reading the files
/// that it names; `None` if no kind has one of its keys.
///
/// # Errors
/// If the file cannot be read or is no TOML.
pub fn read_kind(path: &Path) -> Result<Option<DocumentKind>, DocumentError> {
    let source = Source::new(&path.display().to_string(), &read_file(path)?)?;
    Ok(document_kind(&walk::parse_document(&source)?))
}

/// Reads a document of any kind; its keys determine the kind.
///
/// # Errors
/// Every issue found.
pub fn read_document(path: &Path) -> Result<Document, DocumentError> {
    let bytes = read_file(path)?;
    let source = Source::new(&path.display().to_string(), &bytes)?;
    match document_kind(&walk::parse_document(&source)?) {
        Some(DocumentKind::Scene) => Ok(Document::Scene(Box::new(scene_from_disk(path, bytes)?.scene))),
        Some(DocumentKind::Exercise) => Ok(Document::Exercise(Box::new(ExerciseBundle::from_disk(path, bytes)?))),
        Some(DocumentKind::Curriculum) => {
            let (curriculum, bundles) =
                read_curriculum(source, |file| read_named(path, file, ExerciseBundle::from_disk).map(named_reference))?;
            Ok(Document::Curriculum(Box::new(curriculum), bundles))
        }
        Some(DocumentKind::Instrument) => Ok(Document::Instrument(Box::new(read_instrument(source)?))),
        None => Err(source
            .issue(
                0,
                "document",
                phrase!("of an unknown kind"),
                phrase!(
                    "a scene has [[layer]] or [anatomy], an exercise has scene, a curriculum has [[exercise]], an instrument has [[item]]"
                ),
            )
            .into()),
    }
}

/// Reads a scene from a text as if it were the file `path`: errors carry that name, and meshes are
/// looked up next to it.
///
/// # Errors
/// Every issue found.
pub fn read_scene_text(path: &Path, text: &str) -> Result<Scene, DocumentError> {
    scene_from_disk(path, text.as_bytes().to_vec()).map(|parts| parts.scene)
}

/// Like [`read_scene_text`], but refuses a scene that names an anatomy.
///
/// # Errors
/// Every issue found.
pub fn read_layered_scene_text(path: &Path, text: &str) -> Result<Scene, DocumentError> {
    refuse_body(&Source::new(&path.display().to_string(), text.as_bytes())?)?;
    read_scene_text(path, text)
}

/// Refuses a scene that names an anatomy where layers are required. A recording carries the
/// expanded scene, so that reading it never has to build a body.
fn refuse_body(source: &Source) -> Result<(), DocumentError> {
    let document = walk::parse_document(source)?;
    let body = document.keys().find(|key| key.get_ref() == "anatomy");
    body.map_or(Ok(()), |key| {
        let allowed = phrase!("allowed here: [[layer]], the layers made from the body");
        Err(source.issue(key.span().start, "anatomy", phrase!("a body"), allowed).into())
    })
}

/// Returns the kind of a document: the first kind that has one of its keys.
///
/// The key that every document of a kind requires is tried first. The other keys identify a
/// document without the required one, so that the missing key is reported as such.
fn document_kind(document: &DeTable<'_>) -> Option<DocumentKind> {
    const TELLING: [(DocumentKind, &[&str]); 8] = [
        (DocumentKind::Scene, &["layer", "anatomy"]),
        (DocumentKind::Exercise, &["scene"]),
        (DocumentKind::Curriculum, &["exercise", "exercises"]),
        (DocumentKind::Instrument, &["item", "items"]),
        (DocumentKind::Scene, &["layers", "needle", "structure", "tissue", "rate"]),
        (DocumentKind::Exercise, &["rubric", "target", "entry", "hard_fail", "coaching", "pass_mark"]),
        (DocumentKind::Curriculum, &["mastery"]),
        (DocumentKind::Instrument, &["languages", "licence", "scale", "section", "score"]),
    ];
    let has = |key: &&str| document.keys().any(|k| k.get_ref() == *key);
    TELLING.iter().find(|(_, keys)| keys.iter().any(has)).map(|(kind, _)| *kind)
}

fn named_reference(exercise: ExerciseBundle) -> NamedExercise<ExerciseBundle> {
    NamedExercise { id: exercise.exercise.id.clone(), exercise }
}

impl Curriculum {
    /// Reads a curriculum whose exercises are in memory; `find` looks one up by file name.
    ///
    /// # Errors
    /// Every issue found, including a name that `find` does not know.
    pub fn from_parts(document: &[u8], find: impl Fn(&str) -> Option<ExerciseBundle>) -> Result<Self, DocumentError> {
        let missing = |file: &str| NamedError::Missing(phrase!("{file}: no exercise with this name", file = file));
        let source = Source::new("course", document)?;
        let (curriculum, _) =
            read_curriculum(source, |file| find(file).map(named_reference).ok_or_else(|| missing(file)))?;
        Ok(curriculum)
    }
}

fn scene_from_disk(path: &Path, bytes: Vec<u8>) -> Result<SceneParts, DocumentError> {
    let source = Source::new(&path.display().to_string(), &bytes)?;
    let find = |file: &str| std::fs::read(path_beside(path, file)).map_err(Phrase::data);
    Ok(SceneParts::new(read_scene(source, &find)?, bytes))
}

/// Returns a remark for each value where the exercise's path differs from that for which its
/// scene's anatomy was expanded.
fn list_strayed(exercise: &Exercise, planned: &PlannedNeedle) -> Vec<Remark> {
    let mut remarks = Vec::new();
    let mut remark = |field: &str, found: String, allowed: Phrase| {
        remarks.push(Remark { field: field.to_owned(), found: Phrase::Data(found), allowed });
    };
    let PlannedNeedle { angle_deg, azimuth_deg, .. } = *planned;
    if (exercise.angle_deg - angle_deg).abs() > SAME_DEG {
        let allowed = phrase!("allowed: {angle}°, the angle of the scene's anatomy", angle = angle_deg);
        remark("entry.angle_deg", measure(exercise.angle_deg, "°"), allowed);
    }
    if angle_deg > 0.0 && libm::remainder(exercise.azimuth_deg - azimuth_deg, 360.0).abs() > SAME_DEG {
        let allowed = phrase!("allowed: {angle}°, the angle of the scene's anatomy", angle = azimuth_deg);
        remark("entry.azimuth_deg", measure(exercise.azimuth_deg, "°"), allowed);
    }
    if exercise.entry_mm.iter().any(|mm| mm.abs() > SAME_MM) {
        let [x, y] = exercise.entry_mm;
        let allowed =
            phrase!("allowed: [0, 0], because the needle enters the anatomy there; its offset_mm moves the entry");
        remark("entry.point_mm", format!("[{x}, {y}]"), allowed);
    }
    remarks
}

/// Returns the remark for a picture that cannot be loaded.
fn refuse_picture(at: usize, found: Phrase) -> Remark {
    Remark { field: format!("picture[{at}].file"), found, allowed: picture::allowed_picture() }
}

/// Reads a file of at most `most` bytes.
fn read_at_most(path: &Path, most: usize) -> Result<Vec<u8>, Phrase> {
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(Phrase::data)?;
    let count = file.metadata().map_err(Phrase::data)?.len();
    if count > most as u64 {
        return Err(phrase!("{count} bytes", count = count));
    }
    file.take(most as u64 + 1).read_to_end(&mut bytes).map_err(Phrase::data)?;
    Ok(bytes)
}

/// Reads a document that another document names.
fn read_named<T>(
    naming: &Path,
    file: &str,
    read: impl FnOnce(&Path, Vec<u8>) -> Result<T, DocumentError>,
) -> Result<T, NamedError> {
    let path = path_beside(naming, file);
    let bytes =
        std::fs::read(&path).map_err(|e| NamedError::Missing(Phrase::data(format_args!("{}: {e}", path.display()))))?;
    read(&path, bytes).map_err(NamedError::Refused)
}

/// Returns the path of a file that a document names relative to itself.
#[must_use]
pub fn path_beside(document: &Path, file: &str) -> PathBuf {
    document.parent().unwrap_or(Path::new("")).join(file)
}

pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>, DocumentError> {
    std::fs::read(path).map_err(|e| {
        let issue = Issue {
            file: path.display().to_string(),
            line: 1,
            column: 1,
            field: "document".to_owned(),
            found: Phrase::data(e),
            allowed: phrase!("allowed: a readable TOML document"),
        };
        issue.into()
    })
}
