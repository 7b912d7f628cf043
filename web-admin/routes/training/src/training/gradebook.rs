//! `/cohorts/{id}/gradebook`: the trainees of a cohort against its assignments.

use std::collections::BTreeMap;

use acts::error::Error;
use acts::training::assignments as teaching;
use acts::training::assignments::CohortStandings;
use axum::extract::{Query, State};
use axum::response::Response;
use model::ids::{AssignmentId, CohortId, PersonId};
use model::search_key::family_sort_key;
use model::training::assignment::{Assigned, AssignmentStage, AssignmentStanding, AssignmentTally, SOON_S};
use model::training::due;
use model::training::due::local;
use model::{CurrentPerson, Moment};
use pages::people::listed::ListPart;
use pages::training::assignments::{AssignmentRow, DueLine};
use pages::training::gradebook::{GradebookColumn, GradebookPage, GradebookRow};
use pages::{NavPlace, Shell, format};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, Visitor};
use routes_base::error::PageError;
use routes_base::export::{CsvCell, CsvDialect, download_csv_as, mark_byte_order, neutralise_cell};
use serde::Deserialize;
use store::training::reports;
use store::training::reports::NamedItem;

use super::rows::PeopleOnPage;
use super::{cohorts, standing};

fn href_of(assigned: &Assigned) -> String {
    format!("/assignments/{}", assigned.id)
}

fn due_line(assigned: &Assigned, to: &str, tally: AssignmentTally) -> DueLine {
    DueLine {
        href: href_of(assigned),
        title: assigned.title.clone(),
        to: to.to_owned(),
        due: assigned.due_at.map(|at| local(at, &assigned.time_zone)),
        tally,
    }
}

/// Returns every assignment of a cohort with the tally of its trainees; those of individual
/// trainees come last.
fn tallied<'a>(
    found: &'a CohortStandings,
    cohort: &'a str,
) -> impl Iterator<Item = (&'a Assigned, &'a str, AssignmentTally)> {
    let with_cohort = found.assigned.iter().enumerate().map(move |(at, assigned)| {
        let of_all = found.trainees.iter().map(move |trainee| &trainee.with_cohort[at]);
        (assigned, cohort, AssignmentTally::of(of_all))
    });
    let alone = found.trainees.iter().flat_map(|of| {
        let tally = |own: &AssignmentStanding| AssignmentTally::of(std::iter::once(own));
        of.alone.iter().map(move |own| (&own.assigned, of.trainee.name.as_str(), tally(own)))
    });
    with_cohort.chain(alone)
}

/// Returns the assignments of a cohort and of its trainees.
pub(crate) fn list_assignments_of_cohort(found: &CohortStandings, cohort: &str) -> Vec<DueLine> {
    tallied(found, cohort).map(|(assigned, to, tally)| due_line(assigned, to, tally)).collect()
}

/// Returns those assignments that are due soon and not completed, or that at least one trainee has
/// missed.
pub(crate) fn list_pressing_assignments(found: &CohortStandings, cohort: &str, now: Moment) -> Vec<DueLine> {
    let soon = now.plus_s(SOON_S);
    let is_pressing = |(assigned, _, tally): &(&Assigned, &str, AssignmentTally)| {
        tally.late > 0
            || (tally.done < tally.of && assigned.due_at.is_some_and(|due| !due::is_past(due, now) && due <= soon))
    };
    tallied(found, cohort).filter(is_pressing).map(|(assigned, to, tally)| due_line(assigned, to, tally)).collect()
}

/// How those stand to whom something was assigned in the cohorts that somebody teaches, by assignment.
pub(crate) async fn tally_assignments(
    state: &AppState,
    person: &CurrentPerson,
) -> Result<BTreeMap<AssignmentId, AssignmentTally>, Error> {
    let taught = teaching::taught(state, person.school_id).await?;
    let mut tallies = BTreeMap::new();
    for practised in standing::practice_of_cohorts(state, person).await? {
        let standing = practised.standing(&taught, state.clock.now());
        let found = standing.assignments(state, person.school_id).await?;
        tallies.extend(tallied(&found, "").map(|(assigned, _, tally)| (assigned.id, tally)));
    }
    Ok(tallies)
}

