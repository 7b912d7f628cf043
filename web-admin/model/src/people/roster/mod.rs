//! Rosters as exported by registrars: parsed, validated line by line, and compared with the people
//! of the school.
//!
//! Pure functions of the file and the people, which return a [`RosterDifference`]. People who are
//! not in the file are removed from cohorts only on request.

use std::collections::{BTreeMap, BTreeSet};

use csv::StringRecord;
use serde::{Deserialize, Serialize};

use crate::Role;
use crate::people::email::{is_email, is_odd_in_email, normalize_email};
use crate::search_key::look_alike_key;

mod cell_format;
mod checked_text;
mod columns;
mod difference;
mod mapping;
mod members;
mod quotes;
mod repeats;
mod sheet;
mod table;
mod text;

use checked_text::check_text;
pub use checked_text::is_name;
pub use columns::{RosterColumn, meaning};
pub use difference::{
    Leaving, LineOutcome, RosterChange, RosterDifference, RosterOutcome, RosterRequest, SchoolPerson,
};
pub use mapping::{GroupSplit, MappingDoubt, MappingGuess, RosterMapping};
pub use members::{CourseMember, CourseRoster, KnownMember, KnownMembers, MemberIdentity};
pub use sheet::{WorkbookSheet, is_workbook};
pub use table::RosterTable;
pub(crate) use table::read_csv;

/// Maximum number of lines per file.
pub const MAX_ROWS: usize = 20_000;
/// Maximum number of columns per file.
pub const MAX_COLUMNS: usize = 500;

/// Reason why a whole file is refused.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
pub enum Unreadable {
    /// It contains no line other than the headings.
    #[error("{}", tr!("the file contains no people"))]
    Empty,
    /// It contains too many lines.
    #[error("{}", tr!("the file has more than {most} people; send it in parts", most = MAX_ROWS))]
    TooLong,
    /// It contains too many columns.
    #[error("{}", tr!("the file has more than {most} columns; delete the ones that are not needed", most = MAX_COLUMNS))]
    TooWide,
    /// The unpacked workbook exceeds the size limit.
    #[error("{}", tr!("the workbook is too large: keep only the list of people in it, or save it as CSV"))]
    TooMuch,
    /// The workbook is corrupt, or its sheet has no table.
    #[error("{}", tr!("the workbook cannot be read: save it again as .xlsx, or as CSV"))]
    NotSheet,
    /// All sheets of the workbook are hidden or contain no cells.
    #[error("{}", tr!("every sheet of the workbook is hidden or a chart: show the sheet with the list of people, and save the workbook"))]
    NoVisibleSheet,
    /// It is a workbook in Excel's binary format.
    #[error("{}", tr!("this is a binary workbook (.xlsb): save it as .xlsx, or as CSV"))]
    BinaryExcel,
    /// It is an OpenDocument spreadsheet.
    #[error("{}", tr!("this is an OpenDocument sheet (.ods): save it as .xlsx, or as CSV"))]
    OpenDocument,
    /// The workbook is encrypted with a password.
    #[error("{}", tr!("a password protects the workbook: save it without one, or as CSV"))]
    Sealed,
    /// It is an archive of other files; contains the name of the one that may be the roster.
    #[error("{}", say_archive(.0.as_deref()))]
    Archive(Option<String>),
    /// A quoted field is not closed at its end.
    #[error("{}", tr!("line {line}: a quotation mark opens a field and is not closed at the field’s end, so the following lines cannot be separated. Correct the line, and send the file again", line = .line))]
    OpenQuote {
        /// Line number, from 1.
        line: u64,
    },
    /// It is a workbook from before 2007.
    #[error("{}", tr!("this is an Excel file in the old format (.xls): save it as .xlsx, or as CSV"))]
    OldExcel,
    /// It is not valid CSV.
    #[error("{}", tr!("line {line}: {why}", line = .line, why = .why))]
    NotCsv {
        /// Line number, from 1.
        line: u64,
        /// Error of the CSV parser.
        why: String,
    },
}

fn say_archive(people: Option<&str>) -> String {
    match people {
        Some(file) => tr!("this is a zip archive: unpack it, and send only {file}", file = file),
        None => tr!("this is a zip archive, not a workbook: unpack it, and send the list of people as .xlsx or CSV")
            .to_owned(),
    }
}

