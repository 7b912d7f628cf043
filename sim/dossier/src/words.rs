//! Values, ranges and verdicts in words, for the dossier's text, table and picture.

use crate::compare::{Agreement, DossierLine, Incomparable};
use crate::figures::{MeasuredQuantity, PublishedFigure, PublishedRange};

pub(crate) fn first_upper(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

pub(crate) fn say_why(why: Incomparable) -> String {
    match why {
        Incomparable::NoLayer(layer) => format!("no layer is called {layer}"),
        Incomparable::NotReached(layer) => format!("the needle ends before {layer} opens"),
        Incomparable::NoValues => "no values are published".to_owned(),
        Incomparable::Stated(why) => why.to_owned(),
    }
}

pub(crate) fn say_value(quantity: &MeasuredQuantity, value: f64) -> String {
    match quantity.unit() {
        "m" => format!("{:.1} mm", value * 1e3),
        "N" => format!("{value:.2} N"),
        "" if quantity.is_share() => format!("{:.0} %", value * 1e2),
        "" => format!("{value:.3}"),
        "s" => format!("{value:.3} s"),
        unit => format!("{value:.0} {unit}"),
    }
}

pub(crate) fn say_range(figure: &PublishedFigure) -> String {
    let say = |value: f64| say_value(&figure.quantity, value);
    match figure.range {
        PublishedRange::Between { low, high } => format!("{} to {}", say(low), say(high)),
        PublishedRange::Above(low) => format!("above {}", say(low)),
        PublishedRange::ToldApart(low) => format!("clearly above {}", say(low)),
        PublishedRange::Single(value) => say(value),
        PublishedRange::Unstated => "no values".to_owned(),
    }
}

pub(crate) fn say_verdict(line: &DossierLine) -> String {
    let verdict = match line.agreement {
        Agreement::Inside => "inside".to_owned(),
        Agreement::Outside => "**outside**".to_owned(),
        Agreement::Beside { ratio } => format!("× {ratio:.2}"),
        Agreement::Incomparable(why) => say_why(why),
    };
    if line.fitted { format!("{verdict}, fitted to it") } else { verdict }
}
