//! Force against depth during insertion, over the experts' corridor.

use attempt::AttemptCurve;
use model::scoring::corridor::Corridor;

use super::DrawingSize;
use super::force_depth::{NAMES_HEIGHT, draw_bands, draw_target};
use super::plot::{Plot, extent_with_zero};
use super::scale::Extent;
use super::svg::{Area, Caption, Svg};

/// How deep the drawing goes, in mm: as far as the attempt and the corridor.
#[must_use]
pub fn find_deepest(curve: &AttemptCurve, corridor: &Corridor) -> f64 {
    let attempt = curve.points.iter().map(|point| point.advance_mm);
    corridor.places.iter().map(|place| place.advance_mm).chain(attempt).fold(1.0, f64::max) * 1.05
}

/// Draws an attempt's way in over the corridor.
#[must_use]
pub fn draw_corridor(curve: &AttemptCurve, corridor: &Corridor, size: DrawingSize) -> String {
    let id = format!("corridor-{}", size.name());
    let title = tr!("Force against depth during insertion, with the experts’ corridor");
    let caption = Caption { id: &id, class: size.name(), title, description: &describe_corridor(corridor) };
    let deepest = find_deepest(curve, corridor);
    let forces = curve.points.iter().map(|p| p.force_n).chain(corridor.places.iter().map(|p| p.high_n));
    let force = extent_with_zero(forces).unwrap_or(Extent::new(0.0, 1.0));
    let area = Area { x: 46.0, y: NAMES_HEIGHT + 3.0, width: size.width() - 58.0, height: 230.0 };
    let plot =
        Plot::rising(area, Extent::new(0.0, deepest), Extent::new(force.from * 1.05, (force.to * 1.05).max(0.1)));
    let mut svg = Svg::new(size.width(), area.bottom() + 40.0, &caption);
    draw_bands(&mut svg, &plot, &curve.bands);
    plot.draw_x_axis(&mut svg, size.ticks(), tr!("depth of the tip along the needle (mm)"));
    plot.draw_y_axis(&mut svg, 6, tr!("force (N)"));
    if plot.x.contains(curve.target_depth_mm) {
        draw_target(&mut svg, &plot, curve.target_depth_mm);
    }
    let upper = corridor.places.iter().map(|p| plot.at(p.advance_mm, p.high_n));
    let lower = corridor.places.iter().rev().map(|p| plot.at(p.advance_mm, p.low_n));
    svg.polygon("corridor", &upper.chain(lower).collect::<Vec<_>>());
    let median: Vec<_> = corridor.places.iter().map(|p| plot.at(p.advance_mm, p.median_n)).collect();
    svg.polyline("curve over", &median);
    let turned = curve.points.iter().enumerate().max_by(|a, b| a.1.advance_mm.total_cmp(&b.1.advance_mm));
    let way_in = &curve.points[..turned.map_or(0, |(index, _)| index + 1)];
    let inside = way_in.iter().filter(|p| plot.x.contains(p.advance_mm));
    svg.polyline("curve", &inside.map(|p| plot.at(p.advance_mm, p.force_n)).collect::<Vec<_>>());
    svg.finish()
}

fn describe_corridor(corridor: &Corridor) -> String {
    tr!(
        "The solid line is this attempt. The band covers the middle 80 % of {n} experts, the dashed line is their median; both are aligned at the crossing of each layer.",
        n = corridor.experts
    )
}

#[cfg(test)]
mod tests {
    use attempt::CurvePoint;
    use model::scoring::corridor::corridor as of;

    use super::*;
    use crate::samples;

    #[test]
    fn draws_band_median_and_attempt() {
        let curve = samples::curve();
        let made = of(&curve, &vec![curve.clone(); 5]).expect("five are enough");
        let markup = draw_corridor(&curve, &made, DrawingSize::Wide);
        assert!(markup.contains("class=\"corridor\"") && markup.matches("<polyline").count() == 2, "{markup}");
        let far = AttemptCurve {
            points: [curve.points.clone(), vec![CurvePoint { t_s: 30.0, advance_mm: 60.0, force_n: 1.0 }]].concat(),
            ..curve
        };
        assert!(find_deepest(&far, &made) > 60.0, "what lies beyond the corridor is drawn, too");
        assert!(markup.contains("band fat") && markup.contains("class=\"target\""), "layers and target: {markup}");
    }
}
