//! A roster as registrars send it: read, checked line by line, and compared with the people of the school.
//!
//! Pure: bytes and people go in, a [`RosterDifference`] comes out. Nothing is removed because a file does not name it, unless
//! that is asked for.

use std::collections::{BTreeMap, BTreeSet};

use csv::StringRecord;
use serde::{Deserialize, Serialize};

use super::Role;
use crate::email::{is_email, is_odd_in_email, normalize_email};
use crate::folding::look_alike_key;
use crate::line::is_strange;

mod cell_format;
mod columns;
mod difference;
mod mapping;
mod quotes;
mod repeats;
mod sheet;
mod table;
mod text;

pub use columns::{RosterColumn, meaning};
pub use difference::{
    Leaving, LineOutcome, RosterChange, RosterDifference, RosterOutcome, RosterRequest, SchoolPerson,
};
pub use mapping::{GroupSplit, MappingDoubt, MappingGuess, RosterMapping};
pub use sheet::{WorkbookSheet, is_workbook};
pub use table::RosterTable;

/// Most lines taken at once.
pub const MAX_ROWS: usize = 20_000;
/// Most columns of a file.
pub const MAX_COLUMNS: usize = 500;
/// Longest name, number or cohort, in characters.
const MAX_CHARS: usize = 120;

/// Why a file is refused whole.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
pub enum Unreadable {
    /// It has no line but the heading, or not even that.
    #[error("{}", tr!("the file has no people in it"))]
    Empty,
    /// It has too many lines.
    #[error("{}", tr!("the file has more than {most} people; send it in parts", most = MAX_ROWS))]
    TooLong,
    /// It has too many columns.
    #[error("{}", tr!("the file has more than {most} columns; delete those that tell nothing about people", most = MAX_COLUMNS))]
    TooWide,
    /// A workbook unpacks to more than is read.
    #[error("{}", tr!("the workbook is too large: leave the list of people alone in it, or save it as CSV"))]
    TooMuch,
    /// A workbook is broken, or its sheet has no table.
    #[error("{}", tr!("the workbook cannot be read: save it anew as .xlsx, or as CSV"))]
    NotSheet,
    /// Every sheet of a workbook is hidden or holds no cells.
    #[error("{}", tr!("every sheet of the workbook is hidden or a chart: show the sheet with the list of people, and save the workbook"))]
    NoVisibleSheet,
    /// A workbook in Excel's binary format.
    #[error("{}", tr!("this is a binary workbook (.xlsb): save it as .xlsx, or as CSV"))]
    BinaryExcel,
    /// A sheet of LibreOffice.
    #[error("{}", tr!("this is an OpenDocument sheet (.ods): save it as .xlsx, or as CSV"))]
    OpenDocument,
    /// A workbook that a password seals.
    #[error("{}", tr!("a password protects the workbook: save it without one, or as CSV"))]
    Sealed,
    /// An archive of other files; the one that may hold the people.
    #[error("{}", say_archive(.0.as_deref()))]
    Archive(Option<String>),
    /// A quotation mark opens a field that is not closed where it should be.
    #[error("{}", tr!("line {line}: a quotation mark opens a field and is not closed at the field’s end, so the lines after it cannot be told apart. Correct the line, and send the file again", line = .line))]
    OpenQuote {
        /// From 1.
        line: u64,
    },
    /// A workbook of before 2007.
    #[error("{}", tr!("this is an Excel file of the old kind (.xls): save it as .xlsx, or as CSV"))]
    OldExcel,
    /// It is not CSV.
    #[error("{}", tr!("line {line}: {why}", line = .line, why = .why))]
    NotCsv {
        /// From 1.
        line: u64,
        /// What the reader says.
        why: String,
    },
}

fn say_archive(people: Option<&str>) -> String {
    match people {
        Some(file) => tr!("this is a zip archive: unpack it, and send {file} alone", file = file),
        None => tr!("this is a zip archive and no workbook: unpack it, and send the list of people as .xlsx or CSV")
            .to_owned(),
    }
}

/// Why a line is refused.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// There is no address.
    NoEmail,
    /// This is no address.
    BadEmail(String),
    /// This is an address without a domain, or only the beginning of one.
    NoDomain(String),
    /// A line of points in a gradebook.
    PointsPossible,
    /// The student that a course invents to be tried.
    TestStudent,
    /// Nothing that is read stands in the line.
    NobodyNamed,
    /// Deleted where the file comes from, and nobody here.
    GoneElsewhere,
    /// There is no name.
    NoName,
    /// A spreadsheet would run this.
    Formula(String),
    /// This is longer than allowed, or has characters that cannot be shown.
    BadText(String),
    /// Neither trainee nor instructor.
    BadRole(String),
    /// Neither active nor deleted.
    BadStatus(String),
    /// The formula of this column has no result.
    Unsolved(String),
    /// This line and an earlier one are about one person: they are read together.
    SamePerson(u64),
    /// An earlier line has this address, and says something else of the person.
    SameEmail(u64),
    /// An earlier line has this number.
    SameRegistrarId(u64),
    /// Somebody else of the school has this address.
    EmailOfAnother,
    /// The address cannot be used at this school.
    EmailUnusable,
    /// The person is something else here, and a roster changes no roles.
    OtherRole(Role),
}