/// Reason why a line is refused.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// The email address is missing.
    NoEmail,
    /// The email address is invalid.
    BadEmail(String),
    /// The email address has no domain, or an incomplete one.
    NoDomain(String),
    /// A gradebook line with the maximum points.
    PointsPossible,
    /// The test student of a course.
    TestStudent,
    /// All columns that are read are empty.
    NobodyNamed,
    /// The person is marked as deleted in the file and does not exist here.
    GoneElsewhere,
    /// The name is missing.
    NoName,
    /// A spreadsheet would execute this text as a formula.
    Formula(String),
    /// The text is too long, or contains characters that cannot be shown.
    BadText(String),
    /// The role is neither trainee nor instructor.
    BadRole(String),
    /// The status is neither active nor deleted.
    BadStatus(String),
    /// The formula in this column has no stored result.
    Unsolved(String),
    /// The line concerns the same person as an earlier line and was merged with it.
    SamePerson(u64),
    /// An earlier line has the same email address and contradictory data.
    SameEmail(u64),
    /// An earlier line has the same registration number.
    SameRegistrarId(u64),
    /// Another person of the school has this email address.
    EmailOfAnother,
    /// The person has another role here; a roster changes no roles.
    OtherRole(Role),
    /// The person does not learn in the course of the learning platform, or teaches there, too.
    NoLearner,
    /// Another person of the school has this registration number.
    NumberOfAnother,
}

/// Status of an account.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum AccountStanding {
    /// The account is to be enabled.
    Active,
    /// The account is to be disabled.
    Gone,
}

/// A valid line.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RosterEntry {
    /// Email address, in lower case.
    pub email: String,
    /// Name.
    pub name: String,
    /// Registration number.
    pub registrar_id: Option<String>,
    /// Names of the cohorts to join.
    pub cohorts: Vec<String>,
    /// Role, if given.
    pub role: Option<Role>,
    /// Status of the account, if given.
    pub standing: Option<AccountStanding>,
    /// Identity that the person gets.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub identity: Option<MemberIdentity>,
}

/// A line of a roster.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RosterRow {
    /// Line number in the file, from 1.
    pub line: u64,
    /// The person, or the reason for refusing the line.
    pub entry: Result<RosterEntry, Box<RefusedLine>>,
}

/// A line that is not imported.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RefusedLine {
    /// Text that identifies the line.
    pub shown: String,
    /// Reason.
    pub refusal: Refusal,
    /// Identity in the line: a person mentioned in the file is not removed from a cohort as
    /// missing.
    pub mention: LineMention,
}

impl RefusedLine {
    fn of_entry(RosterEntry { email, name, registrar_id, .. }: &RosterEntry, refusal: Refusal) -> Self {
        let mention = LineMention { email: email.clone(), name: name.clone(), registrar_id: registrar_id.clone() };
        Self { shown: mention.shown(), refusal, mention }
    }
}

/// The identity given in a line, correct or not.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LineMention {
    /// Email address.
    pub email: String,
    /// Name.
    pub name: String,
    /// Registration number.
    pub registrar_id: Option<String>,
}

impl LineMention {
    fn shown(&self) -> String {
        match (self.name.as_str(), self.email.as_str()) {
            ("", email) => email.to_owned(),
            (name, "") => name.to_owned(),
            (name, email) => format!("{name} <{email}>"),
        }
    }
}

/// A parsed roster.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Roster {
    /// Lines.
    pub rows: Vec<RosterRow>,
    /// Headings of columns that are not read.
    pub ignored: Vec<String>,
}

impl Roster {
    /// Unifies cohort names that differ only in case, spaces or composition: uses the spelling of
    /// the school's cohort, or else the first one in the file. `cohort` is the cohort for lines
    /// that name none.
    pub fn spell_cohorts(&mut self, known: impl IntoIterator<Item = String>, cohort: &mut Option<String>) {
        let mut spellings: BTreeMap<String, String> = BTreeMap::new();
        let exact: BTreeSet<String> = known.into_iter().collect();
        for name in &exact {
            spellings.entry(look_alike_key(name)).or_insert_with(|| name.clone());
        }
        let named = self.rows.iter_mut().filter_map(|row| row.entry.as_mut().ok());
        for name in cohort.iter_mut().chain(named.flat_map(|entry| &mut entry.cohorts)) {
            if !exact.contains(name) {
                name.clone_from(spellings.entry(look_alike_key(name)).or_insert_with(|| name.clone()));
            }
        }
        for entry in self.rows.iter_mut().filter_map(|row| row.entry.as_mut().ok()) {
            let mut seen = BTreeSet::new();
            entry.cohorts.retain(|cohort| seen.insert(cohort.clone()));
        }
    }
}

