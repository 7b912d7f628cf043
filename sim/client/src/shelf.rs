//! The catalogue of exercises: those in the given files and folders, their courses, and the
//! documents that cannot be used.
//!
//! A background thread reads the documents. A scene with a body takes a second or more, and the
//! list shows the exercises that were read meanwhile.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread;

use assessment::learning::Mastery;
use documents::load::{path_beside, read_document, read_kind};
use documents::{Curriculum, Document, DocumentKind, ExerciseBundle, Wording};

use crate::exit::Failure;

/// The catalogue.
#[derive(Default)]
pub struct Shelf {
    /// Exercises without duplicates, in order.
    pub exercises: Vec<Offer>,
    /// Documents that cannot be used.
    pub broken: Vec<Broken>,
    /// Documents that are still being read; `None` once all have arrived.
    arriving: Option<Receiver<FoundDocument>>,
}

/// A file, and its document or the reason why it cannot be used.
type FoundDocument = (PathBuf, Result<Document, Failure>);

/// An entry of the catalogue.
#[derive(Clone)]
pub struct Offer {
    /// The exercise.
    pub bundle: Arc<ExerciseBundle>,
    /// Its place in a course, if it belongs to one in the catalogue.
    pub course: Option<CoursePlace>,
}

/// Place of an exercise in a course.
#[derive(Clone, Debug, PartialEq)]
pub struct CoursePlace {
    /// Title of the course.
    pub title: Wording,
    /// Position in the course, from 1, and number of its exercises.
    pub place: [usize; 2],
    /// Ids of the exercises to master first.
    pub prerequisites: Vec<String>,
    /// Rule by which one of them counts as mastered.
    pub mastery: Mastery,
}

/// A document that cannot be used, and the reason.
#[derive(Clone, Debug, PartialEq)]
pub struct Broken {
    /// The file.
    pub path: PathBuf,
    /// The reason, on one line.
    pub why: String,
}

impl Shelf {
    /// Starts to read files and folders, and waits for the first two entries, or for all if there
    /// are fewer. Documents that cannot be used are listed, and do not prevent the use of the
    /// others. Scenes and instruments in a folder are skipped, since courses have their scenes next
    /// to them.
    ///
    /// # Errors
    /// If there is no exercise in the given files and folders.
    pub fn open(paths: &[PathBuf]) -> Result<Self, Failure> {
        let mut shelf = Self::begin(paths.to_vec());
        while (shelf.exercises.is_empty() || shelf.exercises.len() + shelf.broken.len() < 2) && shelf.wait() {}
        shelf.with_exercises()
    }

    /// Reads files and folders completely.
    ///
    /// # Errors
    /// As [`Shelf::open`].
    #[cfg(test)]
    pub fn read(paths: &[PathBuf]) -> Result<Self, Failure> {
        let mut shelf = Self::begin(paths.to_vec());
        while shelf.wait() {}
        shelf.with_exercises()
    }

    fn begin(paths: Vec<PathBuf>) -> Self {
        let (found, arriving) = channel();
        let mut reader = ShelfReader { found, read: BTreeSet::new() };
        thread::spawn(move || reader.read_all(&paths));
        Self { arriving: Some(arriving), ..Self::default() }
    }

    fn with_exercises(self) -> Result<Self, Failure> {
        match (self.exercises.is_empty(), self.broken.is_empty()) {
            (false, _) => Ok(self),
            (true, true) => Err(Failure::input("no exercise found in the given files and folders")),
            (true, false) => Err(Failure::Input(self.broken.into_iter().map(|broken| broken.why).collect())),
        }
    }

    /// Whether documents are still being read.
    pub fn is_reading(&self) -> bool {
        self.arriving.is_some()
    }

    /// Waits for the next document; returns false if there are no more.
    fn wait(&mut self) -> bool {
        match self.arriving.as_ref().map(Receiver::recv) {
            Some(Ok((path, found))) => self.add(&path, found),
            _ => self.arriving = None,
        }
        self.is_reading()
    }

