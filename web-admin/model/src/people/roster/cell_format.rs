//! Numbers and times in the number format of their cell (ECMA-376, part 1, 18.8.30 and 18.8.31):
//! leading zeros, percent, dates. Thousands separators are left out, because registration numbers
//! have none.

use calamine::{ExcelDateTime, NumberFormat};

/// Number formats that Excel shows as the user's local short date, without and with time.
const LOCAL_DATE: u32 = 14;
const LOCAL_DATE_TIME: u32 = 22;
/// Maximum number of decimal places.
const MAX_DECIMALS: usize = 30;

const MONTHS: [&str; 12] = [
    "January",
    "February",
    "March",
    "April",
    "May",
    "June",
    "July",
    "August",
    "September",
    "October",
    "November",
    "December",
];
const DAYS: [&str; 7] = ["Sunday", "Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday"];

/// A token of a number format.
#[derive(Clone, Debug, PartialEq, Eq)]
enum FormatToken {
    /// Literal text.
    Literal(String),
    /// A character with a meaning.
    Code(char),
    /// Text in brackets.
    Bracket(String),
}

/// Splits a format into its sections, which are separated by semicolons.
fn sections(code: &str) -> Vec<Vec<FormatToken>> {
    let mut sections = vec![Vec::new()];
    let mut chars = code.chars();
    while let Some(c) = chars.next() {
        let token = match c {
            ';' => {
                sections.push(Vec::new());
                continue;
            }
            '"' => FormatToken::Literal(chars.by_ref().take_while(|c| *c != '"').collect()),
            '\\' => FormatToken::Literal(chars.next().into_iter().collect()),
            // A space as wide as the next character, or the next character repeated to fill the
            // cell.
            '_' | '*' => {
                chars.next();
                FormatToken::Literal(String::new())
            }
            '[' => FormatToken::Bracket(chars.by_ref().take_while(|c| *c != ']').collect()),
            c if " -+()$:!^&'~{}<>=".contains(c) => FormatToken::Literal(c.to_string()),
            c => FormatToken::Code(c),
        };
        if let Some(section) = sections.last_mut() {
            section.push(token);
        }
    }
    sections
}

/// Returns a number in its format. `None` if the format is "General" or not supported.
pub(super) fn show_number(number: f64, code: &str) -> Option<String> {
    let sections = sections(code);
    let at = match sections.len() {
        1 => 0,
        2 => usize::from(number < 0.0),
        _ if number == 0.0 => 2,
        _ => usize::from(number < 0.0),
    };
    let section = sections.get(at)?;
    let known = |token: &FormatToken| match token {
        FormatToken::Code(code) => "0#?.,%".contains(*code),
        FormatToken::Bracket(text) => !text.starts_with(['<', '>', '=']),
        FormatToken::Literal(_) => true,
    };
    let point = section.iter().position(|token| *token == FormatToken::Code('.')).unwrap_or(section.len());
    let (whole, rest) = section.split_at(point);
    let whole_places: Vec<char> = places(whole).collect();
    if !section.iter().all(known) || whole_places.is_empty() && rest.is_empty() {
        return None;
    }
    let percents = section.iter().filter(|token| **token == FormatToken::Code('%')).count();
    let scaled = (0..percents).fold(number.abs(), |scaled, _| scaled * 100.0);
    let decimal_places: Vec<char> = places(rest).collect();
    let digits = format!("{scaled:.*}", decimal_places.len().min(MAX_DECIMALS));
    let (integer, fraction) = digits.split_once('.').unwrap_or((digits.as_str(), ""));
    let least = whole_places.iter().position(|place| *place == '0').map_or(0, |first| whole_places.len() - first);
    let integer = format!("{:0>least$}", integer.trim_start_matches('0'));
    let sign = if number < 0.0 && at == 0 { "-" } else { "" };
    let fraction = show_fraction(fraction, &decimal_places, percents > 0);
    let shown = format!("{sign}{}{fraction}{}", fill(whole, &integer), literals(rest));
    Some(shown.trim().to_owned()).filter(|shown| !shown.is_empty())
}

