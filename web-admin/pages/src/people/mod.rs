//! User administration: the people of a school.

pub mod bulk;
pub mod listed;
pub mod provisioning;
pub mod roster;

use std::borrow::Borrow;

use askama::Template;
use askama_web::WebTemplate;
use model::Role;
use model::letters::mail::MailTrouble;
use model::people::directory::{AccountState, DirectoryEntry};
use model::training::membership::MembershipRequest;

use self::bulk::{BulkDone, BulkForm, BulkRefused};
use crate::form::{FilledForm, SelectOption};
use crate::letters::MailWay;
use crate::people::listed::ListPart;
use crate::{Shell, StatusWord, format, people};

/// All roles, in the order of selection.
pub const ROLES: [Role; 3] = [Role::Trainee, Role::Instructor, Role::Administrator];

/// The list of people.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "people/list.html")]
pub struct PeoplePage {
    /// Page frame.
    pub shell: Shell,
    /// Search text for name and address.
    pub words: String,
    /// Roles to filter by.
    pub roles: Vec<SelectOption>,
    /// Account states to filter by.
    pub states: Vec<SelectOption>,
    /// Cohorts to filter by.
    pub cohorts: Vec<SelectOption>,
    /// Heading that sorts by name.
    pub by_name: SortHeading,
    /// Heading that sorts by address.
    pub by_email: SortHeading,
    /// Heading that sorts by the registrar's number.
    pub by_number: SortHeading,
    /// Result of the latest bulk action.
    pub done: Option<BulkDone>,
    /// Where letters go.
    pub mail_way: MailWay,
    /// What is to be done to many, and why it was not.
    pub bulk: FilledForm<BulkForm, BulkRefused>,
    /// People found.
    pub rows: Vec<DirectoryEntry>,
    /// Address of the next page.
    pub next: Option<String>,
    /// Whether this is a page after the first.
    pub later: bool,
    /// Whether a filter is active.
    pub filtered: bool,
    /// Numbers of people added and changed by the roster import that has just finished.
    pub imported: Option<(usize, usize)>,
    /// The form that adds a person.
    pub form: FilledForm<PersonForm, PersonRefused>,
}

/// A heading that sorts the list.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SortHeading {
    /// Address of the list sorted by this column; in descending order if it is already sorted by
    /// it.
    pub href: String,
    /// `None` if the list is not sorted by this column, else whether the order is descending.
    pub down: Option<bool>,
}

impl SortHeading {
    const fn direction(&self) -> &'static str {
        match self.down {
            None => "none",
            Some(false) => "ascending",
            Some(true) => "descending",
        }
    }

    const fn arrow(&self) -> &'static str {
        match self.down {
            None => "",
            Some(false) => "▲",
            Some(true) => "▼",
        }
    }
}

/// Input of the form that adds or changes a person.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PersonForm {
    /// Name.
    pub name: String,
    /// Email address.
    pub email: String,
    /// What the registrar knows them by.
    pub number: String,
    /// Roles to choose from.
    pub roles: Vec<SelectOption>,
    /// Cohorts to choose from.
    pub cohorts: Vec<SelectOption>,
}

/// Reasons why a person was not added or changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PersonRefused {
    /// The name is invalid.
    Name,
    /// The email address is invalid.
    Email,
    /// The email address cannot be used.
    Taken,
    /// This is no number.
    Number,
    /// Somebody else of the school has the number.
    NumberTaken,
    /// Nobody takes the administrator's role from themselves.
    OwnRole,
}

/// The change that was just made to a person.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PersonChangeDone {
    /// Added.
    Added,
    /// Changed.
    Changed,
    /// A mail with a link was queued.
    Mailed,
    /// Disabled.
    Disabled,
    /// Enabled.
    Enabled,
    /// Anonymized.
    Erased,
    /// Second factor removed.
    Unfactored,
}

/// The page of a person.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "people/person.html")]
pub struct PersonPage {
    /// Page frame.
    pub shell: Shell,
    /// The person.
    pub person: DirectoryEntry,
    /// Whether the person is the visitor.
    pub own: bool,
    /// Whether the person is on legal hold.
    pub held: bool,
    /// The change that was just made.
    pub done: Option<PersonChangeDone>,
    /// Where letters go.
    pub mail_way: MailWay,
    /// Why their last mail with a link is not known to have gone out.
    pub trouble: Option<MailTrouble>,
    /// Whether a second factor is set up.
    pub second_factor: bool,
    /// The form that changes name, address and role.
    pub form: FilledForm<PersonForm, PersonRefused>,
}

