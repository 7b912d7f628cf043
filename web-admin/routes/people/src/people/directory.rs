//! `/people`: an administrator searches, adds, invites, changes, disables and erases people.

use acts::error::Error;
use acts::people::accounts;
use acts::people::accounts::NewAccount;
use axum::extract::{Query, State};
use axum::response::{IntoResponse, Redirect, Response};
use model::ids::{CohortId, PersonId, SchoolId};
use model::people::directory::{AccountState, BulkAct, DirectoryEntry, PeopleKey, PeopleOrder};
use model::people::email::{is_email, normalize_email, present_email};
use model::people::roster::is_name;
use model::search_key::split_search_words;
use model::{CurrentPerson, PersonKey, Role};
use pages::form::{FilledForm, SelectOption};
use pages::people::bulk::{BulkDone, BulkForm, list_bulk_acts};
use pages::people::{LinkPage, PeoplePage, PersonChangeDone, PersonForm, PersonPage, PersonRefused, SortHeading};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::{PathId, encode_in_query};
use routes_base::auth::{Administrator, Csrf, CsrfForm, NoFields, Visit};
use routes_base::error::PageError;
use routes_base::forms::FormAnswer;
use serde::Deserialize;
use store::auth::second_factors;
use store::letters::mails;
use store::people::directory;
use store::people::directory::{Details, Filter};
use store::privacy::retention;
use store::training::cohorts;

use crate::operations::settings::find_mail_way;

/// People on one page.
const PER_PAGE: u32 = 50;
const DAY_S: i64 = 86_400;

/// Filters of the list. Forms submit empty fields as empty texts, so all fields are read as texts.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct PeopleQuery {
    q: String,
    role: String,
    state: String,
    cohort: String,
    sort: String,
    down: String,
    after: String,
    id: String,
    added: Option<usize>,
    changed: Option<usize>,
    done: Option<BulkAct>,
    to: Option<i64>,
}

impl PeopleQuery {
    pub(super) fn looking_for(q: String, role: String, state: String, cohort: String) -> Self {
        Self { q, role, state, cohort, ..Self::default() }
    }

    fn role(&self) -> Option<Role> {
        self.role.parse().ok()
    }

    fn state(&self) -> Option<AccountState> {
        match self.state.as_str() {
            "active" => Some(AccountState::Active),
            "invited" => Some(AccountState::Invited),
            "disabled" => Some(AccountState::Disabled),
            "erased" => Some(AccountState::Erased),
            _ => None,
        }
    }

    fn order(&self) -> PeopleOrder {
        let by = match self.sort.as_str() {
            "email" => PeopleKey::Email,
            "number" => PeopleKey::Number,
            _ => PeopleKey::Name,
        };
        PeopleOrder { by, down: self.down == "yes" }
    }

    pub(super) fn filter(&self) -> Filter {
        Filter {
            words: split_search_words(&self.q),
            role: self.role(),
            state: self.state(),
            cohort: self.cohort.parse().ok(),
            order: self.order(),
            after: self.id.parse().ok().map(|id| (self.after.clone(), id)),
        }
    }

    /// Returns the address of the first page of the list in an order.
    fn href(&self, order: PeopleOrder) -> String {
        let pairs = [("q", &self.q), ("role", &self.role), ("state", &self.state), ("cohort", &self.cohort)];
        let kept: String = pairs.iter().map(|(name, value)| format!("{name}={}&", encode_in_query(value))).collect();
        format!("/people?{kept}sort={}&down={}", name_key(order.by), if order.down { "yes" } else { "" })
    }

    /// Returns the address of the page that begins after a person.
    fn after(&self, last: &DirectoryEntry) -> String {
        let order = self.order();
        format!("{}&after={}&id={}", self.href(order), encode_in_query(&order.key_of(last)), last.id)
    }

    fn heading(&self, by: PeopleKey) -> SortHeading {
        let order = self.order();
        let here = order.by == by;
        let href = self.href(PeopleOrder { by, down: here && !order.down });
        SortHeading { href, down: here.then_some(order.down) }
    }
}

const fn name_key(key: PeopleKey) -> &'static str {
    match key {
        PeopleKey::Name => "name",
        PeopleKey::Email => "email",
        PeopleKey::Number => "number",
    }
}

pub(super) async fn list_people(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    Query(query): Query<PeopleQuery>,
) -> Result<PeoplePage, PageError> {
    Ok(make_directory_page(&state, Visit::new(&person, &csrf), query, FilledForm::default()).await?)
}

