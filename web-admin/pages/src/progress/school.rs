//! A school's progress: by month, and by year and cohort.

use askama::Template;
use askama_web::WebTemplate;
use assessment::statistics::Estimate;

use crate::{Shell, format};

/// The page.
#[derive(Clone, Debug, Template, WebTemplate)]
#[template(path = "progress/school.html")]
pub struct SchoolProgressPage {
    /// Frame.
    pub shell: Shell,
    /// It is of the whole school; otherwise of the cohorts that the visitor teaches.
    pub whole: bool,
    /// The years in which somebody has practised, UTC, the latest first.
    pub years: Vec<i64>,
    /// The year whose cohorts are shown.
    pub year: i64,
    /// Its cohorts, by name.
    pub cohorts: Vec<YearRow>,
    /// These are not the first of them.
    pub later: bool,
    /// Where the next ones are.
    pub next: Option<String>,
    /// By month, the latest first.
    pub months: Vec<MonthRow>,
}

/// A cohort in a year.
#[derive(Clone, Debug, PartialEq)]
pub struct YearRow {
    /// The cohort's name.
    pub cohort: String,
    /// The page it is made of.
    pub href: String,
    /// Scored attempts.
    pub attempts: i64,
    /// Share of them that passed.
    pub passed: Option<Estimate>,
    /// Mean score, 0–100.
    pub mean: Option<f64>,
}

/// The school in a month.
#[derive(Clone, Debug, PartialEq)]
pub struct MonthRow {
    /// In words.
    pub month: String,
    /// Scored attempts.
    pub attempts: i64,
    /// Share of them that passed.
    pub passed: Option<Estimate>,
    /// Mean score, 0–100.
    pub mean: Option<f64>,
    /// That share as a bar.
    pub bar: String,
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::{charts, samples};

    #[test]
    fn years_and_months_have_their_shares_and_an_empty_school_says_so() {
        let passed = assessment::statistics::wilson(18, 20).ok();
        let full = SchoolProgressPage {
            shell: samples::shell(Role::Administrator),
            whole: true,
            years: vec![2026, 2025],
            year: 2026,
            later: true,
            next: Some("/progress?year=2026&after=Spring%202026".to_owned()),
            cohorts: vec![YearRow {
                cohort: "Spring 2026".to_owned(),
                href: "/cohorts/1/progress".to_owned(),
                attempts: 20,
                passed,
                mean: Some(81.5),
            }],
            months: vec![MonthRow {
                month: "May 2026".to_owned(),
                attempts: 20,
                passed,
                mean: Some(81.5),
                bar: charts::draw_share_bar(0.9),
            }],
        };
        let html = samples::keep_page("school-progress", &full);
        assert!(html.contains("90 % (70–97 %)") && html.contains("/cohorts/1/progress"), "{html}");
        assert!(html.contains("/progress?year=2025") && html.contains("/progress.csv?year=2026"), "{html}");
        assert!(html.contains("href=\"/progress/attempts.csv\""), "{html}");
        let nobody = SchoolProgressPage { cohorts: vec![], later: false, next: None, ..full.clone() };
        assert!(samples::keep_page("school-progress-nobody", &nobody).contains("is in a cohort"));
        let empty = SchoolProgressPage { years: vec![], cohorts: vec![], months: vec![], ..full };
        assert!(samples::keep_page("school-progress-empty", &empty).contains("No scored attempt yet"));
    }
}
