//! Metrics, and the reasons of scores, in the reader's language.
//!
//! A score stores causes, which every language describes from the metric's texts and the figures.
//! Scores from before causes were stored have reasons in English text, which are shown unchanged.

use assessment::words::{deduction_phrase, failure_phrase, name_metric};
use assessment::{Deduction, Direction, HardFailure, catalogue};

use crate::format;

/// Headings of themes, with the prefixes of the metric ids that belong to them.
pub(crate) const GROUPS: [(&str, &[&str]); 5] = [
    (
        sentence!("Accuracy"),
        &["depth_error", "overshoot", "tip_error", "entry_error", "angle_error", "reached", "confirmed", "withdrawn"],
    ),
    (sentence!("Force"), &["peak_force", "rupture_force", "force_", "lateral_peak", "max_lateral"]),
    (sentence!("After each pop"), &["over_insertion", "stop_time"]),
    (
        sentence!("Tissue and structures"),
        &[
            "rupture_energy",
            "cutting",
            "friction",
            "lateral_work",
            "sweep",
            "skin_entries",
            "redirections",
            "structure",
        ],
    ),
    // The empty prefix matches every id that no heading above has claimed.
    (sentence!("Time and motion"), &[""]),
];

/// Returns the index in [`GROUPS`] of a metric's theme: the first that matches, else the last.
pub(crate) fn theme_of_metric(id: &str) -> usize {
    let claims = |(_, starts): &(&str, &[&str])| starts.iter().any(|start| id.starts_with(start));
    GROUPS.iter().position(claims).unwrap_or(GROUPS.len() - 1)
}

/// Returns the name of a metric by its id, capitalized.
#[must_use]
pub fn metric_label(id: &str) -> String {
    format::as_sentence(&words_of(id))
}

/// Returns the name of a recorded metric, capitalized; its recorded label if the catalogue no
/// longer contains it.
#[must_use]
pub fn label_of(id: &str, label: &str) -> String {
    if catalogue::newest_definition(id).is_none() && !label.is_empty() {
        return format::as_sentence(label);
    }
    metric_label(id)
}

/// Returns the definition of a version of a metric, with the version number from 2 on; empty if the
/// catalogue does not contain it.
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
    words::phrase(&name_metric(id))
}

/// Names the better direction of a metric. The force at a rupture is set by the tissue and the same
/// for everyone. Targets are meant to be hit.
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

/// Describes why points were lost, with the value for full marks and advice.
#[must_use]
pub fn deduction_reason(deduction: &Deduction) -> String {
    format::as_sentence(&value_in_words(deduction, deduction.points > 0.0))
}

/// Describes why points were lost, for a list of attempts.
#[must_use]
pub fn short_deduction_reason(deduction: &Deduction) -> String {
    format::as_sentence(&value_in_words(deduction, false))
}

fn value_in_words(deduction: &Deduction, advised: bool) -> String {
    words::phrase(&deduction_phrase(deduction, advised))
}

/// Describes a hard fail: the author's text, with figures in the reader's language.
#[must_use]
pub fn say_failure(failure: &HardFailure) -> String {
    words::phrase(&failure_phrase(failure))
}

#[cfg(test)]
mod tests {
    //! A cause must have the same figures in German, and the same English text as in all other
    //! places.

    use assessment::words::{cost_phrase, deduction_in_words, deduction_with_cost};
    use assessment::{Absent, DeductionCause, FailureCause, UnmetRequirement};
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

    /// Returns every possible cause for every version of every metric, whole and split.
    fn all_deductions() -> Vec<Deduction> {
        let absent = Absent::ALL.map(|reason| DeductionCause::Absent { reason });
        let causes = absent.into_iter().chain(UnmetRequirement::ALL.map(|unmet| DeductionCause::Required { unmet }));
        let values = [-2.44, 0.2, 1.9, 123.4].map(|value| DeductionCause::Measured { value, full: 0.5, zero: 6.0 });
        let higher = DeductionCause::Measured { value: 0.3, full: 0.9, zero: 0.1 };
        let causes: Vec<DeductionCause> = causes.chain(values).chain([higher, DeductionCause::NoSuchMetric]).collect();
        let mut all = Vec::new();
        for definition in catalogue::DEFINITIONS {
            for part in ["", ".fat", ".deep fat", ".fat.rim", ".skin.tip", ".target"] {
                let cases = causes.iter().flat_map(|cause| [0.0, 1.0, 6.25].map(|points| (points, cause.clone())));
                all.extend(cases.map(|(points, cause)| Deduction {
                    version: definition.version,
                    ..deduction(&format!("{}{part}", definition.id), points, cause)
                }));
            }
        }
        all
    }

    #[test]
    fn pages_and_the_window_say_the_same_in_every_language() {
        let all = all_deductions();
        let mut failures = vec![limit()];
        failures.extend(UnmetRequirement::ALL.map(|unmet| HardFailure { cause: FailureCause::Required { unmet } }));
        for language in Language::all() {
            words::within(language, || {
                for told in &all {
                    let window = words::phrase(&deduction_with_cost(told));
                    let (why, cost) = window.rsplit_once(": ").expect("a cost");
                    assert_eq!(deduction_reason(told), format::as_sentence(why), "{told:?}");
                    assert_eq!(cost, words::phrase(&cost_phrase(told.points)));
                }
                for told in &failures {
                    assert_eq!(say_failure(told), words::phrase(&failure_phrase(told)));
                }
            });
        }
        for told in &all {
            assert_eq!(words::phrase(&deduction_with_cost(told)), deduction_in_words(told), "in English as it is kept");
        }
    }

    #[test]
    fn another_language_says_the_same_with_the_same_figures() {
        let said = german(|| deduction_reason(&measured("overshoot_mm", 6.0, 1.9)));
        assert!(said.contains("1,9 mm") && said.contains("0,5 mm") && !said.contains("full marks"), "{said}");
        assert!(german(|| deduction_reason(&measured("depth_error_mm", 6.0, 2.4))).starts_with("2,4 mm zu tief"));
        let split = german(|| deduction_reason(&measured("peak_force_layer_n.outer fat", 0.0, 2.1)));
        assert!(split.ends_with("outer fat 2,1 N") && !split.contains("force"), "{split}");
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