pub(super) async fn make_directory_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    query: PeopleQuery,
    FilledForm { typed, refused }: FilledForm<NewPersonForm, PersonRefused>,
) -> Result<PeoplePage, Error> {
    let (school, filter) = (person.school_id, query.filter());
    let (mut rows, cohorts) = futures::try_join!(
        directory::list_people(state.db.reader(), school, &filter, PER_PAGE + 1),
        cohorts::list_cohorts(state.db.reader(), school),
    )?;
    let more = rows.len() > PER_PAGE as usize;
    rows.truncate(PER_PAGE as usize);
    let mail_way = find_mail_way(state);
    let choices = |chosen: Option<CohortId>| -> Vec<SelectOption> {
        let choice = |c: &cohorts::Cohort| SelectOption {
            value: c.id.to_string(),
            label: c.name.clone(),
            chosen: chosen == Some(c.id),
        };
        cohorts.iter().map(choice).collect()
    };
    Ok(PeoplePage {
        shell: Shell::new(person, csrf.token(), NavPlace::People),
        roles: SelectOption::roles(filter.role),
        states: SelectOption::states(filter.state),
        cohorts: choices(filter.cohort),
        by_name: query.heading(PeopleKey::Name),
        by_email: query.heading(PeopleKey::Email),
        by_number: query.heading(PeopleKey::Number),
        done: query.done.zip(query.to).map(|(act, people)| BulkDone { act, people, mail_way }),
        mail_way,
        bulk: FilledForm::new(BulkForm { acts: list_bulk_acts(None), cohorts: choices(None), ..BulkForm::default() }),
        next: rows.last().filter(|_| more).map(|last| query.after(last)),
        later: filter.after.is_some(),
        filtered: !filter.words.is_empty()
            || filter.role.is_some()
            || filter.state.is_some()
            || filter.cohort.is_some()
            || filter.after.is_some(),
        imported: query.added.zip(query.changed),
        form: FilledForm {
            typed: PersonForm {
                roles: SelectOption::roles(Some(typed.role().unwrap_or(Role::Trainee))),
                cohorts: choices(typed.cohort.parse().ok()),
                name: typed.name,
                email: typed.email,
                number: typed.number,
            },
            refused,
        },
        words: query.q,
        rows,
    })
}

/// The form to add a person.
#[derive(Clone, Debug, Default, Deserialize)]
pub(super) struct NewPersonForm {
    name: String,
    email: String,
    role: String,
    #[serde(default)]
    number: String,
    #[serde(default)]
    cohort: String,
}

impl NewPersonForm {
    fn role(&self) -> Option<Role> {
        self.role.parse().ok()
    }
}

/// What is wrong with what was typed of somebody; `own` is who they are, where they are known.
async fn find_refusal(
    state: &AppState,
    school: SchoolId,
    own: Option<PersonId>,
    details: Details<'_>,
) -> Result<Option<PersonRefused>, Error> {
    if !is_name(details.name) {
        return Ok(Some(PersonRefused::Name));
    }
    if !is_email(&normalize_email(details.email)) {
        return Ok(Some(PersonRefused::Email));
    }
    let Some(number) = details.registrar_id else { return Ok(None) };
    if !is_name(number) {
        return Ok(Some(PersonRefused::Number));
    }
    let holder = directory::find_number_holder(state.db.reader(), school, number).await?;
    Ok(holder.filter(|holder| Some(*holder) != own).map(|_| PersonRefused::NumberTaken))
}

/// Who somebody is said to be, as it was typed.
fn typed_details<'a>(name: &'a str, email: &'a str, number: &'a str) -> Details<'a> {
    Details { name: name.trim(), email: email.trim(), registrar_id: Some(number.trim()).filter(|n| !n.is_empty()) }
}

pub(super) async fn add_person(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<NewPersonForm>,
) -> Result<FormAnswer<PeoplePage>, PageError> {
    let details = typed_details(&form.name, &form.email, &form.number);
    let refused = match find_refusal(&state, person.school_id, None, details).await? {
        Some(refused) => refused,
        None => {
            let role = form.role().ok_or_else(|| Error::BadRequest(format!("role: \"{}\"", form.role)))?;
            // An administrator neither teaches nor learns.
            let cohort = form.cohort.parse().ok().filter(|_| role != Role::Administrator);
            match accounts::add(&state, &person, &NewAccount { details, role, cohort }).await? {
                Some(id) => return Ok(FormAnswer::lead_to(&format!("/people/{id}?done=added"))),
                None => PersonRefused::Taken,
            }
        }
    };
    let (visit, form) = (Visit::new(&person, &csrf), FilledForm::refused(form, refused));
    Ok(FormAnswer::Refused(make_directory_page(&state, visit, PeopleQuery::default(), form).await?))
}

/// Query parameter that names the change just made.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct DoneQuery {
    done: Option<PersonChangeDone>,
}

pub(super) async fn show_person(
    State(state): State<AppState>,
    Administrator(visitor): Administrator,
    PathId(id): PathId<PersonId>,
    csrf: Csrf,
    Query(DoneQuery { done }): Query<DoneQuery>,
) -> Result<PersonPage, PageError> {
    let person = find_person(&state, &visitor, id).await?;
    let form = FilledForm::new(PersonForm {
        name: person.name.clone(),
        email: present_email(&person.email).unwrap_or_default().to_owned(),
        number: person.registrar_id.clone().unwrap_or_default(),
        roles: SelectOption::roles(Some(person.role)),
        cohorts: Vec::new(),
    });
    Ok(PersonPage { done, ..make_person_page(&state, Visit::new(&visitor, &csrf), person, form).await? })
}

