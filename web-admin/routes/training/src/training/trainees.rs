//! `/trainees/{id}`, and a trainee's own home page.

use acts::error::Error;
use acts::training::assignments as teaching;
use acts::training::risks;
use assessment::Deduction;
use axum::extract::{Query, State};
use model::ids::PersonId;
use model::training::assignment::{AssignmentStanding, AttemptHistory};
use model::training::membership::MembershipRequest;
use model::training::progress::{Habits, Progress, ScoredAttempt};
use model::training::support_note::SupportKind;
use model::{CurrentPerson, Moment, Needed, PersonKey, Role};
use pages::people::listed::PageNumbers;
use pages::training::assignments::AssignmentRow;
use pages::training::concern::say_concern;
use pages::training::progress::HabitsView;
use pages::training::risk::SupportNoteRow;
use pages::training::trainee::{CourseView, TraineePage, needed_in_words};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, Visitor};
use routes_base::error::PageError;
use serde::Deserialize;
use store::stations::sign_in_codes;
use store::training::cohorts::Cohort;
use store::training::reports::{ListStretch, ListedAttempt, NamedItem};
use store::training::risks::RiskScope;
use store::training::{cohorts, outcomes, practice, reports, support_notes};

use super::standing::TaughtCourse;
use super::{news, rows, standing};

/// Attempts in which recurring deductions are looked for.
const RECENT: ListStretch = ListStretch { limit: 20, offset: 0 };
/// Number of assignments on a trainee's home page.
const SHOWN_DUE: usize = 3;
/// Records of support on the page.
const SHOWN_NOTES: u32 = 20;
/// Attempts per page of the list.
const PER_PAGE: u32 = 25;

/// Page of the list.
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

/// The stored data that the page of a trainee shows.
struct TraineeRecord {
    practised: Vec<ScoredAttempt>,
    pages: PageNumbers,
    /// The attempts of the page.
    listed: Vec<ListedAttempt>,
    /// The latest attempts, unless they are those of the page.
    recent: Option<Vec<ListedAttempt>>,
    cohorts: Vec<Cohort>,
    sign_in_code: Option<Option<Moment>>,
    requests: Vec<MembershipRequest>,
    has_outcomes: bool,
}

impl TraineeRecord {
    /// Reads all data over one connection: acquiring another one for each statement costs as much
    /// as the statement.
    async fn read(state: &AppState, trainee: PersonKey, own: bool, query: TraineePageQuery) -> Result<Self, Error> {
        let PersonKey { school_id: school, person_id: id } = trainee;
        let mut reader = state.db.reader().acquire().await?;
        let practised = practice::list_trainee_practice(&mut *reader, school, id).await?;
        let pages = number_pages(reports::count_attempts(&mut *reader, school, id).await?, query);
        let stretch = ListStretch { limit: PER_PAGE, offset: pages.page.saturating_sub(1) * PER_PAGE };
        let listed = reports::attempts_of(&mut *reader, school, id, stretch).await?;
        let recent = match pages.page {
            1 => None,
            _ => Some(reports::attempts_of(&mut *reader, school, id, RECENT).await?),
        };
        let cohorts = cohorts::list_cohorts_of_person(&mut *reader, school, id, Role::Trainee).await?;
        let has_outcomes = outcomes::has_outcomes(&mut *reader, school).await?;
        let (mut sign_in_code, mut requests) = (None, Vec::new());
        if own {
            sign_in_code = Some(sign_in_codes::find_code_time(&mut *reader, school, id).await?);
            requests = cohorts::list_membership_requests(&mut *reader, school, None, Some(id)).await?;
        }
        Ok(Self { practised, pages, listed, recent, cohorts, sign_in_code, requests, has_outcomes })
    }

    /// Returns the latest attempts, in which recurring deductions are looked for.
    fn latest(&self) -> &[ListedAttempt] {
        self.recent.as_deref().unwrap_or(&self.listed[..self.listed.len().min(RECENT.limit as usize)])
    }
}