/// Parses a roster with the detected meanings of its columns.
///
/// # Errors
/// If the whole file is refused, with the reason.
pub fn read(bytes: &[u8]) -> Result<Roster, Unreadable> {
    let table = RosterTable::read(bytes)?;
    Ok(table.people(&table.guess().mapping))
}

/// Fields of a line, by the meaning of the columns.
struct LineFields<'a> {
    record: &'a StringRecord,
    mapping: &'a RosterMapping,
}

impl<'a> LineFields<'a> {
    fn of(&self, column: RosterColumn) -> &'a str {
        self.mapping.columns.get(&column).and_then(|index| self.record.get(*index)).unwrap_or_default()
    }

    fn given(&self, column: RosterColumn) -> Option<&'a str> {
        Some(self.of(column)).filter(|text| !text.is_empty())
    }

    /// Returns the name, with the given name first.
    fn name(&self) -> String {
        let whole = format!("{} {}", self.of(RosterColumn::Given), self.of(RosterColumn::Family)).trim().to_owned();
        if whole.is_empty() { turn_name(self.of(RosterColumn::Name)) } else { whole }
    }

    fn role(&self) -> Result<Option<Role>, Refusal> {
        let read = |text: &str| role(text).ok_or_else(|| Refusal::BadRole(text.to_owned()));
        self.given(RosterColumn::Role).map(read).transpose()
    }

    /// Returns the status of the account. A negative statement in any column outweighs positive
    /// ones; "not deleted" by itself is neither.
    fn standing(&self) -> Result<Option<AccountStanding>, Refusal> {
        let refused = |text: &str| Refusal::BadStatus(text.to_owned());
        let word = |column| self.given(column).map(|text| standing(text).ok_or_else(|| refused(text))).transpose();
        let flag = |column| self.given(column).map(|text| flag(text).ok_or_else(|| refused(text))).transpose();
        let (status, enabled) = (word(RosterColumn::Status)?, word(RosterColumn::Enabled)?);
        let (suspended, deleted) = (flag(RosterColumn::Suspended)?, flag(RosterColumn::Deleted)?);
        let gone = suspended == Some(true) || deleted == Some(true);
        let said = [gone.then_some(AccountStanding::Gone), suspended.map(|_| AccountStanding::Active), status, enabled];
        let is_gone = said.contains(&Some(AccountStanding::Gone));
        Ok(if is_gone { Some(AccountStanding::Gone) } else { said.into_iter().flatten().next() })
    }
}

/// Parses a line. `unsolved` is the heading of a column whose formula has no stored result in this
/// line.
fn entry(
    record: &StringRecord,
    mapping: &RosterMapping,
    unsolved: Option<String>,
) -> Result<RosterEntry, Box<RefusedLine>> {
    let fields = LineFields { record, mapping };
    let name = fields.name();
    let email = address_of(fields.given(RosterColumn::Email), fields.given(RosterColumn::Login), mapping);
    let registrar_id = fields.given(RosterColumn::RegistrarId).map(str::to_owned);
    let mention = LineMention { email: email.clone(), name: name.clone(), registrar_id: registrar_id.clone() };
    let refused = |refusal| Box::new(RefusedLine { shown: mention.shown(), refusal, mention: mention.clone() });
    check_person(record, &name).map_err(|refusal| {
        let shown = record.get(0).unwrap_or_default().to_owned();
        Box::new(RefusedLine { shown, refusal, mention: LineMention::default() })
    })?;
    if let Some(heading) = unsolved {
        return Err(refused(Refusal::Unsolved(heading)));
    }
    if mapping.columns.values().all(|index| record.get(*index).unwrap_or_default().is_empty()) {
        return Err(refused(Refusal::NobodyNamed));
    }
    for column in
        [RosterColumn::Name, RosterColumn::Given, RosterColumn::Family, RosterColumn::RegistrarId, RosterColumn::Cohort]
    {
        check_text(fields.of(column)).map_err(refused)?;
    }
    check_email(&email).map_err(refused)?;
    if name.is_empty() {
        return Err(refused(Refusal::NoName));
    }
    Ok(RosterEntry {
        role: fields.role().map_err(refused)?,
        standing: fields.standing().map_err(refused)?,
        cohorts: mapping.split.groups(fields.of(RosterColumn::Cohort)),
        registrar_id,
        email,
        name,
        identity: None,
    })
}

/// Converts "Family, Given" to "Given Family"; a degree after the name stays behind it.
fn turn_name(name: &str) -> String {
    let Some((family, given)) = name.split_once(',').map(|(family, given)| (family.trim(), given.trim())) else {
        return name.to_owned();
    };
    let plain: String = given.to_lowercase().chars().filter(|c| c.is_alphanumeric()).collect();
    let degree = ["md", "phd", "dr", "jr", "sr", "rn", "msc", "bsc", "mbbs", "do", "ba", "ma", "mba"];
    if family.is_empty() || given.is_empty() || given.contains(',') || degree.contains(&plain.as_str()) {
        return name.to_owned();
    }
    format!("{given} {family}")
}

