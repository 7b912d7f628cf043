//! Localised dates.

/// Formats a date, month counted from 1: 2 Mar 2026.
#[must_use]
pub fn date(year: i32, month: u8, day: u8) -> String {
    tr!("{day} {month} {year}", day = day, month = month_name(month), year = year)
}

/// Formats a month, counted from 1, with its year: Mar 2026.
#[must_use]
pub fn month(year: i64, month: u8) -> String {
    tr!("{month} {year}", month = month_name(month), year = year)
}

/// Formats a day with its month, counted from 1: 2 Mar.
#[must_use]
pub fn day(month: u8, day: u8) -> String {
    tr!("{day} {month}", day = day, month = month_name(month))
}

fn month_name(month: u8) -> &'static str {
    match month {
        1 => tr!("Jan"),
        2 => tr!("Feb"),
        3 => tr!("Mar"),
        4 => tr!("Apr"),
        5 => tr!("May"),
        6 => tr!("Jun"),
        7 => tr!("Jul"),
        8 => tr!("Aug"),
        9 => tr!("Sep"),
        10 => tr!("Oct"),
        11 => tr!("Nov"),
        _ => tr!("Dec"),
    }
}
