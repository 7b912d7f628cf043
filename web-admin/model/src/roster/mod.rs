//! A roster as registrars send it: read, checked line by line, and compared with the people of the school.
//!
//! Pure: bytes and people go in, a [`RosterDifference`] comes out. Nothing is removed because a file does not name it, unless
//! that is asked for.

use std::collections::BTreeMap;

use csv::StringRecord;
use serde::{Deserialize, Serialize};

use super::Role;
use crate::line::is_strange;

mod columns;
mod difference;
mod mapping;
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
    /// An earlier line has this address.
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
    /// Who, or why not; what was readable of the name and address comes along.
    pub entry: Result<RosterEntry, (String, Refusal)>,
}

/// A roster that was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Roster {
    /// Its lines.
    pub rows: Vec<RosterRow>,
    /// Headings that mean nothing here.
    pub ignored: Vec<String>,
}

/// Reads a roster by what its columns seem to mean.
///
/// # Errors
/// When it is refused whole, saying why.
pub fn read(bytes: &[u8]) -> Result<Roster, Unreadable> {
    let table = RosterTable::read(bytes)?;
    Ok(table.people(&table.guess().mapping))
}

fn entry(record: &StringRecord, mapping: &RosterMapping) -> Result<RosterEntry, (String, Refusal)> {
    let field = |column| mapping.columns.get(&column).and_then(|index| record.get(*index)).unwrap_or_default();
    let given = |column| Some(field(column)).filter(|text| !text.is_empty());
    let name = name_of(record, mapping);
    let email = address_of(given(RosterColumn::Email), given(RosterColumn::Login), mapping);
    let shown = match (name.is_empty(), email.is_empty()) {
        (false, false) => format!("{name} <{email}>"),
        (false, true) => name.clone(),
        (true, _) => email.clone(),
    };
    let refused = |refusal| (shown.clone(), refusal);
    check_person(record, &name).map_err(|refusal| (record.get(0).unwrap_or_default().to_owned(), refusal))?;
    if mapping.columns.values().all(|index| record.get(*index).unwrap_or_default().is_empty()) {
        return Err(refused(Refusal::NobodyNamed));
    }
    for column in
        [RosterColumn::Name, RosterColumn::Given, RosterColumn::Family, RosterColumn::RegistrarId, RosterColumn::Cohort]
    {
        check_text(field(column)).map_err(refused)?;
    }
    check_email(&email).map_err(refused)?;
    if name.is_empty() {
        return Err(refused(Refusal::NoName));
    }
    let as_role = |text: &str| role(text).ok_or_else(|| refused(Refusal::BadRole(text.to_owned())));
    let as_standing = |text: &str| standing(text).ok_or_else(|| refused(Refusal::BadStatus(text.to_owned())));
    let status = given(RosterColumn::Status).map(as_standing).transpose()?;
    let enabled = given(RosterColumn::Enabled).map(as_standing).transpose()?;
    Ok(RosterEntry {
        role: given(RosterColumn::Role).map(as_role).transpose()?,
        standing: enabled.filter(|standing| *standing == AccountStanding::Gone).or(status).or(enabled),
        registrar_id: given(RosterColumn::RegistrarId).map(str::to_owned),
        cohorts: mapping.split.groups(field(RosterColumn::Cohort)),
        email,
        name,
    })
}

/// The name, given name first.
fn name_of(record: &StringRecord, mapping: &RosterMapping) -> String {
    let field = |column| mapping.columns.get(&column).and_then(|index| record.get(*index)).unwrap_or_default();
    let whole = format!("{} {}", field(RosterColumn::Given), field(RosterColumn::Family)).trim().to_owned();
    if whole.is_empty() { turn_name(field(RosterColumn::Name)) } else { whole }
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
    let address = email.or(login).unwrap_or_default().to_lowercase();
    match &mapping.domain {
        Some(domain) if !address.is_empty() && !address.contains('@') => format!("{address}@{domain}"),
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

/// Whether a text is like `name@example.org`: an address without a domain leads nowhere.
#[must_use]
pub fn is_email(text: &str) -> bool {
    let Some((name, host)) = text.split_once('@') else { return false };
    !name.is_empty()
        && is_domain(host)
        && !text.contains(is_odd_in_email)
        && !text.starts_with(['=', '+', '-', '@'])
        && text.len() <= 254
}

/// Whether a text is like `example.org`.
#[must_use]
pub fn is_domain(text: &str) -> bool {
    let label = |label: &str| {
        let plain = label.chars().all(|c| c.is_alphanumeric() || c == '-');
        plain && !label.is_empty() && !label.starts_with('-') && !label.ends_with('-')
    };
    let last = text.rsplit('.').next().unwrap_or_default();
    text.contains('.') && text.split('.').all(label) && last.contains(|c: char| c.is_alphabetic())
}

fn is_odd_in_email(c: char) -> bool {
    c.is_whitespace() || is_strange(c) || "<>,;\"()".contains(c)
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

/// Refuses every line whose address or number an earlier line has.
fn refuse_repeats(rows: &mut [RosterRow]) {
    let mut addresses = BTreeMap::new();
    let mut numbers = BTreeMap::new();
    for row in rows {
        let Ok(entry) = &row.entry else { continue };
        let same_address = addresses.insert(entry.email.clone(), row.line);
        let same_number = entry.registrar_id.clone().and_then(|number| numbers.insert(number, row.line));
        let refusal = same_address.map(Refusal::SameEmail).or_else(|| same_number.map(Refusal::SameRegistrarId));
        if let Some(refusal) = refusal {
            row.entry = Err((format!("{} <{}>", entry.name, entry.email), refusal));
        }
    }
}

#[cfg(test)]
mod tests;
