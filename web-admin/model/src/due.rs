//! Due dates: said on a school's clock, meant as a moment.

use jiff::civil::{Date, DateTime};
use jiff::tz::{AmbiguousOffset, TimeZone};
use jiff::{Timestamp, ToSpan, Zoned};
use words::dates;

use super::Moment;

/// A minute, in µs.
const MINUTE_US: i64 = 60_000_000;

/// A due date as it was said, and what it means.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DueDate {
    /// As it was said, on the school's clock: `2026-11-30T18:00:00`.
    pub local: String,
    /// The moment.
    pub at: Moment,
}

/// Why a due date is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DueRefused {
    /// It is no date and time.
    #[error("{}", tr!("the due date: “{typed}”; a date and time like 2026-11-30T18:00 is needed", typed = .0))]
    NoDate(String),
    /// The clocks skip it.
    #[error("{}", tr!(
        "the due date: on that day the clocks skip {skipped} in {zone}; the nearest times are {before} and {after}",
        skipped = .skipped,
        zone = .zone,
        before = .before,
        after = .after
    ))]
    Skipped {
        /// What was said.
        skipped: String,
        /// Where.
        zone: String,
        /// The last minute before the gap.
        before: String,
        /// The first moment after it.
        after: String,
    },
    /// There is no such time zone.
    #[error("{}", tr!("the time zone: “{name}”; a name like Europe/Berlin is needed", name = .0))]
    NoZone(String),
}

/// A moment on a school's clock, with the offset that holds then.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Local {
    /// 30 Nov 2026, 18:00.
    pub words: String,
    /// UTC+01:00.
    pub offset: String,
    /// 2026-11-30T18:00:00+01:00.
    pub machine: String,
}

fn zone(name: &str) -> Result<TimeZone, DueRefused> {
    TimeZone::get(name).map_err(|_| DueRefused::NoZone(name.to_owned()))
}

/// Whether there is a time zone of this name.
#[must_use]
pub fn is_zone(name: &str) -> bool {
    zone(name).is_ok()
}

/// The names of all time zones, by name, and one that is kept already.
#[must_use]
pub fn list_zones(kept: &str) -> Vec<String> {
    let mut zones: Vec<String> = jiff::tz::db().available().map(|name| name.as_str().to_owned()).collect();
    zones.push(kept.to_owned());
    zones.sort();
    zones.dedup();
    zones
}

/// Reads a due date on a school's clock. A time that comes twice, when the clocks go back, is the later one.
///
/// # Errors
/// When it is no date, or the clocks skip it.
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

/// The times around a gap: one minute before the clocks jump, and where they land.
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

/// A due date so many calendar days later: the same time of day, whatever the clocks do between. Where they skip it, it
/// is later by as much as they skip.
///
/// # Errors
/// When it was never said like that.
pub fn extended(local: &str, zone_name: &str, days: i64) -> Result<Moment, DueRefused> {
    let zone = zone(zone_name)?;
    let refused = || DueRefused::NoDate(local.to_owned());
    let said: DateTime = local.parse().map_err(|_| refused())?;
    let later = said.checked_add(days.days()).map_err(|_| refused())?;
    Ok(moment(zone.to_ambiguous_timestamp(later).compatible().map_err(|_| refused())?))
}

/// Whether something is late that is due at a moment: the minute that is named counts whole, so that 23:59 ends with the day.
#[must_use]
pub fn is_past(due: Moment, at: Moment) -> bool {
    at.micros() >= due.micros() - due.micros().rem_euclid(MINUTE_US) + MINUTE_US
}

/// Returns the earliest whole minute that is not past at a moment, for comparing many.
#[must_use]
pub fn earliest_open(at: Moment) -> Moment {
    Moment::from_micros(at.micros() - at.micros().rem_euclid(MINUTE_US))
}

/// When a day begins on a school's clock, so many days later; none where it is no date, as 2026-11-30.
#[must_use]
pub fn find_day_start(said: &str, zone_name: &str, days_later: i32) -> Option<Moment> {
    let day: Date = said.parse().ok()?;
    let day = day.checked_add(days_later.days()).ok()?;
    Some(moment(day.to_zoned(zone(zone_name).ok()?).ok()?.timestamp()))
}

/// A moment on a school's clock; on UTC's where the zone has no such name any more.
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

/// A date and a time as people say them.
fn said(at: &Zoned) -> String {
    let date = dates::date(at.year().into(), at.month().unsigned_abs(), at.day().unsigned_abs());
    tr!("{date}, {time}", date = date, time = at.strftime("%H:%M"))
}

fn moment(at: Timestamp) -> Moment {
    Moment::from_micros(at.as_microsecond())
}

#[cfg(test)]
mod tests {
    //! Clocks in Berlin skip from 02:00 to 03:00 on 29 March 2026 and go back on 25 October. Fails when a deadline that
    //! does not exist is taken, or an extension moves the time of day.

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
        // Lord Howe Island moves its clocks by half an hour.
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
    fn an_extension_keeps_the_time_of_day_over_a_change_of_the_clocks() {
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
