//! The metrics of an attempt, one file per theme. Each is a small function of the [`Attempt`].

mod depth;
mod energy;
mod fluoroscopy;
mod force;
mod path;
mod procedure;
mod rupture;
mod structures;
mod time;

use crate::absent::Absent;
use crate::attempt::{Attempt, Outcome};
use crate::catalogue::{DEFINITIONS, Direction, Metric};

/// A metric id with its version.
#[derive(Clone, Copy)]
struct Id<'a> {
    base: &'a str,
    /// Suffix; empty for none.
    suffix: &'a str,
    version: u32,
}

impl<'a> Id<'a> {
    const fn first(base: &'a str) -> Self {
        Self { base, suffix: "", version: 1 }
    }

    const fn second(base: &'a str) -> Self {
        Self { base, suffix: "", version: 2 }
    }

    const fn by(self, suffix: &'a str) -> Self {
        Self { suffix, ..self }
    }
}

/// Collects the results of the themes.
#[derive(Default)]
struct MetricSheet {
    rows: Vec<(usize, Metric)>,
}

impl MetricSheet {
    /// Records the first version of a metric without suffix.
    fn put(&mut self, id: &str, outcome: Outcome) {
        self.enter(Id::first(id), outcome);
    }

    /// Records the second version of a metric without suffix.
    fn put_anew(&mut self, id: &str, outcome: Outcome) {
        self.enter(Id::second(id), outcome);
    }

    /// Records the first version of a metric with a suffix.
    fn put_for(&mut self, id: &str, suffix: &str, outcome: Outcome) {
        self.enter(Id::first(id).by(suffix), outcome);
    }

    /// Changes the favourable direction of the metric recorded last.
    fn turn(&mut self, direction: Direction) {
        if let Some((_, metric)) = self.rows.last_mut() {
            metric.direction = direction;
        }
    }

    fn enter(&mut self, Id { base, suffix, version }: Id<'_>, outcome: Outcome) {
        let row = DEFINITIONS.iter().enumerate().find(|(_, d)| d.id == base && d.version == version);
        let outcome = outcome.and_then(|value| if value.is_finite() { Ok(value) } else { Err(Absent::NotFinite) });
        self.rows.extend(row.map(|(order, definition)| {
            let (id, label) = if suffix.is_empty() {
                (base.to_owned(), definition.label.to_owned())
            } else {
                (format!("{base}.{suffix}"), definition.label_of(suffix))
            };
            let metric = Metric {
                id,
                version: definition.version,
                value: outcome.ok(),
                unit: definition.unit.to_owned(),
                direction: definition.direction,
                applies: outcome.is_ok(),
                label,
                absent: outcome.err(),
            };
            (order, metric)
        }));
    }
}

/// Returns every version of every metric of the catalogue, in its order; the form without suffix
/// first, then the scene's layers or structures.
pub(crate) fn measure_attempt(attempt: &Attempt) -> Vec<Metric> {
    let mut sheet = MetricSheet::default();
    depth::measure_depth(attempt, &mut sheet);
    force::measure_force(attempt, &mut sheet);
    rupture::measure_ruptures(attempt, &mut sheet);
    energy::measure_energy(attempt, &mut sheet);
    structures::measure_structures(attempt, &mut sheet);
    path::measure_path(attempt, &mut sheet);
    time::measure_times(attempt, &mut sheet);
    procedure::measure_procedure(attempt, &mut sheet);
    fluoroscopy::measure_fluoroscopy(attempt, &mut sheet);
    sheet.rows.sort_by_key(|(order, _)| *order);
    sheet.rows.into_iter().map(|(_, metric)| metric).collect()
}
