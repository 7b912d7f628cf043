//! The curve of a sample attempt.

use attempt::{AttemptCurve, BoundaryStage, CurveMark, CurvePoint, LayerSpan, MarkKind, StageSpan};

/// Returns an insertion through three layers with a trocar, a stop, and the withdrawal.
pub(crate) fn curve() -> AttemptCurve {
    let band = |name: &str, top_mm, bottom_mm| LayerSpan {
        name: name.to_owned(),
        texture: name.to_owned(),
        top_mm,
        bottom_mm,
    };
    AttemptCurve {
        bands: vec![band("skin", 0.0, 0.8), band("fat", 0.8, 9.2), band("muscle", 9.2, 48.2)],
        points: curve_points(),
        marks: curve_marks(),
        stages: curve_stages(),
        target_depth_mm: 20.0,
        duration_s: 26.0,
    }
}

/// Boundaries in order: depth in mm at which the tip meets the boundary, stiffness in N/mm, depths
/// in mm at which tip and rim rupture it.
const BOUNDARIES: [(f64, f64, f64, f64); 3] =
    [(0.0, 0.331, 3.02, 5.93), (0.8, 0.083, 6.82, 10.03), (9.2, 0.497, 12.22, 15.02)];

fn force_at(x_mm: f64) -> f64 {
    let elastic = BOUNDARIES.iter().enumerate().map(|(i, (top, k, tip, rim))| {
        let before = i.checked_sub(1).map_or(0.0, |b| BOUNDARIES[b].2);
        let tip_force = if x_mm >= before && x_mm < *tip { k * (x_mm - top).max(0.0) } else { 0.0 };
        let rim_force = if x_mm >= *tip && x_mm < *rim { k * (x_mm - 2.0 - top).max(0.0) } else { 0.0 };
        tip_force + rim_force
    });
    elastic.sum::<f64>() + 0.03 * x_mm.max(0.0)
}

fn curve_points() -> Vec<CurvePoint> {
    let inward = (0..380_u32).map(|i| {
        let t_s = f64::from(i) * 0.045;
        let advance_mm = -6.0 + t_s * 1.642;
        CurvePoint { t_s, advance_mm, force_n: force_at(advance_mm) }
    });
    let hold = (0..60_u32).map(|i| CurvePoint { t_s: 17.1 + f64::from(i) * 0.05, advance_mm: 21.93, force_n: 0.66 });
    let outward = (0..120_u32).map(|i| {
        let t_s = 20.1 + f64::from(i) * 0.049;
        let advance_mm = 21.93 - (t_s - 20.1) * 4.7;
        CurvePoint { t_s, advance_mm, force_n: if advance_mm > 0.0 { -0.02 * advance_mm } else { 0.0 } }
    });
    inward.chain(hold).chain(outward).collect()
}

fn curve_marks() -> Vec<CurveMark> {
    let mark = |kind, advance_mm: f64, name: &str| CurveMark {
        kind,
        t_s: (advance_mm + 6.0) / 1.642,
        advance_mm,
        axial_n: force_at(advance_mm - 0.01),
        name: name.to_owned(),
    };
    vec![
        mark(MarkKind::Contact, 0.0, "skin"),
        mark(MarkKind::TipRupture, 3.02, "skin"),
        mark(MarkKind::RimRupture, 5.93, "skin"),
        mark(MarkKind::TipRupture, 6.82, "fat"),
        mark(MarkKind::RimRupture, 10.03, "fat"),
        mark(MarkKind::TipRupture, 12.22, "muscle"),
        mark(MarkKind::RimRupture, 15.02, "muscle"),
        CurveMark { t_s: 19.0, ..mark(MarkKind::Confirm, 21.93, "") },
    ]
}

fn curve_stages() -> Vec<StageSpan> {
    let span = |boundary, stage, from_mm, to_mm| StageSpan { boundary, stage, from_mm, to_mm };
    let spans = BOUNDARIES.iter().enumerate().flat_map(|(i, (top, _, tip, rim))| {
        let meets = (top + 2.0).max(*tip);
        [
            span(i, BoundaryStage::I, *top, *tip),
            span(i, BoundaryStage::II, *tip, meets),
            span(i, BoundaryStage::III, meets, *rim),
            span(i, BoundaryStage::IV, *rim, 21.93),
        ]
    });
    spans.filter(|s| s.to_mm > s.from_mm).collect()
}
