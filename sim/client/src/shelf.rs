//! What there is to practise: the exercises of the files and folders that were named, their courses, and what could not be read.

use std::fs;
use std::path::{Path, PathBuf};

use assessment::learning::Mastery;
use documents::{Curriculum, Document, ExerciseBundle, Wording};

use crate::exit::Failure;

/// What was found.
#[derive(Default)]
pub struct Shelf {
    /// Each exercise once, in order.
    pub exercises: Vec<Offer>,
    /// Documents that cannot be used.
    pub broken: Vec<Broken>,
}

/// An exercise that is offered.
#[derive(Clone)]
pub struct Offer {
    /// The exercise.
    pub bundle: ExerciseBundle,
    /// Its place in a course, where it is part of one that was found.
    pub course: Option<CoursePlace>,
}

/// Where an exercise stands in a course.
#[derive(Clone, Debug, PartialEq)]
pub struct CoursePlace {
    /// Title of the course.
    pub title: Wording,
    /// Its place, from 1, and how many there are.
    pub place: [usize; 2],
    /// Ids of the exercises to master first.
    pub prerequisites: Vec<String>,
    /// When one of them counts as mastered.
    pub mastery: Mastery,
}

/// A document that cannot be used, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Broken {
    /// The file.
    pub path: PathBuf,
    /// In one line.
    pub why: String,
}

impl Shelf {
    /// Reads files and folders. What is broken is listed, so that it does not stop what is not; what is no exercise is passed over in a
    /// folder, for courses' scenes lie beside them.
    ///
    /// # Errors
    /// When nothing that was named can be practised.
    pub fn read(paths: &[PathBuf]) -> Result<Self, Failure> {
        let mut shelf = Self::default();
        for path in paths {
            if path.is_dir() {
                shelf.take_folder(path);
            } else {
                let refused =
                    |kind| Failure::refused(path, format_args!("is {kind}; an exercise or a curriculum is needed"));
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
            (true, true) => Err(Failure::input("no exercise found in what was named")),
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

    /// Offers an exercise, once.
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
    //! One file that cannot be read must not keep a trainee from all the others, and must not vanish either.

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
