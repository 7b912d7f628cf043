//! Formatting of values: numbers with units, dates, time spans.
//!
//! Templates pass fields by reference and other values by value, hence `impl Borrow`.

use model::people::email::present_email;
use std::borrow::Borrow;

use assessment::statistics::Estimate;
use time::{Date, Duration, OffsetDateTime};
use words::decimal;

use crate::school_time::to_school_time;

/// Formats a number with about three significant digits, and a true minus sign.
#[must_use]
pub fn format_number(value: impl Borrow<f64>) -> String {
    let value = *value.borrow();
    let decimals = match value.abs() {
        size if size >= 100.0 => 0,
        size if size >= 10.0 => 1,
        _ => 2,
    };
    format_fixed(value, decimals)
}

/// Formats a number with a fixed number of decimals, and a true minus sign.
#[must_use]
pub fn format_fixed(value: impl Borrow<f64>, decimals: usize) -> String {
    words::fixed(*value.borrow(), decimals)
}

/// Formats a value with its unit, without a line break in between. Counts and dimensionless numbers
/// have no unit.
#[must_use]
pub fn format_quantity(value: impl Borrow<f64>, unit: &str) -> String {
    let value = *value.borrow();
    match unit {
        "count" => format_fixed(value, 0),
        "1" | "" => format_number(value),
        "°" | "deg" => format!("{}°", format_number(value)),
        unit => format!("{}\u{a0}{unit}", format_number(value)),
    }
}

/// Formats a value stated in a document, with its unit and exactly the digits that the value needs.
#[must_use]
pub fn format_stated(value: impl Borrow<f64>, unit: &str) -> String {
    let number = decimal(&value.borrow().to_string());
    match unit {
        "count" | "1" | "" => number,
        "°" => number + unit,
        unit => format!("{number}\u{a0}{unit}"),
    }
}

/// Formats a score, 0–100, rounded to an integer. Next to a pass mark use [`format_score`], which
/// never rounds a fail up to the mark.
#[must_use]
pub fn format_points(score: impl Borrow<f64>) -> String {
    // The offset keeps rounding errors of the weighted sum from turning a half downwards.
    format_fixed((score.borrow() + 1e-9).round(), 0)
}

/// Formats a score shown next to its pass mark: rounded to an integer, with one or two decimals if
/// the integer would be on the other side of the mark.
#[must_use]
pub fn format_score(score: impl Borrow<f64>, pass_mark: impl Borrow<Option<f64>>) -> String {
    let score = *score.borrow();
    let Some(mark) = *pass_mark.borrow() else { return format_points(score) };
    let is_true = |rounded: f64| (rounded >= mark) == (score >= mark);
    for (decimals, scale) in [(0, 1.0), (1, 10.0), (2, 100.0)] {
        let rounded = ((score + 1e-9) * scale).round() / scale;
        if is_true(rounded) {
            return format_fixed(rounded, decimals);
        }
    }
    format_fixed((score * 100.0).floor() / 100.0, 2)
}

/// Formats a time in an attempt, in s, for addresses and forms: decimal point and two decimals.
#[must_use]
pub fn plain_seconds(t_s: impl Borrow<f64>) -> String {
    format!("{:.2}", t_s.borrow())
}

/// Formats points won or lost on a rubric line, with one decimal if they are not whole.
#[must_use]
pub fn line_points(points: impl Borrow<f64>) -> String {
    let points = *points.borrow();
    let whole = (points - points.round()).abs() < 0.05;
    format_fixed(points, usize::from(!whole))
}

/// Formats a date: 2 March 2026.
#[must_use]
pub fn format_date(at: impl Borrow<OffsetDateTime>) -> String {
    let day = to_school_time(*at.borrow()).date();
    words::dates::date(day.year(), u8::from(day.month()), day.day())
}

/// Formats date and time in the school's time zone: 2 Mar 2026, 09:05. Each page's footer names the
/// time zone.
#[must_use]
pub fn format_date_time(at: impl Borrow<OffsetDateTime>) -> String {
    let at = *at.borrow();
    tr!("{date}, {time}", date = format_date(at), time = format_clock(at))
}

/// Formats the time of day in the school's time zone: 09:05.
#[must_use]
pub fn format_clock(at: impl Borrow<OffsetDateTime>) -> String {
    let at = to_school_time(*at.borrow());
    format!("{:02}:{:02}", at.hour(), at.minute())
}