/// A sign-in link for an administrator to hand over, shown only once.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "people/link.html")]
pub struct LinkPage {
    /// Page frame.
    pub shell: Shell,
    /// The person the link is for.
    pub person: DirectoryEntry,
    /// The link.
    pub link: String,
    /// Validity of the link, in days.
    pub days: i64,
}

/// The page of a cohort's members.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "people/cohort.html")]
pub struct CohortPeoplePage {
    /// Page frame.
    pub shell: Shell,
    /// Address of the cohort's page.
    pub href: String,
    /// Name of the cohort.
    pub name: String,
    /// Those of the instructors and trainees whom the page shows, in this order.
    pub members: Vec<CohortMember>,
    /// Which they are.
    pub list: ListPart,
    /// Who is asked for, and has not answered.
    pub requests: Vec<MembershipRequest>,
    /// The form that adds a person by email address.
    pub email: FilledForm<String, UnknownAddress>,
}

/// Somebody of a cohort.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CohortMember {
    /// Their id.
    pub id: String,
    /// Their name.
    pub name: String,
    /// Their part in it.
    pub role: Role,
}

/// Nobody who can be in a cohort has the address that was typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownAddress;

impl SelectOption {
    /// Returns all roles as options.
    #[must_use]
    pub fn roles(chosen: Option<Role>) -> Vec<Self> {
        let choice = |role: Role| Self {
            value: role.to_string(),
            label: format::as_sentence(role.said()),
            chosen: chosen == Some(role),
        };
        ROLES.into_iter().map(choice).collect()
    }

    /// Returns all account states as options.
    #[must_use]
    pub fn states(chosen: Option<AccountState>) -> Vec<Self> {
        let all = [
            (AccountState::Active, "active"),
            (AccountState::Invited, "invited"),
            (AccountState::Disabled, "disabled"),
            (AccountState::Erased, "erased"),
        ];
        let choice = |(state, value): (AccountState, &str)| Self {
            value: value.to_owned(),
            label: badge_word(state).to_owned(),
            chosen: chosen == Some(state),
        };
        all.into_iter().map(choice).collect()
    }
}

impl PeoplePage {
    /// Returns the page with the reason why a bulk action was refused.
    #[must_use]
    pub fn refuse_bulk_act(self, typed: BulkForm, why: BulkRefused) -> Self {
        let cohorts = self.bulk.typed.cohorts.clone();
        Self { bulk: FilledForm::refused(BulkForm { cohorts, ..typed }, why), ..self }
    }

    fn chosen(options: &[SelectOption]) -> &str {
        options.iter().find(|option| option.chosen).map_or("", |option| option.value.as_str())
    }

    fn is_ticked(&self, person: &DirectoryEntry) -> bool {
        self.bulk.typed.ticked.contains(&person.id.to_string())
    }
}

impl PersonPage {
    fn erased(&self) -> bool {
        self.person.state == AccountState::Erased
    }

    fn disabled(&self) -> bool {
        self.person.state == AccountState::Disabled
    }

    fn invited(&self) -> bool {
        self.person.state == AccountState::Invited
    }
}

fn badge_word(state: AccountState) -> &'static str {
    match state {
        AccountState::Active => tr!("Active"),
        AccountState::Invited => tr!("Invited"),
        AccountState::Disabled => tr!("Disabled"),
        AccountState::Erased => tr!("Anonymous"),
    }
}

/// Returns the badge of an account's state.
#[must_use]
pub fn state_badge(state: impl Borrow<AccountState>) -> String {
    let state = *state.borrow();
    let status = match state {
        AccountState::Active => StatusWord::OnTrack,
        AccountState::Invited => StatusWord::Waiting,
        AccountState::Disabled => StatusWord::Refused,
        AccountState::Erased => StatusWord::Locked,
    };
    status.badge_saying(badge_word(state))
}

#[cfg(test)]
mod tests {
    //! The page must show the next step, and keep user input without executing it.

    use model::ids::PersonId;

    use super::*;
    use crate::people::listed::ListQuery;
    use crate::samples;

    fn listed(name: &str, state: AccountState) -> DirectoryEntry {
        DirectoryEntry {
            id: PersonId::nil(),
            name: name.to_owned(),
            email: "ana@example.org".to_owned(),
            role: Role::Trainee,
            state,
            pseudonym: "p-1".to_owned(),
            registrar_id: Some("4711".to_owned()),
            cohorts: "Spring 2026".to_owned(),
        }
    }

