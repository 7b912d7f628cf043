//! Cohorts: the progress of their trainees, and who needs help.

use askama::Template;
use askama_web::WebTemplate;
use model::Role;
use model::training::cohort::CohortSummary;
use model::training::progress::{Progress, StepProgress, StepState};
use model::training::risk::Concern;
use time::OffsetDateTime;

use crate::form::SelectOption;
use crate::people::listed::ListPart;
use crate::training::addresses::exercise_href;
use crate::training::assignments::DueLine;
use crate::training::concern::say_concern;
use crate::training::trainee::{CourseFacts, score_points};
use crate::{Shell, StatusWord, charts, format};

/// The page of a cohort.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/cohort.html")]
pub struct CohortPage {
    /// Page frame.
    pub shell: Shell,
    /// Address of the cohort's page.
    pub href: String,
    /// Address of its people at risk.
    pub risk_href: String,
    /// The cohort's name.
    pub name: String,
    /// Names of its instructors.
    pub instructors: Vec<String>,
    /// What its trainees come to.
    pub figures: CohortFigures,
    /// Those who are at risk, the most pressing first, as many as the page shows.
    pub help: Vec<TraineeRow>,
    /// What is assigned to it and to its trainees.
    pub due_lines: Vec<DueLine>,
    /// The school's courses, one of them chosen.
    pub courses: Vec<SelectOption>,
    /// The cohort in the chosen course; none where none is taught.
    pub course: Option<CourseShare>,
    /// Those of the trainees whom the page shows, by name.
    pub trainees: Vec<TraineeRow>,
    /// Which they are.
    pub list: ListPart,
    /// Now, for "… days ago".
    pub now: OffsetDateTime,
}

/// What the trainees of a cohort come to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CohortFigures {
    /// Trainees.
    pub trainees: usize,
    /// Those who may need help.
    pub help: usize,
    /// Those who have begun the chosen course.
    pub begun: usize,
    /// Those who have mastered it.
    pub complete: usize,
    /// Scored attempts at its exercises.
    pub attempts: usize,
}

impl CohortFigures {
    /// Counts the standing of everybody in a course, and how many need help.
    #[must_use]
    pub fn new(in_course: &[&Progress], help: usize) -> Self {
        Self {
            trainees: in_course.len(),
            help,
            begun: in_course.iter().filter(|progress| progress.attempts() > 0).count(),
            complete: in_course.iter().filter(|progress| progress.complete()).count(),
            attempts: in_course.iter().map(|progress| progress.attempts()).sum(),
        }
    }
}

/// The list of cohorts.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/cohorts.html")]
pub struct CohortsPage {
    /// Page frame.
    pub shell: Shell,
    /// Cohorts by name.
    pub cohorts: Vec<CohortLine>,
    /// Whether this is a page after the first.
    pub later: bool,
    /// Address of the next page.
    pub next: Option<String>,
}

/// A cohort in a list.
#[derive(Clone, Debug, PartialEq)]
pub struct CohortLine {
    /// Address of its page.
    pub href: String,
    /// Its name.
    pub name: String,
    /// Number of trainees.
    pub trainees: i64,
    /// Number of the trainees' scored attempts.
    pub attempts: i64,
    /// Share of the attempts that passed, 0–1; `None` without attempts.
    passed: Option<f64>,
}

impl CohortLine {
    /// Creates a list entry from a cohort's summary.
    #[must_use]
    pub fn new(cohort: CohortSummary) -> Self {
        let CohortSummary { id, name, trainees, attempts, passes } = cohort;
        let passed = (attempts > 0).then(|| passes as f64 / attempts as f64);
        Self { href: format!("/cohorts/{id}"), name, trainees, attempts, passed }
    }

    /// Returns the share that passed, as a bar and as text.
    #[must_use]
    pub fn passed(&self) -> Option<(String, String)> {
        self.passed.map(|share| (charts::draw_share_bar(share), format::format_percent(share)))
    }
}

/// Summary of a cohort.
#[derive(Clone, Debug, PartialEq)]
pub struct CohortCard {
    /// Address of its page.
    pub href: String,
    /// Its name.
    pub name: String,
    /// Number of trainees.
    pub trainees: usize,
    /// How many of them have mastered a course.
    pub complete: usize,
    /// Number of trainees who may need help.
    pub help: usize,
    /// Share of mastered exercises over all trainees and exercises, 0–1.
    pub mastered: f64,
}

