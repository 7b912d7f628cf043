//! Sample data for the tests of the progress pages, from the fictitious school of the other
//! samples.

use assessment::learning::CusumParams;
use assessment::statistics::{summary, wilson};
use assessment::{Deduction, DeductionCause};
use documents::MasteryRule;
use model::Role;
use model::ids::RevisionId;
use model::training::progress::{Course, Habits, Mastery, Progress, ScoredAttempt};
use model::training::risk::Concern;
use time::Duration;

use super::{
    CohortProgressPage, Comparison, CourseHeat, CurveFacts, CurveRow, HabitsView, Hardness, HeatRow, LearningPage,
    MetricSpreadRow, MetricsPage, ScoredRow, SpreadTheme, Worry, make_heat_cell,
};
use crate::training::trainee::score_points;
use crate::{StatusWord, charts, samples};

fn by_curve() -> (Course, Mastery) {
    let CusumParams { p0, p1, alpha, beta } = CusumParams { p0: 0.2, p1: 0.4, alpha: 0.05, beta: 0.1 };
    let rule =
        Mastery::from_rule(&MasteryRule::Cusum { within: Some(50), p0, p1, alpha, beta }).expect("a rule with lines");
    (Course { rule, ..samples::course() }, rule)
}

/// Returns attempts at the first exercise on two revisions, of which one in seven failed.
fn practised(attempts: usize) -> Vec<ScoredAttempt> {
    let scores: Vec<(&str, f64)> =
        (0..attempts).map(|i| ("feel-the-layers", if i % 7 == 2 { 41.0 } else { 74.0 + (i % 9) as f64 })).collect();
    let mut made = samples::history(&scores, 1);
    if let Some(first) = made.first_mut() {
        first.revision = Some(RevisionId::from_u128(1));
    }
    made
}

fn habits() -> HabitsView {
    let lost = |overshoot, force| {
        [("overshoot_mm", overshoot), ("peak_force_n", force)]
            .map(|(metric, points)| Deduction {
                metric: metric.to_owned(),
                version: 1,
                points,
                cause: DeductionCause::NoSuchMetric,
            })
            .to_vec()
    };
    let attempts = [lost(12.0, 0.0), lost(18.0, 0.0), lost(9.0, 0.5)];
    let pages: Vec<String> = (0..attempts.len()).map(|i| format!("/sessions/{i}")).collect();
    HabitsView::new(Habits::of(&attempts.iter().map(Vec::as_slice).collect::<Vec<_>>()), &pages)
}

pub(super) fn learning_page(attempts: usize) -> LearningPage {
    let (course, rule) = by_curve();
    let step = Progress::of(&course, &practised(attempts)).steps.swap_remove(0);
    let Mastery::Curve(curve) = rule else { unreachable!("the sample's rule is a curve") };
    LearningPage {
        shell: samples::shell(Role::Trainee),
        trainee: ("Ana Lindqvist".to_owned(), "/trainees/1".to_owned()),
        own: true,
        exercise: ("Feel the layers".to_owned(), "/exercises/feel-the-layers".to_owned()),
        course: ("Lower back: first punctures".to_owned(), crate::training::trainee::rule_in_words(&rule)),
        status: StatusWord::Open,
        scores: charts::draw_scores(&score_points(&step.attempts), 60.0, "own", "Feel the layers"),
        curve: CurveFacts::new(&step, curve, "Learning curve"),
        beside: None,
        mixed: step.mixes_revisions(),
        passed: wilson(step.passes(), step.attempts.len()).ok(),
        habits: if attempts > 0 { habits() } else { HabitsView::default() },
        comparison: summary(&[61.0, 72.0, 78.0, 80.0, 91.0, 95.0])
            .ok()
            .filter(|_| attempts > 0)
            .map(|others| Comparison { cohort: "Spring 2026".to_owned(), own: 82.0, others }),
        rows: CurveRow::all(&step),
    }
}

