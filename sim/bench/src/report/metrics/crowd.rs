//! Virtual hands of known skill on the shipped exercises, judged.

use ::recording::Recording;
use assessment::{Assessment, Tryout};
use documents::{ExerciseBundle, Patient};
use law::operator::{Occasion, Operator, Skill};

use crate::error::BenchError;
use crate::progress::MeasurementProgress;

/// A shipped exercise and its scene.
macro_rules! shipped {
    ($exercise:literal, $scene:literal) => {
        (
            include_str!(concat!("../../../../../curricula/", $exercise, ".toml")),
            include_str!(concat!("../../../../../curricula/scenes/", $scene, ".toml")),
        )
    };
}

/// Exercises: stop in a layer, reach a depth, keep a direction between structures, and loss of
/// resistance.
const EXERCISES: [(&str, &str); 4] = [
    shipped!("lower-back-basics/2-stop-in-the-fat", "lower-back-training"),
    shipped!("lower-back-basics/3-reach-the-muscle", "lower-back-training"),
    shipped!("lower-back-basics/6-avoid-the-vessel", "lower-back-vessel"),
    shipped!("lumbar-epidural/1-stop-in-the-epidural-space", "epidural-71kg"),
];

/// Size of the simulated groups.
#[derive(Clone, Copy)]
pub struct Size {
    /// Number of exercises.
    pub exercises: usize,
    /// Number of novices, and of experts, with one attempt each.
    pub group: usize,
    /// Number of people with skills from novice to expert who repeat on other days.
    pub people: usize,
    /// Number of days on which they try.
    pub attempts: usize,
}

impl Size {
    /// Size for a complete report.
    pub const FULL: Self = Self { exercises: EXERCISES.len(), group: 24, people: 16, attempts: 4 };
    /// Smallest size for which every figure can be computed.
    pub const QUICK: Self = Self { exercises: 1, group: 3, people: 3, attempts: 2 };

    fn all(&self) -> usize {
        self.exercises * (2 * self.group + self.people * (self.attempts + 1))
    }
}

/// Attempts at one exercise.
pub struct Crowd {
    /// One attempt of each novice.
    pub novices: Vec<Assessment>,
    /// One attempt of each expert.
    pub experts: Vec<Assessment>,
    /// The attempts of each person.
    pub again: Vec<Vec<Assessment>>,
    /// The people's first attempts without tremor.
    pub steady: Vec<Assessment>,
    /// The people's first attempts as recorded at a quarter of the rate.
    pub slow: Vec<Assessment>,
}

/// Simulates the groups on every exercise.
///
/// # Errors
/// If an embedded document is refused, or if an attempt cannot be judged.
pub fn crowds(size: Size) -> Result<Vec<Crowd>, BenchError> {
    let progress = MeasurementProgress::new(size.all() as u64, "metrics");
    EXERCISES[..size.exercises]
        .iter()
        .map(|(exercise, scene)| Lesson::new(exercise, scene, &progress)?.crowd(size))
        .collect()
}

/// An exercise with the progress bar.
struct Lesson<'a> {
    bundle: ExerciseBundle,
    progress: &'a MeasurementProgress,
}

impl<'a> Lesson<'a> {
    fn new(exercise: &str, scene: &str, progress: &'a MeasurementProgress) -> Result<Self, BenchError> {
        Ok(Self { bundle: ExerciseBundle::from_parts(exercise.as_bytes(), scene.as_bytes(), &[])?, progress })
    }

    fn crowd(&self, size: Size) -> Result<Crowd, BenchError> {
        let [novice, expert] = [Skill::novice(), Skill::expert()];
        let group = |skill: &Skill, from: u64| -> Result<Vec<Assessment>, BenchError> {
            (0..size.group as u64).map(|i| self.judge(&self.record(skill, Occasion::once(from + i))?)).collect()
        };
        let mut crowd = Crowd {
            novices: group(&novice, 1000)?,
            experts: group(&expert, 2000)?,
            again: Vec::new(),
            steady: Vec::new(),
            slow: Vec::new(),
        };
        for person in 0..size.people {
            let skill = novice.towards(&expert, person as f64 / (size.people - 1).max(1) as f64);
            let number = 3000 + 100 * person as u64;
            let on_day = |day: u64| Occasion { person: number, day, attempt: number + day };
            let first = self.record(&skill, on_day(0))?;
            crowd.slow.push(self.judge(&slower(&first))?);
            crowd.steady.push(self.judge(&self.record(&Skill { tremor_m: 0.0, ..skill }, on_day(0))?)?);
            let mut attempts = vec![self.judge(&first)?];
            for day in 1..size.attempts as u64 {
                attempts.push(self.judge(&self.record(&skill, on_day(day))?)?);
            }
            crowd.again.push(attempts);
        }
        Ok(crowd)
    }

    /// Simulates one attempt, on its own patient.
    fn record(&self, skill: &Skill, occasion: Occasion) -> Result<Recording, BenchError> {
        let patient = Patient::draw(&self.bundle.scene, occasion.attempt);
        let tryout = Tryout::new(&self.bundle, patient).map_err(BenchError::work)?;
        let recording = tryout.perform(&mut Operator::on(skill, &self.bundle.plan(), &occasion));
        self.progress.advance(1);
        Ok(recording)
    }

    fn judge(&self, recording: &Recording) -> Result<Assessment, BenchError> {
        assessment::assess(recording, &self.bundle).map_err(BenchError::work)
    }
}

/// Keeps every fourth sample.
fn slower(recording: &Recording) -> Recording {
    let mut slow = recording.clone();
    slow.samples = recording.samples.iter().step_by(4).copied().collect();
    slow
}
