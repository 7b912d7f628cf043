//! A score taken apart: what each line of the rubric gave, why, and everything else that was measured.

use assessment::{Deduction, HardFailure, Metric};
use documents::Exercise;

use super::charts::{self, LayerDamage};
use super::{format, metric};

/// What was judged, by what.
#[derive(Clone, Copy, Debug)]
pub struct GradedAttempt<'a> {
    /// 0–100.
    pub score: f64,
    /// At or above the pass mark and no hard fail.
    pub passed: bool,
    /// Points lost, per line of the rubric.
    pub deductions: &'a [Deduction],
    /// Reasons of hard fails.
    pub hard_fails: &'a [HardFailure],
    /// Every metric.
    pub metrics: &'a [Metric],
    /// The exercise as it was judged; absent when the school never published it.
    pub exercise: Option<&'a Exercise>,
}

/// A score with its arithmetic.
#[derive(Clone, Debug, PartialEq)]
pub struct JudgementView {
    /// 0–100.
    pub score: f64,
    /// At or above the pass mark and no hard fail.
    pub passed: bool,
    /// Score needed to pass, 0–100.
    pub pass_mark: Option<f64>,
    /// The score as a bar with the pass mark on it.
    pub bar: String,
    /// Reasons of hard fails.
    pub hard_fails: Vec<String>,
    /// What cost points, dearest first: reason and points.
    pub lost: Vec<(String, f64)>,
    /// Every line of the rubric.
    pub rubric: Vec<RubricRow>,
    /// Every other metric, by what it tells.
    pub groups: Vec<MetricGroup>,
    /// Energy by layer.
    pub damage: Vec<LayerDamage>,
    /// The same as bars, for both widths.
    pub damage_chart: String,
    /// Other damage: label and value.
    pub damage_facts: Vec<(String, String)>,
}

/// A line of the rubric, judged.
#[derive(Clone, Debug, PartialEq)]
pub struct RubricRow {
    /// What was measured.
    pub label: String,
    /// How it is defined.
    pub definition: String,
    /// The attempt's value, with its unit.
    pub value: String,
    /// What earns everything, with its unit; empty when the rubric is not known here.
    pub full: String,
    /// What earns nothing, with its unit.
    pub zero: String,
    /// Points earned.
    pub earned: Option<f64>,
    /// Points to be had.
    pub available: Option<f64>,
    /// Points lost.
    pub lost: f64,
    /// The reason, in words.
    pub why: String,
}

/// Metrics that tell of one thing.
#[derive(Clone, Debug, PartialEq)]
pub struct MetricGroup {
    /// Heading.
    pub title: &'static str,
    /// Metrics that apply, in the catalogue's order.
    pub rows: Vec<MeasuredRow>,
    /// Names of those that do not apply to this attempt.
    pub absent: Vec<String>,
}

/// A metric outside the rubric.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredRow {
    /// What was measured.
    pub label: String,
    /// How it is defined.
    pub definition: String,
    /// The value with its unit.
    pub value: String,
    /// Which way is better.
    pub better: &'static str,
}

/// Headings, and the beginnings of the ids below them.
const GROUPS: [(&str, &[&str]); 5] = [
    (
        sentence!("Accuracy"),
        &["depth_error", "overshoot", "tip_error", "entry_error", "angle_error", "reached", "confirmed", "withdrawn"],
    ),
    (sentence!("Force"), &["peak_force", "rupture_force", "force_", "lateral_peak"]),
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
    (sentence!("Time and motion"), &[""]),
];

impl JudgementView {
    /// Takes a score apart.
    #[must_use]
    pub fn new(graded: &GradedAttempt<'_>) -> Self {
        let mut lost: Vec<(String, f64)> = graded
            .deductions
            .iter()
            .filter(|d| d.points > 0.0)
            .map(|d| (metric::deduction_reason(d), d.points))
            .collect();
        lost.sort_by(|a, b| b.1.total_cmp(&a.1));
        let damage = damage_of_layers(graded.metrics);
        let pass_mark = graded.exercise.map(|e| e.pass_mark);
        Self {
            score: graded.score,
            passed: graded.passed,
            pass_mark,
            bar: charts::draw_score_bar(graded.score, pass_mark),
            hard_fails: graded.hard_fails.iter().map(metric::say_failure).collect(),
            lost,
            rubric: graded.deductions.iter().map(|d| make_rubric_row(graded, d)).collect(),
            groups: group_metrics(graded),
            damage_chart: charts::draw_both_widths(|size| charts::draw_damage(&damage, size)),
            damage,
            damage_facts: damage_facts(graded.metrics),
        }
    }
}

fn make_rubric_row(graded: &GradedAttempt<'_>, deduction: &Deduction) -> RubricRow {
    let measured = graded.metrics.iter().find(|m| m.id == deduction.metric && m.version == deduction.version);
    let unit = measured.map_or("", |m| m.unit.as_str());
    let line = graded.exercise.and_then(|e| e.rubric.iter().find(|l| l.metric == deduction.metric));
    let weights: f64 = graded.exercise.map_or(0.0, |e| e.rubric.iter().map(|l| l.weight).sum());
    let available = line.filter(|_| weights > 0.0).map(|l| l.weight / weights * 100.0);
    RubricRow {
        label: measured.map_or_else(|| metric::metric_label(&deduction.metric), |m| metric::label_of(&m.id, &m.label)),
        definition: metric::metric_definition(&deduction.metric, deduction.version),
        value: measured.map_or_else(|| tr!("not measured").to_owned(), measured_value),
        full: line.map_or_else(String::new, |l| format::format_stated(l.full, unit)),
        zero: line.map_or_else(String::new, |l| format::format_stated(l.zero, unit)),
        earned: available.map(|a| (a - deduction.points).max(0.0)),
        available,
        lost: deduction.points,
        why: metric::deduction_reason(deduction),
    }
}

