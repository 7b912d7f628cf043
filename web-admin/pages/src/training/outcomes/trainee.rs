//! The outcomes of a trainee: evidence, the current level, and all decisions.

use askama::Template;
use askama_web::WebTemplate;
use model::training::outcome::LONGEST_NOTE;
use model::training::progress::Progress;
use time::OffsetDateTime;

use crate::{Shell, format};

/// The page of a trainee's outcomes.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/outcomes/trainee.html")]
pub struct TraineeOutcomesPage {
    /// Page frame.
    pub shell: Shell,
    /// Name of the trainee.
    pub name: String,
    /// Address of the trainee's page.
    pub href: String,
    /// Whether it is the visitor's own page.
    pub own: bool,
    /// The outcomes, by code.
    pub outcomes: Vec<OutcomeView>,
    /// Names of the levels, lowest first.
    pub levels: Vec<String>,
    /// Whether the visitor decides on levels.
    pub may_decide: bool,
    /// Why a decision was refused.
    pub refused: Option<String>,
}

impl TraineeOutcomesPage {
    /// Names a level.
    fn name_level(&self, level: &i64) -> String {
        level_words(&self.levels, *level)
    }
}

/// Returns number and name of a level.
#[must_use]
pub fn level_words(levels: &[String], level: i64) -> String {
    let name = usize::try_from(level - 1).ok().and_then(|at| levels.get(at));
    name.map_or_else(|| level.to_string(), |name| format!("{level} – {name}"))
}

/// An outcome, and what a trainee has shown.
#[derive(Clone, Debug, PartialEq)]
pub struct OutcomeView {
    /// Address of the form for a decision.
    pub decide_href: String,
    /// Code.
    pub code: String,
    /// Title.
    pub title: String,
    /// Description; may be empty.
    pub description: String,
    /// Evidence, by course.
    pub evidence: Vec<CourseEvidence>,
    /// Decisions, newest first.
    pub decisions: Vec<DecisionRow>,
}

impl OutcomeView {
    /// Returns the decision in force, if there is one.
    #[must_use]
    pub fn current(&self) -> Option<&DecisionRow> {
        self.decisions.first().filter(|decision| decision.level.is_some())
    }
}

/// A trainee's work in a course.
#[derive(Clone, Debug, PartialEq)]
pub struct CourseEvidence {
    /// Title of the course.
    pub title: String,
    /// Number of mastered exercises.
    pub mastered: usize,
    /// Number of exercises.
    pub exercises: usize,
    /// Number of passed attempts.
    pub passed: usize,
    /// Number of scored attempts.
    pub attempts: usize,
    /// Number of attempts that an instructor supervised.
    pub supervised: usize,
    /// Number of finished ratings of attempts.
    pub ratings: u32,
    /// Time of the last attempt.
    pub last_at: Option<OffsetDateTime>,
}

impl CourseEvidence {
    /// Summarizes the progress in a course, without supervision and ratings.
    #[must_use]
    pub fn new(title: &str, progress: &Progress) -> Self {
        let attempts = || progress.steps.iter().flat_map(|step| &step.attempts);
        Self {
            title: title.to_owned(),
            mastered: progress.mastered(),
            exercises: progress.steps.len(),
            passed: attempts().filter(|attempt| attempt.passed).count(),
            attempts: attempts().count(),
            supervised: 0,
            ratings: 0,
            last_at: progress.last_at,
        }
    }

    pub(super) fn mastered_words(&self) -> String {
        tr!("{mastered} of {all}", mastered = self.mastered, all = self.exercises)
    }
}

/// A decision on a level.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DecisionRow {
    /// Level, from 1; `None` if the entrustment ended.
    pub level: Option<i64>,
    /// Reason; may be empty.
    pub note: String,
    /// Name of who decided.
    pub by: String,
    /// Time.
    pub at: OffsetDateTime,
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::samples;
    use crate::training::outcomes::name_levels;

    fn page(role: Role) -> TraineeOutcomesPage {
        let decision = |level, day| DecisionRow {
            level,
            note: "Ten in the ward <alone>".to_owned(),
            by: "Dr Ek".to_owned(),
            at: samples::NOW - time::Duration::days(day),
        };
        let evidence =
            CourseEvidence { supervised: 2, ratings: 3, ..CourseEvidence::new("Lower back", &samples::progress()) };
        let outcome = |decisions| OutcomeView {
            decide_href: "/trainees/1/outcomes/2".to_owned(),
            code: "EPA 3".to_owned(),
            title: "Lumbar puncture".to_owned(),
            description: "From consent to documentation.".to_owned(),
            evidence: vec![evidence.clone()],
            decisions,
        };
        TraineeOutcomesPage {
            shell: samples::shell(role),
            name: "Ada".to_owned(),
            href: "/trainees/1".to_owned(),
            own: role == Role::Trainee,
            outcomes: vec![
                outcome(vec![decision(Some(4), 1), decision(Some(2), 90)]),
                outcome(vec![decision(None, 2)]),
            ],
            levels: name_levels(Vec::new()),
            may_decide: role != Role::Trainee,
            refused: None,
        }
    }

    #[test]
    fn teachers_decide_and_trainees_read() {
        let teacher = samples::keep_page("trainee-outcomes", &page(Role::Instructor));
        assert!(
            teacher.contains("Ten in the ward &#60;alone&#62;") && teacher.contains("4 – Acts without supervision")
        );
        assert_eq!(teacher.matches("action=\"/trainees/1/outcomes/2\"").count(), 2, "{teacher}");
        let own = samples::keep_page("own-outcomes", &page(Role::Trainee));
        assert!(!own.contains("action=\"/trainees/") && own.contains("4 – Acts without supervision"));
    }

    #[test]
    fn an_ended_entrustment_is_not_in_force() {
        let page = page(Role::Trainee);
        assert_eq!(page.outcomes.iter().map(|outcome| outcome.current().is_some()).collect::<Vec<_>>(), [true, false]);
        assert_eq!(level_words(&page.levels, 9), "9", "a level without a name");
    }
}
