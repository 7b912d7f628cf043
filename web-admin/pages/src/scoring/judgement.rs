//! Breakdown of a score: the points of each rubric line with reasons, and all other metrics.

use assessment::{Assessment, Deduction, DepthMiss, FailureCause, HardFailure, Metric, UnmetRequirement};
use attempt::AttemptCurve;
use documents::Exercise;

use crate::charts::LayerDamage;
use crate::metric::{GROUPS, theme_of_metric};
use crate::scoring::moments;
use crate::{charts, format, metric};

/// The graded attempt, with everything needed to explain its score.
#[derive(Clone, Copy, Debug)]
pub struct GradedAttempt<'a> {
    /// Score, 0–100.
    pub score: f64,
    /// Whether the score reaches the pass mark without a hard fail.
    pub passed: bool,
    /// Points lost, per line of the rubric.
    pub deductions: &'a [Deduction],
    /// Reasons of hard fails.
    pub hard_fails: &'a [HardFailure],
    /// All metrics.
    pub metrics: &'a [Metric],
    /// The exercise as graded; `None` if the school never published it.
    pub exercise: Option<&'a Exercise>,
    /// Names of the structures that must be reached.
    pub targets: &'a [String],
    /// The attempt's curve; `None` if it is not available.
    pub curve: Option<&'a AttemptCurve>,
    /// The same metrics in the attempts of others.
    pub others: &'a OthersSpreads,
}

/// Distributions of metrics over the attempts of others, if enough of them have tried.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OthersSpreads {
    /// Over the latest attempt of each other trainee in the trainee's cohorts.
    pub cohort: Vec<MetricSpread>,
    /// Over the newest passed attempt of each consenting expert.
    pub experts: Vec<MetricSpread>,
}

/// Quartiles of a metric over several attempts.
#[derive(Clone, Debug, PartialEq)]
pub struct MetricSpread {
    /// Id of the metric.
    pub id: String,
    /// Version of its definition.
    pub version: u32,
    /// Lower quartile, median, upper quartile.
    pub quartiles: [f64; 3],
}

/// A reason for lost points or a fail, with the time to look at.
#[derive(Clone, Debug, PartialEq)]
pub struct LostPoints {
    /// The reason as text.
    pub why: String,
    /// Points lost; 0 for a hard fail.
    pub points: f64,
    /// Time in the attempt that decided it, in s.
    pub at_s: Option<f64>,
}

/// A score with its breakdown.
#[derive(Clone, Debug, PartialEq)]
pub struct JudgementView {
    /// Score, 0–100.
    pub score: f64,
    /// Whether the score reaches the pass mark without a hard fail.
    pub passed: bool,
    /// Score needed to pass, 0–100.
    pub pass_mark: Option<f64>,
    /// The score as a bar with the pass mark on it.
    pub bar: String,
    /// Reasons of hard fails.
    pub hard_fails: Vec<LostPoints>,
    /// What the attempt would have scored, 0–100, had it not lacked what is required; absent where nothing is lacking.
    pub without_gate: Option<f64>,
    /// What cost points, or would have had the attempt not lacked what is required; dearest first.
    pub lost: Vec<LostPoints>,
    /// Whether there are values of the cohort to compare with.
    pub beside_cohort: bool,
    /// Whether there are values of experts to compare with.
    pub beside_experts: bool,
    /// All lines of the rubric.
    pub rubric: Vec<RubricRow>,
    /// All other metrics, by theme.
    pub groups: Vec<MetricGroup>,
    /// Energy by layer.
    pub damage: Vec<LayerDamage>,
    /// Energy by layer as bars, at both widths.
    pub damage_chart: String,
    /// Other measures of damage: label and value.
    pub damage_facts: Vec<(String, String)>,
}