/// Formats a day without its year: 2 Mar.
#[must_use]
pub fn format_short_date(day: impl Borrow<Date>) -> String {
    let day = day.borrow();
    words::dates::day(u8::from(day.month()), day.day())
}

/// Formats a month, given as 12 × year + month − 1: Mar 2026.
#[must_use]
#[expect(clippy::expect_used, reason = "what is left of a division by 12 is 0 to 11")]
pub fn format_month(months: i64) -> String {
    let month = u8::try_from(months.rem_euclid(12) + 1).expect("1 to 12");
    words::dates::month(months.div_euclid(12), month)
}

/// Splits an email address before its @ sign, where a line may break; without one, the words for it.
#[must_use]
pub fn split_email(email: &str) -> (&str, &str) {
    match present_email(email) {
        Some(email) => email.split_at(email.find('@').unwrap_or(email.len())),
        None => (tr!("no address"), ""),
    }
}

/// Inserts non-breaking spaces, so that no line breaks within brackets or next to an equals sign.
#[must_use]
pub fn hold_brackets(figures: &str) -> String {
    let (mut held, mut within) = (String::with_capacity(figures.len()), false);
    for letter in figures.chars() {
        within = letter == '(' || within && letter != ')';
        match letter {
            ' ' if within => held.push('\u{a0}'),
            // A line may break after a dash: the word joiner prevents it.
            '–' if within => held.push_str("–\u{2060}"),
            letter => held.push(letter),
        }
    }
    held.replace(" = ", "\u{a0}=\u{a0}")
}

/// Formats a time for the `datetime` attribute of `<time>`, which allows milliseconds at most.
#[must_use]
pub fn format_machine_time(at: impl Borrow<OffsetDateTime>) -> String {
    let at = *at.borrow();
    let whole_ms = at.replace_millisecond(at.millisecond()).unwrap_or(at);
    whole_ms.format(&time::format_description::well_known::Rfc3339).unwrap_or_default()
}

/// Formats the age of a time: within the hour, in hours, or in whole days.
#[must_use]
pub fn format_age(at: impl Borrow<OffsetDateTime>, now: impl Borrow<OffsetDateTime>) -> String {
    let (at, now) = (*at.borrow(), *now.borrow());
    let past = now - at;
    match past.whole_days() {
        ..=-1 => format_date(at),
        0 if past < Duration::hours(1) => tr!("less than an hour ago").to_owned(),
        0 => trn!("{n} hour ago", "{n} hours ago", past.whole_hours()),
        days => trn!("{n} day ago", "{n} days ago", days),
    }
}

/// Formats a time span: 42.0 s, or 2 min 5 s.
#[must_use]
pub fn format_span(seconds: f64) -> String {
    if !seconds.is_finite() || seconds < 0.0 {
        return tr!("unknown").to_owned();
    }
    let minutes = (seconds / 60.0).floor();
    match (minutes, (seconds % 60.0).floor()) {
        (..1.0, _) => format!("{}\u{a0}s", format_fixed(seconds, 1)),
        (_, ..1.0) => format!("{minutes:.0}\u{a0}min"),
        (_, rest) => format!("{minutes:.0} min {rest:.0}\u{a0}s"),
    }
}

/// Formats a size: 1.4 MB.
#[must_use]
pub fn format_size(bytes: i64) -> String {
    let bytes = bytes.max(0) as f64;
    if bytes < 1e6 {
        format!("{:.0}\u{a0}kB", (bytes / 1e3).ceil())
    } else if bytes < 1e9 {
        format!("{}\u{a0}MB", format_fixed(bytes / 1e6, 1))
    } else {
        format!("{}\u{a0}GB", format_fixed(bytes / 1e9, 1))
    }
}

/// Formats a share without its interval, in whole percent.
#[must_use]
pub fn format_percent(share: impl Borrow<f64>) -> String {
    format!("{}\u{a0}%", format_fixed(share.borrow() * 100.0, 0))
}

/// Formats a share with its 95 % interval: 90 % (70–97 %).
#[must_use]
pub fn format_share(share: impl Borrow<Estimate>) -> String {
    let Estimate { value, low, high, .. } = share.borrow();
    let percent = |share: &f64| format_fixed(share * 100.0, 0);
    format!("{} % ({}–{} %)", percent(value), percent(low), percent(high))
}