/// A trainee and their page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedTrainee {
    /// Their page.
    pub href: String,
    /// Their name.
    pub name: String,
}

/// A trainee of a cohort.
#[derive(Clone, Debug)]
pub struct TraineeRow {
    /// Address of the trainee's page.
    pub href: String,
    /// Their name.
    pub name: String,
    /// Number of exercises mastered, and number of exercises.
    pub mastered: (usize, usize),
    /// Mastery strip: one square per exercise.
    pub strip: String,
    /// Title and address of the current exercise.
    pub doing: Option<(String, String)>,
    /// Number of scored attempts.
    pub attempts: usize,
    /// Time of the latest attempt.
    pub last_at: Option<OffsetDateTime>,
    /// Sparkline of the scores on the current exercise, if there are any.
    pub spark: Option<String>,
    /// Status in the course.
    pub status: StatusWord,
    /// Reasons why the trainee may need help: kind and reason.
    pub concerns: Vec<(&'static str, String)>,
}

/// Progress of a cohort in a course.
#[derive(Clone, Debug)]
pub struct CourseShare {
    /// The course's title.
    pub title: String,
    /// Its exercises in order.
    pub exercises: Vec<ExerciseShare>,
}

/// Progress of a cohort on an exercise.
#[derive(Clone, Debug)]
pub struct ExerciseShare {
    /// Address of the exercise's page.
    pub href: String,
    /// Its title.
    pub title: String,
    /// Number of trainees who mastered it.
    pub mastered: usize,
    /// Share of these trainees, as a bar.
    pub bar: String,
    /// Names of the trainees currently working on it.
    pub here: Vec<String>,
    /// Number of scored attempts.
    pub attempts: usize,
    /// Number of passed attempts.
    pub passes: usize,
}

impl CohortPage {
    /// Cards of trainees who may need help that stand on a page.
    pub const HELP_SHOWN: usize = 12;

    /// How many more need help than the page shows.
    fn unshown_help(&self) -> usize {
        self.figures.help.saturating_sub(self.help.len())
    }
}

impl TraineeRow {
    /// A trainee's standing in a course, and why they may need help in any.
    #[must_use]
    pub fn new(who: NamedTrainee, facts: &CourseFacts<'_>, progress: &Progress, concerns: &[Concern]) -> Self {
        let NamedTrainee { href, name } = who;
        let doing = progress.next.map(|i| &facts.course.steps[i]);
        let current = progress.next.map(|i| &progress.steps[i]);
        let strip =
            progress.steps.iter().map(|s| (matches!(s.state, StepState::Mastered { .. }), !s.attempts.is_empty()));
        let mark = progress.next.and_then(|i| facts.pass_marks.get(i)).copied().unwrap_or(0.0);
        Self {
            href,
            name,
            mastered: (progress.mastered(), progress.steps.len()),
            strip: charts::draw_mastery_strip(&strip.collect::<Vec<_>>()),
            doing: doing.map(|step| (step.title.clone(), exercise_href(&step.exercise))),
            attempts: progress.attempts(),
            last_at: progress.last_at,
            spark: current
                .filter(|s| !s.attempts.is_empty())
                .map(|s| charts::draw_sparkline(&score_points(&s.attempts), mark)),
            status: standing_in_course(progress, concerns),
            concerns: concerns.iter().map(say_concern).collect(),
        }
    }
}

fn standing_in_course(progress: &Progress, concerns: &[Concern]) -> StatusWord {
    if !concerns.is_empty() {
        StatusWord::Help
    } else if progress.complete() {
        StatusWord::Complete
    } else if progress.attempts() == 0 {
        StatusWord::NotBegun
    } else {
        StatusWord::OnTrack
    }
}

impl CourseShare {
    /// Summarizes the progress of trainees in a course.
    #[must_use]
    pub fn new(facts: &CourseFacts<'_>, trainees: &[(&str, &Progress)]) -> Self {
        let exercises = (0..facts.course.steps.len()).map(|i| exercise_share(facts, trainees, i)).collect();
        Self { title: facts.title.to_owned(), exercises }
    }
}

fn exercise_share(facts: &CourseFacts<'_>, trainees: &[(&str, &Progress)], index: usize) -> ExerciseShare {
    let step = &facts.course.steps[index];
    let done = || trainees.iter().map(|(_, progress)| &progress.steps[index]);
    let mastered = done().filter(|s| matches!(s.state, StepState::Mastered { .. })).count();
    let is_here = |progress: &Progress| progress.attempts() > 0 && progress.next == Some(index);
    let here = trainees.iter().filter(|(_, p)| is_here(p)).map(|(name, _)| (*name).to_owned()).collect();
    ExerciseShare {
        href: exercise_href(&step.exercise),
        title: step.title.clone(),
        mastered,
        bar: charts::draw_share_bar(mastered as f64 / trainees.len().max(1) as f64),
        here,
        attempts: done().map(|s| s.attempts.len()).sum(),
        passes: done().map(StepProgress::passes).sum(),
    }
}

/// Names on a line before the rest is counted.
const NAMED: usize = 8;

impl ExerciseShare {
    /// Who is working on it, in words.
    fn say_here(&self) -> String {
        let named = self.here.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
        match self.here.len().saturating_sub(NAMED) {
            0 => named,
            more => trn!("{named} and {n} more", "{named} and {n} more", more, named = named),
        }
    }
}

impl CohortCard {
    /// A cohort in short, from the standing of its trainees in the courses that they are on.
    #[must_use]
    pub fn new<'a>(href: String, name: String, trainees: impl Iterator<Item = &'a Progress>) -> Self {
        let mut card = Self { href, name, trainees: 0, complete: 0, help: 0, mastered: 0.0 };
        let (mut mastered, mut all) = (0, 0);
        for progress in trainees {
            (mastered, all) = (mastered + progress.mastered(), all + progress.steps.len());
            card.trainees += 1;
        }
        card.mastered = mastered as f64 / all.max(1) as f64;
        card
    }