fn places(tokens: &[FormatToken]) -> impl Iterator<Item = char> {
    tokens.iter().filter_map(|token| match token {
        FormatToken::Code(place @ ('0' | '#' | '?')) => Some(*place),
        _ => None,
    })
}

/// Returns the decimal point and the decimal places. A whole number that is not a percentage has
/// none: "12345.00" cannot be a registration number.
fn show_fraction(digits: &str, places: &[char], is_share: bool) -> String {
    if !is_share && digits.bytes().all(|digit| digit == b'0') {
        return String::new();
    }
    let needed = places.iter().rposition(|place| *place == '0').map_or(0, |last| last + 1);
    let kept = digits.trim_end_matches('0').len().max(needed.min(digits.len()));
    if kept == 0 { String::new() } else { format!(".{}", &digits[..kept]) }
}

/// Fills digits into placeholders from the right; the first placeholder takes all remaining digits.
fn fill(tokens: &[FormatToken], digits: &str) -> String {
    let mut left: Vec<char> = digits.chars().collect();
    let mut open = places(tokens).count();
    let mut shown: Vec<String> = Vec::new();
    for token in tokens.iter().rev() {
        match token {
            FormatToken::Code('0' | '#' | '?') => {
                open -= 1;
                let taken = if open == 0 { 0 } else { left.len().saturating_sub(1) };
                shown.push(left.split_off(taken.min(left.len())).into_iter().collect());
            }
            other => shown.push(literals(std::slice::from_ref(other))),
        }
    }
    shown.into_iter().rev().collect()
}

fn literals(tokens: &[FormatToken]) -> String {
    let literal = |token: &FormatToken| match token {
        FormatToken::Literal(text) => text.clone(),
        FormatToken::Code('%') => "%".to_owned(),
        // A currency symbol, followed by a locale.
        FormatToken::Bracket(text) => {
            text.strip_prefix('$').and_then(|text| text.split('-').next()).unwrap_or_default().to_owned()
        }
        FormatToken::Code(_) => String::new(),
    };
    tokens.iter().map(literal).collect()
}

/// Returns the format of a cell; `None` if Excel shows it in the user's local format.
pub(super) fn code_of(format: &NumberFormat) -> Option<String> {
    let local = matches!(format.format_id, Some(LOCAL_DATE | LOCAL_DATE_TIME));
    (!local).then(|| format.format_code.clone())
}

/// Returns a date or time in its format, with English names of months and days. Without a format it
/// is an ISO date.
pub(super) fn show_time(time: &ExcelDateTime, code: Option<&str>) -> String {
    let clock = ShownTime::of(time);
    let shown = code.and_then(|code| clock.show(sections(code).first()?));
    shown.unwrap_or_else(|| clock.iso())
}

/// Fields of a date and time.
struct ShownTime {
    year: u16,
    month: u8,
    day: u8,
    hour: u8,
    minute: u8,
    second: u8,
    /// Days since the epoch of the workbook.
    days: f64,
}

impl ShownTime {
    fn of(time: &ExcelDateTime) -> Self {
        let (year, month, day, hour, minute, second, _) = time.to_ymd_hms_milli();
        Self { year, month, day, hour, minute, second, days: time.as_f64() }
    }

    /// Returns the date, if there is one, and the time, unless it is midnight.
    fn iso(&self) -> String {
        let date = format!("{:04}-{:02}-{:02}", self.year, self.month, self.day);
        let time = format!("{:02}:{:02}", self.hour, self.minute);
        match (self.days < 1.0, (self.hour, self.minute, self.second) == (0, 0, 0)) {
            (true, _) => time,
            (false, true) => date,
            (false, false) => format!("{date} {time}"),
        }
    }

