//! A trainee's training: their own home, and what an instructor sees of it.

use askama::Template;
use askama_web::WebTemplate;
use model::assignment::AssignmentStage;
use model::membership::MembershipRequest;
use model::progress::{Course, CurveRule, Mastery, Progress, ScoredAttempt, StepProgress, StepState};
use model::{Needed, Role, Uncounted};
use time::OffsetDateTime;

use super::charts::{self, ScorePoint};
use super::concern::say_concern;
use super::listed::PageNumbers;
use super::progress::HabitsView;
use super::session::uncounted_in_short;
use super::{Shell, StatusWord, format};
use crate::addresses::exercise_href;

/// A trainee's home.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "trainee.html")]
pub struct TraineePage {
    /// Frame.
    pub shell: Shell,
    /// The trainee's name.
    pub name: String,
    /// The trainee is the visitor.
    pub own: bool,
    /// What is new for the visitor, on their own page.
    pub news: Vec<super::news::NewsItem>,
    /// What is assigned to the trainee and not done, what is due first before.
    pub due: Vec<super::assignments::AssignmentRow>,
    /// Where the transcript is.
    pub transcript: String,
    /// Who asks to have the visitor in a cohort.
    pub requests: Vec<MembershipRequest>,
    /// Cohorts, by name.
    pub cohorts: Vec<String>,
    /// Courses that they have begun, the one in progress first; before any attempt the school's first.
    pub courses: Vec<CourseView>,
    /// The school's other courses.
    pub others: Vec<CourseView>,
    /// What costs most, and what costs nothing, over the latest attempts.
    pub habits: HabitsView,
    /// Latest attempts, newest first.
    pub attempts: Vec<OwnAttemptRow>,
    /// Which stretch of the attempts this is.
    pub pages: PageNumbers,
    /// On the visitor's own page: since when they have had a sign-in code, if they have one.
    pub sign_in_code: Option<Option<OffsetDateTime>>,
}

/// A sign-in code that was just made.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "sign_in_code.html")]
pub struct SignInCodePage {
    /// Frame.
    pub shell: Shell,
    /// The code.
    pub code: String,
    /// For how long it is shown, in min.
    pub minutes: i64,
}

impl SignInCodePage {
    fn shown_for(&self) -> String {
        trn!("This page shows it for {n} minute.", "This page shows it for {n} minutes.", self.minutes)
    }
}

/// How far a trainee has come in a course.
#[derive(Clone, Debug)]
pub struct CourseView {
    /// Title.
    pub title: String,
    /// Where a certificate is issued, once everything is mastered.
    pub certificate: Option<String>,
    /// What must be proved of the attempts that certify, in words, where everything is mastered and too little is proved.
    pub unproved: Option<&'static str>,
    /// The mastery rule in words.
    pub rule: String,
    /// What to do next.
    pub next: Option<NextStep>,
    /// Exercises mastered.
    pub mastered: usize,
    /// The course is mastered.
    pub complete: bool,
    /// Since when, where it is mastered by an earlier revision.
    pub mastered_before: Option<OffsetDateTime>,
    /// Why help may be needed.
    pub concerns: Vec<(&'static str, String)>,
    /// Exercises in order.
    pub steps: Vec<CourseStepRow>,
    /// Score over time, title and drawing, one per exercise tried.
    pub charts: Vec<(String, String)>,
}

/// What to do next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NextStep {
    /// Page of the exercise.
    pub href: String,
    /// Its title.
    pub title: String,
    /// Why this one, and how far it is from mastery.
    pub why: String,
}

/// An exercise of a course.
#[derive(Clone, Debug)]
pub struct CourseStepRow {
    /// Page of the exercise.
    pub href: String,
    /// Page of the trainee's learning curve on it, once there is one.
    pub curve_href: Option<String>,
    /// Its title.
    pub title: String,
    /// How it stands.
    pub status: StatusWord,
    /// More about how it stands.
    pub detail: String,
    /// Scored attempts.
    pub attempts: usize,
    /// Attempts passed.
    pub passes: usize,
    /// Best score, 0–100.
    pub best: Option<f64>,
    /// Scores as a small line.
    pub spark: String,
}

/// An attempt in a list.
#[derive(Clone, Debug)]
pub struct OwnAttemptRow {
    /// Page of the attempt.
    pub href: String,
    /// When it began.
    pub at: OffsetDateTime,
    /// Who tried, where the list mixes people.
    pub trainee: Option<String>,
    /// Title of the exercise.
    pub exercise: String,
    /// How it stands.
    pub status: StatusWord,
    /// 0–100, once scored.
    pub score: Option<f64>,
    /// The computed score, 0–100, where somebody has put another in its place.
    pub computed: Option<f64>,
    /// What cost most.
    pub note: String,
    /// The re-simulation differs.
    pub flagged: bool,
    /// Why it counts nowhere; absent where it counts.
    pub uncounted: Option<Uncounted>,
}

