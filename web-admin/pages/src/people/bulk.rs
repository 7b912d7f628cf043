//! Confirmation of bulk actions on people.

use std::borrow::Borrow;

use askama::Template;
use askama_web::WebTemplate;
use model::count_i64;
use model::people::directory::{BulkAct, BulkExemption, BulkPlan};

use super::{SelectOption, bulk};
use crate::Shell;
use crate::letters::MailWay;

/// Bulk actions, in the order of the list.
pub const BULK_ACTS: [BulkAct; 5] = [BulkAct::Invite, BulkAct::Join, BulkAct::Leave, BulkAct::Disable, BulkAct::Enable];

/// Input of the form below the list of people.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BulkForm {
    /// Actions to choose from.
    pub acts: Vec<SelectOption>,
    /// Cohorts to choose from.
    pub cohorts: Vec<SelectOption>,
    /// Ids of the ticked people.
    pub ticked: Vec<String>,
    /// Whether the action applies to all people found instead of the ticked ones.
    pub everybody: bool,
}

/// Reasons why a bulk action was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BulkRefused {
    /// No person is ticked.
    Nobody,
    /// No action is chosen.
    NoAct,
    /// No cohort is chosen.
    NoCohort,
    /// More people than the given maximum.
    TooMany(u32),
}

/// Result of a bulk action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BulkDone {
    /// The action.
    pub act: BulkAct,
    /// Number of people.
    pub people: i64,
    /// Where letters go.
    pub mail_way: MailWay,
}

/// The page that asks to confirm a bulk action.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "people/bulk.html")]
pub struct BulkPage {
    /// Page frame.
    pub shell: Shell,
    /// The action.
    pub act: BulkAct,
    /// The cohort of the action: id and name.
    pub cohort: Option<SelectOption>,
    /// The people affected, and those left out.
    pub plan: BulkPlan,
}

/// Returns the name of an action in addresses and forms.
#[must_use]
pub const fn name_bulk_act(act: BulkAct) -> &'static str {
    match act {
        BulkAct::Invite => "invite",
        BulkAct::Join => "join",
        BulkAct::Leave => "leave",
        BulkAct::Disable => "disable",
        BulkAct::Enable => "enable",
    }
}

/// Returns the actions as options.
#[must_use]
pub fn list_bulk_acts(chosen: Option<BulkAct>) -> Vec<SelectOption> {
    let word = |act| match act {
        BulkAct::Invite => tr!("Resend the invitation"),
        BulkAct::Join => tr!("Add to a cohort"),
        BulkAct::Leave => tr!("Remove from a cohort"),
        BulkAct::Disable => tr!("Disable"),
        BulkAct::Enable => tr!("Enable"),
    };
    let option = |act: BulkAct| SelectOption {
        value: name_bulk_act(act).to_owned(),
        label: word(act).to_owned(),
        chosen: chosen == Some(act),
    };
    BULK_ACTS.into_iter().map(option).collect()
}

/// Describes the result of a bulk action.
#[must_use]
pub fn say_bulk_done(done: &BulkDone) -> String {
    let n = done.people;
    match done.act {
        BulkAct::Invite if done.mail_way == MailWay::Folder => trn!(
            "{n} invitation was saved as a file on the server: no mail server is set up, so nobody receives it.",
            "{n} invitations were saved as files on the server: no mail server is set up, so nobody receives them.",
            n
        ),
        BulkAct::Invite => trn!("{n} invitation is being sent.", "{n} invitations are being sent.", n),
        BulkAct::Join => trn!("{n} person was added to the cohort.", "{n} people were added to the cohort.", n),
        BulkAct::Leave => {
            trn!("{n} person was removed from the cohort.", "{n} people were removed from the cohort.", n)
        }
        BulkAct::Disable => trn!(
            "{n} account was disabled: signed out everywhere, tokens revoked. Attempts and scores stay.",
            "{n} accounts were disabled: signed out everywhere, tokens revoked. Attempts and scores stay.",
            n
        ),
        BulkAct::Enable => trn!("{n} account was enabled.", "{n} accounts were enabled.", n),
    }
}

/// Describes why a bulk action was refused.
#[must_use]
pub fn say_bulk_refused(refused: &BulkRefused) -> String {
    match refused {
        BulkRefused::Nobody => tr!("Nobody is selected: tick people in the list first.").to_owned(),
        BulkRefused::NoAct => tr!("Choose an action.").to_owned(),
        BulkRefused::NoCohort => tr!("Choose a cohort.").to_owned(),
        BulkRefused::TooMany(most) => {
            tr!("Too many people are selected: at most {n} at once. Narrow the search.", n = most)
        }
    }
}

