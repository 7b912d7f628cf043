//! Times in the time zone of the reader's school. The zone is task-local to a request, like the
//! language; UTC if the school has not set one.

use std::future::Future;

use jiff::Timestamp;
use jiff::tz::TimeZone;
use time::{OffsetDateTime, UtcOffset};

tokio::task_local! {
    static CLOCK: TimeZone;
}

/// Runs a future whose pages show times in a time zone; UTC if the name is unknown.
pub async fn on_school_clock<F: Future>(zone: &str, future: F) -> F::Output {
    CLOCK.scope(TimeZone::get(zone).unwrap_or(TimeZone::UTC), future).await
}

/// Returns the name of the time zone, like Europe/Berlin.
#[must_use]
pub fn zone_name() -> String {
    CLOCK.try_with(|zone| zone.iana_name().unwrap_or("UTC").to_owned()).unwrap_or_else(|_| "UTC".to_owned())
}

/// Converts a time to the school's time zone.
#[must_use]
pub fn to_school_time(at: OffsetDateTime) -> OffsetDateTime {
    let offset_s = |zone: &TimeZone| {
        let at = Timestamp::from_second(at.unix_timestamp()).ok()?;
        Some(zone.to_offset(at).seconds())
    };
    let offset = CLOCK.try_with(offset_s).ok().flatten().and_then(|s| UtcOffset::from_whole_seconds(s).ok());
    at.to_offset(offset.unwrap_or(UtcOffset::UTC))
}

#[cfg(test)]
mod tests {
    //! Daylight saving time must be applied, and days must begin at midnight of the school's time
    //! zone.

    use time::macros::datetime;

    use super::*;

    #[tokio::test]
    async fn a_moment_is_told_on_the_schools_clock_of_that_day() {
        let (winter, summer) = (datetime!(2026-11-22 23:09 UTC), datetime!(2026-06-30 22:30 UTC));
        assert_eq!(to_school_time(winter).hour(), 23, "UTC where nobody has settled it");
        on_school_clock("Europe/Berlin", async {
            let [winter, summer] = [winter, summer].map(to_school_time);
            assert_eq!((winter.day(), winter.hour(), winter.minute()), (23, 0, 9));
            assert_eq!((summer.month() as u8, summer.day(), summer.hour()), (7, 1, 0));
            assert_eq!(zone_name(), "Europe/Berlin");
        })
        .await;
        on_school_clock("Atlantis", async { assert_eq!(zone_name(), "UTC") }).await;
    }
}