/// Returns a person of the administrator's school.
pub(crate) async fn find_person(
    state: &AppState,
    visitor: &CurrentPerson,
    id: PersonId,
) -> Result<DirectoryEntry, PageError> {
    Ok(directory::find_directory_entry(state.db.reader(), visitor.school_id, id).await?.ok_or(Error::NotFound)?)
}

async fn make_person_page(
    state: &AppState,
    Visit { person: visitor, csrf }: Visit<'_>,
    person: DirectoryEntry,
    form: FilledForm<PersonForm, PersonRefused>,
) -> Result<PersonPage, Error> {
    let key = PersonKey { school_id: visitor.school_id, person_id: person.id };
    Ok(PersonPage {
        shell: Shell::new(visitor, csrf.token(), NavPlace::People),
        own: visitor.id == person.id,
        done: None,
        mail_way: find_mail_way(state),
        second_factor: second_factors::is_second_factor_on(state.db.reader(), key).await?,
        held: retention::find_hold_time(state.db.reader(), visitor.school_id, person.id).await?.is_some(),
        trouble: mails::find_mail_trouble(state.db.reader(), visitor.school_id, person.id).await?,
        form,
        person,
    })
}

/// The form to change a person.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct PersonChangeForm {
    name: String,
    email: String,
    /// Empty: it stays as it is.
    #[serde(default)]
    number: String,
    role: Role,
}

pub(super) async fn change_person(
    State(state): State<AppState>,
    Administrator(visitor): Administrator,
    PathId(id): PathId<PersonId>,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<PersonChangeForm>,
) -> Result<FormAnswer<PersonPage>, PageError> {
    let person = find_person(&state, &visitor, id).await?;
    if person.state == AccountState::Erased {
        return Err(Error::Conflict(tr!("this person is anonymised; that cannot be undone").to_owned()).into());
    }
    // A person without an address may stay so.
    let is_kept = form.email.trim().is_empty() && present_email(&person.email).is_none();
    let email = if is_kept { &person.email } else { &form.email };
    let details = typed_details(&form.name, email, &form.number);
    let own_role = visitor.id == id && form.role != Role::Administrator;
    let refused = find_refusal(&state, visitor.school_id, Some(id), details).await?;
    let refused = match refused.or(own_role.then_some(PersonRefused::OwnRole)) {
        Some(refused) => refused,
        None => {
            if accounts::change(&state, &visitor, &person, details, form.role).await? {
                return Ok(FormAnswer::Answered(redirect_to_person(id, "changed")));
            }
            PersonRefused::Taken
        }
    };
    let roles = SelectOption::roles(Some(form.role));
    let typed = PersonForm { name: form.name, email: form.email, number: form.number, roles, cohorts: Vec::new() };
    let (visit, form) = (Visit::new(&visitor, &csrf), FilledForm::refused(typed, refused));
    Ok(FormAnswer::Refused(make_person_page(&state, visit, person, form).await?))
}

fn redirect_to_person(id: PersonId, what: &str) -> Response {
    Redirect::to(&format!("/people/{id}?done={what}")).into_response()
}

pub(super) async fn mail_link(
    State(state): State<AppState>,
    Administrator(visitor): Administrator,
    PathId(id): PathId<PersonId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Response, PageError> {
    let person = find_person(&state, &visitor, id).await?;
    accounts::mail_link(&state, &visitor, &person).await?;
    Ok(redirect_to_person(id, "mailed"))
}

/// Creates a link and renders it directly: with a redirect it would have to be stored until it is
/// shown.
pub(super) async fn show_link(
    State(state): State<AppState>,
    Administrator(visitor): Administrator,
    PathId(id): PathId<PersonId>,
    csrf: Csrf,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<LinkPage, PageError> {
    let person = find_person(&state, &visitor, id).await?;
    let (link, lifetime_s) = accounts::hand_over_link(&state, &visitor, &person).await?;
    let shell = Shell::new(&visitor, csrf.token(), NavPlace::People);
    Ok(LinkPage { shell, person, link, days: lifetime_s / DAY_S })
}

pub(super) async fn disable_person(
    State(state): State<AppState>,
    Administrator(visitor): Administrator,
    PathId(id): PathId<PersonId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Response, PageError> {
    find_person(&state, &visitor, id).await?;
    refuse_own_account(&visitor, id)?;
    accounts::disable(&state, &visitor, id).await?;
    Ok(redirect_to_person(id, "disabled"))
}

pub(crate) fn refuse_own_account(visitor: &CurrentPerson, id: PersonId) -> Result<(), Error> {
    if visitor.id == id {
        return Err(Error::Conflict(tr!("you cannot disable your own account: ask another administrator").to_owned()));
    }
    Ok(())
}

pub(super) async fn enable_person(
    State(state): State<AppState>,
    Administrator(visitor): Administrator,
    PathId(id): PathId<PersonId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Response, PageError> {
    find_person(&state, &visitor, id).await?;
    accounts::enable(&state, &visitor, id).await?;
    Ok(redirect_to_person(id, "enabled"))
}