fn say_exemption(why: impl Borrow<BulkExemption>) -> &'static str {
    match why.borrow() {
        BulkExemption::Themselves => tr!("you cannot disable your own account"),
        BulkExemption::SignedUp => tr!("has already chosen a password"),
        BulkExemption::Disabled => tr!("the account is disabled"),
        BulkExemption::Enabled => tr!("the account is not disabled"),
        BulkExemption::Anonymous => tr!("was anonymised"),
        BulkExemption::Administrator => tr!("administrators cannot be in a cohort"),
        BulkExemption::Member => tr!("is already in the cohort"),
        BulkExemption::Stranger => tr!("is not in the cohort"),
    }
}

impl BulkPage {
    fn cohort_name(&self) -> &str {
        self.cohort.as_ref().map_or("", |cohort| cohort.label.as_str())
    }

    fn count(&self) -> i64 {
        count_i64(self.plan.people.len())
    }

    fn heading(&self) -> String {
        let n = self.count();
        match self.act {
            BulkAct::Invite => trn!("Resend {n} invitation", "Resend {n} invitations", n),
            BulkAct::Join => {
                trn!("Add {n} person to “{cohort}”", "Add {n} people to “{cohort}”", n, cohort = self.cohort_name())
            }
            BulkAct::Leave => trn!(
                "Remove {n} person from “{cohort}”",
                "Remove {n} people from “{cohort}”",
                n,
                cohort = self.cohort_name()
            ),
            BulkAct::Disable => trn!("Disable {n} account", "Disable {n} accounts", n),
            BulkAct::Enable => trn!("Enable {n} account", "Enable {n} accounts", n),
        }
    }

    fn consequence(&self) -> &'static str {
        match self.act {
            BulkAct::Invite => tr!("Links sent earlier no longer work."),
            BulkAct::Join => {
                tr!(
                    "Assignments of the cohort now apply to them, and the instructors of the cohort see their attempts."
                )
            }
            BulkAct::Leave => {
                tr!("The instructors of the cohort can no longer see their attempts. Attempts and scores are kept.")
            }
            BulkAct::Disable => tr!(
                "They are signed out everywhere, and their tokens are revoked. Attempts and scores stay. Can be undone."
            ),
            BulkAct::Enable => tr!("They can sign in again. Revoked tokens stay revoked."),
        }
    }

    fn exempt_summary(&self) -> String {
        let n = count_i64(self.plan.exempt.len());
        trn!("{n} person is skipped", "{n} people are skipped", n)
    }
}

#[cfg(test)]
mod tests {
    //! Every person left out must have a reason, and the names of actions must parse.

    use model::Role;
    use model::ids::PersonId;
    use model::people::directory::{AccountState, DirectoryEntry, ExemptPerson};

    use super::*;
    use crate::samples;

    fn listed(name: &str) -> DirectoryEntry {
        DirectoryEntry {
            id: PersonId::nil(),
            name: name.to_owned(),
            email: "ana@example.org".to_owned(),
            role: Role::Trainee,
            state: AccountState::Active,
            pseudonym: "p-1".to_owned(),
            registrar_id: None,
            cohorts: String::new(),
        }
    }

    #[test]
    fn who_is_left_out_is_named_with_the_reason() {
        let exempt = vec![ExemptPerson { person: listed("Bo <i>"), why: BulkExemption::Member }];
        let cohort = SelectOption { value: "c1".to_owned(), label: "Spring".to_owned(), chosen: true };
        let plan = BulkPlan { people: vec![listed("Ana"), listed("Cy")], exempt };
        let shell = samples::shell(Role::Administrator);
        let page = BulkPage { shell: shell.clone(), act: BulkAct::Join, cohort: Some(cohort), plan };
        let html = samples::keep_page("people-bulk", &page);
        assert!(html.contains("Add 2 people to “Spring”") && html.contains("is already in the cohort"), "{html}");
        assert!(html.contains("Bo &#60;i&#62;") && html.contains("name=\"cohort\" value=\"c1\""), "{html}");
        let page = BulkPage { shell, act: BulkAct::Enable, cohort: None, plan: BulkPlan::default() };
        let html = samples::keep_page("people-bulk-nobody", &page);
        assert!(!html.contains("/people/bulk/do"), "{html}");
    }

    #[test]
    fn the_acts_are_read_as_they_are_written() {
        for act in BULK_ACTS {
            let read: BulkAct = serde_json::from_value(name_bulk_act(act).into()).unwrap();
            assert_eq!(read, act);
        }
    }
}
