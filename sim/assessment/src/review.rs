//! Finds mistakes in a rubric by comparison with the catalogue.

use documents::{ExerciseBundle, HardFail, Remark, RubricLine, StructureKind};
use phrase::{Phrase, phrase};

use crate::catalogue::{Direction, find_definition};

/// Returns remarks for the author: lines that reward the worse value, limits that fail the better
/// one, and metrics that no rubric should use. The exercise remains usable.
#[must_use]
pub fn review_rubric(bundle: &ExerciseBundle) -> Vec<Remark> {
    let lines = bundle.exercise.rubric.iter().enumerate();
    let of_lines = lines.flat_map(|(i, line)| {
        let path = format!("rubric[{i}]");
        [find_unoffered_metric(&path, &line.metric, line.version), find_reversed_line(&path, line, bundle)]
    });
    let limits = bundle.exercise.hard_fails.iter().enumerate();
    let of_limits = limits.flat_map(|(i, limit)| {
        let path = format!("hard_fail[{i}]");
        [find_unoffered_metric(&path, &limit.metric, limit.version), find_backward_limit(&path, limit, bundle)]
    });
    of_lines.chain(of_limits).flatten().collect()
}

fn find_unoffered_metric(path: &str, metric: &str, version: u32) -> Option<Remark> {
    let definition = find_definition(metric, version).filter(|definition| !definition.unoffered.is_empty())?;
    let found = phrase!("{metric}, version {version}", metric = metric, version = u64::from(version));
    let why = Phrase::Sentence { words: definition.unoffered, values: Vec::new() };
    let allowed = phrase!("not recommended for rubrics: {why}", why = why);
    Some(Remark { field: format!("{path}.metric"), found, allowed })
}

fn find_reversed_line(path: &str, line: &RubricLine, bundle: &ExerciseBundle) -> Option<Remark> {
    let direction = metric_direction(&line.metric, line.version, bundle)?;
    let wrong = match direction {
        Direction::Higher => line.full < line.zero,
        Direction::Lower | Direction::Range => line.full > line.zero,
    };
    let found = phrase!("full {full}, zero {zero}", full = line.full, zero = line.zero);
    let metric = line.metric.as_str();
    let allowed = match direction {
        Direction::Lower => phrase!("lower {metric} is better: `full` must be less than `zero`", metric = metric),
        Direction::Higher => phrase!("higher {metric} is better: `full` must be greater than `zero`", metric = metric),
        Direction::Range => phrase!("{metric} closer to 0 is better: `full` must be less than `zero`", metric = metric),
    };
    wrong.then(|| Remark { field: format!("{path}.full"), found, allowed })
}

fn find_backward_limit(path: &str, limit: &HardFail, bundle: &ExerciseBundle) -> Option<Remark> {
    let is_higher = metric_direction(&limit.metric, limit.version, bundle)? == Direction::Higher;
    let allowed =
        phrase!("higher {metric} is better, but a limit fails attempts above it", metric = limit.metric.as_str());
    let found = Phrase::data(limit.above);
    is_higher.then(|| Remark { field: format!("{path}.above"), found, allowed })
}

/// Returns the favourable direction; that of the clearance to a target is reversed.
fn metric_direction(metric: &str, version: u32, bundle: &ExerciseBundle) -> Option<Direction> {
    let direction = find_definition(metric, version)?.direction;
    let structure = metric.strip_prefix("structure_clearance_mm.");
    let is_target =
        |name: &str| bundle.scene.structures.iter().any(|s| s.spec.name == name && s.kind() == StructureKind::Target);
    Some(if structure.is_some_and(is_target) { Direction::Lower } else { direction })
}
