//! The administrator's page of the papers that data protection asks for: the record of processing
//! activities with the settings in force.

mod record;

use std::collections::BTreeMap;

use askama::Template;
use askama_web::WebTemplate;
use model::privacy::recipient::Recipient;
use model::{FactorRule, Needed};
pub use record::ProcessingRecord;
use record::RecordSection;
use time::OffsetDateTime;

use crate::operations::settings::factor_rule_words;
use crate::training::trainee::needed_in_words;
use crate::{Shell, StatusWord, format};

/// The page of papers.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "operations/papers.html")]
pub struct PapersPage {
    /// Page frame.
    pub shell: Shell,
    /// Time of the request.
    pub at: OffsetDateTime,
    /// Settings of the school.
    pub facts: SchoolFacts,
    /// Where data goes: the systems that are set up. A missing kind is off.
    pub recipients: BTreeMap<Recipient, Vec<String>>,
    /// The record, in the language of the page if it is written in that.
    pub record: ProcessingRecord,
}

/// Settings that matter to data protection.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SchoolFacts {
    /// Name of the school.
    pub school: String,
    /// Who answers for the data and where to ask; empty if the school states nothing.
    pub data_notice: String,
    /// Months without activity after which a person is erased, and days of warning; `None` means
    /// never.
    pub erased_after: Option<(u32, u32)>,
    /// Whether free texts are erased with the person.
    pub erases_texts: bool,
    /// Whether recordings are erased with the person.
    pub erases_recordings: bool,
    /// Whether only administrators sign in with a password.
    pub passwords_of_administrators_only: bool,
    /// Who needs a second factor.
    pub factor_rule: FactorRule,
    /// Names of the directories that provision accounts.
    pub directories: Vec<String>,
    /// Whether reminders are mailed, and news.
    pub mails: [bool; 2],
    /// Whether trainees see figures of others.
    pub shows_others: bool,
    /// Proofs that certificates need.
    pub needed: Needed,
    /// Websites that may upload.
    pub origins: Vec<String>,
    /// Time of the last backup.
    pub backup_at: Option<OffsetDateTime>,
}

/// A setting on the page.
struct FactLine {
    name: &'static str,
    state: FactState,
    /// Where to change it.
    href: &'static str,
}

/// The state of a setting.
enum FactState {
    Said(String),
    On,
    Off,
}

impl FactLine {
    fn said(name: &'static str, words: impl Into<String>, href: &'static str) -> Self {
        Self { name, state: FactState::Said(words.into()), href }
    }

    const fn switch(name: &'static str, is_on: bool, href: &'static str) -> Self {
        Self { name, state: if is_on { FactState::On } else { FactState::Off }, href }
    }

    /// A list that is off if it is empty.
    fn list(name: &'static str, all: &[String], href: &'static str) -> Self {
        let state = if all.is_empty() { FactState::Off } else { FactState::Said(all.join(", ")) };
        Self { name, state, href }
    }
}

impl SchoolFacts {
    fn lines(&self) -> Vec<FactLine> {
        const SETTINGS: &str = "/admin/settings";
        const RETENTION: &str = "/admin/retention";
        let notice = match self.data_notice.as_str() {
            "" => tr!("not stated yet").to_owned(),
            notice => notice.to_owned(),
        };
        let erased = match self.erased_after {
            Some((months, days)) => {
                tr!("after {months} months without activity, with {days} days of warning", months = months, days = days)
            }
            None => tr!("off: nobody is erased automatically").to_owned(),
        };
        let passwords = match self.passwords_of_administrators_only {
            true => tr!("administrators only"),
            false => tr!("everybody"),
        };
        let backup = self.backup_at.map_or_else(|| tr!("none yet").to_owned(), format::format_date_time);
        let [reminders, news] = self.mails;
        vec![
            FactLine::said(tr!("Controller"), &self.school, SETTINGS),
            FactLine::said(tr!("Contact and notice"), notice, SETTINGS),
            FactLine::said(tr!("Erasure of inactive people"), erased, RETENTION),
            FactLine::switch(tr!("Free texts are erased with a person"), self.erases_texts, RETENTION),
            FactLine::switch(tr!("Recordings are erased with a person"), self.erases_recordings, RETENTION),
            FactLine::said(tr!("Sign-in by password"), passwords, "/admin/sign-in"),
            FactLine::said(tr!("Second factor required for"), factor_rule_words(self.factor_rule), SETTINGS),
            FactLine::list(tr!("Accounts from directories"), &self.directories, "/admin/provisioning"),
            FactLine::switch(tr!("Reminders by email"), reminders, SETTINGS),
            FactLine::switch(tr!("News by email"), news, SETTINGS),
            FactLine::switch(tr!("Trainees see figures of others"), self.shows_others, SETTINGS),
            FactLine::said(tr!("Counts for certificates"), needed_in_words(self.needed), SETTINGS),
            FactLine::list(tr!("Uploads from other sites"), &self.origins, "/admin/origins"),
            FactLine::said(tr!("Last backup"), backup, "/admin/backups"),
        ]
    }
}