/// Returns the same attempts in a course whose rule counts passes.
pub(super) fn learning_beside_passes(attempts: usize) -> LearningPage {
    let page = learning_page(attempts);
    let rule = crate::training::trainee::rule_in_words(&Mastery::Passes { passes: 3, of: 5 });
    LearningPage { curve: None, beside: page.curve, course: (page.course.0, rule), ..page }
}

pub(super) fn cohort_progress_page() -> CohortProgressPage {
    let course = samples::course();
    let people = [
        ("Ana Lindqvist", samples::ana()),
        ("Bruno Ferrari", samples::history(&[("feel-the-layers", 22.0); 5], 3)),
        ("Dorothea Achterberg-Nakamura", vec![]),
    ];
    let judged = people.map(|(name, attempts)| (name, Progress::of(&course, &attempts)));
    let row = |(name, progress): &(&str, Progress)| HeatRow {
        name: (*name).to_owned(),
        href: "/trainees/1".to_owned(),
        cells: progress
            .steps
            .iter()
            .zip(&course.steps)
            .map(|(step, of)| make_heat_cell(format!("/trainees/1/exercises/{}", of.exercise), step, 60.0))
            .collect(),
    };
    let stuck = Concern::Failing {
        exercise: "feel-the-layers".to_owned(),
        title: "Feel the layers".to_owned(),
        fails: 5,
        last_score: 22.0,
    };
    let exercise = |(i, title): (usize, &str)| Hardness {
        title: title.to_owned(),
        href: "/cohorts/1/exercises/feel-the-layers".to_owned(),
        tried: 2,
        mastered: 1,
        passed: wilson(4, 9 + i).ok(),
        hardest: i == 0,
    };
    CohortProgressPage {
        shell: samples::shell(Role::Instructor),
        cohort: ("Spring 2026".to_owned(), "/cohorts/1".to_owned()),
        courses: vec![CourseHeat {
            title: "Lower back: first punctures".to_owned(),
            exercises: course.steps.iter().map(|s| s.title.as_str()).enumerate().map(exercise).collect(),
            rows: judged.iter().map(row).collect(),
        }],
        worries: vec![Worry {
            name: "Bruno Ferrari".to_owned(),
            href: "/trainees/1/exercises/feel-the-layers".to_owned(),
            concern: crate::training::concern::say_concern(&stuck),
        }],
        days: (0_usize..28)
            .map(|i| (samples::NOW.date() - Duration::days(27 - i64::try_from(i).expect("few")), i % 5, i % 3))
            .collect(),
        day: Some((samples::NOW.date(), vec![scored_row("/sessions/7")])),
    }
}

pub(super) fn metrics_page() -> MetricsPage {
    let metric = |id: &str, label: &str, unit: &str, values: &[f64]| {
        let five = summary(values).expect("values");
        (id.to_owned(), MetricSpreadRow { label: label.to_owned(), unit: unit.to_owned(), five })
    };
    let metrics = vec![
        metric("depth_error_mm", "Depth error", "mm", &[-1.2, 0.4, 3.1]),
        metric("peak_force_n", "Peak force", "N", &[1.8, 2.4, 2.5]),
        metric("skin_entries", "Skin entries", "count", &[1.0, 1.0, 1.0]),
    ];
    MetricsPage {
        shell: samples::shell(Role::Instructor),
        cohort: ("Spring 2026".to_owned(), "/cohorts/1".to_owned()),
        exercise: ("Stop in the fat".to_owned(), "/exercises/stop-in-the-fat".to_owned()),
        scores: summary(&[41.0, 72.5, 80.0]).ok(),
        themes: SpreadTheme::sort_metrics(metrics, &["depth_error_mm"]),
        scored: vec![scored_row("/sessions/1")],
    }
}

fn scored_row(href: &str) -> ScoredRow {
    ScoredRow {
        name: "Ana Lindqvist".to_owned(),
        exercise: "Feel the layers".to_owned(),
        href: href.to_owned(),
        at: samples::NOW,
        score: 80.0,
        passed: true,
    }
}