/// What both the page and its file are made of.
struct CohortGradebook {
    cohort: NamedItem<CohortId>,
    found: CohortStandings,
    registrar_ids: BTreeMap<PersonId, String>,
}

async fn find_gradebook(state: &AppState, person: &CurrentPerson, id: CohortId) -> Result<CohortGradebook, Error> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let cohort = reports::cohort(reader, person, id).await?.ok_or(Error::NotFound)?;
    let courses = teaching::taught(state, school).await?;
    let practised = standing::practice_of_cohort(state, school, cohort).await?;
    let mut found = practised.standing(&courses, state.clock.now()).assignments(state, school).await?;
    found.trainees.sort_by_cached_key(|of| family_sort_key(&of.trainee.name));
    let registrar_ids = reports::registrar_ids(reader, school, id).await?;
    Ok(CohortGradebook { cohort: practised.cohort, found, registrar_ids })
}

pub(crate) async fn show_gradebook(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<CohortId>,
    Query(query): Query<PeopleOnPage>,
    csrf: Csrf,
) -> Result<GradebookPage, PageError> {
    let CohortGradebook { cohort, found, mut registrar_ids } = find_gradebook(&state, &person, id).await?;
    let of_cohort = tallied(&found, &cohort.name).take(found.assigned.len());
    let columns = of_cohort.map(|(assigned, to, tally)| {
        let DueLine { href, title, due, tally, .. } = due_line(assigned, to, tally);
        GradebookColumn { href, title, due, tally }
    });
    let columns = columns.collect();
    let alone = list_assignments_of_cohort(&found, &cohort.name).split_off(found.assigned.len());
    let (trainees, list) = ListPart::of(query.into(), found.trainees, |of| &of.trainee.name);
    let rows = trainees.into_iter().map(|of| GradebookRow {
        href: format!("/trainees/{}", of.trainee.id),
        registrar_id: registrar_ids.remove(&of.trainee.id),
        name: of.trainee.name,
        cells: of.with_cohort.into_iter().map(AssignmentRow::own).collect(),
    });
    Ok(GradebookPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Cohorts),
        href: cohorts::cohort_href(&cohort),
        name: cohort.name,
        columns,
        rows: rows.collect(),
        list,
        alone,
    })
}

/// Format of the file.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct GradebookQuery {
    /// 1: with a byte order mark, without which Excel does not recognise UTF-8.
    bom: u8,
    /// 1: with a decimal comma, and semicolons between cells.
    comma: u8,
}

/// Returns points rounded to whole numbers.
fn points_cell(points: Option<f64>) -> CsvCell {
    points.map_or(CsvCell::Empty, |points| CsvCell::Number(points.round()))
}

pub(crate) async fn download_gradebook(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<CohortId>,
    Query(query): Query<GradebookQuery>,
) -> Result<Response, PageError> {
    let CohortGradebook { cohort, found, registrar_ids } = find_gradebook(&state, &person, id).await?;
    let mut names = vec![tr!("Registrar’s number").to_owned(), tr!("Name").to_owned()];
    for assigned in &found.assigned {
        let parts = [tr!("state"), tr!("best score"), tr!("attempts"), tr!("done on")];
        names.extend(parts.map(|part| neutralise_cell(&format!("{}: {part}", assigned.title))));
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut rows = Vec::new();
    for of in found.trainees {
        let number = registrar_ids.get(&of.trainee.id).map_or(CsvCell::Empty, |number| CsvCell::from(number.as_str()));
        let mut row = vec![number, CsvCell::from(of.trainee.name)];
        for cell in of.with_cohort.into_iter().map(AssignmentRow::own) {
            let done_on = match &cell.stage {
                AssignmentStage::Done { on, .. } => CsvCell::from(format::format_date(*on)),
                _ => CsvCell::Empty,
            };
            let attempts = CsvCell::Number(cell.attempts as f64);
            row.extend([CsvCell::from(cell.say_state()), points_cell(cell.best), attempts, done_on]);
        }
        rows.push(row);
    }
    let dialect = if query.comma == 1 { CsvDialect::Comma } else { CsvDialect::Point };
    let file = format!("gradebook-{}", cohort.name);
    let file = download_csv_as(dialect, &file, &names, &rows).map_err(Error::from)?;
    Ok(if query.bom == 1 { mark_byte_order(file) } else { file })
}
