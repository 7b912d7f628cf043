//! Metrics, and the reasons of scores, in the reader's language.
//!
//! A score keeps causes, and every language says them from the metric's words and the figures. What was scored before there were causes
//! kept its reasons in English words, and is shown in them.

use assessment::catalogue::{self, Split};
use assessment::{Deduction, DeductionCause, Direction, FailureCause, HardFailure};
use law::axial::Contactor;

use super::{anatomy, format};

/// Name of a metric by its id, with a capital.
#[must_use]
pub fn metric_label(id: &str) -> String {
    format::as_sentence(&words_of(id))
}

/// Name of a metric that was measured, with a capital; its own where the catalogue has it no more.
#[must_use]
pub fn label_of(id: &str, label: &str) -> String {
    if catalogue::newest_definition(id).is_none() && !label.is_empty() {
        return format::as_sentence(label);
    }
    metric_label(id)
}

/// How a version of a metric is defined; empty for one that the catalogue has not. A later version than the first says so.
#[must_use]
pub fn metric_definition(id: &str, version: u32) -> String {
    let definition = catalogue::find_definition(id, version).map_or_else(String::new, |d| words::known(d.definition));
    match version {
        0 | 1 => definition,
        _ if definition.is_empty() => definition,
        _ => tr!("{definition} (Version {version})", definition = definition, version = version),
    }
}

fn words_of(id: &str) -> String {
    let Some(definition) = catalogue::newest_definition(id) else { return id.to_owned() };
    let metric = words::known(definition.label);
    let Some((_, part)) = id.split_once('.') else { return metric };
    match (definition.split, part.rsplit_once('.')) {
        (Some(Split::Boundary), Some((layer, contactor))) => {
            let contactor = if contactor == "rim" { Contactor::Rim } else { Contactor::Tip };
            let pop = words::phrase(&contactor.into_layer(&anatomy::say_structure(layer)));
            tr!("{metric}, {pop}", metric = metric, pop = pop)
        }
        (Some(Split::Layer), _) => tr!("{metric} in {layer}", metric = metric, layer = anatomy::say_structure(part)),
        (Some(Split::Structure), _) => {
            tr!("{metric} to {structure}", metric = metric, structure = anatomy::say_structure(part))
        }
        _ => format!("{metric}: {}", words::known(part)),
    }
}

/// Which way of a metric is better, in a word. The force at a pop is the tissue's: it is the same for everybody. A target is to be met.
#[must_use]
pub fn say_better_way(id: &str, direction: Direction, targets: &[String]) -> &'static str {
    let (base, part) = id.split_once('.').unwrap_or((id, ""));
    match base {
        "rupture_force_n" => tr!("set by the tissue"),
        "structure_hits" if part == "target" => tr!("higher"),
        "structure_clearance_mm" if targets.iter().any(|target| target == part) => tr!("lower"),
        _ => match direction {
            Direction::Lower => tr!("lower"),
            Direction::Higher => tr!("higher"),
            Direction::Range => tr!("near 0"),
        },
    }
}

/// Why points were lost, with what earns full marks and advice.
#[must_use]
pub fn deduction_reason(deduction: &Deduction) -> String {
    format::as_sentence(&value_in_words(deduction, deduction.points > 0.0))
}

/// Why points were lost, for a list of attempts.
#[must_use]
pub fn short_deduction_reason(deduction: &Deduction) -> String {
    format::as_sentence(&value_in_words(deduction, false))
}

fn value_in_words(deduction: &Deduction, advised: bool) -> String {
    let metric = || words_of(&deduction.metric);
    match &deduction.cause {
        DeductionCause::Measured { value, full, zero } => {
            say_measured(deduction, *value, advised.then_some((*full, full > zero)))
        }
        DeductionCause::Absent { reason } => format!("{}: {}", metric(), words::known(reason.words())),
        DeductionCause::Required { unmet } => format!("{}: {}", metric(), words::known(unmet.words())),
        DeductionCause::NoSuchMetric => tr!("{metric}: this scene has no such metric", metric = deduction.metric),
        DeductionCause::Worded { words } => words.clone(),
    }
}

/// A value; where it cost something, also what earns full marks, whether more than that does, and advice.
fn say_measured(deduction: &Deduction, value: f64, full: Option<(f64, bool)>) -> String {
    let definition = catalogue::find_definition(&deduction.metric, deduction.version);
    let unit = definition.map_or("", |definition| definition.unit);
    if definition.is_some_and(|definition| definition.direction == Direction::Range) {
        let found = say_figure(value.abs(), unit);
        return if value >= 0.0 {
            tr!("{found} too deep", found = found)
        } else {
            tr!("{found} too shallow", found = found)
        };
    }
    let found = format!("{} {}", words_of(&deduction.metric), say_figure(value, unit));
    let Some((full, more)) = full else { return found };
    let (full, advice) = (say_figure(full, unit), words::known(definition.map_or("", |definition| definition.advice)));
    if more {
        tr!("{found}, full marks for {full} or more – {advice}", found = found, full = full, advice = advice)
    } else {
        tr!("{found}, full marks for {full} or less – {advice}", found = found, full = full, advice = advice)
    }
}

/// A value with its unit, in the reader's language.
fn say_figure(value: f64, unit: &str) -> String {
    words::decimal(&assessment::words::say_figure(value, unit))
}

/// Why an attempt failed whatever its points: the author's words, and the figures in the reader's language.
#[must_use]
pub fn say_failure(failure: &HardFailure) -> String {
    match &failure.cause {
        FailureCause::Required { unmet } => words::known(unmet.failure_words()),
        FailureCause::Limit { words: author, metric, version, value, limit } => {
            let why = author.in_language(words::current().code());
            let unit = catalogue::find_definition(metric, *version).map_or("", |definition| definition.unit);
            let found = format!("{} {}", words_of(metric), say_figure(*value, unit));
            tr!("{why} ({found}, limit {limit})", why = why, found = found, limit = say_figure(*limit, unit))
        }
        FailureCause::Worded { words } => words::known(words),
    }
}

