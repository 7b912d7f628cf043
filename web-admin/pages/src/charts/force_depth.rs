//! Force against depth, with layers behind the curve, ruptures on it and the stages of each
//! boundary below.

use attempt::{AttemptCurve, CurvePoint, LayerSpan};

use super::plot::{Plot, extent_with_zero};
use super::scale::Extent;
use super::svg::{Area, Caption, PaperPoint, Svg, text_width};
use super::{DrawingSize, marks};
use crate::format;

const LEFT: f64 = 46.0;
const RIGHT: f64 = 12.0;
const LABEL_ROW: f64 = 15.0;
const LABEL_ROWS: usize = 4;
/// Height reserved for the names that [`draw_bands`] writes above the layers.
pub(super) const NAMES_HEIGHT: f64 = LABEL_ROWS as f64 * LABEL_ROW;
const LANE: f64 = 32.0;

/// Draws force against depth.
#[must_use]
pub fn draw_force_over_depth(curve: &AttemptCurve, size: DrawingSize) -> String {
    let id = format!("force-depth-{}", size.name());
    let caption = Caption {
        id: &id,
        class: size.name(),
        title: tr!("Force against depth"),
        description: &describe_force_over_depth(curve),
    };
    let plot = plot_force_over_depth(curve, size);
    let lanes = boundaries_with_stages(curve);
    let lanes_top = plot.area.bottom() + 44.0;
    let lanes_height = if lanes.is_empty() { 0.0 } else { 20.0 + LANE * lanes.len() as f64 };
    let mut svg = Svg::new(size.width(), lanes_top + lanes_height, &caption);
    draw_bands(&mut svg, &plot, &curve.bands);
    plot.draw_x_axis(&mut svg, size.ticks(), tr!("depth of the tip along the needle (mm)"));
    plot.draw_y_axis(&mut svg, 7, tr!("force (N)"));
    draw_target(&mut svg, &plot, curve.target_depth_mm);
    draw_curve(&mut svg, &plot, curve);
    draw_marks(&mut svg, &plot, curve);
    if !lanes.is_empty() {
        svg.text("lane-title", PaperPoint::new(LEFT, lanes_top + 10.0), tr!("Stage at each boundary"));
    }
    for (row, boundary) in (0_u32..).zip(&lanes) {
        draw_lane(&mut svg, &plot, curve, *boundary, lanes_top + 20.0 + LANE * f64::from(row));
    }
    svg.finish()
}

fn plot_force_over_depth(curve: &AttemptCurve, size: DrawingSize) -> Plot {
    let deepest = curve.points.iter().map(|p| p.advance_mm).fold(curve.target_depth_mm, f64::max);
    let force = extent_with_zero(curve.points.iter().map(|p| p.force_n)).unwrap_or(Extent::new(0.0, 1.0));
    let height = if size == DrawingSize::Wide { 300.0 } else { 240.0 };
    let area = Area { x: LEFT, y: NAMES_HEIGHT, width: size.width() - LEFT - RIGHT, height };
    // The margin above the highest peak leaves room for its number.
    Plot::rising(
        area,
        Extent::new(0.0, deepest.max(1.0) * 1.05),
        Extent::new(force.from * 1.05, (force.to * 1.12).max(0.1)),
    )
}

fn describe_force_over_depth(curve: &AttemptCurve) -> String {
    let peak = curve.points.iter().max_by(|a, b| a.force_n.total_cmp(&b.force_n));
    let layers: Vec<&str> = curve.bands.iter().map(|b| b.name.as_str()).collect();
    let ruptures = marks::number_marks(curve).count();
    match peak {
        Some(peak) => trn!(
            "Axial force on the hand over the depth of the tip, through {layers}. The highest force is {force} at {depth}; {n} event is marked and listed in the table below.",
            "Axial force on the hand over the depth of the tip, through {layers}. The highest force is {force} at {depth}; {n} events are marked and listed in the table below.",
            ruptures,
            layers = layers.join(", "),
            force = format::format_quantity(peak.force_n, "N"),
            depth = format::format_quantity(peak.advance_mm, "mm")
        ),
        None => tr!("The recording contains no samples.").to_owned(),
    }
}

/// Draws layers as bands. A name is written above the start of its layer, in the first row with
/// enough room; it is left out if no row has room.
pub(super) fn draw_bands(svg: &mut Svg, plot: &Plot, bands: &[LayerSpan]) {
    let mut row_ends = [0.0; LABEL_ROWS];
    for band in bands.iter().filter(|b| plot.x.contains(b.top_mm)) {
        let area = plot.column(band.top_mm, band.bottom_mm);
        svg.rect(&format!("band {}", texture_class(&band.texture)), area);
        let width = text_width(&band.name);
        let x = area.x.min(plot.area.right() - width).max(0.0);
        let row = row_ends.iter().position(|end| *end <= x);
        let baseline = plot.area.y - 5.0 - LABEL_ROW * row.unwrap_or(0) as f64;
        svg.line("boundary", PaperPoint::new(area.x, baseline - 8.0), PaperPoint::new(area.x, plot.area.bottom()));
        if let Some(row) = row {
            row_ends[row] = x + width + 8.0;
            svg.text("layer-name", PaperPoint::new(x + 3.0, baseline), &band.name);
        }
    }
}

