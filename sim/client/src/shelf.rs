//! The catalogue of exercises: those in the given files and folders, their courses, and the
//! documents that cannot be used.

use std::fs;
use std::path::{Path, PathBuf};

use assessment::learning::Mastery;
use documents::{Curriculum, Document, ExerciseBundle, Wording};

use crate::exit::Failure;

/// The catalogue.
#[derive(Default)]
pub struct Shelf {
    /// Exercises without duplicates, in order.
    pub exercises: Vec<Offer>,
    /// Documents that cannot be used.
    pub broken: Vec<Broken>,
}

/// An entry of the catalogue.
#[derive(Clone)]
pub struct Offer {
    /// The exercise.
    pub bundle: ExerciseBundle,
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
    /// Reads files and folders. Documents that cannot be used are listed, and do not prevent the
    /// use of the others. Scenes and instruments in a folder are skipped, since courses have their
    /// scenes next to them.
    ///
    /// # Errors
    /// If there is no exercise in the given files and folders.
    pub fn read(paths: &[PathBuf]) -> Result<Self, Failure> {
        let mut shelf = Self::default();
        for path in paths {
            if path.is_dir() {
                shelf.take_folder(path);
            } else {
                let refused =
                    |kind| Failure::refused(path, format_args!("is {kind}; allowed: an exercise or a curriculum"));
                match documents::load::read_document(path) {
                    Ok(Document::Scene(_)) => shelf.put_aside(path, &refused("a scene")),
                    Ok(Document::Instrument(_)) => shelf.put_aside(path, &refused("an instrument")),
                    Ok(document) => shelf.take(path, document),
                    Err(error) => shelf.put_aside(path, &Failure::from(error)),
                }
            }
        }
        match (shelf.exercises.is_empty(), shelf.broken.is_empty()) {
            (false, _) => Ok(shelf),
            (true, true) => Err(Failure::input("no exercise found in the given files and folders")),
            (true, false) => Err(Failure::Input(shelf.broken.into_iter().map(|broken| broken.why).collect())),
        }
    }

    fn take_folder(&mut self, folder: &Path) {
        let listed = match fs::read_dir(folder) {
            Ok(listed) => listed,
            Err(error) => return self.put_aside(folder, &Failure::refused(folder, error)),
        };
        let mut paths: Vec<PathBuf> = listed.flatten().map(|entry| entry.path()).collect();
        paths.sort();
        for path in paths {
            if path.is_dir() {
                self.take_folder(&path);
            } else if path.extension().is_some_and(|extension| extension == "toml") {
                match documents::load::read_document(&path) {
                    Ok(document) => self.take(&path, document),
                    Err(error) => self.put_aside(&path, &Failure::from(error)),
                }
            }
        }
    }

    fn take(&mut self, path: &Path, document: Document) {
        match document {
            Document::Exercise(bundle) => self.offer(Offer { bundle: *bundle, course: None }),
            Document::Curriculum(course, bundles) => {
                let mastery = Mastery::from_rule(&course.mastery);
                for bundle in bundles {
                    let course = mastery.ok().and_then(|mastery| place(&course, &bundle.exercise.id, mastery));
                    self.offer(Offer { bundle, course });
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
    fn an_exercise_knows_its_course_and_what_comes_before_it() {
        let shelf = Shelf::read(&[course()]).expect("the shipped course");
        let second = shelf.exercises.get(1).and_then(|offer| offer.course.clone()).expect("its course");
        assert_eq!((second.place, second.prerequisites.len()), ([2, 7], 1), "{second:?}");
    }
}