    fn show(&self, section: &[FormatToken]) -> Option<String> {
        let runs = runs(section);
        let halves = runs.iter().any(|run| matches!(run, FormatRun::HalfOfDay));
        let letter = |run: &FormatRun| match run {
            FormatRun::Letters(letter, _) => Some(*letter),
            _ => None,
        };
        let mut shown = String::new();
        for (at, run) in runs.iter().enumerate() {
            let part = match run {
                FormatRun::Text(text) => text.clone(),
                FormatRun::HalfOfDay => (if self.hour < 12 { "AM" } else { "PM" }).to_owned(),
                FormatRun::Elapsed(unit, width) => self.elapsed(*unit, *width)?,
                FormatRun::Letters('m', width) => {
                    let before = runs[..at].iter().rev().find_map(letter) == Some('h')
                        || runs[..at].iter().rev().any(|run| matches!(run, FormatRun::Elapsed('h', _)));
                    let after = runs[at + 1..].iter().find_map(letter) == Some('s');
                    if before || after { padded(self.minute, *width) } else { self.month(*width) }
                }
                FormatRun::Letters('h', width) if halves => padded((self.hour + 11) % 12 + 1, *width),
                FormatRun::Letters(letter, width) => self.letters(*letter, *width)?,
            };
            shown.push_str(&part);
        }
        Some(shown.trim().to_owned()).filter(|shown| !shown.is_empty())
    }

    fn letters(&self, letter: char, width: usize) -> Option<String> {
        // Day 1 of the epoch counts as a Sunday, because Excel counts 29 February 1900, which did
        // not exist.
        let weekday = DAYS[(self.days.floor() as i64 - 1).rem_euclid(7) as usize];
        Some(match (letter, width) {
            ('y', 1 | 2) => format!("{:02}", self.year % 100),
            ('y', _) => format!("{:04}", self.year),
            ('d', 1 | 2) => padded(self.day, width),
            ('d', 3) => weekday[..3].to_owned(),
            ('d', _) => weekday.to_owned(),
            ('h', _) => padded(self.hour, width),
            ('s', _) => padded(self.second, width),
            _ => return None,
        })
    }

    fn month(&self, width: usize) -> String {
        let name = MONTHS[usize::from(self.month.clamp(1, 12)) - 1];
        match width {
            1 | 2 => padded(self.month, width),
            3 => name[..3].to_owned(),
            5 => name[..1].to_owned(),
            _ => name.to_owned(),
        }
    }

    fn elapsed(&self, unit: char, width: usize) -> Option<String> {
        let per_day = match unit {
            'h' => 24.0,
            'm' => 1440.0,
            's' => 86_400.0,
            _ => return None,
        };
        Some(format!("{:0>width$.0}", (self.days * per_day + 1e-6).floor()))
    }
}

fn padded(number: u8, width: usize) -> String {
    format!("{number:0>width$}", width = width.min(2))
}

/// A part of a time format, with runs of equal letters combined.
enum FormatRun {
    Text(String),
    Letters(char, usize),
    Elapsed(char, usize),
    HalfOfDay,
}

