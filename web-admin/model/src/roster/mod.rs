//! A roster as registrars send it: read, checked line by line, and compared with the people of the school.
//!
//! Pure: bytes and people go in, a [`RosterDifference`] comes out. Nothing is removed because a file does not name it, unless
//! that is asked for.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Role;
use crate::line::is_strange;

mod columns;
mod difference;
mod text;

pub use columns::{RosterColumn, meaning};
pub use difference::{
    Leaving, LineOutcome, RosterChange, RosterDifference, RosterOutcome, RosterRequest, SchoolPerson,
};

/// Most lines taken at once.
pub const MAX_ROWS: usize = 20_000;
/// Longest name, number or cohort, in characters.
const MAX_CHARS: usize = 120;

/// Why a file is refused whole.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unreadable {
    /// It has no line but the heading, or not even that.
    #[error("{}", tr!("the file has no people in it"))]
    Empty,
    /// A column that is needed is not there.
    #[error("{}", tr!(
        "no column for the {missing}; the columns are {found}; {allowed} would do",
        missing = words::say(.missing),
        found = .found,
        allowed = .allowed
    ))]
    MissingColumn {
        /// What is missing.
        missing: &'static str,
        /// The headings.
        found: String,
        /// Headings that would do.
        allowed: &'static str,
    },
    /// Two columns tell the same.
    #[error("{}", tr!("the columns “{one}” and “{other}” mean the same; leave one out", one = .0, other = .1))]
    Twice(String, String),
    /// It has too many lines.
    #[error("{}", tr!("the file has more than {most} people; send it in parts", most = MAX_ROWS))]
    TooLong,
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
    /// The cohort they are to be in.
    pub cohort: Option<String>,
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

/// Reads a roster.
///
/// # Errors
/// When it is refused whole, saying why.
pub fn read(bytes: &[u8]) -> Result<Roster, Unreadable> {
    let text = text::read(bytes);
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(text.separator)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(text.body.as_bytes());
    let headings = reader.headers().map_err(|error| not_csv(&error, text.skipped))?.clone();
    let (columns, ignored) = assign(&headings)?;
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| not_csv(&error, text.skipped))?;
        if record.iter().all(str::is_empty) {
            continue;
        }
        if rows.len() == MAX_ROWS {
            return Err(Unreadable::TooLong);
        }
        let line = record.position().map_or(0, |at| line_of(at, &text.body)) + text.skipped;
        rows.push(RosterRow { line, entry: entry(&record, &columns) });
    }
    if rows.is_empty() {
        return Err(Unreadable::Empty);
    }
    refuse_repeats(&mut rows);
    Ok(Roster { rows, ignored })
}

/// The line that a record stands in, from 1. The reader is still before what ends the last line, and before empty ones, when it tells
/// where the next record begins.
fn line_of(at: &csv::Position, body: &str) -> u64 {
    let rest = usize::try_from(at.byte()).ok().and_then(|byte| body.as_bytes().get(byte..)).unwrap_or_default();
    let before = rest.iter().take_while(|byte| matches!(byte, b'\r' | b'\n'));
    at.line() + before.map(|byte| u64::from(*byte == b'\n')).sum::<u64>()
}

fn not_csv(error: &csv::Error, skipped: u64) -> Unreadable {
    let line = error.position().map_or(1, csv::Position::line) + skipped;
    Unreadable::NotCsv { line, why: "this is not a line of CSV".to_owned() }
}

type Columns = BTreeMap<RosterColumn, usize>;

