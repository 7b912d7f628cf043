//! A school's progress by month, and by year and cohort.

use askama::Template;
use askama_web::WebTemplate;
use assessment::statistics::Estimate;

use crate::{Shell, format};

/// The page of a school's progress.
#[derive(Clone, Debug, Template, WebTemplate)]
#[template(path = "training/progress/school.html")]
pub struct SchoolProgressPage {
    /// Page frame.
    pub shell: Shell,
    /// Whether it covers the whole school; otherwise it covers the visitor's cohorts.
    pub whole: bool,
    /// Years with attempts, in UTC, latest first.
    pub years: Vec<i64>,
    /// The selected year.
    pub year: i64,
    /// Cohorts of that year, by name.
    pub cohorts: Vec<YearRow>,
    /// Whether this is a page after the first.
    pub later: bool,
    /// Address of the next page.
    pub next: Option<String>,
    /// Months, latest first.
    pub months: Vec<MonthRow>,
}

/// A cohort in a year.
#[derive(Clone, Debug, PartialEq)]
pub struct YearRow {
    /// The cohort's name.
    pub cohort: String,
    /// Address of the cohort's progress.
    pub href: String,
    /// Number of scored attempts.
    pub attempts: i64,
    /// Share of these attempts that passed.
    pub passed: Option<Estimate>,
    /// Mean score, 0–100.
    pub mean: Option<f64>,
}

/// The school in a month.
#[derive(Clone, Debug, PartialEq)]
pub struct MonthRow {
    /// Month and year as text.
    pub month: String,
    /// Number of scored attempts.
    pub attempts: i64,
    /// Share of these attempts that passed.
    pub passed: Option<Estimate>,
    /// Mean score, 0–100.
    pub mean: Option<f64>,
    /// The share as a bar.
    pub bar: String,
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::{charts, samples};

    #[test]
    fn school_progress_shows_yearly_shares_or_that_none_exist() {
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