/// Returns the first 12 digits of a hash: enough to compare by eye.
#[must_use]
pub fn shorten_hash(hash: &str) -> &str {
    hash.get(..12).unwrap_or(hash)
}

/// Returns the text with its first letter in upper case.
#[must_use]
pub fn as_sentence(text: &str) -> String {
    let mut rest = text.chars();
    rest.next().map_or_else(String::new, |first| first.to_uppercase().chain(rest).collect())
}

/// Converts fact names to owned strings.
pub(crate) fn name_facts(facts: Vec<(&'static str, String)>) -> Vec<(String, String)> {
    facts.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

#[cfg(test)]
mod tests {
    //! A figure must not show useless digits, round a fail up to the pass mark, or show a negative
    //! zero.

    use time::macros::datetime;
    use words::Language;

    use super::*;

    #[test]
    fn figures_carry_unit_and_sensible_decimals() {
        assert_eq!(format_quantity(1.934, "mm"), "1.93\u{a0}mm");
        assert_eq!(format_quantity(-12.34, "N"), "−12.3\u{a0}N");
        assert_eq!(format_quantity(-0.001, "mm"), "0.00\u{a0}mm");
        assert_eq!(
            [format_stated(2.0, "mm"), format_stated(0.5, "°"), format_stated(-1.25, "1")],
            ["2\u{a0}mm", "0.5°", "−1.25"]
        );
        assert_eq!(
            [format_quantity(3.0, "count"), format_quantity(4.0, "°"), format_quantity(0.5, "1")],
            ["3", "4.00°", "0.50"]
        );
    }

    #[test]
    fn no_line_breaks_within_brackets() {
        assert_eq!(hold_brackets("2.0 (1.5 to 2.5), n = 8"), "2.0 (1.5\u{a0}to\u{a0}2.5), n\u{a0}=\u{a0}8");
        assert_eq!(hold_brackets("2.0 (1.5–2.5) mm"), "2.0 (1.5–\u{2060}2.5) mm");
    }

    #[test]
    fn scores_are_rounded() {
        assert_eq!([format_points(58.7), format_points(58.4), format_points(100.0 - 1e-12)], ["59", "58", "100"]);
        assert_eq!(format_points(0.5), "1");
    }

    #[test]
    fn a_fail_beside_its_pass_mark_is_not_rounded_up_to_it() {
        let said = [69.2, 69.6, 69.96, 69.999, 70.0, 58.7].map(|score| format_score(score, Some(70.0)));
        assert_eq!(said, ["69", "69.6", "69.96", "69.99", "70", "59"]);
        assert_eq!([format_score(62.4, Some(62.3)), format_score(69.6, None)], ["62.4", "70"]);
    }

    #[test]
    fn points_of_a_line_show_a_decimal_only_where_there_is_one() {
        assert_eq!([line_points(12.0), line_points(2.54), line_points(-0.0)], ["12", "2.5", "0"]);
    }

    #[test]
    fn times_read_as_people_say_them() {
        let now = datetime!(2026-03-02 09:05 UTC);
        assert_eq!(format_date_time(now), "2 Mar 2026, 09:05");
        assert_eq!(format_age(datetime!(2026-03-02 06:00 UTC), now), "3 hours ago");
        assert_eq!(format_age(datetime!(2026-03-01 06:00 UTC), now), "1 day ago");
        assert_eq!(
            [format_span(42.04), format_span(125.0), format_span(300.0)],
            ["42.0\u{a0}s", "2 min 5\u{a0}s", "5\u{a0}min"]
        );
        assert_eq!(format_span(f64::NAN), "unknown");
    }

    #[test]
    fn a_machine_reads_milliseconds_at_most() {
        let times =
            [datetime!(2026-03-02 09:05:01.987654 UTC), datetime!(2026-03-02 09:05 UTC)].map(format_machine_time);
        assert_eq!(times, ["2026-03-02T09:05:01.987Z", "2026-03-02T09:05:00Z"]);
    }

    #[test]
    fn a_sentence_begins_with_a_capital() {
        assert_eq!(as_sentence("épaule"), "Épaule");
    }

    #[test]
    fn german_writes_numbers_and_dates_its_own_way() {
        let german = Language::named("de").expect("German");
        let said = words::within(german, || {
            [format_quantity(-1.934, "mm"), format_date_time(datetime!(2026-03-02 09:05 UTC))]
        });
        assert_eq!(said, ["−1,93\u{a0}mm", "2. März 2026, 09:05"]);
    }
}
