//! A cohort compared with that of the year before at the same week of the term, and the terms of a
//! school.

use askama::Template;
use askama_web::WebTemplate;
use assessment::statistics::{Summary, summary};
use model::Role;
use model::surveys::groups::LEAST;
use model::training::term::{Term, TermFigures};
use serde::Deserialize;

use crate::charts::{BoxRow, Extent, ShareLine};
use crate::form::{FilledForm, SelectOption, read_trimmed_text};
use crate::{Shell, charts, format};

/// A cohort compared with another one.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/programme.html")]
pub struct ProgrammePage {
    /// Page frame.
    pub shell: Shell,
    /// Address of the cohort's page.
    pub href: String,
    /// Its name.
    pub name: String,
    /// For administrators: the terms to choose from.
    pub terms: Vec<SelectOption>,
    /// The courses to choose from.
    pub courses: Vec<SelectOption>,
    /// The cohorts to compare with.
    pub others: Vec<SelectOption>,
    /// Weeks without practice that are a pause.
    pub pause_weeks: u32,
    /// The comparison; `None` if the cohort belongs to no term, or the school teaches no course.
    pub comparison: Option<CohortComparison>,
}

/// Figures of one or two cohorts in a course.
#[derive(Clone, Debug)]
pub struct CohortComparison {
    /// Week of the term, from 1.
    pub week: u32,
    /// Titles of the course's exercises.
    pub exercises: Vec<String>,
    /// The cohort, and the one that it is compared with.
    pub cohorts: Vec<ComparedCohort>,
}

/// Figures of a cohort.
#[derive(Clone, Debug)]
pub struct ComparedCohort {
    /// Name and term.
    pub label: String,
    /// Figures up to the week.
    pub now: TermFigures,
    /// Share mastered at the end of each week, as far as it is known.
    pub shares: Vec<f64>,
}

impl CohortComparison {
    fn draw_shares(&self) -> String {
        let line = |of: &ComparedCohort| ShareLine { label: of.label.clone(), shares: of.shares.clone() };
        let lines: Vec<ShareLine> = self.cohorts.iter().map(line).collect();
        charts::draw_both_widths(|size| charts::draw_shares(&lines, "shares", tr!("Share mastered by week"), size))
    }

    /// Returns the rows of the table of shares: week, and the share of each cohort.
    fn share_rows(&self) -> Vec<(usize, Vec<String>)> {
        let weeks = self.cohorts.iter().map(|of| of.shares.len()).max().unwrap_or(0);
        let share = |of: &ComparedCohort, week: usize| of.shares.get(week).map_or_else(dash, format::format_percent);
        (0..weeks).map(|week| (week + 1, self.cohorts.iter().map(|of| share(of, week)).collect())).collect()
    }

    /// Returns what each cohort has mastered by now: label with the number of trainees, and share.
    fn shares_now(&self) -> Vec<(String, String)> {
        let now = |of: &ComparedCohort| match of.now.shares.last() {
            Some(share) => {
                let label = tr!("{group}, n = {n}", group = of.label, n = of.now.trainees);
                (label, format::format_percent(*share))
            }
            None => (of.label.clone(), hidden()),
        };
        self.cohorts.iter().map(now).collect()
    }

    fn draw_attempts(&self) -> String {
        let rows = self.exercises.iter().enumerate().flat_map(|(index, title)| {
            let row =
                move |of: &ComparedCohort| make_box_row(&format!("{} · {title}", of.label), &of.now.to_mastery[index]);
            self.cohorts.iter().map(row)
        });
        draw_rows(
            &rows.filter(|row| row.quartiles.is_some()).collect::<Vec<_>>(),
            "attempts",
            tr!("Attempts to mastery"),
        )
    }

    /// Returns the rows of the table of attempts: exercise, and the distribution in each cohort.
    fn attempt_rows(&self) -> Vec<(&str, Vec<String>)> {
        let cells = |index: usize| self.cohorts.iter().map(|of| say_distribution(&of.now.to_mastery[index])).collect();
        self.exercises.iter().enumerate().map(|(index, title)| (title.as_str(), cells(index))).collect()
    }

    fn draw_pauses(&self) -> String {
        let rows: Vec<BoxRow> = self.cohorts.iter().map(|of| make_box_row(&of.label, &of.now.pauses)).collect();
        let rows: Vec<BoxRow> = rows.into_iter().filter(|row| row.quartiles.is_some()).collect();
        draw_rows(&rows, "pauses", tr!("Change of the score after a pause"))
    }

    fn pause_rows(&self) -> Vec<(&str, String)> {
        self.cohorts.iter().map(|of| (of.label.as_str(), say_distribution(&of.now.pauses))).collect()
    }
}

fn dash() -> String {
    "–".to_owned()
}

fn hidden() -> String {
    tr!("hidden: fewer than {least} people", least = LEAST)
}

/// Draws distributions on a common axis; nothing if there are none.
fn draw_rows(rows: &[BoxRow], key: &str, title: &str) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let ends = rows.iter().filter_map(|row| row.ends).flat_map(|(least, greatest)| [least, greatest]);
    let range = Extent::around(ends);
    charts::draw_both_widths(|size| charts::draw_boxes(rows, range, key, title, size))
}