#[cfg(test)]
mod tests {
    //! A cause is said in German with the same figures, and in English as every other place says it.

    use assessment::words::{deduction_in_words, failure_in_words};
    use assessment::{Absent, UnmetRequirement};
    use words::Language;

    use super::*;

    fn german<T>(say: impl FnOnce() -> T) -> T {
        words::within(Language::named("de").expect("German"), say)
    }

    fn deduction(metric: &str, points: f64, cause: DeductionCause) -> Deduction {
        Deduction { metric: metric.to_owned(), version: 1, points, cause }
    }

    fn measured(metric: &str, points: f64, value: f64) -> Deduction {
        deduction(metric, points, DeductionCause::Measured { value, full: 0.5, zero: 6.0 })
    }

    fn limit() -> HardFailure {
        let (words, metric) = ("The force went above 10 N".into(), "peak_force_n".to_owned());
        HardFailure { cause: FailureCause::Limit { words, metric, version: 1, value: 12.3, limit: 10.0 } }
    }

    #[test]
    fn a_target_is_to_be_met_and_a_pop_is_the_tissues() {
        let targets = ["cyst".to_owned()];
        let way = |id: &str, direction| say_better_way(id, direction, &targets);
        assert_eq!(way("structure_hits.target", Direction::Lower), "higher");
        assert_eq!(way("structure_hits.vessel", Direction::Lower), "lower");
        assert_eq!(way("structure_clearance_mm.cyst", Direction::Higher), "lower");
        assert_eq!(way("structure_clearance_mm.artery", Direction::Higher), "higher");
        assert_eq!(way("rupture_force_n.skin.tip", Direction::Lower), "set by the tissue");
        assert_eq!(way("depth_error_mm", Direction::Range), "near 0");
    }

    #[test]
    fn pages_and_other_places_say_the_same_in_english() {
        let causes = Absent::ALL.map(|reason| DeductionCause::Absent { reason });
        let causes = causes.into_iter().chain(UnmetRequirement::ALL.map(|unmet| DeductionCause::Required { unmet }));
        let mut deductions: Vec<Deduction> = causes.map(|cause| deduction("overshoot_mm", 6.0, cause)).collect();
        deductions.push(deduction("charm", 6.0, DeductionCause::NoSuchMetric));
        for (metric, points, value) in [
            ("overshoot_mm", 6.0, 1.9),
            ("overshoot_mm", 0.0, 0.2),
            ("depth_error_mm", 6.0, -2.44),
            ("depth_error_mm", 6.0, 2.44),
            ("peak_force_layer_n.deep fat", 6.0, 2.1),
            ("over_insertion_mm.fat.rim", 6.0, 2.1),
            ("skin_entries", 6.0, 2.0),
        ] {
            deductions.push(measured(metric, points, value));
        }
        for deduction in &deductions {
            let page = value_in_words(deduction, deduction.points > 0.0);
            let elsewhere = deduction_in_words(deduction);
            let (why, _cost) = elsewhere.rsplit_once(": ").expect("a cost");
            assert_eq!(page, why);
        }
        let mut failures = vec![limit()];
        failures.extend(UnmetRequirement::ALL.map(|unmet| HardFailure { cause: FailureCause::Required { unmet } }));
        for told in &failures {
            assert_eq!(say_failure(told), failure_in_words(told));
        }
    }

    #[test]
    fn another_language_says_the_same_with_the_same_figures() {
        let said = german(|| deduction_reason(&measured("overshoot_mm", 6.0, 1.9)));
        assert!(said.contains("1,9 mm") && said.contains("0,5 mm") && !said.contains("full marks"), "{said}");
        assert!(german(|| deduction_reason(&measured("depth_error_mm", 6.0, 2.4))).starts_with("2,4 mm zu tief"));
        let split = german(|| deduction_reason(&measured("peak_force_layer_n.deep fat", 0.0, 2.1)));
        assert!(split.ends_with("deep fat 2,1 N") && !split.contains("force"), "{split}");
        let pop = german(|| short_deduction_reason(&measured("over_insertion_mm.fat.rim", 6.0, 2.1)));
        assert!(pop.ends_with("Rand in Fett 2,1 mm"), "{pop}");
        assert_eq!(german(|| say_failure(&limit())), "The force went above 10 N (Spitzenkraft 12,3 N, Grenze 10 N)");
        for unmet in UnmetRequirement::ALL {
            let cause = FailureCause::Required { unmet };
            assert_ne!(german(|| say_failure(&HardFailure { cause })), unmet.failure_words());
        }
    }

    #[test]
    fn what_was_kept_in_words_is_shown_as_it_was_kept() {
        let words = "overshoot 1.9 mm".to_owned();
        let kept = deduction("overshoot_mm", 6.0, DeductionCause::Worded { words });
        assert_eq!(german(|| deduction_reason(&kept)), "Overshoot 1.9 mm");
        let kept = HardFailure { cause: FailureCause::Worded { words: "worded (by hand)".to_owned() } };
        assert_eq!(german(|| say_failure(&kept)), "worded (by hand)");
    }

    #[test]
    fn a_later_version_of_a_definition_says_so() {
        let [first, second] = [1, 2].map(|version| metric_definition("stop_time_s.skin.rim", version));
        assert!(!first.is_empty() && !first.contains('(') && second.ends_with("(Version 2)"), "{first} {second}");
        assert_eq!(metric_definition("stop_time_s", 9) + &metric_definition("charm", 2), "");
    }
}