    /// Adds the documents that were read since the last call; returns those that cannot be used.
    pub fn take_arrived(&mut self) -> &[Broken] {
        let known = self.broken.len();
        while let Some(arriving) = &self.arriving {
            match arriving.try_recv() {
                Ok((path, found)) => self.add(&path, found),
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => self.arriving = None,
            }
        }
        self.broken.get(known..).unwrap_or_default()
    }

    fn add(&mut self, path: &Path, found: Result<Document, Failure>) {
        match found {
            Ok(document) => self.take(path, document),
            Err(failure) => self.put_aside(path, &failure),
        }
    }

    fn take(&mut self, path: &Path, document: Document) {
        match document {
            Document::Exercise(bundle) => self.offer(Offer { bundle: Arc::from(bundle), course: None }),
            Document::Curriculum(course, bundles) => {
                let mastery = Mastery::from_rule(&course.mastery);
                for bundle in bundles {
                    let course = mastery.ok().and_then(|mastery| place(&course, &bundle.exercise.id, mastery));
                    self.offer(Offer { bundle: Arc::new(bundle), course });
                }
                if let Err(why) = mastery {
                    self.put_aside(path, &Failure::refused(path, format_args!("mastery: {why}")));
                }
            }
            Document::Scene(_) | Document::Instrument(_) => {}
        }
    }

    /// Adds an exercise. If it is there already, only a missing place in a course is filled in.
    fn offer(&mut self, offer: Offer) {
        let is_it = |known: &&mut Offer| known.bundle.exercise.sha256 == offer.bundle.exercise.sha256;
        match self.exercises.iter_mut().find(is_it) {
            Some(known) => known.course = known.course.take().or(offer.course),
            None => self.exercises.push(offer),
        }
    }

    fn put_aside(&mut self, path: &Path, failure: &Failure) {
        self.broken.push(Broken { path: path.to_owned(), why: failure.to_string() });
    }
}

/// Reads documents in the background; ends when the catalogue is dropped.
struct ShelfReader {
    found: Sender<FoundDocument>,
    /// Exercises that were read as part of a course, by canonical path: a body is built once.
    read: BTreeSet<PathBuf>,
}

/// The catalogue was dropped.
struct Dropped;

impl ShelfReader {
    fn read_all(&mut self, paths: &[PathBuf]) {
        // An error means that nobody waits for the other documents.
        let _ = paths.iter().try_for_each(|path| if path.is_dir() { self.read_folder(path) } else { self.read(path) });
    }

    /// Reads the courses of a folder, then its other exercises, then its folders.
    fn read_folder(&mut self, folder: &Path) -> Result<(), Dropped> {
        let listed = match fs::read_dir(folder) {
            Ok(listed) => listed,
            Err(error) => return self.send(folder, Err(Failure::refused(folder, error))),
        };
        let mut paths: Vec<PathBuf> = listed.flatten().map(|entry| entry.path()).collect();
        paths.sort();
        let (folders, files): (Vec<_>, Vec<_>) = paths.into_iter().partition(|path| path.is_dir());
        let documents = files.into_iter().filter(|path| path.extension().is_some_and(|extension| extension == "toml"));
        let kinds = documents.map(|path| (read_kind(&path).ok().flatten(), path));
        let is_skipped = |kind| matches!(kind, Some(DocumentKind::Scene | DocumentKind::Instrument));
        let (courses, others): (Vec<_>, Vec<_>) =
            kinds.filter(|(kind, _)| !is_skipped(*kind)).partition(|(kind, _)| *kind == Some(DocumentKind::Curriculum));
        courses.iter().chain(&others).try_for_each(|(_, path)| self.read(path))?;
        folders.iter().try_for_each(|folder| self.read_folder(folder))
    }

