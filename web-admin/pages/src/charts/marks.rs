//! Marks on the curves: one shape and one number per event, the same in all charts and in the
//! table.

use attempt::{AttemptCurve, CurveMark, MarkKind};

use super::svg::{PaperPoint, Svg};

/// Returns the numbered marks, from 1: ruptures, structure hits and confirmations.
pub fn number_marks(curve: &AttemptCurve) -> impl Iterator<Item = (usize, &CurveMark)> {
    let shown = |mark: &&CurveMark| !matches!(mark.kind, MarkKind::Contact | MarkKind::SkinExit);
    (1..).zip(curve.marks.iter().filter(shown))
}

/// Draws a mark. Each kind has its own shape, so that kinds do not depend on colour.
pub fn draw_mark(svg: &mut Svg, kind: MarkKind, at: PaperPoint) {
    let PaperPoint { x, y } = at;
    match kind {
        MarkKind::TipRupture => svg.polygon(
            "mark tip",
            &[PaperPoint::new(x - 5.0, y + 4.0), PaperPoint::new(x + 5.0, y + 4.0), PaperPoint::new(x, y - 5.0)],
        ),
        MarkKind::RimRupture => svg.polygon(
            "mark rim",
            &[
                PaperPoint::new(x - 5.5, y),
                PaperPoint::new(x, y - 5.5),
                PaperPoint::new(x + 5.5, y),
                PaperPoint::new(x, y + 5.5),
            ],
        ),
        MarkKind::StructureHit | MarkKind::HubContact => {
            svg.line("mark hit", PaperPoint::new(x - 5.0, y - 5.0), PaperPoint::new(x + 5.0, y + 5.0));
            svg.line("mark hit", PaperPoint::new(x - 5.0, y + 5.0), PaperPoint::new(x + 5.0, y - 5.0));
        }
        MarkKind::Confirm => {
            svg.circle("mark confirm", at, 5.5);
            svg.circle("mark confirm-dot", at, 1.5);
        }
        MarkKind::Contact | MarkKind::SkinExit => svg.circle("mark contact", at, 3.0),
    }
}

/// Draws the numbers of marks; a number that would cover the previous one is moved above it, or
/// below if there is no room.
pub fn draw_mark_numbers(svg: &mut Svg, placed: &[(usize, PaperPoint)], ceiling: f64) {
    let mut before: Option<PaperPoint> = None;
    for (number, PaperPoint { x, y }) in placed {
        let mut top = (y - 10.0).max(ceiling);
        if let Some(last) = before
            && (x - last.x).abs() < 13.0
            && (top - last.y).abs() < 12.0
        {
            top = if last.y - 12.0 >= ceiling { last.y - 12.0 } else { last.y + 26.0 };
        }
        let place = PaperPoint::new(*x, top);
        svg.text("mark-number middle", place, &number.to_string());
        before = Some(place);
    }
}