/// A graded line of the rubric.
#[derive(Clone, Debug, PartialEq)]
pub struct RubricRow {
    /// Name of the metric.
    pub label: String,
    /// Definition of the metric.
    pub definition: String,
    /// Value of the attempt, with unit.
    pub value: String,
    /// Median and quartiles of the cohort, with unit; empty if too few have a value.
    pub cohort: String,
    /// Median and quartiles of the experts, with unit; empty if too few have a value.
    pub experts: String,
    /// Value that earns full marks, with unit; empty if the rubric is not known here.
    pub full: String,
    /// Value that earns no marks, with unit; empty if the rubric is not known here.
    pub zero: String,
    /// Points earned.
    pub earned: Option<f64>,
    /// Points that the line would have earned, where the attempt lacks what is required.
    pub would_earn: Option<f64>,
    /// Points to be had.
    pub available: Option<f64>,
    /// Points lost.
    pub lost: f64,
}

/// Metrics of one theme.
#[derive(Clone, Debug, PartialEq)]
pub struct MetricGroup {
    /// Heading.
    pub title: &'static str,
    /// Metrics that apply, in the order of the catalogue.
    pub rows: Vec<MeasuredRow>,
    /// Names of the metrics that do not apply to this attempt.
    pub absent: Vec<String>,
}

/// A metric outside the rubric.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredRow {
    /// Name of the metric.
    pub label: String,
    /// Definition of the metric.
    pub definition: String,
    /// Value, with unit.
    pub value: String,
    /// Direction that is better; for values set by the tissue alone, a note that they are.
    pub better: &'static str,
    /// Median and quartiles of the cohort, with unit; empty if too few have a value.
    pub cohort: String,
    /// Median and quartiles of the experts, with unit; empty if too few have a value.
    pub experts: String,
}

impl JudgementView {
    /// Builds the breakdown of a score.
    #[must_use]
    pub fn new(graded: &GradedAttempt<'_>) -> Self {
        let damage = damage_of_layers(graded.metrics);
        let pass_mark = graded.exercise.map(|e| e.pass_mark);
        let ungated = graded.judge_without_gate();
        let lines = ungated.as_ref().map_or(graded.deductions, |ungated| &ungated.deductions);
        let rubric_row = |deduction| {
            let would_be = ungated.as_ref().and_then(|ungated| find_same_line(&ungated.deductions, deduction));
            make_rubric_row(graded, deduction, would_be)
        };
        Self {
            score: graded.score,
            passed: graded.passed,
            pass_mark,
            bar: charts::draw_score_bar(graded.score, pass_mark),
            hard_fails: graded.hard_fails.iter().map(|failure| graded.failure_with_moment(failure)).collect(),
            without_gate: ungated.as_ref().map(|ungated| ungated.score),
            lost: list_lost_points(graded, lines),
            beside_cohort: !graded.others.cohort.is_empty(),
            beside_experts: !graded.others.experts.is_empty(),
            rubric: graded.deductions.iter().map(rubric_row).collect(),
            groups: group_metrics(graded),
            damage_chart: charts::draw_both_widths(|size| charts::draw_damage(&damage, size)),
            damage,
            damage_facts: damage_facts(graded.metrics),
        }
    }
}

impl GradedAttempt<'_> {
    fn second_of(&self, metric: &str) -> Option<f64> {
        self.curve.map(|curve| moments::find_deciding_second(metric, self.metrics, curve))
    }

    fn failure_with_moment(&self, failure: &HardFailure) -> LostPoints {
        let at_s = match &failure.cause {
            FailureCause::Limit { metric, .. } => self.second_of(metric),
            FailureCause::Required { unmet: UnmetRequirement::Within } => self.second_of(DepthMiss::METRIC),
            FailureCause::Required { .. } | FailureCause::Worded { .. } => None,
        };
        let why = match &failure.cause {
            FailureCause::Required { unmet: UnmetRequirement::Within } => self.say_distance(),
            _ => None,
        };
        LostPoints { why: why.unwrap_or_else(|| metric::say_failure(failure)), points: 0.0, at_s }
    }

    /// How far the position was from the target, and how far it may be; nothing where either is not known.
    fn say_distance(&self) -> Option<String> {
        let DepthMiss { error_mm, allowed_mm } = DepthMiss::find(self.metrics, self.exercise?)?;
        let distance = format::format_quantity(error_mm.abs(), "mm");
        let allowed = format::format_stated(allowed_mm, "mm");
        Some(match error_mm > 0.0 {
            true => tr!("No points: {distance} too deep, {allowed} allowed.", distance = distance, allowed = allowed),
            false => {
                tr!("No points: {distance} too shallow, {allowed} allowed.", distance = distance, allowed = allowed)
            }
        })
    }

    /// The same attempt judged as if nothing were required; nothing where it lacks none of that.
    fn judge_without_gate(&self) -> Option<Assessment> {
        assessment::judge_without_requirements(self.metrics, self.hard_fails, self.exercise?)
    }
}

