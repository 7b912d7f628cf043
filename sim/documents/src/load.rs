//! From files or attachments to checked documents.

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

/// An exercise enters an anatomy at the angle at which its layers were measured, to so many degrees, and at that place, to so many mm.
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
    /// Each picture of the briefing, in order; none where it was rebuilt without them, as from a recording.
    pub pictures: Vec<PictureFile>,
}

/// A scene with every byte it was read from.
struct SceneParts {
    scene: Scene,
    bytes: Vec<u8>,
    meshes: Files,
    /// How a needle is planned to go in, where an anatomy was met with it.
    planned: Option<PlannedNeedle>,
}

impl SceneParts {
    /// What was read, with the bytes that a recording carries: those of the document, or of what its anatomy became.
    fn new(read: ReadScene, bytes: Vec<u8>) -> Self {
        let ReadScene { scene, files, expanded } = read;
        let planned = expanded.as_ref().map(|expanded| expanded.planned);
        Self { scene, bytes: expanded.map_or(bytes, |expanded| expanded.bytes), meshes: files, planned }
    }
}

impl ExerciseBundle {
    /// Reads an exercise and all it names from disk.
    ///
    /// # Errors
    /// Every issue found.
    pub fn read(path: &Path) -> Result<Self, DocumentError> {
        Self::from_disk(path, read_file(path)?)
    }

    /// What an attempt at it is simulated with, and verified with: the scene for a patient, met at the exercise's angle.
    #[must_use]
    pub fn specimen_spec(&self, patient: &Patient) -> SpecimenSpec {
        self.scene.specimen_spec(patient, self.exercise.planned_needle())
    }

    /// What a virtual operator intends at it, with the scene's needle in its hand.
    #[must_use]
    pub fn plan(&self) -> Plan {
        Plan { reach_m: self.scene.needle.length_mm * 1e-3, ..self.exercise.plan() }
    }

    /// What a recording of it is verified with: its field judged as it was when the recording was made.
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

    /// Rebuilds it from a recording's attachments, without the pictures of its briefing, which are not among them.
    ///
    /// # Errors
    /// Every issue found; a mesh that the scene names and `meshes` lacks is one, and a scene that names a body another.
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

    /// Reads an exercise and its scene, which may name a body, from texts; neither has a file beside it.
    ///
    /// # Errors
    /// Every issue found; a file that either names is one.
    pub fn from_texts(exercise: &str, scene: &str) -> Result<Self, DocumentError> {
        let read_scene =
            |_: &str| scene_from_disk(Path::new("scene"), scene.as_bytes().to_vec()).map_err(NamedError::Refused);
        Self::assemble("exercise", exercise.as_bytes().to_vec(), read_scene, None)
    }

    /// The same with the pictures of its briefing, by their names.
    ///
    /// # Errors
    /// Every picture that it names and `files` lacks, or that is none, at its place in the document.
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

    /// What is wrong where its briefing names a picture that is not among those at hand.
    #[must_use]
    pub fn list_missing_pictures(&self, at_hand: &[String]) -> Vec<Remark> {
        let rows = self.exercise.pictures.iter().enumerate().filter(|(_, named)| !at_hand.contains(&named.file));
        let allowed = || if at_hand.is_empty() { phrase!("no picture was added yet") } else { one_of(at_hand) };
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

/// Reads a document of any kind, telling the kind from its keys.
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
                phrase!("of no kind that is known"),
                phrase!(
                    "a scene has [[layer]] or [anatomy], an exercise has scene, a curriculum has [[exercise]], an instrument has [[item]]"
                ),
            )
            .into()),
    }
}

/// Reads a scene from a text, as if it stood at `path`: that names it in errors, and its meshes lie beside it.
///
/// # Errors
/// Every issue found.
pub fn read_scene_text(path: &Path, text: &str) -> Result<Scene, DocumentError> {
    scene_from_disk(path, text.as_bytes().to_vec()).map(|parts| parts.scene)
}

/// The same of a scene that has its layers written, and names no body.
///
/// # Errors
/// Every issue found.
pub fn read_layered_scene_text(path: &Path, text: &str) -> Result<Scene, DocumentError> {
    refuse_body(&Source::new(&path.display().to_string(), text.as_bytes())?)?;
    read_scene_text(path, text)
}

/// Refuses a scene that names a body where layers are needed: a recording carries what came of one, and does not cost its reader a body.
fn refuse_body(source: &Source) -> Result<(), DocumentError> {
    let document = walk::parse_document(source)?;
    let body = document.keys().find(|key| key.get_ref() == "anatomy");
    body.map_or(Ok(()), |key| {
        let allowed = phrase!("allowed here: [[layer]], as came of a body");
        Err(source.issue(key.span().start, "anatomy", phrase!("a body"), allowed).into())
    })
}

/// The kind of a document: the first that has one of its telling keys.
///
/// The key that every document of a kind needs comes first; the others tell the kind of one that lacks it, so that the
/// lack is reported as what it is.
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
    /// Reads a curriculum whose exercises are at hand: `find` gives the one that stands under a file's name.
    ///
    /// # Errors
    /// Every issue found; a name that `find` does not know is one.
    pub fn from_parts(document: &[u8], find: impl Fn(&str) -> Option<ExerciseBundle>) -> Result<Self, DocumentError> {
        let missing = |file: &str| NamedError::Missing(phrase!("{file}: no exercise of this name", file = file));
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

/// Where an exercise goes another way than the one that its scene's anatomy was met on.
fn list_strayed(exercise: &Exercise, planned: &PlannedNeedle) -> Vec<Remark> {
    let mut remarks = Vec::new();
    let mut remark = |field: &str, found: String, allowed: Phrase| {
        remarks.push(Remark { field: field.to_owned(), found: Phrase::Data(found), allowed });
    };
    let PlannedNeedle { angle_deg, azimuth_deg, .. } = *planned;
    if (exercise.angle_deg - angle_deg).abs() > SAME_DEG {
        let allowed = phrase!("allowed: {angle}°, as the scene's anatomy has it", angle = angle_deg);
        remark("entry.angle_deg", measure(exercise.angle_deg, "°"), allowed);
    }
    if angle_deg > 0.0 && libm::remainder(exercise.azimuth_deg - azimuth_deg, 360.0).abs() > SAME_DEG {
        let allowed = phrase!("allowed: {angle}°, as the scene's anatomy has it", angle = azimuth_deg);
        remark("entry.azimuth_deg", measure(exercise.azimuth_deg, "°"), allowed);
    }
    if exercise.entry_mm.iter().any(|mm| mm.abs() > SAME_MM) {
        let [x, y] = exercise.entry_mm;
        let allowed = phrase!("allowed: [0, 0], for the anatomy is met there; its offset_mm moves the entry");
        remark("entry.point_mm", format!("[{x}, {y}]"), allowed);
    }
    remarks
}

/// What is said of a picture that cannot be had.
fn refuse_picture(at: usize, found: Phrase) -> Remark {
    Remark { field: format!("picture[{at}].file"), found, allowed: picture::allowed_picture() }
}

/// The bytes of a file that has no more than are allowed.
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

/// Reads a document that another one names.
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

/// The path of a file that a document names relative to itself.
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
