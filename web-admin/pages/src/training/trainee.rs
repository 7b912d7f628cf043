//! A trainee's page: the trainee's own home page, and the instructor's view of it.

use askama::Template;
use askama_web::WebTemplate;
use model::training::assignment::AssignmentStage;
use model::training::membership::MembershipRequest;
use model::training::progress::{Course, CurveRule, Mastery, Progress, ScoredAttempt, StepProgress, StepState};
use model::{Needed, Role, Uncounted};
use time::OffsetDateTime;

use crate::charts::ScorePoint;
use crate::people::listed::PageNumbers;
use crate::recordings::session::uncounted_in_short;
use crate::training::addresses::exercise_href;
use crate::training::progress::HabitsView;
use crate::training::risk::SupportNoteRow;
use crate::{Shell, StatusWord, charts, format};

/// A trainee's page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/trainee.html")]
pub struct TraineePage {
    /// Page frame.
    pub shell: Shell,
    /// The trainee's name.
    pub name: String,
    /// Whether the trainee is the visitor.
    pub own: bool,
    /// News for the visitor, on their own page; else empty.
    pub news: Vec<crate::letters::news::NewsItem>,
    /// For those who teach the trainee: the reasons why they are at risk.
    pub concerns: Vec<(&'static str, String)>,
    /// What was done for them; for the trainee: the messages.
    pub notes: Vec<SupportNoteRow>,
    /// Where those who teach the trainee record it.
    pub support_href: Option<String>,
    /// Assignments that are not done, by due date.
    pub due: Vec<crate::training::assignments::AssignmentRow>,
    /// Address of the transcript.
    pub transcript: String,
    /// Address of the outcomes, if the school has some.
    pub outcomes: Option<String>,
    /// Open requests to add the visitor to a cohort.
    pub requests: Vec<MembershipRequest>,
    /// Names of cohorts, in order.
    pub cohorts: Vec<String>,
    /// Courses the trainee has begun, the current one first; before the first attempt, the school's
    /// first course.
    pub courses: Vec<CourseView>,
    /// The school's other courses.
    pub others: Vec<CourseView>,
    /// The lines that lose most points, and those that lose almost none, over the latest attempts.
    pub habits: HabitsView,
    /// Latest attempts, newest first.
    pub attempts: Vec<OwnAttemptRow>,
    /// Position in the list of attempts.
    pub pages: PageNumbers,
    /// On the visitor's own page: when their sign-in code was created, if they have one.
    pub sign_in_code: Option<Option<OffsetDateTime>>,
}

/// A newly created sign-in code.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/sign_in_code.html")]
pub struct SignInCodePage {
    /// Page frame.
    pub shell: Shell,
    /// The code.
    pub code: String,
    /// Minutes for which the page shows it.
    pub minutes: i64,
}

impl SignInCodePage {
    fn shown_for(&self) -> String {
        trn!("This page shows the code for {n} minute.", "This page shows the code for {n} minutes.", self.minutes)
    }
}

/// A trainee's progress in a course.
#[derive(Clone, Debug)]
pub struct CourseView {
    /// Title.
    pub title: String,
    /// Address that issues a certificate, once everything is mastered.
    pub certificate: Option<String>,
    /// Evidence required of certifying attempts, if everything is mastered but evidence is missing.
    pub unproved: Option<&'static str>,
    /// The mastery rule as text.
    pub rule: String,
    /// Recommended next step.
    pub next: Option<NextStep>,
    /// Number of exercises mastered.
    pub mastered: usize,
    /// The course is mastered.
    pub complete: bool,
    /// Since when, where it is mastered by an earlier revision.
    pub mastered_before: Option<OffsetDateTime>,
    /// Exercises in order.
    pub steps: Vec<CourseStepRow>,
    /// Scores over time for each exercise tried: title and drawing.
    pub charts: Vec<(String, String)>,
}

/// The recommended next step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NextStep {
    /// Address of the exercise's page.
    pub href: String,
    /// Title of the exercise.
    pub title: String,
    /// Reason for the recommendation, and what is missing for mastery.
    pub why: String,
}

/// An exercise in a course.
#[derive(Clone, Debug)]
pub struct CourseStepRow {
    /// Address of the exercise's page.
    pub href: String,
    /// Address of the trainee's learning curve, once there is an attempt.
    pub curve_href: Option<String>,
    /// Its title.
    pub title: String,
    /// Status.
    pub status: StatusWord,
    /// Details of the status.
    pub detail: String,
    /// Number of scored attempts.
    pub attempts: usize,
    /// Number of passed attempts.
    pub passes: usize,
    /// Best score, 0–100.
    pub best: Option<f64>,
    /// Sparkline of the scores.
    pub spark: String,
}

