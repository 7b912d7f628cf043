//! Due dates, entered in a school's local time and converted to a moment.

use jiff::civil::{Date, DateTime};
use jiff::tz::{AmbiguousOffset, TimeZone};
use jiff::{Timestamp, ToSpan, Zoned};
use words::dates;

use crate::Moment;

/// One minute, in µs.
const MINUTE_US: i64 = 60_000_000;

/// A due date: local time and moment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DueDate {
    /// Local time of the school, as entered: `2026-11-30T18:00:00`.
    pub local: String,
    /// The moment.
    pub at: Moment,
}

/// Reason why a due date is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DueRefused {
    /// It is not a date and time.
    #[error("{}", tr!("the due date: “{typed}”; enter a date and time like 2026-11-30T18:00", typed = .0))]
    NoDate(String),
    /// The local time does not exist because the clocks are put forward.
    #[error("{}", tr!(
        "the due date: {skipped} does not exist on that day in {zone}, because the clocks change; the nearest times are {before} and {after}",
        skipped = .skipped,
        zone = .zone,
        before = .before,
        after = .after
    ))]
    Skipped {
        /// Local time, as entered.
        skipped: String,
        /// Time zone.
        zone: String,
        /// Last minute before the gap.
        before: String,
        /// First minute after the gap.
        after: String,
    },
    /// The time zone does not exist.
    #[error("{}", tr!("the time zone: “{name}”; enter a name like Europe/Berlin", name = .0))]
    NoZone(String),
}

/// A moment in a school's local time, with the UTC offset at that moment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Local {
    /// For people: `30 Nov 2026, 18:00`.
    pub words: String,
    /// UTC offset: `UTC+01:00`.
    pub offset: String,
    /// For programs: `2026-11-30T18:00:00+01:00`.
    pub machine: String,
}

fn zone(name: &str) -> Result<TimeZone, DueRefused> {
    TimeZone::get(name).map_err(|_| DueRefused::NoZone(name.to_owned()))
}

/// Returns whether a time zone with this name exists.
#[must_use]
pub fn is_zone(name: &str) -> bool {
    zone(name).is_ok()
}

/// Returns the names of all time zones, sorted, including the currently stored one.
#[must_use]
pub fn list_zones(kept: &str) -> Vec<String> {
    let mut zones: Vec<String> = jiff::tz::db().available().map(|name| name.as_str().to_owned()).collect();
    zones.push(kept.to_owned());
    zones.sort();
    zones.dedup();
    zones
}

/// Parses a due date in a school's local time. If the time occurs twice because the clocks are put
/// back, the later moment is used.
///
/// # Errors
/// If it is not a date and time, the clocks skip it, or the time zone does not exist.
pub fn read(said: &str, zone_name: &str) -> Result<DueDate, DueRefused> {
    let zone = zone(zone_name)?;
    let local: DateTime = said.trim().parse().map_err(|_| DueRefused::NoDate(said.to_owned()))?;
    let ambiguous = zone.to_ambiguous_timestamp(local);
    if let AmbiguousOffset::Gap { before, after } = ambiguous.offset() {
        let (Ok(early), Ok(late)) = (after.to_timestamp(local), before.to_timestamp(local)) else {
            return Err(DueRefused::NoDate(said.to_owned()));
        };
        return Err(skipped(local, &zone, zone_name, early, late));
    }
    let at = ambiguous.later().map_err(|_| DueRefused::NoDate(said.to_owned()))?;
    Ok(DueDate { local: local.to_string(), at: moment(at) })
}

/// Returns the error for a skipped time, with its neighbours: one minute before the gap, and its
/// end.
fn skipped(local: DateTime, zone: &TimeZone, zone_name: &str, early: Timestamp, late: Timestamp) -> DueRefused {
    let jump = zone.following(early).next().map_or(late, |transition| transition.timestamp());
    let minute = |at: Timestamp| at.to_zoned(zone.clone()).strftime("%H:%M").to_string();
    DueRefused::Skipped {
        skipped: local.strftime("%H:%M").to_string(),
        zone: zone_name.to_owned(),
        before: minute(jump.checked_sub(1.minute()).unwrap_or(jump)),
        after: minute(jump),
    }
}

/// Returns a due date extended by calendar days. The local time of day stays the same, even if the
/// clocks change in between; if the clocks skip this time, the result is later by the skipped time.
///
/// # Errors
/// If `local` is not a date and time, or the time zone does not exist.
pub fn extended(local: &str, zone_name: &str, days: i64) -> Result<Moment, DueRefused> {
    let zone = zone(zone_name)?;
    let refused = || DueRefused::NoDate(local.to_owned());
    let said: DateTime = local.parse().map_err(|_| refused())?;
    let later = said.checked_add(days.days()).map_err(|_| refused())?;
    Ok(moment(zone.to_ambiguous_timestamp(later).compatible().map_err(|_| refused())?))
}

/// Returns whether a due date has passed at a moment. The due minute belongs to the allowed time,
/// so that 23:59 means the end of the day.
#[must_use]
pub fn is_past(due: Moment, at: Moment) -> bool {
    at.micros() >= due.micros() - due.micros().rem_euclid(MINUTE_US) + MINUTE_US
}