    fn read(&mut self, path: &Path) -> Result<(), Dropped> {
        if self.read.contains(&canonical(path)) {
            return Ok(());
        }
        let refused = |kind| Failure::refused(path, format_args!("is {kind}; allowed: an exercise or a curriculum"));
        let found = match read_document(path) {
            Ok(Document::Scene(_)) => Err(refused("a scene")),
            Ok(Document::Instrument(_)) => Err(refused("an instrument")),
            found => found.map_err(Failure::from),
        };
        if let Ok(Document::Curriculum(course, _)) = &found {
            self.read.extend(course.entries.iter().map(|entry| canonical(&path_beside(path, &entry.file))));
        }
        self.send(path, found)
    }

    fn send(&self, path: &Path, found: Result<Document, Failure>) -> Result<(), Dropped> {
        self.found.send((path.to_owned(), found)).map_err(|_| Dropped)
    }
}

/// Returns the canonical path of a file, or the path itself if it has none.
fn canonical(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}

fn place(course: &Curriculum, exercise: &str, mastery: Mastery) -> Option<CoursePlace> {
    let at = course.entries.iter().position(|entry| entry.exercise == exercise)?;
    Some(CoursePlace {
        title: course.title.clone(),
        place: [at + 1, course.entries.len()],
        prerequisites: course.entries.get(at)?.prerequisites.clone(),
        mastery,
    })
}

#[cfg(test)]
mod tests {
    //! Fails if one broken file hides all other exercises, or is not listed.

    use super::*;

    fn course() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula/lower-back-basics")
    }

    #[test]
    fn a_broken_file_is_listed_and_the_others_are_offered() {
        let folder = tempfile::TempDir::new().expect("a folder");
        let broken = folder.path().join("broken.toml");
        fs::write(&broken, "title = 3").expect("written");
        let shelf = Shelf::read(&[folder.path().to_owned(), course()]).expect("there is something to practise");
        assert_eq!(shelf.exercises.len(), 7);
        assert_eq!(shelf.broken.iter().map(|broken| &broken.path).collect::<Vec<_>>(), [&broken]);
        assert!(shelf.broken[0].why.contains("broken.toml"), "{}", shelf.broken[0].why);
        assert!(Shelf::read(&[broken]).is_err(), "where nothing else is there, that is the answer");
    }

    #[test]
    fn catalogue_opens_before_all_its_documents_are_read() {
        let curricula = course().join("..");
        let mut shelf = Shelf::open(&[course(), curricula.join("lumbar-epidural-on-a-body")]).expect("exercises");
        assert!(shelf.is_reading() && shelf.exercises.len() == 7, "the bodies are still being built");
        while shelf.wait() {}
        assert_eq!((shelf.exercises.len(), shelf.is_reading()), (10, false));
        assert!(shelf.exercises.iter().all(|offer| offer.course.is_some()));
        let alone = Shelf::open(&[course().join("1-feel-the-layers.toml")]).expect("an exercise");
        assert_eq!((alone.exercises.len(), alone.is_reading()), (1, false), "its briefing is opened at once");
    }

    #[test]
    fn exercises_of_a_course_are_read_once_and_scenes_never() {
        let (found, arriving) = channel();
        ShelfReader { found, read: BTreeSet::new() }.read_all(&[course(), course().join("1-feel-the-layers.toml")]);
        let names: Vec<_> = arriving.iter().map(|(path, _)| path.file_name().map(std::ffi::OsStr::to_owned)).collect();
        assert_eq!(names, [Some("course.toml".into())]);
        let (found, arriving) = channel();
        ShelfReader { found, read: BTreeSet::new() }.read_all(&[course().join("../scenes")]);
        assert_eq!(arriving.iter().count(), 0);
    }

    #[test]
    fn an_exercise_knows_its_course_and_what_comes_before_it() {
        let shelf = Shelf::read(&[course()]).expect("the shipped course");
        let second = shelf.exercises.get(1).and_then(|offer| offer.course.clone()).expect("its course");
        assert_eq!((second.place, second.prerequisites.len()), ([2, 7], 1), "{second:?}");
    }
}
