//! Marks on the curves: one shape and one number per event, the same in every chart and in the table.

use attempt::{AttemptCurve, CurveMark, MarkKind};

use super::svg::Svg;

/// The marks that are numbered, with their numbers from 1: ruptures, structure hits and confirmations.
pub fn numbered(curve: &AttemptCurve) -> impl Iterator<Item = (usize, &CurveMark)> {
    let shown = |mark: &&CurveMark| !matches!(mark.kind, MarkKind::Contact | MarkKind::SkinExit);
    (1..).zip(curve.marks.iter().filter(shown))
}

/// Draws a mark's shape. Each kind has its own, so that none depends on its colour.
pub fn draw(svg: &mut Svg, kind: MarkKind, (x, y): (f64, f64)) {
    match kind {
        MarkKind::TipRupture => svg.polygon("mark tip", &[(x - 5.0, y + 4.0), (x + 5.0, y + 4.0), (x, y - 5.0)]),
        MarkKind::RimRupture => svg.polygon("mark rim", &[(x - 5.5, y), (x, y - 5.5), (x + 5.5, y), (x, y + 5.5)]),
        MarkKind::StructureHit => {
            svg.line("mark hit", (x - 5.0, y - 5.0), (x + 5.0, y + 5.0));
            svg.line("mark hit", (x - 5.0, y + 5.0), (x + 5.0, y - 5.0));
        }
        MarkKind::Confirm => {
            svg.circle("mark confirm", (x, y), 5.5);
            svg.circle("mark confirm-dot", (x, y), 1.5);
        }
        MarkKind::Contact | MarkKind::SkinExit => svg.circle("mark contact", (x, y), 3.0),
    }
}

/// Numbers beside marks, kept apart: a number that would cover the one before is lifted above it.
pub fn draw_numbers(svg: &mut Svg, placed: &[(usize, (f64, f64))], ceiling: f64) {
    let mut before: Option<(f64, f64)> = None;
    for (number, (x, y)) in placed {
        let mut top = (y - 10.0).max(ceiling);
        if let Some((last_x, last_top)) = before
            && (x - last_x).abs() < 13.0
            && (top - last_top).abs() < 12.0
        {
            top = if last_top - 12.0 >= ceiling { last_top - 12.0 } else { last_top + 26.0 };
        }
        svg.text("mark-number middle", (*x, top), &number.to_string());
        before = Some((*x, top));
    }
}
