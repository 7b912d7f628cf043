//! A school's progress, for its administrators.

use assessment::statistics::{Estimate, wilson};
use axum::extract::State;
use axum::response::Response;

use crate::AppState;
use crate::domain::CurrentPerson;
use crate::error::PageError;
use crate::export::{self, Cell};
use crate::routes::auth::Csrf;
use crate::routes::pages::admin::administrators_only;
use crate::storage::practice::{self, Sums, YearOfCohort};
use crate::views::progress::{MonthRow, SchoolProgressPage, YearRow};
use crate::views::{Place, Shell, charts};

fn passed(sums: &Sums) -> Option<Estimate> {
    wilson(usize::try_from(sums.passes).ok()?, usize::try_from(sums.attempts).ok()?).ok()
}

fn mean(sums: &Sums) -> Option<f64> {
    let attempts = u32::try_from(sums.attempts).ok().filter(|attempts| *attempts > 0)?;
    Some(sums.points / f64::from(attempts))
}

pub(super) async fn show(
    State(state): State<AppState>,
    person: CurrentPerson,
    csrf: Csrf,
) -> Result<SchoolProgressPage, PageError> {
    administrators_only(&person)?;
    let (reader, school) = (state.db.reader(), person.school_id);
    let years = practice::by_year(reader, school).await?;
    let months = practice::by_month(reader, school).await?;
    Ok(SchoolProgressPage {
        shell: Shell::new(&person, csrf.token(), Place::Administration),
        years: years.into_iter().map(year_row).collect(),
        months: months.into_iter().rev().map(month_row).collect(),
    })
}

fn year_row(year: YearOfCohort) -> YearRow {
    YearRow {
        year: year.year,
        href: format!("/cohorts/{}/progress", year.cohort_id),
        cohort: year.cohort,
        attempts: year.sums.attempts,
        passed: passed(&year.sums),
        mean: mean(&year.sums),
    }
}

fn month_row((month, sums): (i64, Sums)) -> MonthRow {
    let passed = passed(&sums);
    MonthRow {
        month: format!("{:04}-{:02}", month.div_euclid(12), month.rem_euclid(12) + 1),
        attempts: sums.attempts,
        passed,
        mean: mean(&sums),
        bar: charts::share_bar(passed.map_or(0.0, |p| p.value)),
    }
}

pub(super) async fn export(State(state): State<AppState>, person: CurrentPerson) -> Result<Response, PageError> {
    administrators_only(&person)?;
    let years = practice::by_year(state.db.reader(), person.school_id).await?;
    let rows: Vec<Vec<Cell>> = years.into_iter().map(year_row).map(cells).collect();
    let names = ["year", "cohort", "attempts", "share_passed", "share_low_95", "share_high_95", "mean_score"];
    Ok(export::download("progress-by-year", &names, &rows)?)
}

fn cells(row: YearRow) -> Vec<Cell> {
    vec![
        Cell::Number(f64::from(row.year)),
        Cell::from(row.cohort),
        Cell::Number(row.attempts as f64),
        Cell::from(row.passed.map(|p| p.value)),
        Cell::from(row.passed.map(|p| p.low)),
        Cell::from(row.passed.map(|p| p.high)),
        Cell::from(row.mean),
    ]
}