fn find_same_line<'a>(deductions: &'a [Deduction], line: &Deduction) -> Option<&'a Deduction> {
    deductions.iter().find(|other| other.metric == line.metric && other.version == line.version)
}

/// What cost points, dearest first.
fn list_lost_points(graded: &GradedAttempt<'_>, deductions: &[Deduction]) -> Vec<LostPoints> {
    let dear = deductions.iter().filter(|deduction| deduction.points > 0.0);
    let mut lost: Vec<LostPoints> = dear
        .map(|deduction| LostPoints {
            why: metric::deduction_reason(deduction),
            points: deduction.points,
            at_s: graded.second_of(&deduction.metric),
        })
        .collect();
    lost.sort_by(|a, b| b.points.total_cmp(&a.points));
    lost
}

/// Formats median and quartiles of a metric over the attempts of others.
fn say_spread(spreads: &[MetricSpread], id: &str, version: u32, unit: &str) -> String {
    let found = spreads.iter().find(|spread| spread.id == id && spread.version == version);
    found.map_or_else(String::new, |MetricSpread { quartiles: [lower, median, upper], .. }| {
        let [lower, median] = [lower, median].map(format::format_number);
        tr!(
            "{median} ({lower} to {upper})",
            median = median,
            lower = lower,
            upper = format::format_quantity(upper, unit)
        )
    })
}

fn make_rubric_row(graded: &GradedAttempt<'_>, deduction: &Deduction, would_be: Option<&Deduction>) -> RubricRow {
    let measured = graded.metrics.iter().find(|m| m.id == deduction.metric && m.version == deduction.version);
    let unit = measured.map_or("", |m| m.unit.as_str());
    let line = graded.exercise.and_then(|e| e.rubric.iter().find(|l| l.metric == deduction.metric));
    let weights: f64 = graded.exercise.map_or(0.0, |e| e.rubric.iter().map(|l| l.weight).sum());
    let available = line.filter(|_| weights > 0.0).map(|l| l.weight / weights * 100.0);
    RubricRow {
        label: measured.map_or_else(|| metric::metric_label(&deduction.metric), |m| metric::label_of(&m.id, &m.label)),
        definition: metric::metric_definition(&deduction.metric, deduction.version),
        value: measured.map_or_else(|| tr!("not measured").to_owned(), measured_value),
        cohort: say_spread(&graded.others.cohort, &deduction.metric, deduction.version, unit),
        experts: say_spread(&graded.others.experts, &deduction.metric, deduction.version, unit),
        full: line.map_or_else(String::new, |l| format::format_stated(l.full, unit)),
        zero: line.map_or_else(String::new, |l| format::format_stated(l.zero, unit)),
        earned: available.map(|a| (a - deduction.points).max(0.0)),
        would_earn: would_be.and_then(|would_be| Some((available? - would_be.points).max(0.0))),
        available,
        lost: deduction.points,
    }
}

fn measured_value(metric: &Metric) -> String {
    match metric.value {
        Some(value) if metric.applies => format::format_quantity(value, &metric.unit),
        _ => tr!("not applicable").to_owned(),
    }
}

