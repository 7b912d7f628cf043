//! A school's progress: by month, and by year and cohort.

use askama::Template;
use askama_web::WebTemplate;
use assessment::statistics::Estimate;

use crate::views::{Shell, format};

/// The page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "progress/school.html")]
pub struct SchoolProgressPage {
    /// Frame.
    pub shell: Shell,
    /// By year and cohort, the latest year first.
    pub years: Vec<YearRow>,
    /// By month, the latest first.
    pub months: Vec<MonthRow>,
}

/// A cohort in a year.
#[derive(Clone, Debug, PartialEq)]
pub struct YearRow {
    /// Year, UTC.
    pub year: i32,
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
    /// Year and month, as 2026-05.
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
    use super::*;
    use crate::domain::Role;
    use crate::views::{charts, samples};

    #[test]
    fn years_and_months_have_their_shares_and_an_empty_school_says_so() {
        let passed = assessment::statistics::wilson(18, 20).ok();
        let full = SchoolProgressPage {
            shell: samples::shell(Role::Administrator),
            years: vec![YearRow {
                year: 2026,
                cohort: "Spring 2026".to_owned(),
                href: "/cohorts/1/progress".to_owned(),
                attempts: 20,
                passed,
                mean: Some(81.5),
            }],
            months: vec![MonthRow {
                month: "2026-05".to_owned(),
                attempts: 20,
                passed,
                mean: Some(81.5),
                bar: charts::share_bar(0.9),
            }],
        };
        let html = samples::keep("school-progress", &full);
        assert!(html.contains("90 % (70–97 %)") && html.contains("/cohorts/1/progress"), "{html}");
        let empty = SchoolProgressPage { years: vec![], months: vec![], ..full };
        assert!(samples::keep("school-progress-empty", &empty).contains("No scored attempt yet"));
    }
}
