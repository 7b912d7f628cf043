//! `/trainees/{id}`, and a trainee's own home.

use acts::assignments as teaching;
use acts::error::Error;
use assessment::Deduction;
use axum::extract::{Query, State};
use model::assignment::AssignmentStanding;
use model::ids::PersonId;
use model::progress::{Habits, Progress};
use model::{CurrentPerson, Moment, Role};
use pages::assignments::AssignmentRow;
use pages::progress::HabitsView;
use pages::trainee::{CourseView, PageNumbers, TraineePage, needed_in_words};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, Visitor};
use routes_base::error::PageError;
use serde::Deserialize;
use store::reports::{ListStretch, ListedAttempt, NamedItem};
use store::{cohorts, practice, reports, sign_in_codes};

use super::standing::TaughtCourse;
use super::{news, rows, standing};

/// Attempts over which habits are looked for.
const RECENT: ListStretch = ListStretch { limit: 20, offset: 0 };
/// Assignments on a trainee's home.
const SHOWN_DUE: usize = 3;
/// Attempts on one page of the list.
const PER_PAGE: u32 = 25;

/// Which page of the list.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
pub(crate) struct TraineePageQuery {
    /// From 1.
    page: Option<u32>,
}

pub(crate) async fn show_trainee(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<PersonId>,
    csrf: Csrf,
    Query(query): Query<TraineePageQuery>,
) -> Result<TraineePage, PageError> {
    let trainee = reports::trainee(state.db.reader(), &person, id).await?.ok_or(Error::NotFound)?;
    let shell = Shell::new(&person, csrf.token(), NavPlace::Elsewhere);
    Ok(make_trainee_page(&state, shell, &person, trainee, query).await?)
}

/// The page of a trainee whom the visitor may see.
pub(crate) async fn make_trainee_page(
    state: &AppState,
    shell: Shell,
    visitor: &CurrentPerson,
    trainee: NamedItem<PersonId>,
    query: TraineePageQuery,
) -> Result<TraineePage, Error> {
    let (reader, school) = (state.db.reader(), visitor.school_id);
    let courses = standing::taught_courses(state, school).await?;
    let attempts = practice::list_trainee_practice(reader, school, trainee.id).await?;
    let mut progress = standing::progress_in_courses(&courses, &attempts, state);
    let href = format!("/trainees/{}", trainee.id);
    let (needed, proved) = standing::proved_attempts(state, school, trainee.id, &attempts).await?;
    let now = state.clock.now().to_utc();
    let view = |(i, progress)| {
        let taught: &TaughtCourse = &courses[i];
        let view = CourseView::new(&taught.facts(Some(&href)), &progress, i);
        match view.complete && !Progress::of(&taught.course, &proved, now).complete() {
            true => CourseView { certificate: None, unproved: Some(needed_in_words(needed)), ..view },
            false => view,
        }
    };
    let pages = number_pages(reports::count_attempts(reader, school, trainee.id).await?, query);
    let stretch = ListStretch { limit: PER_PAGE, offset: pages.page.saturating_sub(1) * PER_PAGE };
    let cohorts = cohorts::list_cohorts_of_person(reader, school, trainee.id, Role::Trainee).await?;
    let own = trainee.id == visitor.id;
    let sign_in_code = match own {
        true => Some(sign_in_codes::find_code_time(reader, school, visitor.id).await?.map(Moment::to_utc)),
        false => None,
    };
    let latest = reports::attempts_of(reader, school, trainee.id, RECENT).await?;
    let requests =
        if own { cohorts::list_membership_requests(reader, school, None, Some(visitor.id)).await? } else { Vec::new() };
    let due = teaching::standings(state, school, trainee.id).await?;
    // Those begun come first; before any attempt the school's first course leads.
    let begun = progress.iter().filter(|(_, progress)| progress.attempts() > 0).count();
    let others = progress.split_off(begun.max(1).min(progress.len()));
    Ok(TraineePage {
        shell,
        news: if own { news::list_news(state, visitor).await? } else { Vec::new() },
        due: due.into_iter().filter(AssignmentStanding::is_open).take(SHOWN_DUE).map(AssignmentRow::own).collect(),
        transcript: format!("{href}/transcript"),
        requests,
        habits: habits_of_attempts(&latest),
        name: trainee.name,
        own,
        sign_in_code,
        cohorts: cohorts.into_iter().map(|c| c.name).collect(),
        courses: progress.into_iter().map(&view).collect(),
        others: others.into_iter().map(&view).collect(),
        attempts: rows::own_rows(reports::attempts_of(reader, school, trainee.id, stretch).await?),
        pages,
    })
}

/// What costs most over attempts that count, newest first.
pub(crate) fn habits_of_attempts(latest: &[ListedAttempt]) -> HabitsView {
    let counted = || latest.iter().filter(|attempt| attempt.uncounted.is_none());
    let scored = || counted().filter_map(|attempt| Some((attempt, &attempt.deductions.as_ref()?.0[..])));
    let deductions: Vec<&[Deduction]> = scored().map(|(_, deductions)| deductions).collect();
    let pages: Vec<String> = scored().map(|(attempt, _)| format!("/sessions/{}", attempt.id)).collect();
    HabitsView::new(Habits::of(&deductions), &pages)
}

/// A page beyond the last is the last.
fn number_pages(entries: u32, query: TraineePageQuery) -> PageNumbers {
    let last = entries.div_ceil(PER_PAGE).max(1);
    PageNumbers { page: query.page.unwrap_or(1).clamp(1, last), last, entries }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_lies_between_the_first_and_the_last() {
        let page = |entries, page| number_pages(entries, TraineePageQuery { page }).page;
        assert_eq!([page(60, None), page(60, Some(0)), page(60, Some(2)), page(60, Some(99))], [1, 1, 2, 3]);
        assert_eq!(number_pages(0, TraineePageQuery::default()), PageNumbers { page: 1, last: 1, entries: 0 });
        assert_eq!(number_pages(25, TraineePageQuery::default()).last, 1);
    }
}