fn runs(section: &[FormatToken]) -> Vec<FormatRun> {
    let mut runs: Vec<FormatRun> = Vec::new();
    let mut at = 0;
    while let Some(token) = section.get(at) {
        at += 1;
        match token {
            FormatToken::Code('a' | 'A') => {
                // "AM/PM" or "A/P".
                let more = section[at..]
                    .iter()
                    .take_while(|token| matches!(token, FormatToken::Code(c) if "mMpP/".contains(*c)));
                at += more.count();
                runs.push(FormatRun::HalfOfDay);
            }
            FormatToken::Code(c) if c.is_ascii_alphabetic() => {
                let letter = c.to_ascii_lowercase();
                match runs.last_mut() {
                    Some(FormatRun::Letters(last, width)) if *last == letter => *width += 1,
                    _ => runs.push(FormatRun::Letters(letter, 1)),
                }
            }
            // Fractions of seconds, and the placeholder for text.
            FormatToken::Code('0' | '@') => {}
            FormatToken::Code('.') if section.get(at) == Some(&FormatToken::Code('0')) => {}
            FormatToken::Code(c) => runs.push(FormatRun::Text(c.to_string())),
            FormatToken::Literal(text) => runs.push(FormatRun::Text(text.clone())),
            FormatToken::Bracket(text) => {
                let letter = text.chars().next().unwrap_or_default().to_ascii_lowercase();
                let same = text.chars().all(|c| c.to_ascii_lowercase() == letter);
                if same && "hms".contains(letter) {
                    runs.push(FormatRun::Elapsed(letter, text.len()));
                }
            }
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    //! Checks that numbers and times are read as the spreadsheet shows them.

    use calamine::ExcelDateTimeType;

    use super::*;

    #[test]
    fn numbers_are_read_as_they_are_shown() {
        for (number, code, shown) in [
            (12345.0, "0000000", Some("0012345")),
            (123_456_789.0, "0000000", Some("123456789")),
            (12345.0, "000-00-0000", Some("000-01-2345")),
            (12345.0, "00\\-00000", Some("00-12345")),
            (12345.0, "\"M\"0000000", Some("M0012345")),
            (12345.0, "0000000;-0000000;\"none\"", Some("0012345")),
            (0.0, "0000000;-0000000;\"none\"", None),
            (12345.0, "[Red]0000000_ ", Some("0012345")),
            (12345.0, "[$-407]0000000", Some("0012345")),
            (12345.0, "#,##0", Some("12345")),
            (12345.0, "0.00", Some("12345")),
            (2.5, "0.00", Some("2.50")),
            (2.5, "0.##", Some("2.5")),
            (0.5, "0%", Some("50%")),
            (0.125, "0.0%", Some("12.5%")),
            (1.0, "0.00%", Some("100.00%")),
            (-7.0, "000", Some("-007")),
            (-7.0, "000;(000)", Some("(007)")),
            (0.0, "000", Some("000")),
            (12345.0, "General", None),
            (12345.0, "@", None),
            (12345.0, "0.00E+00", None),
            (0.5, "# ?/?", None),
            (12345.0, "[>9999]00000-0000;00000", None),
            (7.0, "", None),
        ] {
            assert_eq!(show_number(number, code).as_deref(), shown, "{number} as {code}");
        }
    }

    #[test]
    fn times_are_read_as_they_are_shown() {
        for (days, code, shown) in [
            (46296.0, "mmm-yy", "Oct-26"),
            (46296.0, "d-mmm", "1-Oct"),
            (46296.0, "yyyy-mm-dd", "2026-10-01"),
            (46296.0, "dd/mm/yyyy;@", "01/10/2026"),
            (46296.0, "d. mmmm yyyy", "1. October 2026"),
            (46296.0, "[$-407]dddd, dd.mm.yy", "Thursday, 01.10.26"),
            (10.0 / 24.0, "h:mm", "10:00"),
            (10.0 / 24.0, "hh:mm:ss", "10:00:00"),
            (13.5 / 24.0, "h:mm AM/PM", "1:30 PM"),
            (0.5 / 24.0, "h:mm am/pm", "12:30 AM"),
            (46296.75, "m/d/yyyy h:mm", "10/1/2026 18:00"),
            (1.5, "[h]:mm:ss", "36:00:00"),
            (7.5 / 1440.0, "mm:ss", "07:30"),
            (46296.0, "ggge", "2026-10-01"),
        ] {
            let time = ExcelDateTime::new(days, ExcelDateTimeType::DateTime, false);
            assert_eq!(show_time(&time, Some(code)), shown, "{days} as {code}");
        }
        let shown = |days| show_time(&ExcelDateTime::new(days, ExcelDateTimeType::DateTime, false), None);
        assert_eq!((shown(46296.0).as_str(), shown(46296.75).as_str()), ("2026-10-01", "2026-10-01 18:00"));
    }
}