/// An attempt in a list.
#[derive(Clone, Debug)]
pub struct OwnAttemptRow {
    /// Address of the attempt's page.
    pub href: String,
    /// Start of the attempt.
    pub at: OffsetDateTime,
    /// Name of the trainee, if the list contains several people.
    pub trainee: Option<String>,
    /// Title of the exercise.
    pub exercise: String,
    /// Status.
    pub status: StatusWord,
    /// Score, 0–100, once scored.
    pub score: Option<f64>,
    /// Computed score, 0–100, if it was overridden.
    pub computed: Option<f64>,
    /// The largest loss of points.
    pub note: String,
    /// Whether the re-simulation differs.
    pub flagged: bool,
    /// Why it does not count; `None` if it does.
    pub uncounted: Option<Uncounted>,
}

/// Course data from which a course view is built.
#[derive(Clone, Copy, Debug)]
pub struct CourseFacts<'a> {
    /// Address of the trainee's page, if the facts are for a single trainee.
    pub trainee: Option<&'a str>,
    /// Id of the course.
    pub id: &'a str,
    /// Title.
    pub title: &'a str,
    /// Exercises and mastery rule.
    pub course: &'a Course,
    /// Pass mark of each exercise, 0–100, in the order of the course.
    pub pass_marks: &'a [f64],
}

impl OwnAttemptRow {
    /// Describes briefly why the attempt does not count.
    #[must_use]
    pub fn uncounted_words(&self) -> Option<&'static str> {
        self.uncounted.map(uncounted_in_short)
    }
}

impl TraineePage {
    /// Returns the caption of the table of attempts.
    #[must_use]
    pub fn attempts_caption(&self) -> String {
        trn!("{n} attempt in all, newest first", "{n} attempts in all, newest first", self.pages.entries)
    }
}

impl CourseView {
    /// Describes progress as text and drawings. `key` keeps the ids of drawings unique across
    /// courses.
    #[must_use]
    pub fn new(facts: &CourseFacts<'_>, progress: &Progress, key: usize) -> Self {
        let steps = (0..progress.steps.len()).map(|i| make_step_row(facts, progress, i)).collect();
        let tried = |i: &usize| !progress.steps[*i].attempts.is_empty();
        let charts =
            (0..progress.steps.len()).filter(tried).map(|i| draw_step_scores(facts, progress, key, i)).collect();
        Self {
            title: facts.title.to_owned(),
            certificate: facts
                .trainee
                .filter(|_| progress.complete())
                .map(|trainee| format!("{trainee}/certificates/{}", facts.id)),
            unproved: None,
            rule: rule_in_words(&facts.course.rule),
            next: progress.next.map(|i| make_next_step(facts.course, progress, i)),
            mastered: progress.mastered(),
            complete: progress.complete(),
            mastered_before: progress.earlier.is_some().then(|| progress.completed_on()).flatten(),
            steps,
            charts,
        }
    }
}

/// Describes the evidence that a school requires of certifying attempts.
#[must_use]
pub fn needed_in_words(needed: Needed) -> &'static str {
    match needed {
        Needed::Nothing => tr!("every scored attempt"),
        Needed::Resimulated => tr!("attempts whose re-simulation is identical"),
        Needed::SignedOrSupervised => tr!("attempts that a paired station has signed, or that were supervised"),
        Needed::Supervised => tr!("attempts that were supervised"),
    }
}

/// Describes the mastery rule.
#[must_use]
pub fn rule_in_words(rule: &Mastery) -> String {
    match *rule {
        Mastery::Passes { passes, of } if passes == of => {
            trn!("mastered with {n} pass in a row", "mastered with {n} passes in a row", passes)
        }
        Mastery::Passes { passes, of } => {
            tr!("mastered after {passes} passes within {of} consecutive attempts", passes = passes, of = of)
        }
        Mastery::Curve(curve) => curve_in_words(&curve),
    }
}

fn curve_in_words(CurveRule { params, .. }: &CurveRule) -> String {
    let percent = |share: f64| format::format_fixed(share * 100.0, 0);
    tr!(
        "mastered when the learning curve shows at most {acceptable} % failures rather than {unacceptable} %",
        acceptable = percent(params.p0),
        unacceptable = percent(params.p1)
    )
}

fn make_next_step(course: &Course, progress: &Progress, index: usize) -> NextStep {
    let step = &course.steps[index];
    let done = &progress.steps[index];
    let why = match (&done.state, &course.rule, &done.curve) {
        (StepState::Open { passes }, Mastery::Passes { passes: needed, of }, _) if !done.attempts.is_empty() => {
            tr!(
                "{passes} of the last {of} attempts passed; {needed} are needed.",
                passes = passes,
                of = of,
                needed = needed
            )
        }
        (StepState::Regressing { .. }, _, Some(curve)) => {
            trn!(
                "Was mastered, then lost: one more success restores it.",
                "Was mastered, then lost: {n} consecutive successes restore it.",
                curve.successes_needed
            )
        }
        (_, _, Some(curve)) if !done.attempts.is_empty() => {
            trn!("One more success to mastery.", "{n} more consecutive successes to mastery.", curve.successes_needed)
        }
        _ => tr!("Not attempted yet.").to_owned(),
    };
    NextStep { href: exercise_href(&step.exercise), title: step.title.clone(), why }
}

