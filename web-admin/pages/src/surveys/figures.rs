//! Formatting of survey statistics.

use model::surveys::results::{Alpha, AlphaRemark, ConfidenceInterval, Quartiles, RaterAgreement, SurveyFigure};

use crate::format;

/// Formats a statistic, or the reason why it cannot be computed.
fn say_figure<T>(figure: &SurveyFigure<T>, words: impl Fn(&T) -> String) -> String {
    match figure {
        SurveyFigure::Value(value) => words(value),
        SurveyFigure::None { not_computable } => tr!("not computable: {why}", why = words::phrase(not_computable)),
    }
}

/// Formats median and quartiles: 3.0 (2.0–4.0).
#[must_use]
pub fn say_quartiles(figure: &SurveyFigure<Quartiles>) -> String {
    say_figure(figure, |q| {
        format!(
            "{} ({}–{})",
            format::format_number(q.median),
            format::format_number(q.lower),
            format::format_number(q.upper)
        )
    })
}

/// Formats a value with its confidence interval: 68.1 (60.2 to 76.0).
#[must_use]
pub fn say_interval(figure: &SurveyFigure<ConfidenceInterval>) -> String {
    say_figure(figure, |i| {
        tr!(
            "{value} ({low} to {high})",
            value = format::format_number(i.value),
            low = format::format_number(i.low),
            high = format::format_number(i.high)
        )
    })
}

/// Formats a content validity index with its sample size and interval: 0.87 (n = 12, 0.62 to 0.96).
#[must_use]
pub fn say_validity(figure: &SurveyFigure<ConfidenceInterval>) -> String {
    say_figure(figure, |i| {
        tr!(
            "{value} (n = {n}, {low} to {high})",
            value = format::format_number(i.value),
            n = i.n,
            low = format::format_number(i.low),
            high = format::format_number(i.high)
        )
    })
}

/// Formats Cronbach's α with its interval, sample size and number of incomplete responses.
#[must_use]
pub fn say_alpha(figure: &SurveyFigure<Alpha>) -> String {
    say_figure(figure, |a| {
        tr!(
            "{value} ({low} to {high}; n = {n}, {missing} incomplete)",
            value = format::format_fixed(a.alpha, 2),
            low = format::format_fixed(a.low, 2),
            high = format::format_fixed(a.high, 2),
            n = a.n,
            missing = a.missing
        )
    })
}

/// Explains a negative α; empty for other values.
#[must_use]
pub fn say_alpha_remark(figure: &SurveyFigure<Alpha>) -> &'static str {
    match figure.value().and_then(|alpha| alpha.remark) {
        Some(AlphaRemark::Negative) => {
            tr!(
                "Negative: some items correlate negatively with the others. Check whether an item should be reverse-scored."
            )
        }
        Some(AlphaRemark::FewResponses) | None => "",
    }
}

/// Formats a correlation or an item's α, with two decimals.
#[must_use]
pub fn say_coefficient(figure: &SurveyFigure<f64>) -> String {
    say_figure(figure, |value| format::format_fixed(*value, 2))
}

/// Formats the four intraclass correlations with the number of raters and of incomplete ratings.
#[must_use]
pub fn say_agreement(figure: &SurveyFigure<RaterAgreement>) -> String {
    say_figure(figure, |a| {
        let [two_one, three_one, three_k] = [a.icc_2_1, a.icc_3_1, a.icc_3_k].map(format::format_number);
        let two_k = a.icc_2_k.map_or_else(|| "–".to_owned(), format::format_number);
        let figures = format!("ICC(2,1) {two_one}, (2,k) {two_k}, (3,1) {three_one}, (3,k) {three_k}");
        tr!(
            "{figures}; {people} people, {missing} incomplete",
            figures = figures,
            people = a.raters,
            missing = a.missing
        )
    })
}

/// Formats the S-CVI/Ave. As a mean of shares it has no confidence interval of its own.
#[must_use]
pub fn say_scale_validity(figure: &SurveyFigure<ConfidenceInterval>) -> String {
    say_figure(figure, |i| {
        trn!("{value}, over {n} item", "{value}, over {n} items", i.n, value = format::format_number(i.value))
    })
}