fn summarize(values: &[f64]) -> Option<Summary> {
    summary(values).ok()
}

fn make_box_row(label: &str, values: &[f64]) -> BoxRow {
    let found = summarize(values);
    BoxRow {
        label: found
            .as_ref()
            .map_or_else(|| label.to_owned(), |found| tr!("{group}, n = {n}", group = label, n = found.n)),
        quartiles: found.as_ref().map(|of| (of.lower_quartile, of.median, of.upper_quartile)),
        ends: found.as_ref().map(|of| (of.min, of.max)),
        mean: None,
    }
}

fn say_distribution(values: &[f64]) -> String {
    let fixed = |value: f64| format::format_fixed(value, 1);
    summarize(values).map_or_else(dash, |of| {
        tr!(
            "median {median} ({lower} to {upper}), n = {n}",
            median = fixed(of.median),
            lower = fixed(of.lower_quartile),
            upper = fixed(of.upper_quartile),
            n = of.n
        )
    })
}

/// The terms of a school.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/terms.html")]
pub struct TermsPage {
    /// Page frame.
    pub shell: Shell,
    /// The terms, latest first.
    pub terms: Vec<Term>,
    /// The form to add one.
    pub form: FilledForm<TermForm>,
}

/// Input of the form to add a term.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct TermForm {
    /// Name.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub name: String,
    /// First day, as 2026-10-12.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub starts_on: String,
}

impl TermsPage {
    fn cohorts_words(term: &Term) -> String {
        trn!("{n} cohort", "{n} cohorts", term.cohorts)
    }
}

#[cfg(test)]
mod tests {
    //! The table must say what the picture shows, and a small group must not be shown.

    use model::Moment;
    use model::ids::TermId;

    use super::*;
    use crate::samples;

    fn figures(trainees: usize, share: f64) -> TermFigures {
        TermFigures {
            trainees,
            shares: (0..6).map(|week| share * f64::from(week) / 5.0).collect(),
            to_mastery: vec![(0..trainees).map(|n| 3.0 + n as f64).collect(), Vec::new()],
            pauses: (0..trainees).map(|n| -4.0 - n as f64).collect(),
        }
    }

    fn page(cohorts: Vec<ComparedCohort>) -> ProgrammePage {
        let exercises = vec!["Feel the <layers>".to_owned(), "Stop in the fat".to_owned()];
        let option = |label: &str| SelectOption { value: "1".to_owned(), label: label.to_owned(), chosen: true };
        ProgrammePage {
            shell: samples::shell(Role::Administrator),
            href: "/cohorts/1".to_owned(),
            name: "Year 4, group A".to_owned(),
            terms: vec![option("Winter 2026/27")],
            courses: vec![option("Lower back")],
            others: vec![option("Year 4, 2025")],
            pause_weeks: 2,
            comparison: Some(CohortComparison { week: 6, exercises, cohorts }),
        }
    }

    fn compared(label: &str, now: TermFigures) -> ComparedCohort {
        let shares = now.shares.clone();
        ComparedCohort { label: label.to_owned(), now, shares }
    }

    #[test]
    fn two_cohorts_are_drawn_and_listed() {
        let cohorts = vec![compared("A, 2026", figures(8, 0.5)), compared("A, 2025", figures(7, 0.4))];
        let html = samples::keep_page("programme", &page(cohorts));
        assert_eq!(html.matches("polyline class=\"series").count(), 4, "two lines at two widths");
        assert!(html.contains("median 6.5 (4.8 to 8.2), n = 8") && html.contains("50\u{a0}%"), "{html}");
    }

    #[test]
    fn a_small_group_is_not_shown() {
        let cohorts =
            vec![compared("A, 2026", figures(8, 0.5)), compared("A, 2025", figures(4, 0.4).without_small_groups())];
        let html = samples::keep_page("programme-small", &page(cohorts));
        assert_eq!(html.matches("polyline class=\"series").count(), 2, "{html}");
        assert!(html.contains("hidden: fewer than 5 people") && !html.contains("n = 4"), "{html}");
    }

    #[test]
    fn a_cohort_without_a_term_says_what_to_do() {
        let page = ProgrammePage { comparison: None, ..page(vec![]) };
        assert!(samples::keep_page("programme-empty", &page).contains("does not belong to a term"));
        let term = Term {
            id: TermId::nil(),
            name: "Winter <2026>".to_owned(),
            starts_on: "2026-10-12".to_owned(),
            starts_at: Moment::from(samples::NOW),
            cohorts: 2,
        };
        let form = FilledForm::refused(TermForm::default(), "there is a term already".to_owned());
        let terms = TermsPage { shell: samples::shell(Role::Administrator), terms: vec![term], form };
        let html = samples::keep_page("terms", &terms);
        assert!(html.contains("2 cohorts") && html.contains("There is a term already"), "{html}");
    }
}
