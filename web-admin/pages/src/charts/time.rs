//! Force and depth against time: two plots over one axis, so that a pop in the force lines up with
//! a jump in the depth.

use attempt::AttemptCurve;

use super::force_depth::texture_class;
use super::plot::{Plot, extent_with_zero};
use super::scale::Extent;
use super::svg::{Area, Caption, PaperPoint, Svg};
use super::{DrawingSize, marks};
use crate::format;

const LEFT: f64 = 46.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 22.0;
const GAP: f64 = 16.0;

/// Draws force in the upper plot and depth in the lower one.
#[must_use]
pub fn draw_force_and_depth(curve: &AttemptCurve, size: DrawingSize) -> String {
    let id = format!("force-time-{}", size.name());
    let title = tr!("Force and depth over time");
    let caption = Caption { id: &id, class: size.name(), title, description: &describe_attempt(curve) };
    let (force, depth) = plots_over_time(curve, size);
    let mut svg = Svg::new(size.width(), depth.area.bottom() + 40.0, &caption);
    for band in curve.bands.iter().filter(|b| depth.y.contains(b.top_mm)) {
        svg.rect(&format!("band {}", texture_class(&band.texture)), depth.row(band.top_mm, band.bottom_mm));
    }
    force.draw_y_axis(&mut svg, 5, tr!("force (N)"));
    depth.draw_y_axis(&mut svg, 6, tr!("depth (mm)"));
    depth.draw_x_axis(&mut svg, size.ticks(), tr!("time since the start (s)"));
    draw_target_depth(&mut svg, &depth, curve.target_depth_mm);
    draw_moments(&mut svg, &force, &depth, curve);
    let force_line: Vec<_> = curve.points.iter().map(|p| force.at(p.t_s, p.force_n)).collect();
    let depth_line: Vec<_> = curve.points.iter().map(|p| depth.at(p.t_s, p.advance_mm)).collect();
    svg.polyline("curve", &force_line);
    svg.polyline("curve depth", &depth_line);
    svg.finish()
}

fn plots_over_time(curve: &AttemptCurve, size: DrawingSize) -> (Plot, Plot) {
    let width = size.width() - LEFT - RIGHT;
    let (upper, lower) = if size == DrawingSize::Wide { (150.0, 170.0) } else { (120.0, 150.0) };
    let force_area = Area { x: LEFT, y: TOP, width, height: upper };
    let depth_area = Area { x: LEFT, y: TOP + upper + GAP, width, height: lower };
    let time = Extent::new(0.0, curve.duration_s);
    let force = extent_with_zero(curve.points.iter().map(|p| p.force_n)).unwrap_or(Extent::new(0.0, 1.0));
    // Ten millimetres above the skin are enough to show the approach.
    let above = curve.points.iter().map(|p| p.advance_mm).fold(0.0, f64::min).max(-10.0);
    let below = curve.points.iter().map(|p| p.advance_mm).fold(curve.target_depth_mm, f64::max).max(1.0);
    (
        Plot::rising(force_area, time, Extent::new(force.from * 1.05, (force.to * 1.05).max(0.1))),
        Plot::falling(depth_area, time, Extent::new(above, below * 1.05)),
    )
}

fn describe_attempt(curve: &AttemptCurve) -> String {
    let deepest = curve.points.iter().map(|p| p.advance_mm).fold(0.0, f64::max);
    tr!(
        "Above, the axial force on the hand; below, the depth of the tip, down to {deepest}, with the layers in the background. The attempt lasted {span}. The numbers refer to the table of events.",
        deepest = format::format_quantity(deepest, "mm"),
        span = format::format_span(curve.duration_s)
    )
}

fn draw_target_depth(svg: &mut Svg, plot: &Plot, target_mm: f64) {
    let y = plot.y.at(target_mm);
    svg.line("target", PaperPoint::new(plot.area.x, y), PaperPoint::new(plot.area.right(), y));
    svg.text("target-name", PaperPoint::new(plot.area.x + 5.0, y - 5.0), tr!("target"));
}

/// Draws a thin line through both plots for each event, with its number on top.
fn draw_moments(svg: &mut Svg, force: &Plot, depth: &Plot, curve: &AttemptCurve) {
    let mut free_from = 0.0;
    for (number, mark) in marks::number_marks(curve) {
        let x = force.x.at(mark.t_s);
        svg.line("moment", PaperPoint::new(x, force.area.y), PaperPoint::new(x, depth.area.bottom()));
        marks::draw_mark(svg, mark.kind, PaperPoint::new(x, depth.y.at(mark.advance_mm)));
        // Simultaneous events share a position: only the first number is printed, the table lists
        // all of them.
        if x >= free_from {
            svg.text("mark-number middle", PaperPoint::new(x, force.area.y - 6.0), &number.to_string());
            free_from = x + 11.0;
        }
    }
}

#[cfg(test)]
mod tests {
    //! Both curves must be drawn, and an attempt of zero duration must not cause a division by
    //! zero.

    use super::*;
    use crate::samples;

    #[test]
    fn draws_both_curves_with_the_layers_behind_the_depth() {
        let markup = draw_force_and_depth(&samples::curve(), DrawingSize::Wide);
        assert_eq!(markup.matches("<polyline").count(), 2);
        assert!(markup.contains("band muscle") && markup.contains("class=\"moment\""));
    }

    #[test]
    fn an_attempt_of_no_length_is_drawn_without_nonsense() {
        let curve = AttemptCurve { points: vec![], marks: vec![], duration_s: 0.0, ..samples::curve() };
        let markup = draw_force_and_depth(&curve, DrawingSize::Narrow);
        assert!(!markup.contains("NaN") && !markup.contains("polyline"));
    }
}
