//! Metrics, and the reasons of scores, in the reader's language.
//!
//! A score keeps its reasons as they were worded when it was made, in English. Another language says the same anew, from
//! the words of the metric and the figures in the reason; what it cannot take apart, it shows as it was kept.

use assessment::Deduction;
use assessment::catalogue::{self, Definition, Split};
use mechanics::axial::Contactor;

use super::{anatomy, format};
use crate::words::{self, Language};

/// Name of a metric by its id, with a capital.
#[must_use]
pub fn label(id: &str) -> String {
    format::sentence(&words_of(id))
}

/// Name of a metric that was measured, with a capital; its own where the catalogue has it no more.
#[must_use]
pub fn label_of(id: &str, label: &str) -> String {
    if catalogue::newest(id).is_none() && !label.is_empty() {
        return format::sentence(label);
    }
    self::label(id)
}

/// How a version of a metric is defined; empty for one that the catalogue has not. A later version than the first says so.
#[must_use]
pub fn definition(id: &str, version: u32) -> String {
    let definition = catalogue::definition(id, version).map_or_else(String::new, |d| words::known(d.definition));
    match version {
        0 | 1 => definition,
        _ if definition.is_empty() => definition,
        _ => tr!("{definition} (Version {version})", definition = definition, version = version),
    }
}

fn words_of(id: &str) -> String {
    let Some(definition) = catalogue::newest(id) else { return id.to_owned() };
    let metric = words::known(definition.label);
    let Some((_, part)) = id.split_once('.') else { return metric };
    match (definition.split, part.rsplit_once('.')) {
        (Some(Split::Boundary), Some((layer, contactor))) => {
            let contactor = if contactor == "rim" { Contactor::Rim } else { Contactor::Tip };
            let pop = words::phrase(&contactor.into_layer(&anatomy::said(layer)));
            tr!("{metric}, {pop}", metric = metric, pop = pop)
        }
        (Some(Split::Layer), _) => tr!("{metric} in {layer}", metric = metric, layer = anatomy::said(part)),
        (Some(Split::Structure), _) => tr!("{metric} to {structure}", metric = metric, structure = anatomy::said(part)),
        _ => format!("{metric}: {}", words::known(part)),
    }
}

/// Why points were lost, with what earns full marks and advice.
#[must_use]
pub fn reason(deduction: &Deduction) -> String {
    let why = renamed(&deduction.metric, without_cost(&deduction.why));
    format::sentence(&in_own_language(&deduction.metric, &why).unwrap_or(why))
}

/// Why points were lost, for a list of attempts.
#[must_use]
pub fn short_reason(deduction: &Deduction) -> String {
    let why = renamed(&deduction.metric, without_cost(&deduction.why));
    let what = why.split_once(", full marks for ").map_or(why.as_str(), |(what, _)| what);
    format::sentence(&in_own_language(&deduction.metric, what).unwrap_or_else(|| what.to_owned()))
}

/// Why an attempt failed whatever its points: the author's words, and the figures in the reader's language.
#[must_use]
pub fn hard_fail(why: &str) -> String {
    let Some((words, figures)) = why.rsplit_once(" (") else { return words::known(why) };
    let taken = figures.strip_suffix(')').and_then(|figures| figures.rsplit_once(", limit "));
    let Some((found, limit)) = taken else { return why.to_owned() };
    let split = |c: char| c.is_ascii_digit() || c == '−';
    let (label, value) = found.split_at(found.find(split).unwrap_or(found.len()));
    let (label, value) = (words::known(label.trim_end()), format::decimal(value));
    tr!(
        "{why} ({found}, limit {limit})",
        why = words,
        found = format!("{label} {value}"),
        limit = format::decimal(limit)
    )
}

/// A reason ends with its cost, which stands in a column of its own on pages.
fn without_cost(why: &str) -> &str {
    match why.rsplit_once(": ") {
        Some((reason, cost)) if cost.starts_with('−') || cost == "no points lost" => reason,
        _ => why,
    }
}

/// A reason that was kept when pops were still called by `through` and the layer entered, with today's name of the pop.
fn renamed(metric: &str, why: &str) -> String {
    let pop = metric.split_once('.').and_then(|(_, part)| part.rsplit_once('.'));
    match (catalogue::newest(metric).and_then(|definition| definition.split), pop) {
        (Some(Split::Boundary), Some((layer, contactor))) => {
            why.replacen(&format!(", {contactor} through {layer}"), &format!(", {contactor} into {layer}"), 1)
        }
        _ => why.to_owned(),
    }
}