    /// Returns the share of mastered exercises as a bar.
    #[must_use]
    pub fn bar(&self) -> String {
        charts::draw_share_bar(self.mastered)
    }

    /// Describes how many trainees may need help.
    #[must_use]
    pub fn help_words(&self) -> String {
        trn!("{n} needs help", "{n} need help", self.help)
    }

    /// Returns the share of mastered exercises as text.
    #[must_use]
    pub fn percent(&self) -> String {
        format::format_percent(self.mastered)
    }
}

#[cfg(test)]
mod tests {
    //! An instructor must see who needs help and why on a single page.

    use model::ids::CohortId;

    use super::*;
    use crate::samples;

    #[test]
    fn tells_who_is_where_and_who_needs_help() {
        let page = samples::cohort_page();
        let html = samples::keep_page("cohort", &page);
        assert!(!page.help.is_empty());
        for row in &page.help {
            assert!(html.contains(&row.concerns[0].1), "the reason of {}", row.name);
        }
        assert!(html.contains("Needs help") && html.contains("On track") && html.contains("<caption"));
    }

    #[test]
    fn a_cohort_without_trainees_says_what_to_do() {
        let page =
            CohortPage { figures: CohortFigures::default(), help: vec![], trainees: vec![], ..samples::cohort_page() };
        assert!(samples::keep_page("cohort-empty", &page).contains("This cohort is empty"));
    }

    #[test]
    fn cohort_page_lists_a_few_in_need_of_help_and_counts_the_rest() {
        let sample = samples::cohort_page();
        let figures = CohortFigures { help: 480, ..sample.figures };
        let html = samples::keep_page("cohort-help", &CohortPage { figures, ..sample });
        assert!(html.contains("478 more people need help") && html.contains("/at-risk?cohort=1"), "{html}");
    }

    #[test]
    fn the_list_links_each_cohort() {
        let line = |name: &str, attempts| {
            let id = CohortId::nil();
            CohortLine::new(CohortSummary { id, name: name.to_owned(), trainees: 12, attempts, passes: attempts / 2 })
        };
        let page = CohortsPage {
            shell: samples::shell(Role::Instructor),
            cohorts: vec![line("Spring <1>", 40), line("Summer", 0)],
            later: true,
            next: Some("/cohorts?after=Summer".to_owned()),
        };
        let html = samples::keep_page("cohorts", &page);
        assert!(
            html.contains(r#"href="/cohorts/0000"#) && html.contains("50\u{a0}%") && html.contains("More"),
            "{html}"
        );
        let empty = CohortsPage { cohorts: vec![], later: false, next: None, ..page };
        assert!(samples::keep_page("cohorts-empty", &empty).contains("No cohorts yet"));
    }
}
