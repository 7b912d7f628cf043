//! Bulk actions of an administrator: previewed on one page, confirmed on the next.

use acts::error::Error;
use acts::people::bulk;
use acts::people::bulk::{BulkRequest, MOST_PEOPLE};
use axum::extract::State;
use axum::response::Redirect;
use model::ids::{CohortId, PersonId};
use model::people::directory::BulkAct;
use model::{CurrentPerson, count_u32};
use pages::form::{FilledForm, SelectOption};
use pages::people::PeoplePage;
use pages::people::bulk::{BulkForm, BulkPage, BulkRefused, list_bulk_acts, name_bulk_act};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::auth::{Administrator, Csrf, CsrfForm, Visit};
use routes_base::error::PageError;
use routes_base::forms::FormAnswer;
use serde::Deserialize;
use store::people::directory;
use store::training::cohorts;

use super::directory::{PeopleQuery, make_directory_page};

/// The bulk form below the list of people.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct BulkAsked {
    act: String,
    cohort: String,
    person: Vec<PersonId>,
    everybody: String,
    q: String,
    role: String,
    state: String,
    among: String,
}

impl BulkAsked {
    fn act(&self) -> Option<BulkAct> {
        pages::people::bulk::BULK_ACTS.into_iter().find(|act| name_bulk_act(*act) == self.act)
    }

    /// Returns the query that the list was filtered by.
    fn query(&self) -> PeopleQuery {
        let (q, role, state) = (self.q.clone(), self.role.clone(), self.state.clone());
        PeopleQuery::looking_for(q, role, state, self.among.clone())
    }

    async fn list_meant(&self, state: &AppState, by: &CurrentPerson) -> Result<Vec<PersonId>, Error> {
        if self.everybody != "yes" {
            return Ok(self.person.clone());
        }
        let filter = self.query().filter();
        let found = directory::list_people(state.db.reader(), by.school_id, &filter, MOST_PEOPLE + 1).await?;
        Ok(found.into_iter().map(|person| person.id).collect())
    }

    /// Returns the requested action, or the reason why it is incomplete.
    fn request(&self, people: Vec<PersonId>) -> Result<BulkRequest, BulkRefused> {
        let act = self.act().ok_or(BulkRefused::NoAct)?;
        let cohort: Option<CohortId> = self.cohort.parse().ok().filter(|_| act.needs_cohort());
        match count_u32(people.len()) {
            0 => Err(BulkRefused::Nobody),
            asked if asked > MOST_PEOPLE => Err(BulkRefused::TooMany(MOST_PEOPLE)),
            _ if act.needs_cohort() && cohort.is_none() => Err(BulkRefused::NoCohort),
            _ => Ok(BulkRequest { act, cohort, people }),
        }
    }
}

/// Shows the people that the action would affect, and those it would skip.
pub(super) async fn show_bulk_act(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfForm(asked): CsrfForm<BulkAsked>,
) -> Result<Result<BulkPage, FormAnswer<PeoplePage>>, PageError> {
    let meant = asked.list_meant(&state, &person).await?;
    let request = match asked.request(meant) {
        Ok(request) => request,
        Err(why) => {
            let typed = BulkForm {
                acts: list_bulk_acts(asked.act()),
                ticked: asked.person.iter().map(PersonId::to_string).collect(),
                everybody: asked.everybody == "yes",
                ..BulkForm::default()
            };
            let page =
                make_directory_page(&state, Visit::new(&person, &csrf), asked.query(), FilledForm::default()).await?;
            return Ok(Err(FormAnswer::Refused(page.refuse_bulk_act(typed, why))));
        }
    };
    let plan = bulk::plan_bulk_act(&state, &person, &request).await?;
    let cohort = match request.cohort {
        Some(id) => cohorts::find_cohort(state.db.reader(), person.school_id, id).await.map_err(Error::from)?,
        None => None,
    };
    let option =
        |cohort: cohorts::Cohort| SelectOption { value: cohort.id.to_string(), label: cohort.name, chosen: true };
    let shell = Shell::new(&person, csrf.token(), NavPlace::People);
    Ok(Ok(BulkPage { shell, act: request.act, cohort: cohort.map(option), plan }))
}

/// A previewed action that is confirmed.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct BulkConfirmed {
    act: BulkAct,
    cohort: Option<CohortId>,
    #[serde(default)]
    person: Vec<PersonId>,
}

pub(super) async fn do_bulk_act(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    CsrfForm(BulkConfirmed { act, cohort, person: people }): CsrfForm<BulkConfirmed>,
) -> Result<Redirect, PageError> {
    let done = bulk::do_bulk_act(&state, &person, &BulkRequest { act, cohort, people }).await?;
    Ok(Redirect::to(&format!("/people?done={}&to={}", name_bulk_act(act), done.people.len())))
}