/// What a course view is made of.
#[derive(Clone, Copy, Debug)]
pub struct CourseFacts<'a> {
    /// The trainee's page, where the facts are for one trainee.
    pub trainee: Option<&'a str>,
    /// The course's id.
    pub id: &'a str,
    /// Title.
    pub title: &'a str,
    /// Exercises and rule.
    pub course: &'a Course,
    /// The pass mark of each exercise, 0–100, in the course's order.
    pub pass_marks: &'a [f64],
}

impl OwnAttemptRow {
    /// Why it counts nowhere, in a few words.
    #[must_use]
    pub fn uncounted_words(&self) -> Option<&'static str> {
        self.uncounted.map(uncounted_in_short)
    }
}

impl TraineePage {
    /// What the table of attempts is called.
    #[must_use]
    pub fn attempts_caption(&self) -> String {
        trn!("{n} attempt in all, newest first", "{n} attempts in all, newest first", self.pages.entries)
    }
}

impl CourseView {
    /// Puts progress into words and drawings. `key` keeps the drawings' ids apart between courses.
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
            concerns: progress.concerns.iter().map(|c| say_concern(c)).collect(),
            steps,
            charts,
        }
    }
}

/// What a school asks to be proved of an attempt that certifies, in words.
#[must_use]
pub fn needed_in_words(needed: Needed) -> &'static str {
    match needed {
        Needed::Nothing => tr!("every scored attempt"),
        Needed::Resimulated => tr!("attempts whose re-simulation is identical"),
        Needed::SignedOrSupervised => tr!("attempts that a paired station has signed, or that were supervised"),
        Needed::Supervised => tr!("attempts that were supervised"),
    }
}

/// The mastery rule in words.
#[must_use]
pub fn rule_in_words(rule: &Mastery) -> String {
    match *rule {
        Mastery::Passes { passes, of } if passes == of => {
            trn!("mastered with {n} pass in a row", "mastered with {n} passes in a row", passes)
        }
        Mastery::Passes { passes, of } => {
            tr!("mastered with {passes} passes among {of} attempts in a row", passes = passes, of = of)
        }
        Mastery::Curve(curve) => curve_in_words(&curve),
    }
}

fn curve_in_words(CurveRule { params, .. }: &CurveRule) -> String {
    let percent = |share: f64| format::format_fixed(share * 100.0, 0);
    tr!(
        "mastered when its learning curve shows at most {acceptable} % failures rather than {unacceptable} %",
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
                "Mastered before, and lost again: one more success will show it anew.",
                "Mastered before, and lost again: {n} more straight successes will show it anew.",
                curve.successes_needed
            )
        }
        (_, _, Some(curve)) if !done.attempts.is_empty() => {
            trn!(
                "One more success will show mastery.",
                "{n} more straight successes will show mastery.",
                curve.successes_needed
            )
        }
        _ => tr!("Not tried yet.").to_owned(),
    };
    NextStep { href: exercise_href(&step.exercise), title: step.title.clone(), why }
}

/// The points of a score chart.
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

/// What a learning curve still asks for.
fn still_needed(done: &StepProgress) -> String {
    done.curve.as_ref().map_or_else(String::new, |curve| {
        trn!("one more success", "{n} more straight successes", curve.successes_needed)
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
    //! The home must tell what to do next and why, and be useful before the first attempt.

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
        assert!(html.contains("Not tried yet.") && html.contains("No attempts yet"), "{html}");
    }

    #[test]
    fn a_sign_in_code_is_offered_to_its_owner_alone() {
        let own = |made| TraineePage { sign_in_code: Some(made), ..samples::trainee_page(true) };
        assert!(samples::keep_page("trainee-without-code", &own(None)).contains("Make a sign-in code"));
        assert!(samples::keep_page("trainee-with-code", &own(Some(samples::NOW))).contains("Replace the code"));
        let seen = samples::keep_page("trainee-for-instructor", &samples::trainee_page(false));
        assert!(!seen.contains("sign-in-code"), "{seen}");
        let page = SignInCodePage { shell: samples::shell(Role::Trainee), code: "ABC-DEF".to_owned(), minutes: 10 };
        assert!(samples::keep_page("sign-in-code", &page).contains("ABC-DEF"));
    }

    #[test]
    fn rules_are_said_in_words() {
        let rule = |passes, of| rule_in_words(&Mastery::Passes { passes, of });
        assert_eq!(rule(3, 5), "mastered with 3 passes among 5 attempts in a row");
        assert_eq!(rule(3, 3), "mastered with 3 passes in a row");
        assert_eq!(rule(1, 1), "mastered with 1 pass in a row");
    }
}
