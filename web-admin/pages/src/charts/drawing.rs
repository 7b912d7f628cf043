//! The curves of an attempt as drawings and tables.

use std::borrow::Borrow;

use attempt::{AttemptCurve, BoundaryStage, StageSpan};
use recording::keep_extremes;

use crate::{anatomy, charts, format};

/// The curves as drawings and tables.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// Force against depth, at both widths.
    pub force_depth: String,
    /// Force and depth against time, at both widths.
    pub force_time: String,
    /// Numbered events.
    pub marks: Vec<MarkRow>,
    /// Stages of each boundary.
    pub stages: Vec<StageRow>,
    /// Name, start and end of each layer, in mm along the needle.
    pub layers: Vec<(String, f64, f64)>,
    /// Time in s, advance along the needle in mm and force in N at up to 24 points, including the
    /// extremes.
    pub points: Vec<(f64, f64, f64)>,
    /// Address of the replay; `None` on pages that must not reveal the trainee.
    pub replay: Option<String>,
}

/// A numbered event.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkRow {
    /// Number in the drawings.
    pub number: usize,
    /// Description.
    pub what: String,
    /// Time, in s.
    pub t_s: f64,
    /// Position, in mm along the needle.
    pub advance_mm: f64,
    /// Axial force on the hand just before the event, in N.
    pub force_n: f64,
}

/// A stage of a boundary.
#[derive(Clone, Debug, PartialEq)]
pub struct StageRow {
    /// Name of the layer below the boundary.
    pub boundary: String,
    /// The stage.
    pub stage: BoundaryStage,
    /// Start, in mm along the needle.
    pub from_mm: f64,
    /// End, in mm along the needle.
    pub to_mm: f64,
}

/// Returns the address of a time in a replay.
#[must_use]
pub fn moment_href(replay: &str, t_s: f64) -> String {
    format!("{replay}?t={}", format::plain_seconds(t_s))
}

/// Maximum number of rows in the table of the curve.
const TABLE_ROWS: usize = 24;

impl Drawing {
    /// Draws a curve.
    #[must_use]
    pub fn new(curve: &AttemptCurve) -> Self {
        let curve = &anatomy::name_layers_of_curve(curve);
        let rows = keep_extremes(&curve.points, TABLE_ROWS, |point| point.force_n).into_iter();
        Self {
            force_depth: charts::draw_both_widths(|size| charts::draw_force_over_depth(curve, size)),
            force_time: charts::draw_both_widths(|size| charts::draw_force_and_depth(curve, size)),
            marks: charts::number_marks(curve)
                .map(|(number, mark)| MarkRow {
                    number,
                    what: anatomy::say_event(mark.kind, &mark.name),
                    t_s: mark.t_s,
                    advance_mm: mark.advance_mm,
                    force_n: mark.axial_n,
                })
                .collect(),
            stages: make_stage_rows(curve),
            layers: curve.bands.iter().map(|b| (b.name.clone(), b.top_mm, b.bottom_mm)).collect(),
            points: rows.map(|p| (p.t_s, p.advance_mm, p.force_n)).collect(),
            replay: None,
        }
    }

    /// Links the events to their time in a replay.
    #[must_use]
    pub fn leading_to(self, replay: &str) -> Self {
        Self { replay: Some(replay.to_owned()), ..self }
    }

    /// Returns the address of the replay at a time of the attempt.
    pub(crate) fn watched_at(&self, t_s: impl Borrow<f64>) -> Option<String> {
        self.replay.as_ref().map(|replay| moment_href(replay, *t_s.borrow()))
    }
}

fn make_stage_rows(curve: &AttemptCurve) -> Vec<StageRow> {
    let row = |span: &StageSpan| StageRow {
        boundary: curve.bands.get(span.boundary).map_or_else(String::new, |b| b.name.clone()),
        stage: span.stage,
        from_mm: span.from_mm,
        to_mm: span.to_mm,
    };
    curve.stages.iter().map(row).collect()
}