/// Returns the email address in lower case. A login that is an address replaces a missing address.
fn address_of(email: Option<&str>, login: Option<&str>, mapping: &RosterMapping) -> String {
    let has_emails = mapping.columns.contains_key(&RosterColumn::Email);
    let login = login.filter(|login| !has_emails || login.contains('@') || mapping.domain.is_some());
    let address = normalize_email(email.or(login).unwrap_or_default());
    match &mapping.domain {
        Some(domain) if !address.is_empty() && !address.contains('@') => {
            normalize_email(&format!("{address}@{domain}"))
        }
        _ => address,
    }
}

/// Refuses gradebook lines that do not concern a person.
fn check_person(record: &StringRecord, name: &str) -> Result<(), Refusal> {
    let first = record.get(0).unwrap_or_default().to_lowercase();
    if ["points possible", "punkte möglich", "mögliche punkte"].contains(&first.as_str()) {
        return Err(Refusal::PointsPossible);
    }
    if ["student, test", "test student"].contains(&first.as_str()) || name.eq_ignore_ascii_case("test student") {
        return Err(Refusal::TestStudent);
    }
    Ok(())
}

fn check_email(email: &str) -> Result<(), Refusal> {
    if email.is_empty() {
        return Err(Refusal::NoEmail);
    }
    if is_email(email) {
        return Ok(());
    }
    let bare = email.split_once('@').is_none_or(|(_, host)| !host.contains(['.', '@']));
    let spoilt = email.starts_with('@') || email.contains(is_odd_in_email);
    Err(if bare && !spoilt { Refusal::NoDomain(email.to_owned()) } else { Refusal::BadEmail(email.to_owned()) })
}

/// Normalizes a word: lower case, letters and digits only. "Tutor/-innen" and "tutorinnen" are
/// equal.
fn plain_word(text: &str) -> String {
    text.to_lowercase().chars().filter(|c| c.is_alphanumeric()).collect()
}

fn role(text: &str) -> Option<Role> {
    const TRAINEE: [&str; 19] = [
        "trainee",
        "student",
        "students",
        "learner",
        "studentother",
        "studierende",
        "studierender",
        "studentin",
        "studentinnen",
        "studenten",
        "autor",
        "autorin",
        "autorinnen",
        "teilnehmer",
        "teilnehmerin",
        "teilnehmende",
        "teilnehmerinnen",
        "leser",
        "leserinnen",
    ];
    const INSTRUCTOR: [&str; 20] = [
        "instructor",
        "teacher",
        "editingteacher",
        "noneditingteacher",
        "tutor",
        "tutorin",
        "tutorinnen",
        "lehrende",
        "lehrender",
        "lehrperson",
        "lehrkraft",
        "dozent",
        "dozentin",
        "dozentinnen",
        "dozenten",
        "dozierende",
        "trainer",
        "trainerin",
        "trainerinnen",
        "ta",
    ];
    let word = plain_word(text);
    let is = |words: &[&str]| words.contains(&word.as_str());
    if is(&TRAINEE) {
        return Some(Role::Trainee);
    }
    is(&INSTRUCTOR).then_some(Role::Instructor)
}

/// Parses the value of a boolean column.
fn flag(text: &str) -> Option<bool> {
    match plain_word(text).as_str() {
        "1" | "true" | "yes" | "y" | "ja" | "wahr" | "x" => Some(true),
        "0" | "false" | "no" | "n" | "nein" | "falsch" => Some(false),
        _ => None,
    }
}

fn standing(text: &str) -> Option<AccountStanding> {
    match plain_word(text).as_str() {
        "active" | "enrolled" | "aktiv" | "immatrikuliert" | "zugelassen" | "angemeldet" | "zu" | "an" | "true"
        | "yes" | "ja" | "wahr" | "1" => Some(AccountStanding::Active),
        "deleted" | "inactive" | "suspended" | "withdrawn" | "tobedeleted" | "inaktiv" | "exmatrikuliert"
        | "abgemeldet" | "gelöscht" | "gesperrt" | "false" | "no" | "nein" | "falsch" | "0" => {
            Some(AccountStanding::Gone)
        }
        _ => None,
    }
}

#[cfg(test)]
mod sheet_tests;
#[cfg(test)]
mod tests;