/// A section of the record on the page.
struct ShownSection<'a> {
    heading: &'a str,
    paragraphs: &'a [String],
    head: Vec<String>,
    rows: Vec<ShownRow>,
    items: &'a [String],
}

/// A row of a table: each cell with its column, and the systems of a recipient.
struct ShownRow {
    cells: Vec<(String, String)>,
    systems: Option<Vec<String>>,
}

impl PapersPage {
    /// Returns the code of the record's language if it is not that of the page.
    fn foreign_language(&self) -> Option<&'static str> {
        (self.record.language != words::current().code()).then_some(self.record.language)
    }

    /// Returns the sections of the record. The activities are shown without the tables of the
    /// database, the recipients with their systems.
    fn sections(&self) -> Vec<ShownSection<'_>> {
        self.record.sections.iter().enumerate().map(|(number, section)| self.show_section(number, section)).collect()
    }

    fn show_section<'a>(&self, number: usize, section: &'a RecordSection) -> ShownSection<'a> {
        let mut rows = section.table.iter();
        let mut head: Vec<String> = rows.next().into_iter().flatten().map(|name| format::as_sentence(name)).collect();
        if number == ACTIVITIES {
            head.pop();
        }
        let cells = |row: &[String]| head.iter().cloned().zip(row.iter().cloned()).collect();
        let rows = rows.map(|row| ShownRow { cells: cells(row), systems: self.systems(row) }).collect();
        let RecordSection { heading, paragraphs, items, .. } = section;
        ShownSection { heading, paragraphs, head, rows, items }
    }

    /// Returns the systems of the recipient in a row; `None` in a row about something else.
    fn systems(&self, row: &[String]) -> Option<Vec<String>> {
        let recipient = Recipient::of_row(row.first()?).filter(|_| row.len() == RECIPIENT_COLUMNS)?;
        Some(self.recipients.get(&recipient).cloned().unwrap_or_default())
    }
}

/// Number of the section with the activities, whose last column lists tables of the database.
const ACTIVITIES: usize = 0;
/// Number of columns of the table of recipients.
const RECIPIENT_COLUMNS: usize = 3;

#[cfg(test)]
mod tests {
    //! Fails when a setting in force is missing from the page, or a disabled one is not shown as off.

    use model::Role;
    use words::Language;

    use super::*;
    use crate::samples;

    fn page() -> PapersPage {
        PapersPage {
            shell: samples::shell(Role::Administrator),
            at: samples::NOW,
            facts: SchoolFacts {
                school: "Nord <Schule>".to_owned(),
                data_notice: String::new(),
                erased_after: Some((24, 30)),
                erases_texts: true,
                erases_recordings: false,
                passwords_of_administrators_only: true,
                factor_rule: FactorRule::Teachers,
                directories: vec!["Entra".to_owned()],
                mails: [true, false],
                shows_others: false,
                needed: Needed::Supervised,
                origins: Vec::new(),
                backup_at: Some(samples::NOW),
            },
            recipients: BTreeMap::from([(Recipient::MailServer, vec!["mail.example.org".to_owned()])]),
            record: ProcessingRecord::in_language(Language::ENGLISH),
        }
    }

    #[test]
    fn papers_show_settings_and_what_is_off() {
        let html = samples::keep_page("papers", &page());
        for wanted in [
            "Nord &#60;Schule&#62;",
            "not stated yet",
            "24 months",
            "30 days",
            "Entra",
            "mail.example.org",
            "Article 32",
            "argon2id",
        ] {
            assert!(html.contains(wanted), "{wanted} is not in {html}");
        }
        let off = |html: &str| html.matches("Off</span>").count();
        assert_eq!(off(&html), 4 + Recipient::ALL.len() - 1, "switches, origins, and all recipients but one");
        let bare = PapersPage { recipients: BTreeMap::new(), ..page() };
        assert_eq!(off(&samples::keep_page("papers-bare", &bare)), 4 + Recipient::ALL.len());
    }
}