/// Returns the CSS class of a layer's texture; unknown textures get a neutral one.
pub(super) fn texture_class(texture: &str) -> &'static str {
    match texture {
        "skin" => "skin",
        "fat" => "fat",
        "muscle" => "muscle",
        "fascia" | "ligament" | "tendon" => "fascia",
        _ => "tissue",
    }
}

pub(super) fn draw_target(svg: &mut Svg, plot: &Plot, target_mm: f64) {
    let x = plot.x.at(target_mm);
    svg.line("target", PaperPoint::new(x, plot.area.y), PaperPoint::new(x, plot.area.bottom()));
    let beyond = x + 70.0 > plot.area.right();
    let (class, x) = if beyond { ("target-name end", x - 4.0) } else { ("target-name", x + 4.0) };
    svg.text(class, PaperPoint::new(x, plot.area.y + 15.0), tr!("target"));
}

/// Draws the insertion as a solid line and the withdrawal as a dashed one.
fn draw_curve(svg: &mut Svg, plot: &Plot, curve: &AttemptCurve) {
    let deepest =
        (0..curve.points.len()).max_by(|a, b| curve.points[*a].advance_mm.total_cmp(&curve.points[*b].advance_mm));
    let Some(deepest) = deepest else { return };
    let place = |points: &[CurvePoint]| -> Vec<PaperPoint> {
        points.iter().filter(|p| plot.x.contains(p.advance_mm)).map(|p| plot.at(p.advance_mm, p.force_n)).collect()
    };
    svg.polyline("curve out", &place(&curve.points[deepest..]));
    svg.polyline("curve", &place(&curve.points[..=deepest]));
}

fn draw_marks(svg: &mut Svg, plot: &Plot, curve: &AttemptCurve) {
    let mut placed = Vec::new();
    for (number, mark) in marks::number_marks(curve).filter(|(_, m)| plot.x.contains(m.advance_mm)) {
        let at = plot.at(mark.advance_mm, mark.axial_n);
        marks::draw_mark(svg, mark.kind, at);
        placed.push((number, at));
    }
    marks::draw_mark_numbers(svg, &placed, plot.area.y + 10.0);
}

/// Returns the boundaries that have stages, from the surface down.
fn boundaries_with_stages(curve: &AttemptCurve) -> Vec<usize> {
    (0..curve.bands.len()).filter(|b| curve.stages.iter().any(|s| s.boundary == *b)).collect()
}

fn draw_lane(svg: &mut Svg, plot: &Plot, curve: &AttemptCurve, boundary: usize, top: f64) {
    svg.text("layer-name", PaperPoint::new(LEFT, top + 8.0), &curve.bands[boundary].name);
    for span in curve.stages.iter().filter(|s| s.boundary == boundary) {
        let column = plot.column(span.from_mm, span.to_mm);
        let area = Area { y: top + 12.0, height: 14.0, ..column };
        svg.rect(&format!("stage {}", span.stage.class()), area);
        if area.width > text_width(span.stage.numeral()) {
            svg.text("stage-name middle", PaperPoint::new(area.x + area.width / 2.0, top + 23.0), span.stage.numeral());
        }
    }
}

#[cfg(test)]
mod tests {
    //! The plot must contain everything the session page refers to, and an empty recording must be
    //! drawn.

    use super::*;
    use crate::samples;

    #[test]
    fn shows_layers_ruptures_and_stages() {
        let markup = draw_force_over_depth(&samples::curve(), DrawingSize::Wide);
        for wanted in
            ["band skin", "band fat", "band muscle", "mark tip", "mark rim", "mark confirm", ">III<", "target"]
        {
            assert!(markup.contains(wanted), "{wanted} is missing");
        }
    }

    #[test]
    fn empty_and_single_point_curves_are_drawn_without_nan() {
        let empty = AttemptCurve { points: vec![], marks: vec![], stages: vec![], ..samples::curve() };
        let single = AttemptCurve { points: samples::curve().points[..1].to_vec(), ..empty.clone() };
        for curve in [empty, single] {
            for size in [DrawingSize::Wide, DrawingSize::Narrow] {
                let markup = draw_force_over_depth(&curve, size);
                assert!(!markup.contains("NaN") && !markup.contains("inf"), "{markup}");
                assert!(!markup.contains("polyline"));
            }
        }
    }

    #[test]
    fn every_place_lies_on_the_paper() {
        let markup = draw_force_over_depth(&samples::curve(), DrawingSize::Narrow);
        let points = markup.split("points=\"").skip(1).filter_map(|rest| rest.split('"').next());
        for pair in points.flat_map(str::split_whitespace) {
            let (x, y) = pair.split_once(',').expect("a pair");
            let (x, y): (f64, f64) = (x.parse().expect("x"), y.parse().expect("y"));
            assert!((0.0..=340.0).contains(&x) && (0.0..=600.0).contains(&y), "{pair}");
        }
    }
}