/// A reason said anew; none in English, and none for what is worded otherwise.
fn in_own_language(metric: &str, why: &str) -> Option<String> {
    if words::current() == Language::ENGLISH {
        return None;
    }
    if let Some(found) = why.strip_suffix(" too deep") {
        return Some(tr!("{found} too deep", found = format::decimal(found)));
    }
    if let Some(found) = why.strip_suffix(" too shallow") {
        return Some(tr!("{found} too shallow", found = format::decimal(found)));
    }
    let definition = catalogue::newest(metric)?;
    let english =
        metric.split_once('.').map_or_else(|| definition.label.to_owned(), |(_, part)| definition.label_of(part));
    let rest = why.strip_prefix(&english)?;
    if let Some(absent) = rest.strip_prefix(": ") {
        return Some(format!("{}: {}", words_of(metric), words::known(absent)));
    }
    let Some((found, marks)) = rest.split_once(", full marks for ") else {
        return Some(words_of(metric) + &format::decimal(rest));
    };
    full_marks(definition, &(words_of(metric) + &format::decimal(found)), marks)
}

/// What was found, what earns full marks, and advice.
fn full_marks(definition: &Definition, found: &str, marks: &str) -> Option<String> {
    let advice = words::known(definition.advice);
    if let Some((full, _)) = marks.split_once(" or less – ") {
        let full = format::decimal(full);
        return Some(tr!(
            "{found}, full marks for {full} or less – {advice}",
            found = found,
            full = full,
            advice = advice
        ));
    }
    let (full, _) = marks.split_once(" or more – ")?;
    let full = format::decimal(full);
    Some(tr!("{found}, full marks for {full} or more – {advice}", found = found, full = full, advice = advice))
}

#[cfg(test)]
mod tests {
    //! A reason kept in English must be told in German with the same figures, and never be lost.

    use super::*;

    fn german(metric: &str, why: &str) -> String {
        let deduction = Deduction { metric: metric.to_owned(), version: 1, points: 6.0, why: why.to_owned() };
        words::within(Language::named("de").expect("German"), || reason(&deduction))
    }

    #[test]
    fn english_reasons_stay_as_they_were_kept() {
        let why = "overshoot 1.9 mm, full marks for 0.5 mm or less – brace the hand: −6 points".to_owned();
        let deduction = Deduction { metric: "overshoot_mm".to_owned(), version: 1, points: 6.0, why };
        assert_eq!(reason(&deduction), "Overshoot 1.9 mm, full marks for 0.5 mm or less – brace the hand");
        assert_eq!(short_reason(&deduction), "Overshoot 1.9 mm");
    }

    #[test]
    fn another_language_says_the_same_with_the_same_figures() {
        let said = german("overshoot_mm", "overshoot 1.9 mm, full marks for 0.5 mm or less – brace: −6 points");
        assert!(said.contains("1,9 mm") && said.contains("0,5 mm") && !said.contains("full marks"), "{said}");
        assert!(german("depth_error_mm", "2.4 mm too deep: −6 points").starts_with("2,4 mm zu tief"));
        let split = german("peak_force_layer_n.deep fat", "peak force in deep fat 2.1 N: no points lost");
        assert!(split.ends_with("deep fat 2,1 N") && !split.contains("force"), "{split}");
        for kept in ["into", "through"] {
            let said = german(
                "over_insertion_mm.fat.rim",
                &format!("advance after the pop, rim {kept} fat 2.1 mm: −6 points"),
            );
            assert!(said.ends_with("Rand in Fett 2,1 mm"), "{said}");
        }
    }

    #[test]
    fn a_later_version_of_a_definition_says_so() {
        let [first, second] = [1, 2].map(|version| definition("stop_time_s.skin.rim", version));
        assert!(!first.is_empty() && !first.contains('(') && second.ends_with("(Version 2)"), "{first} {second}");
        assert_eq!(definition("stop_time_s", 9) + &definition("charm", 2), "");
    }

    #[test]
    fn what_cannot_be_taken_apart_is_shown_as_it_was_kept() {
        assert_eq!(german("overshoot_mm", "went too far: −6 points"), "Went too far");
        assert_eq!(german("charm", "charm 3: −6 points"), "Charm 3");
    }

    #[test]
    fn a_failed_limit_keeps_the_authors_words_and_its_figures() {
        let why = "The force went above 10 N (peak force 12.3 N, limit 10 N)";
        assert_eq!(hard_fail(why), why);
        let german = words::within(Language::named("de").expect("German"), || hard_fail(why));
        assert_eq!(german, "The force went above 10 N (Spitzenkraft 12,3 N, Grenze 10 N)");
        let unmet = "Nothing is earned: the position was not confirmed.";
        assert_eq!(hard_fail(unmet), unmet);
        let german = words::within(Language::named("de").expect("German"), || hard_fail(unmet));
        assert_ne!(german, unmet);
        assert_eq!(hard_fail("worded by hand"), "worded by hand");
        assert_eq!(hard_fail("worded (by hand)"), "worded (by hand)");
    }
}
