//! Calendars of due dates (RFC 5545).

use std::fmt::Write;

use crate::Moment;

/// Longest line in octets, without its end.
const LONGEST_LINE: usize = 75;

/// A due date.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CalendarEvent {
    /// Identifier that stays the same when the date changes.
    pub uid: String,
    /// Number of the revision.
    pub sequence: i64,
    /// Time of the last change.
    pub changed_at: Moment,
    /// When it is due.
    pub due_at: Moment,
    /// What is due.
    pub summary: String,
    /// Address of its page.
    pub url: String,
}

/// Writes a calendar. Times are UTC, so that no definition of a time zone is needed.
#[must_use]
pub fn write_calendar(name: &str, events: &[CalendarEvent]) -> String {
    let mut out = String::new();
    for line in ["BEGIN:VCALENDAR", "VERSION:2.0", "PRODID:-//Stylet//Due dates//EN", "CALSCALE:GREGORIAN"] {
        put_line(&mut out, line);
    }
    // RFC 7986, and the name that older programs know.
    for property in ["NAME", "X-WR-CALNAME"] {
        put_line(&mut out, &format!("{property}:{}", escape_text(name)));
    }
    put_line(&mut out, "REFRESH-INTERVAL;VALUE=DURATION:PT6H");
    put_line(&mut out, "X-PUBLISHED-TTL:PT6H");
    for event in events {
        put_event(&mut out, event);
    }
    put_line(&mut out, "END:VCALENDAR");
    out
}

fn put_event(out: &mut String, event: &CalendarEvent) {
    let changed = utc(event.changed_at);
    let lines = [
        "BEGIN:VEVENT".to_owned(),
        format!("UID:{}", escape_text(&event.uid)),
        format!("DTSTAMP:{changed}"),
        format!("LAST-MODIFIED:{changed}"),
        format!("SEQUENCE:{}", event.sequence),
        format!("DTSTART:{}", utc(event.due_at)),
        format!("SUMMARY:{}", escape_text(&event.summary)),
        format!("URL:{}", event.url),
        "TRANSP:TRANSPARENT".to_owned(),
        "END:VEVENT".to_owned(),
    ];
    for line in lines {
        put_line(out, &line);
    }
}

/// Formats a moment as in RFC 5545, section 3.3.5, in UTC.
fn utc(at: Moment) -> String {
    let at = at.to_utc();
    let (date, time) = (at.date(), at.time());
    format!(
        "{:04}{:02}{:02}T{:02}{:02}{:02}Z",
        date.year(),
        u8::from(date.month()),
        date.day(),
        time.hour(),
        time.minute(),
        time.second()
    )
}

/// Escapes a text as in RFC 5545, section 3.3.11. Line ends become `\n`; other control characters, which no text
/// may contain, are left out.
fn escape_text(text: &str) -> String {
    let mut out = String::new();
    for c in text.replace("\r\n", "\n").chars() {
        match c {
            '\\' | ';' | ',' => out.extend(['\\', c]),
            '\n' | '\r' | '\u{2028}' | '\u{2029}' => out.push_str("\\n"),
            c if c.is_control() => {}
            c => out.push(c),
        }
    }
    out
}

/// Appends a line, folded so that no part is longer than 75 octets and none ends within a character.
fn put_line(out: &mut String, line: &str) {
    let mut used = 0;
    for c in line.chars() {
        if used + c.len_utf8() > LONGEST_LINE {
            out.push_str("\r\n ");
            used = 1;
        }
        out.push(c);
        used += c.len_utf8();
    }
    // Writing to a `String` cannot fail.
    let _ = out.write_str("\r\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(summary: &str) -> CalendarEvent {
        CalendarEvent {
            uid: "1-2@stylet".to_owned(),
            sequence: 3,
            changed_at: Moment::from_micros(1_779_269_400_000_000),
            due_at: Moment::from_micros(1_779_296_400_999_999),
            summary: summary.to_owned(),
            url: "https://stylet.example/assignments".to_owned(),
        }
    }

    #[test]
    fn an_event_has_its_instants_in_utc() {
        let text = write_calendar("Nord", &[event("Due")]);
        for line in
            ["DTSTART:20260520T170000Z", "DTSTAMP:20260520T093000Z", "SEQUENCE:3", "UID:1-2@stylet", "NAME:Nord"]
        {
            assert!(text.contains(&format!("\r\n{line}\r\n")), "{line} is missing in {text}");
        }
        assert!(text.starts_with("BEGIN:VCALENDAR\r\n") && text.ends_with("END:VCALENDAR\r\n"), "{text}");
        assert!(write_calendar("", &[]).contains("VERSION:2.0"));
    }

    #[test]
    fn no_title_ends_a_line_or_begins_a_property() {
        let hostile = "a;b,c\\d\r\nEND:VEVENT\rX-EVIL:1\u{2028}\u{0}\u{7}e\u{85}";
        let text = write_calendar(hostile, &[event(hostile)]);
        assert_eq!(text.matches("\r\nEND:VEVENT").count(), 1, "{text}");
        assert!(text.contains("SUMMARY:a\\;b\\,c\\\\d\\nEND:VEVENT\\nX-EVIL:1\\ne"), "{text}");
        assert!(!text.replace("\r\n", "").chars().any(char::is_control), "{text:?}");
    }

    #[test]
    fn every_line_has_at_most_75_octets() {
        let long = "Größe 💉 ".repeat(40);
        let text = write_calendar(&long, &[event(&long)]);
        assert!(text.split("\r\n").all(|line| line.len() <= LONGEST_LINE), "{text}");
        assert!(text.replace("\r\n ", "").contains(&format!("SUMMARY:{long}")), "{text}");
    }
}