/// Whether somebody is to be able to sign in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum AccountStanding {
    /// Yes.
    Active,
    /// No.
    Gone,
}

/// A line that says who somebody is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RosterEntry {
    /// In lower case.
    pub email: String,
    /// As it is shown.
    pub name: String,
    /// What the registrar knows them by.
    pub registrar_id: Option<String>,
    /// The cohorts they are to be in.
    pub cohorts: Vec<String>,
    /// What they are to be, where the file says so.
    pub role: Option<Role>,
    /// Whether they are to sign in, where the file says so.
    pub standing: Option<AccountStanding>,
}

/// A line of a roster.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RosterRow {
    /// Its line in the file, from 1.
    pub line: u64,
    /// Who, or why not.
    pub entry: Result<RosterEntry, Box<RefusedLine>>,
}

/// A line that is not imported.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RefusedLine {
    /// What is shown of it.
    pub shown: String,
    /// Why.
    pub refusal: Refusal,
    /// Whom it is about: whoever stands in the file does not leave for being missing from it.
    pub mention: LineMention,
}

impl RefusedLine {
    fn of_entry(RosterEntry { email, name, registrar_id, .. }: &RosterEntry, refusal: Refusal) -> Self {
        let mention = LineMention { email: email.clone(), name: name.clone(), registrar_id: registrar_id.clone() };
        Self { shown: mention.shown(), refusal, mention }
    }
}

/// What a line says of whom it is about, right or wrong.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LineMention {
    /// The address.
    pub email: String,
    /// The name.
    pub name: String,
    /// The registrar's number.
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

/// A roster that was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Roster {
    /// Its lines.
    pub rows: Vec<RosterRow>,
    /// Headings that mean nothing here.
    pub ignored: Vec<String>,
}

impl Roster {
    /// Writes cohorts that differ only in case, spaces or composition from one of the school's, or from an earlier one of the file, as that
    /// one is written. `cohort` is the one for lines that name none.
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

/// Reads a roster by what its columns seem to mean.
///
/// # Errors
/// When it is refused whole, saying why.
pub fn read(bytes: &[u8]) -> Result<Roster, Unreadable> {
    let table = RosterTable::read(bytes)?;
    Ok(table.people(&table.guess().mapping))
}

/// What stands in a line, by what its columns mean.
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

    /// The name, given name first.
    fn name(&self) -> String {
        let whole = format!("{} {}", self.of(RosterColumn::Given), self.of(RosterColumn::Family)).trim().to_owned();
        if whole.is_empty() { turn_name(self.of(RosterColumn::Name)) } else { whole }
    }

    fn role(&self) -> Result<Option<Role>, Refusal> {
        let read = |text: &str| role(text).ok_or_else(|| Refusal::BadRole(text.to_owned()));
        self.given(RosterColumn::Role).map(read).transpose()
    }

    /// Whether they are to sign in. Whatever says that they are not outweighs what says that they are; "not deleted" says neither.
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

/// Reads a line. `unsolved` is the heading of a column whose formula has no result in it.
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
    })
}

/// "Family, Given" as "Given Family"; what follows a name as a degree stays behind it.
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

/// The address in lower case. What somebody signs in with stands for an address that is missing, where it is one.
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

/// Lines of a gradebook that are about nobody.
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

/// A text that may be kept: neither a formula, which a spreadsheet would run when the name comes out in an export, nor
/// too long, nor with characters that cannot be shown.
fn check_text(text: &str) -> Result<(), Refusal> {
    if text.starts_with(['=', '+', '-', '@']) {
        return Err(Refusal::Formula(text.to_owned()));
    }
    if text.chars().count() > MAX_CHARS || text.contains(is_strange) {
        return Err(Refusal::BadText(text.chars().filter(|c| !is_strange(*c)).take(40).collect()));
    }
    Ok(())
}

/// Whether a name may be given to somebody or something.
#[must_use]
pub fn is_name(text: &str) -> bool {
    !text.trim().is_empty() && check_text(text).is_ok()
}

/// A word in plain form: lower case, letters only. "Tutor/-innen" and "tutorinnen" are one.
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

/// A word of a column that is called after what it says: yes or no.
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
