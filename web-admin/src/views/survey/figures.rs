//! Figures of a survey in words.

use crate::domain::survey::results::{Agreement, Alpha, Figure, Interval, Quartiles};
use crate::views::format;

/// A figure in words, or why there is none.
fn said<T>(figure: &Figure<T>, words: impl Fn(&T) -> String) -> String {
    match figure {
        Figure::Value(value) => words(value),
        Figure::None { not_computable } => format!("not computable: {not_computable}"),
    }
}

/// 3.0 (2.0–4.0).
#[must_use]
pub fn quartiles(figure: &Figure<Quartiles>) -> String {
    said(figure, |q| format!("{} ({}–{})", format::number(q.median), format::number(q.lower), format::number(q.upper)))
}

/// 68.1 (60.2 to 76.0).
#[must_use]
pub fn interval(figure: &Figure<Interval>) -> String {
    said(figure, |i| format!("{} ({} to {})", format::number(i.value), format::number(i.low), format::number(i.high)))
}

/// 0.87 (12 of 12).
#[must_use]
pub fn validity(figure: &Figure<Interval>) -> String {
    said(figure, |i| {
        format!("{} (n = {}, {} to {})", format::number(i.value), i.n, format::number(i.low), format::number(i.high))
    })
}

/// α with what it rests on.
#[must_use]
pub fn alpha(figure: &Figure<Alpha>) -> String {
    said(figure, |a| format!("{} (n = {}, {} incomplete)", format::number(a.alpha), a.n, a.missing))
}

/// The four correlations with what they rest on.
#[must_use]
pub fn agreement(figure: &Figure<Agreement>) -> String {
    said(figure, |a| {
        let all = [a.icc_2_1, a.icc_2_k, a.icc_3_1, a.icc_3_k].map(format::number);
        let [two_one, two_k, three_one, three_k] = all;
        format!(
            "ICC(2,1) {two_one}, (2,k) {two_k}, (3,1) {three_one}, (3,k) {three_k}; {} people, {} incomplete",
            a.raters, a.missing
        )
    })
}

/// S-CVI/Ave: a mean of shares has no interval of its own.
#[must_use]
pub fn scale_validity(figure: &Figure<Interval>) -> String {
    said(figure, |i| format!("{}, over {}", format::number(i.value), format::counted(i.n, "item")))
}