fn measured_value(metric: &Metric) -> String {
    match metric.value {
        Some(value) if metric.applies => format::format_quantity(value, &metric.unit),
        _ => tr!("not applicable").to_owned(),
    }
}

/// The metrics that the rubric does not judge, by the newest definition that they were measured by, each below the first heading that
/// claims it.
fn group_metrics(graded: &GradedAttempt<'_>) -> Vec<MetricGroup> {
    let mut groups =
        GROUPS.map(|(title, _)| MetricGroup { title: words::say(title), rows: Vec::new(), absent: Vec::new() });
    let is_newest = |m: &Metric| graded.metrics.iter().all(|other| other.id != m.id || other.version <= m.version);
    let unjudged = |m: &&Metric| is_newest(m) && graded.deductions.iter().all(|d| d.metric != m.id);
    for metric in graded.metrics.iter().filter(unjudged) {
        let claims = |(_, starts): &(&str, &[&str])| starts.iter().any(|start| metric.id.starts_with(start));
        if let Some(index) = GROUPS.iter().position(claims) {
            let row = make_metric_row(metric);
            if metric.applies && metric.value.is_some() {
                groups[index].rows.push(row);
            } else {
                groups[index].absent.push(row.label);
            }
        }
    }
    groups.into_iter().filter(|g| !g.rows.is_empty() || !g.absent.is_empty()).collect()
}

fn make_metric_row(measured: &Metric) -> MeasuredRow {
    MeasuredRow {
        label: metric::label_of(&measured.id, &measured.label),
        definition: metric::metric_definition(&measured.id, measured.version),
        value: measured_value(measured),
        better: match measured.direction {
            assessment::Direction::Lower => tr!("lower"),
            assessment::Direction::Higher => tr!("higher"),
            assessment::Direction::Range => tr!("near 0"),
        },
    }
}

/// The energy metrics by layer, in the order of the layers.
fn damage_of_layers(metrics: &[Metric]) -> Vec<LayerDamage> {
    let mut layers: Vec<LayerDamage> = Vec::new();
    for (part, layer, value) in metrics.iter().filter_map(values_by_layer) {
        let index = layers.iter().position(|l| l.name == layer).unwrap_or_else(|| {
            layers.push(LayerDamage { name: layer.to_owned(), ..LayerDamage::default() });
            layers.len() - 1
        });
        match part {
            "rupture_energy_mj" => layers[index].rupture_mj = value,
            "cutting_energy_mj" => layers[index].cutting_mj = value,
            "friction_energy_mj" => layers[index].friction_mj = value,
            _ => layers[index].lateral_mj = value,
        }
    }
    layers
}

fn values_by_layer(metric: &Metric) -> Option<(&str, &str, f64)> {
    let (part, layer) = metric.id.split_once('.')?;
    let energies = ["rupture_energy_mj", "cutting_energy_mj", "friction_energy_mj", "lateral_work_mj"];
    energies.contains(&part).then_some((part, layer, metric.value?))
}

fn damage_facts(metrics: &[Metric]) -> Vec<(String, String)> {
    let wanted = ["sweep_area_mm2", "skin_entries", "structure_hits"];
    let found = wanted.iter().filter_map(|id| metrics.iter().find(|m| m.id == *id));
    found.map(|m| (metric::label_of(&m.id, &m.label), measured_value(m))).collect()
}

#[cfg(test)]
mod tests {
    //! The arithmetic on the page must be the score's own: lines add up to it, and no metric is shown twice or lost.

    use crate::samples;

    #[test]
    fn the_lines_add_up_to_the_score() {
        let judgement = samples::judgement();
        let earned: f64 = judgement.rubric.iter().filter_map(|r| r.earned).sum();
        let available: f64 = judgement.rubric.iter().filter_map(|r| r.available).sum();
        assert!((available - 100.0).abs() < 1e-9);
        assert!((earned - judgement.score).abs() < 1e-9, "{earned} is not {}", judgement.score);
    }

    #[test]
    fn what_cost_most_comes_first_and_what_cost_nothing_is_left_out() {
        let lost = samples::judgement().lost;
        assert!(lost.windows(2).all(|w| w[0].1 >= w[1].1));
        assert!(lost.iter().all(|(why, points)| *points > 0.0 && !why.contains("points")));
    }

    #[test]
    fn every_metric_is_shown_once() {
        let metrics = samples::metrics();
        let judgement = samples::judgement();
        let shown =
            judgement.rubric.len() + judgement.groups.iter().map(|g| g.rows.len() + g.absent.len()).sum::<usize>();
        assert_eq!(shown, metrics.len());
    }

    #[test]
    fn damage_is_read_by_layer() {
        let layers = samples::judgement().damage;
        let names: Vec<&str> = layers.iter().map(|l| l.name.as_str()).collect();
        assert_eq!(names, ["skin", "fat", "muscle"]);
        assert!(layers[0].rupture_mj > 0.0);
    }
}
