//! Comparison of cohorts, for their teachers, and a school's progress, for its administrators.

use assessment::statistics::{Estimate, wilson};
use axum::extract::{Query, State};
use axum::response::Response;
use model::Role;
use pages::training::progress::{MonthRow, SchoolProgressPage, YearRow};
use pages::{NavPlace, Shell, charts, format};
use routes_base::AppState;
use routes_base::addresses::encode_in_query;
use routes_base::auth::{Csrf, Teacher};
use routes_base::error::PageError;
use routes_base::export::{CsvCell, download_csv};
use serde::Deserialize;
use store::training::tallies;
use store::training::tallies::{Sums, YearOfCohort};

/// Cohorts per page.
const PER_PAGE: u32 = 50;

fn passed_share(sums: &Sums) -> Option<Estimate> {
    wilson(usize::try_from(sums.passes).ok()?, usize::try_from(sums.attempts).ok()?).ok()
}

fn mean_score(sums: &Sums) -> Option<f64> {
    let attempts = u32::try_from(sums.attempts).ok().filter(|attempts| *attempts > 0)?;
    Some(sums.points / f64::from(attempts))
}

/// The year shown, and the name of the cohort after which the page begins.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct YearQuery {
    year: Option<i64>,
    after: String,
}

impl YearQuery {
    /// Returns the requested year, or the latest one with attempts.
    fn chosen(&self, years: &[i64]) -> i64 {
        self.year.or_else(|| years.first().copied()).unwrap_or_default()
    }
}

/// Returns the years of some months, latest first. Months are 12 × year + month − 1, earliest
/// first.
fn years_with_attempts(months: &[(i64, Sums)]) -> Vec<i64> {
    let mut years: Vec<i64> = months.iter().rev().map(|(month, _)| month.div_euclid(12)).collect();
    years.dedup();
    years
}

pub(super) async fn show_school_progress(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
    Query(query): Query<YearQuery>,
) -> Result<SchoolProgressPage, PageError> {
    let reader = state.db.reader();
    let months = tallies::list_tallies_by_month(reader, &person).await?;
    let years = years_with_attempts(&months);
    let year = query.chosen(&years);
    let mut cohorts = tallies::list_tallies_in_year(reader, &person, year, &query.after, PER_PAGE + 1).await?;
    let more = cohorts.len() > PER_PAGE as usize;
    cohorts.truncate(PER_PAGE as usize);
    let next = cohorts.last().filter(|_| more);
    let whole = person.role == Role::Administrator;
    Ok(SchoolProgressPage {
        shell: Shell::new(&person, csrf.token(), if whole { NavPlace::Administration } else { NavPlace::Cohorts }),
        whole,
        year,
        years,
        later: !query.after.is_empty(),
        next: next.map(|last| format!("/progress?year={year}&after={}", encode_in_query(&last.cohort))),
        cohorts: cohorts.into_iter().map(make_year_row).collect(),
        months: months.into_iter().rev().map(|(month, sums)| make_month_row(month, sums)).collect(),
    })
}

fn make_year_row(year: YearOfCohort) -> YearRow {
    YearRow {
        href: format!("/cohorts/{}/progress", year.cohort_id),
        cohort: year.cohort,
        attempts: year.sums.attempts,
        passed: passed_share(&year.sums),
        mean: mean_score(&year.sums),
    }
}

fn make_month_row(month: i64, sums: Sums) -> MonthRow {
    let passed = passed_share(&sums);
    MonthRow {
        month: format::format_month(month),
        attempts: sums.attempts,
        passed,
        mean: mean_score(&sums),
        bar: charts::draw_share_bar(passed.map_or(0.0, |p| p.value)),
    }
}

pub(super) async fn export_school_progress(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Query(query): Query<YearQuery>,
) -> Result<Response, PageError> {
    let reader = state.db.reader();
    let year = query.chosen(&years_with_attempts(&tallies::list_tallies_by_month(reader, &person).await?));
    let cohorts = match person.role {
        Role::Administrator => tallies::list_school_tallies_in_year(reader, person.school_id, year).await?,
        // An instructor teaches few of the cohorts, so these are summed one by one.
        _ => tallies::list_tallies_in_year(reader, &person, year, "", u32::MAX).await?,
    };
    let rows: Vec<Vec<CsvCell>> = cohorts.into_iter().map(make_year_row).map(|row| year_cells(year, row)).collect();
    let names = ["year", "cohort", "attempts", "share_passed", "share_low_95", "share_high_95", "mean_score"];
    Ok(download_csv(&format!("progress-{year}"), &names, &rows)?)
}

fn year_cells(year: i64, row: YearRow) -> Vec<CsvCell> {
    vec![
        CsvCell::Number(year as f64),
        CsvCell::from(row.cohort),
        CsvCell::Number(row.attempts as f64),
        CsvCell::from(row.passed.map(|p| p.value)),
        CsvCell::from(row.passed.map(|p| p.low)),
        CsvCell::from(row.passed.map(|p| p.high)),
        CsvCell::from(row.mean),
    ]
}