/// Which column tells what, and the headings that tell nothing.
fn assign(headings: &csv::StringRecord) -> Result<(Columns, Vec<String>), Unreadable> {
    let mut columns = Columns::new();
    let mut ignored = Vec::new();
    for (index, heading) in headings.iter().enumerate() {
        match meaning(heading) {
            Some(column) => {
                if let Some(first) = columns.insert(column, index) {
                    return Err(Unreadable::Twice(headings[first].to_owned(), heading.to_owned()));
                }
            }
            None => ignored.push(heading.to_owned()),
        }
    }
    let has = |column| columns.contains_key(&column);
    let missing = |missing, allowed| {
        let found = headings.iter().map(|heading| format!("“{heading}”")).collect::<Vec<_>>().join(", ");
        Err(Unreadable::MissingColumn { missing, found, allowed })
    };
    if !has(RosterColumn::Email) && !has(RosterColumn::Login) {
        return missing(sentence!("email address"), "“email”, “e-mail” or “login_id”");
    }
    let named = has(RosterColumn::Name) || has(RosterColumn::Given) && has(RosterColumn::Family);
    if !named {
        return missing(sentence!("name"), "“name”, or “first_name” and “last_name”,");
    }
    Ok((columns, ignored))
}

fn entry(record: &csv::StringRecord, columns: &Columns) -> Result<RosterEntry, (String, Refusal)> {
    let field = |column| columns.get(&column).and_then(|index| record.get(*index)).unwrap_or_default();
    let given = |column| Some(field(column)).filter(|text| !text.is_empty());
    let email = given(RosterColumn::Email).or_else(|| given(RosterColumn::Login)).unwrap_or_default().to_lowercase();
    let whole = format!("{} {}", field(RosterColumn::Given), field(RosterColumn::Family)).trim().to_owned();
    let name = if whole.is_empty() { field(RosterColumn::Name).to_owned() } else { whole };
    let shown = if name.is_empty() { email.clone() } else { format!("{name} <{email}>") };
    let refused = |refusal| (shown.clone(), refusal);
    for column in
        [RosterColumn::Name, RosterColumn::Given, RosterColumn::Family, RosterColumn::RegistrarId, RosterColumn::Cohort]
    {
        check_text(field(column)).map_err(refused)?;
    }
    if email.is_empty() {
        return Err(refused(Refusal::NoEmail));
    }
    if !is_email(&email) {
        return Err(refused(Refusal::BadEmail(email.clone())));
    }
    if name.is_empty() {
        return Err(refused(Refusal::NoName));
    }
    Ok(RosterEntry {
        role: given(RosterColumn::Role).map(role).transpose().map_err(refused)?,
        standing: given(RosterColumn::Status).map(standing).transpose().map_err(refused)?,
        registrar_id: given(RosterColumn::RegistrarId).map(str::to_owned),
        cohort: given(RosterColumn::Cohort).map(str::to_owned),
        email,
        name,
    })
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

/// Whether a text is like `name@example.org`.
#[must_use]
pub fn is_email(text: &str) -> bool {
    let parts = text.split_once('@').filter(|(name, host)| !name.is_empty() && !host.is_empty() && !host.contains('@'));
    let strange = |c: char| c.is_whitespace() || is_strange(c) || "<>,;\"()".contains(c);
    parts.is_some() && !text.contains(strange) && !text.starts_with(['=', '+', '-', '@']) && text.len() <= 254
}

/// Whether a name may be given to somebody or something.
#[must_use]
pub fn is_name(text: &str) -> bool {
    !text.trim().is_empty() && check_text(text).is_ok()
}

fn role(text: &str) -> Result<Role, Refusal> {
    match text.to_lowercase().as_str() {
        "trainee" | "student" | "learner" | "studierende" | "studierender" | "studentin" => Ok(Role::Trainee),
        "instructor" | "teacher" | "tutor" | "lehrende" | "lehrender" | "dozent" | "dozentin" => Ok(Role::Instructor),
        _ => Err(Refusal::BadRole(text.to_owned())),
    }
}

fn standing(text: &str) -> Result<AccountStanding, Refusal> {
    match text.to_lowercase().as_str() {
        "active" | "enrolled" | "aktiv" | "immatrikuliert" => Ok(AccountStanding::Active),
        "deleted" | "inactive" | "suspended" | "withdrawn" | "inaktiv" | "exmatrikuliert" => Ok(AccountStanding::Gone),
        _ => Err(Refusal::BadStatus(text.to_owned())),
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