    fn list(rows: Vec<DirectoryEntry>, filtered: bool) -> PeoplePage {
        PeoplePage {
            shell: samples::shell(Role::Administrator),
            words: "<ana".to_owned(),
            roles: SelectOption::roles(Some(Role::Trainee)),
            states: SelectOption::states(None),
            cohorts: vec![],
            by_name: SortHeading { href: "/people?sort=name".to_owned(), down: Some(false) },
            by_email: SortHeading::default(),
            by_number: SortHeading::default(),
            done: Some(BulkDone {
                act: model::people::directory::BulkAct::Disable,
                people: 2,
                mail_way: MailWay::Server,
            }),
            mail_way: MailWay::Folder,
            bulk: FilledForm::refused(
                BulkForm { acts: bulk::list_bulk_acts(None), ..BulkForm::default() },
                BulkRefused::Nobody,
            ),
            next: Some("/people?after=x".to_owned()),
            later: true,
            filtered,
            imported: Some((3, 1)),
            form: FilledForm::refused(
                PersonForm { roles: SelectOption::roles(None), ..PersonForm::default() },
                PersonRefused::Taken,
            ),
            rows,
        }
    }

    #[test]
    fn the_list_shows_states_and_keeps_what_was_typed() {
        let states = [AccountState::Active, AccountState::Invited, AccountState::Disabled, AccountState::Erased];
        let html = samples::keep_page("people", &list(states.map(|state| listed("Ana", state)).to_vec(), true));
        assert!(
            html.contains("value=\"&#60;ana\"") && html.contains("Invited") && html.contains("Anonymous"),
            "{html}"
        );
        assert!(html.contains("3 people added, 1 changed") && html.contains("cannot be used"), "{html}");
        assert!(samples::keep_page("people-none", &list(vec![], true)).contains("No people found"));
        assert!(samples::keep_page("people-empty", &list(vec![], false)).contains("Import a roster"));
    }

    #[test]
    fn a_person_can_be_invited_disabled_or_enabled_as_they_stand() {
        let page = |state, own| PersonPage {
            shell: samples::shell(Role::Administrator),
            person: listed("Ana", state),
            own,
            held: own,
            done: Some(PersonChangeDone::Mailed),
            mail_way: MailWay::Folder,
            trouble: Some(MailTrouble::Unsent("the mail server rejected the email".to_owned())),
            second_factor: true,
            form: FilledForm::new(PersonForm {
                name: "Ana".to_owned(),
                roles: SelectOption::roles(None),
                ..PersonForm::default()
            }),
        };
        let invited = samples::keep_page("person-invited", &page(AccountState::Invited, false));
        assert!(
            invited.contains("Resend the invitation")
                && invited.contains("nobody receives it")
                && invited.contains("rejected the email"),
            "{invited}"
        );
        let disabled = samples::keep_page("person-disabled", &page(AccountState::Disabled, false));
        assert!(disabled.contains("/enable\"") && !disabled.contains("/disable\""), "{disabled}");
        let own = samples::keep_page("person-own", &page(AccountState::Active, true));
        assert!(disabled.contains("second-factor/reset") && !own.contains("second-factor/reset"), "{own}");
        assert!(!own.contains("/disable\"") && !own.contains("/erase\""), "nobody locks themselves out: {own}");
        let erased = samples::keep_page("person-erased", &page(AccountState::Erased, false));
        assert!(!erased.contains("/change\""), "{erased}");
    }

    #[test]
    fn a_link_and_a_cohort_render() {
        let shell = samples::shell(Role::Administrator);
        let person = listed("Ana", AccountState::Invited);
        let link = LinkPage { shell: shell.clone(), person, link: "https://x/join/1".to_owned(), days: 14 };
        assert!(samples::keep_page("person-link", &link).contains("https://x/join/1"));
        let members = vec![CohortMember { id: "1".to_owned(), name: "Ana <b>".to_owned(), role: Role::Trainee }];
        let (members, list) = ListPart::of(ListQuery::default(), members, |one| &one.name);
        let (href, name) = ("/cohorts/1".to_owned(), "Spring".to_owned());
        let requests = vec![samples::request()];
        let email = FilledForm::refused("x@y.z".to_owned(), UnknownAddress);
        let page = CohortPeoplePage { shell, href, name, members, list, requests, email };
        let html = samples::keep_page("cohort-people", &page);
        assert!(html.contains("Ana &#60;b&#62;") && html.contains("value=\"x@y.z\""), "{html}");
    }
}