/// Returns the page of a trainee whom the visitor may see.
pub(crate) async fn make_trainee_page(
    state: &AppState,
    shell: Shell,
    visitor: &CurrentPerson,
    trainee: NamedItem<PersonId>,
    query: TraineePageQuery,
) -> Result<TraineePage, Error> {
    let (school, own) = (visitor.school_id, trainee.id == visitor.id);
    let key = PersonKey { school_id: school, person_id: trainee.id };
    let courses = standing::taught_courses(state, school).await?;
    let record = TraineeRecord::read(state, key, own, query).await?;
    let mut progress = standing::progress_in_courses(&courses, &record.practised);
    let href = format!("/trainees/{}", trainee.id);
    let (needed, proved) = match progress.iter().any(|(_, progress)| progress.complete()) {
        true => standing::proved_attempts(state, school, trainee.id, &record.practised).await?,
        false => (Needed::Nothing, Vec::new()),
    };
    let now = state.clock.now();
    let view = |(i, progress)| {
        let taught: &TaughtCourse = &courses[i];
        let view = CourseView::new(&taught.facts(Some(&href)), &progress, i);
        match view.complete && !Progress::of(&taught.course, &proved).complete() {
            true => CourseView { certificate: None, unproved: Some(needed_in_words(needed)), ..view },
            false => view,
        }
    };
    let judged = standing::judged_courses(&courses);
    let due = teaching::standings_by(state, key, &AttemptHistory::new(&judged, &record.practised, now)).await?;
    let support = find_support(state, visitor, trainee.id).await?;
    // Courses with attempts come first; without any attempt the school's first course leads.
    let begun = progress.iter().filter(|(_, progress)| progress.attempts() > 0).count();
    let others = progress.split_off(begun.max(1).min(progress.len()));
    Ok(TraineePage {
        shell,
        news: if own { news::list_news(state, visitor).await? } else { Vec::new() },
        concerns: support.concerns,
        notes: support.notes,
        support_href: support.href,
        due: due.into_iter().filter(AssignmentStanding::is_open).take(SHOWN_DUE).map(AssignmentRow::own).collect(),
        transcript: format!("{href}/transcript"),
        outcomes: record.has_outcomes.then(|| format!("{href}/outcomes")),
        habits: habits_of_attempts(record.latest()),
        requests: record.requests,
        name: trainee.name,
        own,
        sign_in_code: record.sign_in_code.map(|made| made.map(Moment::to_utc)),
        cohorts: record.cohorts.into_iter().map(|c| c.name).collect(),
        courses: progress.into_iter().map(&view).collect(),
        others: others.into_iter().map(&view).collect(),
        attempts: rows::own_rows(record.listed),
        pages: record.pages,
    })
}

/// Returns the most costly recurring deductions over attempts that count, newest first.
pub(crate) fn habits_of_attempts(latest: &[ListedAttempt]) -> HabitsView {
    let counted = || latest.iter().filter(|attempt| attempt.uncounted.is_none());
    let scored = || counted().filter_map(|attempt| Some((attempt, &attempt.deductions.as_ref()?.0[..])));
    let deductions: Vec<&[Deduction]> = scored().map(|(_, deductions)| deductions).collect();
    let pages: Vec<String> = scored().map(|(attempt, _)| format!("/sessions/{}", attempt.id)).collect();
    HabitsView::new(Habits::of(&deductions), &pages)
}

/// Returns the page numbers; a page beyond the last is the last one.
fn number_pages(entries: u32, query: TraineePageQuery) -> PageNumbers {
    let last = entries.div_ceil(PER_PAGE).max(1);
    PageNumbers { page: query.page.unwrap_or(1).clamp(1, last), last, entries }
}

/// Support records of a trainee, and the reasons for risk.
#[derive(Default)]
struct Support {
    concerns: Vec<(&'static str, String)>,
    notes: Vec<SupportNoteRow>,
    href: Option<String>,
}

/// Returns everything to those who teach the trainee, and the messages to the trainee.
async fn find_support(state: &AppState, visitor: &CurrentPerson, trainee: PersonId) -> Result<Support, Error> {
    let key = PersonKey { school_id: visitor.school_id, person_id: trainee };
    let notes = support_notes::list_support_notes(state.db.reader(), key, SHOWN_NOTES).await?;
    if trainee == visitor.id {
        let messages = notes.into_iter().filter(|note| note.kind == SupportKind::Message);
        return Ok(Support { notes: messages.map(SupportNoteRow::new).collect(), ..Support::default() });
    }
    let found = risks::list_people_at_risk(state, visitor, RiskScope::Trainee(trainee)).await?;
    Ok(Support {
        concerns: found.iter().flat_map(|of| of.concerns.iter().map(say_concern)).collect(),
        notes: notes.into_iter().map(SupportNoteRow::new).collect(),
        href: Some(format!("/at-risk?trainee={trainee}")),
    })
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
