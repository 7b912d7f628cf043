//! Plausibility of an attempt's start time.

use crate::Moment;

/// Clock offsets up to this value are ignored, in µs.
const RIGHT_US: i64 = 60_000_000;
/// Maximum age at which the start time of an unsigned recording is accepted, in s.
const UNSIGNED_S: i64 = 24 * 3600;

/// The start time claimed by a recording and its sender.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Claim {
    /// Start time, by the clock of the machine that recorded it.
    pub began: Moment,
    /// Duration, in s.
    pub duration_s: f64,
    /// Offset of the sender's clock, in µs, positive if it is ahead; `None` if unknown.
    pub ahead_us: Option<i64>,
    /// Pairing time of the station that signed the recording; `None` if it is unsigned.
    pub paired_at: Option<Moment>,
}

impl Claim {
    /// Returns the start time by the server's clock. The attempt must end before it was received.
    /// It cannot start before the pairing of the station if it is signed, or more than a day before
    /// it was received if it is unsigned.
    #[must_use]
    pub fn believed(&self, received: Moment) -> Moment {
        let wrong_us = self.ahead_us.filter(|ahead_us| ahead_us.saturating_abs() > RIGHT_US).unwrap_or(0);
        let told = Moment::from_micros(self.began.micros().saturating_sub(wrong_us));
        let length_us = (self.duration_s.max(0.0) * 1e6).ceil() as i64;
        let latest = Moment::from_micros(received.micros().saturating_sub(length_us));
        let earliest = self.paired_at.unwrap_or_else(|| received.plus_s(-UNSIGNED_S));
        told.max(earliest).min(latest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: Moment = Moment::from_micros(1_795_269_600_000_000);
    const HOUR_S: i64 = 3600;

    fn claim(began: Moment) -> Claim {
        Claim { began, duration_s: 30.0, ahead_us: None, paired_at: None }
    }

    #[test]
    fn nothing_ends_after_it_was_received() {
        for began in [NOW, NOW.plus_s(-29), NOW.plus_s(900 * 365 * 24 * HOUR_S), Moment::from_micros(i64::MAX)] {
            assert_eq!(claim(began).believed(NOW), NOW.plus_s(-30));
        }
        assert_eq!(claim(NOW.plus_s(-31)).believed(NOW), NOW.plus_s(-31));
    }

    #[test]
    fn start_is_trusted_for_a_day_or_since_pairing_if_signed() {
        let (yesterday, paired_at) = (NOW.plus_s(-24 * HOUR_S), NOW.plus_s(-90 * 24 * HOUR_S));
        let last_month = NOW.plus_s(-30 * 24 * HOUR_S);
        assert_eq!(claim(last_month).believed(NOW), yesterday);
        let signed = |began| Claim { paired_at: Some(paired_at), ..claim(began) };
        assert_eq!(signed(last_month).believed(NOW), last_month);
        assert_eq!(signed(Moment::from_micros(0)).believed(NOW), paired_at);
        assert_eq!(signed(NOW.plus_s(HOUR_S)).believed(NOW), NOW.plus_s(-30));
    }

    #[test]
    fn wrong_clock_is_corrected_and_a_nearly_right_one_kept() {
        let ahead = |seconds: i64, began| Claim { ahead_us: Some(seconds * 1_000_000), ..claim(began) }.believed(NOW);
        let then = NOW.plus_s(-HOUR_S);
        assert_eq!(ahead(7200, then.plus_s(7200)), then, "two hours fast");
        assert_eq!(ahead(-7200, then.plus_s(-7200)), then, "two hours slow");
        assert_eq!(ahead(59, then.plus_s(59)), then.plus_s(59));
        assert_eq!(ahead(i64::MIN / 1_000_000, then), NOW.plus_s(-30), "no clock overflows");
    }
}
