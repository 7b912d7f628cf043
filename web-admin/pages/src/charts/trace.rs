//! A strip of a force trace without further information, with the user's marks and, once they may
//! be shown, the pops.

use model::recordings::series::TimeSpan;

use super::DrawingSize;
use super::plot::Plot;
use super::scale::Extent;
use super::svg::{Area, Caption, PaperPoint, Svg};

/// Left edge of the axis, in units of the drawing; a script uses it to compute the time under the
/// pointer.
pub const LEFT: f64 = 46.0;
/// Margin right of the axis, in units of the drawing.
pub const RIGHT: f64 = 20.0;
const TOP: f64 = 24.0;
/// Width reserved for the label of a pop, in units of the drawing.
const POP_NAME: f64 = 80.0;

/// Content of a strip.
#[derive(Clone, Copy, Debug)]
pub struct TraceStrip<'a> {
    /// Number of the strip, from 1.
    pub number: usize,
    /// Start and end, in s.
    pub stretch_s: Extent,
    /// Smallest and largest force of the whole trace, in N.
    pub force_n: Extent,
    /// Force samples, as minimum and maximum per time span.
    pub spans: &'a [TimeSpan],
    /// Marks of the whole trace, in s.
    pub marks: &'a [f64],
    /// Pops of the whole trace, in s; empty until they may be shown.
    pub pops: &'a [f64],
}

/// Draws a strip: marks as numbered lines, pops as dashed lines from above the plot.
#[must_use]
pub fn draw_trace_strip(strip: &TraceStrip<'_>, size: DrawingSize) -> String {
    let Extent { from: from_s, to: to_s } = strip.stretch_s;
    let id = format!("strip-{}-{}", strip.number, size.name());
    let title = tr!("Force from {from} to {to} s", from = format!("{from_s:.0}"), to = format!("{to_s:.0}"));
    let description = tr!(
        "Force on the hand over time. {marks} marks, {pops} pops shown.",
        marks = moments_within(strip.marks, strip.stretch_s).count(),
        pops = moments_within(strip.pops, strip.stretch_s).count()
    );
    let caption = Caption { id: &id, class: size.name(), title: &title, description: &description };
    let area = Area { x: LEFT, y: TOP, width: size.width() - LEFT - RIGHT, height: 130.0 };
    let Extent { from: low, to: high } = strip.force_n;
    let plot = Plot::rising(area, strip.stretch_s, Extent::new(low, high.max(low + 0.1) * 1.05));
    let mut svg = Svg::new(size.width(), area.bottom() + 40.0, &caption);
    plot.draw_y_axis(&mut svg, 4, tr!("force (N)"));
    plot.draw_x_axis(&mut svg, size.ticks() + 1, tr!("time since the start (s)"));
    let mut named_x = f64::NEG_INFINITY;
    for (_, pop) in moments_within(strip.pops, strip.stretch_s) {
        let x = plot.x.at(pop);
        svg.line("pop", PaperPoint::new(x, area.y - 4.0), PaperPoint::new(x, area.bottom()));
        // Only the first of several adjacent pops is labelled.
        if x - named_x > POP_NAME {
            svg.text("pop-name middle", PaperPoint::new(x, area.y - 9.0), tr!("pop"));
            named_x = x;
        }
    }
    let line: Vec<PaperPoint> = strip
        .spans
        .iter()
        .filter(|span| (from_s..=to_s).contains(&span.t_s))
        .flat_map(|span| [plot.at(span.t_s, span.force_min_n), plot.at(span.t_s, span.force_max_n)])
        .collect();
    svg.polyline("curve", &line);
    for (number, mark) in moments_within(strip.marks, strip.stretch_s) {
        let x = plot.x.at(mark);
        svg.line("own-mark", PaperPoint::new(x, area.y), PaperPoint::new(x, area.bottom()));
        svg.text("mark-number", PaperPoint::new(x + 3.0, area.y + 11.0), &number.to_string());
    }
    svg.finish()
}

/// Returns the times within a strip, with their numbers in the whole trace, from 1. A time at a
/// boundary belongs to the later strip.
fn moments_within(moments: &[f64], stretch_s: Extent) -> impl Iterator<Item = (usize, f64)> + '_ {
    let numbered = moments.iter().enumerate().map(|(at, moment)| (at + 1, *moment));
    numbered.filter(move |(_, moment)| *moment >= stretch_s.from && *moment < stretch_s.to)
}

#[cfg(test)]
mod tests {
    //! A mark must appear only on its own strip, and a pop only once it may be shown.

    use super::*;

    fn span(t_s: f64) -> TimeSpan {
        TimeSpan { t_s, depth_min_mm: 0.0, depth_max_mm: 0.0, force_min_n: 0.5, force_max_n: 1.0, lateral_max_n: 0.0 }
    }

    #[test]
    fn marks_and_pops_are_drawn_where_they_lie() {
        let spans = [span(5.0), span(6.0), span(7.0)];
        let strip = TraceStrip {
            number: 2,
            stretch_s: Extent::new(5.0, 10.0),
            force_n: Extent::new(0.0, 3.0),
            spans: &spans,
            marks: &[1.0, 6.0, 10.0],
            pops: &[6.1, 6.2],
        };
        let markup = draw_trace_strip(&strip, DrawingSize::Wide);
        assert_eq!(markup.matches("class=\"own-mark\"").count(), 1);
        assert!(markup.contains(">2</text>") && markup.matches("class=\"pop\"").count() == 2, "{markup}");
        assert_eq!(markup.matches(">pop</text>").count(), 1, "names do not lie on each other: {markup}");
        let blinded = draw_trace_strip(&TraceStrip { pops: &[], ..strip }, DrawingSize::Narrow);
        assert!(!blinded.contains("class=\"pop"), "{blinded}");
    }
}