/// Groups the metrics that the rubric does not grade by theme, each under the first heading that
/// matches. Of several versions of a metric, only the newest is listed.
fn group_metrics(graded: &GradedAttempt<'_>) -> Vec<MetricGroup> {
    let mut groups =
        GROUPS.map(|(title, _)| MetricGroup { title: words::say(title), rows: Vec::new(), absent: Vec::new() });
    let is_newest = |m: &Metric| graded.metrics.iter().all(|other| other.id != m.id || other.version <= m.version);
    let unjudged = |m: &&Metric| is_newest(m) && graded.deductions.iter().all(|d| d.metric != m.id);
    for metric in graded.metrics.iter().filter(unjudged) {
        let (index, row) = (theme_of_metric(&metric.id), make_metric_row(graded, metric));
        if metric.applies && metric.value.is_some() {
            groups[index].rows.push(row);
        } else {
            groups[index].absent.push(row.label);
        }
    }
    groups.into_iter().filter(|g| !g.rows.is_empty() || !g.absent.is_empty()).collect()
}

fn make_metric_row(graded: &GradedAttempt<'_>, measured: &Metric) -> MeasuredRow {
    let beside = |spreads: &[MetricSpread]| say_spread(spreads, &measured.id, measured.version, &measured.unit);
    MeasuredRow {
        label: metric::label_of(&measured.id, &measured.label),
        definition: metric::metric_definition(&measured.id, measured.version),
        value: measured_value(measured),
        better: metric::say_better_way(&measured.id, measured.direction, graded.targets),
        cohort: beside(&graded.others.cohort),
        experts: beside(&graded.others.experts),
    }
}

/// Returns the energy metrics by layer, in the order of the layers.
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
    //! The breakdown must agree with the score: lines add up to it, and no metric is repeated or
    //! missing.

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
        assert!(lost.windows(2).all(|w| w[0].points >= w[1].points));
        assert!(lost.iter().all(|lost| lost.points > 0.0 && !lost.why.contains("points")));
    }

    #[test]
    fn each_lost_point_leads_to_its_second() {
        let judgement = samples::judgement();
        let deep = judgement.lost.iter().find(|lost| lost.why.contains("too deep")).expect("the depth");
        assert_eq!(deep.at_s, Some(19.0), "where the position was confirmed");
        assert!(judgement.lost.iter().all(|lost| lost.at_s.is_some()));
    }

    #[test]
    fn missed_requirement_is_stated_once_and_hides_no_deduction() {
        let judgement = samples::missed_judgement();
        let [failed] = &judgement.hard_fails[..] else { panic!("{:?}", judgement.hard_fails) };
        assert!(failed.why.contains("1.93\u{a0}mm too deep, 1.5\u{a0}mm allowed"), "{}", failed.why);
        assert_eq!(failed.at_s, Some(19.0));
        let depth = &judgement.lost[0].why;
        assert!(depth.contains("too deep") && !depth.contains("too far from the target"), "{depth}");
        assert!((judgement.without_gate.expect("a score") - 80.75).abs() < 0.5, "{:?}", judgement.without_gate);
        let would_earn: f64 = judgement.rubric.iter().filter_map(|row| row.would_earn).sum();
        assert!((would_earn - judgement.without_gate.expect("a score")).abs() < 1e-9);
        let page = samples::keep_page("session-missed", &samples::missed_page());
        assert!(page.contains("Points that would have been lost") && page.contains("otherwise"), "{page}");
    }

    #[test]
    fn a_metric_stands_beside_those_of_others() {
        let judgement = samples::judgement();
        let row = judgement.rubric.iter().find(|row| row.label == "Peak force").expect("a row");
        assert_eq!((row.cohort.as_str(), row.experts.as_str()), ("2.30 (1.90 to 2.70\u{a0}N)", ""));
        assert!(judgement.beside_cohort && !judgement.beside_experts);
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