/// Returns the earliest whole minute that is not past at a moment, for comparison in queries.
#[must_use]
pub fn earliest_open(at: Moment) -> Moment {
    Moment::from_micros(at.micros() - at.micros().rem_euclid(MINUTE_US))
}

/// Returns the start of a day in a school's local time, `days_later` days after the given date.
/// `None` if the date does not have the format 2026-11-30.
#[must_use]
pub fn find_day_start(said: &str, zone_name: &str, days_later: i32) -> Option<Moment> {
    let day: Date = said.parse().ok()?;
    let day = day.checked_add(days_later.days()).ok()?;
    Some(moment(day.to_zoned(zone(zone_name).ok()?).ok()?.timestamp()))
}

/// Converts a moment to a school's local time, or to UTC if the time zone no longer exists.
#[must_use]
pub fn local(at: Moment, zone_name: &str) -> Local {
    let zone = zone(zone_name).unwrap_or(TimeZone::UTC);
    let zoned = Timestamp::from_microsecond(at.micros()).unwrap_or(Timestamp::UNIX_EPOCH).to_zoned(zone);
    Local {
        words: said(&zoned),
        offset: format!("UTC{}", zoned.strftime("%:z")),
        machine: zoned.strftime("%Y-%m-%dT%H:%M:%S%:z").to_string(),
    }
}

/// Formats a date and time for people.
fn said(at: &Zoned) -> String {
    let date = dates::date(at.year().into(), at.month().unsigned_abs(), at.day().unsigned_abs());
    tr!("{date}, {time}", date = date, time = at.strftime("%H:%M"))
}

fn moment(at: Timestamp) -> Moment {
    Moment::from_micros(at.as_microsecond())
}

#[cfg(test)]
mod tests {
    //! The clocks in Berlin skip from 02:00 to 03:00 on 29 March 2026 and are put back on 25
    //! October. The tests check that times that do not exist are refused, and that an extension
    //! keeps the time of day.

    use super::*;

    const BERLIN: &str = "Europe/Berlin";

    #[test]
    fn a_time_that_the_clocks_skip_is_refused_with_its_neighbours() {
        let refused = read("2026-03-29T02:30", BERLIN).unwrap_err();
        let expected = DueRefused::Skipped {
            skipped: "02:30".to_owned(),
            zone: BERLIN.to_owned(),
            before: "01:59".to_owned(),
            after: "03:00".to_owned(),
        };
        assert_eq!(refused, expected);
        assert!(refused.to_string().contains("01:59 and 03:00"));
        assert!(read("2026-03-29T03:00", BERLIN).is_ok() && read("2026-03-29T02:30", "UTC").is_ok());
        // Lord Howe Island changes its clocks by half an hour.
        let howe = read("2026-10-04T02:15", "Australia/Lord_Howe").unwrap_err();
        assert!(matches!(howe, DueRefused::Skipped { before, after, .. } if before == "01:59" && after == "02:30"));
    }

    #[test]
    fn a_time_that_comes_twice_is_the_later_one() {
        let due = read("2026-10-25T02:30", BERLIN).unwrap();
        assert_eq!(
            (local(due.at, BERLIN).offset.as_str(), due.at.to_string().as_str()),
            ("UTC+01:00", "2026-10-25T01:30:00Z")
        );
    }

    #[test]
    fn extension_keeps_the_local_time_across_a_clock_change() {
        let due = read("2026-03-27T18:00", BERLIN).unwrap();
        let later = extended(&due.local, BERLIN, 7).unwrap();
        assert_eq!(
            (local(due.at, BERLIN).words.as_str(), local(due.at, BERLIN).offset.as_str()),
            ("27 Mar 2026, 18:00", "UTC+01:00")
        );
        assert_eq!(
            (local(later, BERLIN).words.as_str(), local(later, BERLIN).offset.as_str()),
            ("3 Apr 2026, 18:00", "UTC+02:00")
        );
        assert_eq!(later.micros() - due.at.micros(), (7 * 24 - 1) * 3_600_000_000, "an hour is skipped on the way");
        let skipped = extended("2026-03-28T02:30:00", BERLIN, 1).unwrap();
        assert_eq!(local(skipped, BERLIN).words, "29 Mar 2026, 03:30");
    }

    #[test]
    fn the_minute_of_a_deadline_counts_whole() {
        let due = read("2026-11-30T23:59", BERLIN).unwrap().at;
        let seconds = |after: i64| Moment::from_micros(due.micros() + after * 1_000_000);
        for after in [-1, 0, 1, 59] {
            assert!(!is_past(due, seconds(after)) && earliest_open(seconds(after)) <= due, "{after}");
        }
        for after in [60, 61, 3600] {
            assert!(is_past(due, seconds(after)) && earliest_open(seconds(after)) > due, "{after}");
        }
        assert_eq!(
            find_day_start("2026-12-01", BERLIN, 0),
            Some(seconds(60)),
            "the day and its last minute end together"
        );
    }

    #[test]
    fn what_is_no_date_or_no_zone_is_said_so() {
        assert_eq!(read("tomorrow", BERLIN), Err(DueRefused::NoDate("tomorrow".to_owned())));
        assert_eq!(read("2026-03-29T02:30", "Mars/Base"), Err(DueRefused::NoZone("Mars/Base".to_owned())));
        assert!(is_zone("UTC") && is_zone("Asia/Shanghai") && !is_zone("nowhere"));
    }
}
