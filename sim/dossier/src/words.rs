//! Values, ranges and verdicts in words, for the dossier's text, table and picture.

use documents::NeedleFamily;

use crate::compare::{Agreement, DossierLine, Incomparable};
use crate::figures::{PublishedFigure, PublishedRange};
use crate::quantity::MeasuredQuantity;

pub(crate) fn first_upper(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Describes a family of needles in words.
pub(crate) const fn name_family(family: NeedleFamily) -> &'static str {
    match family {
        NeedleFamily::RenalAccess => "renal access needle",
        NeedleFamily::Tuohy => "Tuohy needle",
        NeedleFamily::Spinal => "spinal needle",
        NeedleFamily::Veress => "Veress needle",
        NeedleFamily::Trocar => "laparoscopic trocar",
        NeedleFamily::Organ => "needle into an organ",
    }
}

pub(crate) fn say_why(why: Incomparable) -> String {
    match why {
        Incomparable::Family { measured, scene: Some(scene) } => {
            format!("measured with a {}, the scene has a {}", name_family(measured), name_family(scene))
        }
        Incomparable::Family { measured, scene: None } => {
            format!("measured with a {}, the scene names no family", name_family(measured))
        }
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
        PublishedRange::Means { low, high } if low < high => format!("means {} to {}, ± 25 %", say(low), say(high)),
        PublishedRange::Means { low, .. } => format!("mean {}, ± 25 %", say(low)),
        PublishedRange::Spread { mean, deviation } => format!("{} ± 2 × {}", say(mean), say(deviation)),
        PublishedRange::Above(low) => format!("above {}", say(low)),
        PublishedRange::Distinguishable(low) => format!("clearly above {}", say(low)),
        PublishedRange::Single(value) => say(value),
        PublishedRange::Unstated => "no values".to_owned(),
    }
}

pub(crate) fn say_verdict(line: &DossierLine) -> String {
    let verdict = match line.agreement {
        Agreement::Inside => "inside".to_owned(),
        Agreement::Outside => "**outside**".to_owned(),
        Agreement::SingleValue { ratio } => format!("× {ratio:.2}"),
        Agreement::Incomparable(why) => say_why(why),
    };
    let verdict = match line.excepted.filter(|_| line.agreement == Agreement::Outside) {
        Some(why) => format!("{verdict}: {why}"),
        None => verdict,
    };
    if line.fitted { format!("{verdict}, fitted to it") } else { verdict }
}

/// Describes a line in one sentence: title, the scene's value and what was published.
#[must_use]
pub fn describe_line(line: &DossierLine) -> String {
    let value = say_value(&line.figure.quantity, line.value.unwrap_or_default());
    format!("{}: {value} ({})", line.figure.title, say_range(line.figure))
}