/// Returns the points of a score chart.
#[must_use]
pub fn score_points(attempts: &[ScoredAttempt]) -> Vec<ScorePoint> {
    attempts.iter().map(|a| ScorePoint { at: a.at, score: a.score, passed: a.passed }).collect()
}

fn make_step_row(facts: &CourseFacts<'_>, progress: &Progress, index: usize) -> CourseStepRow {
    let (step, done) = (&facts.course.steps[index], &progress.steps[index]);
    let (status, detail) = match &done.state {
        StepState::Mastered { on } => (StatusWord::Mastered, tr!("on {date}", date = format::format_date(*on))),
        StepState::Open { .. } if progress.next == Some(index) => (StatusWord::Current, still_needed(done)),
        StepState::Open { .. } => (StatusWord::Open, still_needed(done)),
        StepState::Locked { missing } => (StatusWord::Locked, tr!("after {missing}", missing = missing.join(", "))),
        StepState::Regressing { since, .. } => {
            (StatusWord::Regressing, tr!("since {date}", date = format::format_date(*since)))
        }
    };
    let curve = facts.trainee.filter(|_| !done.attempts.is_empty());
    CourseStepRow {
        href: exercise_href(&step.exercise),
        curve_href: curve.map(|trainee| format!("{trainee}/exercises/{}", step.exercise)),
        title: step.title.clone(),
        status,
        detail,
        attempts: done.attempts.len(),
        passes: done.passes(),
        best: done.best(),
        spark: charts::draw_sparkline(&score_points(&done.attempts), pass_mark_of_step(facts, index)),
    }
}

/// Describes how many successes the learning curve still requires.
fn still_needed(done: &StepProgress) -> String {
    done.curve.as_ref().map_or_else(String::new, |curve| {
        trn!("one more success", "{n} more consecutive successes", curve.successes_needed)
    })
}

fn pass_mark_of_step(facts: &CourseFacts<'_>, index: usize) -> f64 {
    facts.pass_marks.get(index).copied().unwrap_or(0.0)
}

fn draw_step_scores(facts: &CourseFacts<'_>, progress: &Progress, key: usize, index: usize) -> (String, String) {
    let points = score_points(&progress.steps[index].attempts);
    let title = facts.course.steps[index].title.clone();
    let drawing = charts::draw_scores(&points, pass_mark_of_step(facts, index), &format!("{key}-{index}"), &title);
    (title, drawing)
}

#[cfg(test)]
mod tests {
    //! The home page must show the next step with its reason, and be useful before the first
    //! attempt.

    use super::*;
    use crate::samples;

    #[test]
    fn the_own_home_says_what_is_next() {
        let html = samples::keep_page("trainee-home", &samples::trainee_page(true));
        assert!(html.contains("Do next") && html.contains("2 of the last 5 attempts passed; 3 are needed."), "{html}");
        assert!(html.contains("<caption"));
    }

    #[test]
    fn an_instructor_sees_the_reasons_for_help() {
        let html = samples::keep_page("trainee-for-instructor", &samples::trainee_page(false));
        assert!(html.contains("Ana Lindqvist") && html.contains("no attempt for"), "{html}");
    }

    #[test]
    fn a_newcomer_is_told_how_to_start() {
        let html = samples::keep_page("trainee-newcomer", &samples::newcomer_page());
        assert!(html.contains("Not attempted yet.") && html.contains("No attempts yet"), "{html}");
    }

    #[test]
    fn a_sign_in_code_is_offered_to_its_owner_alone() {
        let own = |made| TraineePage { sign_in_code: Some(made), ..samples::trainee_page(true) };
        assert!(samples::keep_page("trainee-without-code", &own(None)).contains("Create a sign-in code"));
        assert!(samples::keep_page("trainee-with-code", &own(Some(samples::NOW))).contains("Replace the code"));
        let seen = samples::keep_page("trainee-for-instructor", &samples::trainee_page(false));
        assert!(!seen.contains("sign-in-code"), "{seen}");
        let page = SignInCodePage { shell: samples::shell(Role::Trainee), code: "ABC-DEF".to_owned(), minutes: 10 };
        assert!(samples::keep_page("sign-in-code", &page).contains("ABC-DEF"));
    }

    #[test]
    fn rules_are_said_in_words() {
        let rule = |passes, of| rule_in_words(&Mastery::Passes { passes, of });
        assert_eq!(rule(3, 5), "mastered after 3 passes within 5 consecutive attempts");
        assert_eq!(rule(3, 3), "mastered with 3 passes in a row");
        assert_eq!(rule(1, 1), "mastered with 1 pass in a row");
    }
}
