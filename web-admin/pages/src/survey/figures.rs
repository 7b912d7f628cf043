//! Figures of a survey in words.

use crate::format;
use model::survey::results::{Agreement, Alpha, Figure, Interval, Quartiles};

/// A figure in words, or why there is none.
fn said<T>(figure: &Figure<T>, words: impl Fn(&T) -> String) -> String {
    match figure {
        Figure::Value(value) => words(value),
        Figure::None { not_computable } => tr!("not computable: {why}", why = words::phrase(not_computable)),
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
    said(figure, |i| {
        tr!(
            "{value} ({low} to {high})",
            value = format::number(i.value),
            low = format::number(i.low),
            high = format::number(i.high)
        )
    })
}

/// 0.87 (12 of 12).
#[must_use]
pub fn validity(figure: &Figure<Interval>) -> String {
    said(figure, |i| {
        tr!(
            "{value} (n = {n}, {low} to {high})",
            value = format::number(i.value),
            n = i.n,
            low = format::number(i.low),
            high = format::number(i.high)
        )
    })
}

/// α with what it rests on.
#[must_use]
pub fn alpha(figure: &Figure<Alpha>) -> String {
    said(figure, |a| {
        tr!("{value} (n = {n}, {missing} incomplete)", value = format::number(a.alpha), n = a.n, missing = a.missing)
    })
}

/// The four correlations with what they rest on.
#[must_use]
pub fn agreement(figure: &Figure<Agreement>) -> String {
    said(figure, |a| {
        let [two_one, three_one, three_k] = [a.icc_2_1, a.icc_3_1, a.icc_3_k].map(format::number);
        let two_k = a.icc_2_k.map_or_else(|| "–".to_owned(), format::number);
        let figures = format!("ICC(2,1) {two_one}, (2,k) {two_k}, (3,1) {three_one}, (3,k) {three_k}");
        tr!(
            "{figures}; {people} people, {missing} incomplete",
            figures = figures,
            people = a.raters,
            missing = a.missing
        )
    })
}

/// S-CVI/Ave: a mean of shares has no interval of its own.
#[must_use]
pub fn scale_validity(figure: &Figure<Interval>) -> String {
    said(figure, |i| trn!("{value}, over {n} item", "{value}, over {n} items", i.n, value = format::number(i.value)))
}
