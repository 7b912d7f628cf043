//! The exercise as a cross-section in the plane of the needle: layers, structures, planned path and
//! target.

use super::DrawingSize;
use super::force_depth::texture_class;
use super::labels::Labels;
use super::plot::Plot;
use super::scale::Extent;
use super::svg::{Area, Caption, PaperPoint, Svg, text_width};
use crate::format;

/// Content of the drawing, in mm: across is measured in the direction of the needle's lean from the
/// entry point, depth from the skin.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossSection {
    /// Name, texture and thickness in mm of each layer, from the surface down.
    pub layers: Vec<(String, String, f64)>,
    /// Angle of the needle to the surface normal, in degrees.
    pub angle_deg: f64,
    /// Target depth along the needle, in mm.
    pub target_depth_mm: f64,
    /// Structures, projected onto the plane or cut by it.
    pub structures: Vec<SectionStructure>,
}

/// A structure in the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionStructure {
    /// Name.
    pub name: String,
    /// Class: target, vessel, nerve, bone or organ.
    pub kind: &'static str,
    /// Shape in the plane.
    pub outline: StructureOutline,
}

/// A point in the plane, in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionPoint {
    /// Distance from the entry point in the direction of the needle's lean.
    pub across_mm: f64,
    /// Depth below the skin.
    pub depth_mm: f64,
}

impl SectionPoint {
    /// Creates a point from its coordinates in mm.
    #[must_use]
    pub const fn new(across_mm: f64, depth_mm: f64) -> Self {
        Self { across_mm, depth_mm }
    }
}

/// A shape in the plane, in mm.
#[derive(Clone, Debug, PartialEq)]
pub enum StructureOutline {
    /// A sphere.
    Circle {
        /// Centre.
        centre: SectionPoint,
        /// Radius, in mm.
        radius_mm: f64,
    },
    /// A cuboid.
    Rect {
        /// Smallest across and depth.
        from: SectionPoint,
        /// Largest across and depth.
        to: SectionPoint,
    },
    /// A capsule: a cylinder with hemispherical ends.
    Capsule {
        /// Centre of one end.
        from: SectionPoint,
        /// Centre of the other end.
        to: SectionPoint,
        /// Radius, in mm.
        radius_mm: f64,
    },
    /// Closed contours of the cut. Points within an odd number of contours are inside.
    Cut(Vec<Vec<SectionPoint>>),
}

impl StructureOutline {
    /// Returns the greatest depth, in mm.
    fn bottom(&self) -> f64 {
        match self {
            Self::Circle { centre, radius_mm } => centre.depth_mm + radius_mm,
            Self::Rect { to, .. } => to.depth_mm,
            Self::Capsule { from, to, radius_mm } => from.depth_mm.max(to.depth_mm) + radius_mm,
            Self::Cut(loops) => loops.iter().flatten().map(|point| point.depth_mm).fold(0.0, f64::max),
        }
    }

    /// Returns the closed contours of the shape.
    fn loops(&self) -> Vec<Vec<SectionPoint>> {
        match self {
            Self::Circle { centre, radius_mm } => vec![outline_rod(*centre, *centre, *radius_mm)],
            Self::Rect { from, to } => {
                let corner = SectionPoint::new;
                vec![vec![*from, corner(to.across_mm, from.depth_mm), *to, corner(from.across_mm, to.depth_mm)]]
            }
            Self::Capsule { from, to, radius_mm } => vec![outline_rod(*from, *to, *radius_mm)],
            Self::Cut(loops) => loops.clone(),
        }
    }
}

/// Returns the outline of a capsule: a semicircle about each end, rotated into the capsule's
/// direction.
fn outline_rod(from: SectionPoint, to: SectionPoint, radius: f64) -> Vec<SectionPoint> {
    let turn = libm::atan2(to.depth_mm - from.depth_mm, to.across_mm - from.across_mm);
    let half = |centre: SectionPoint, start: f64| {
        (0..=18_u32).map(move |i| {
            let angle = start + std::f64::consts::PI * f64::from(i) / 18.0;
            let (across_mm, depth_mm) = (radius * libm::cos(angle), radius * libm::sin(angle));
            SectionPoint::new(centre.across_mm + across_mm, centre.depth_mm + depth_mm)
        })
    };
    let quarter = std::f64::consts::FRAC_PI_2;
    half(to, turn - quarter).chain(half(from, turn + quarter)).collect()
}

/// Space shown above the skin, in mm.
const ABOVE: f64 = 16.0;
const LEFT: f64 = 46.0;

/// Draws the section at the same scale in both directions.
#[must_use]
pub fn draw_cross_section(section: &CrossSection, size: DrawingSize) -> String {
    let id = format!("section-{}", size.name());
    let title = tr!("Cross-section along the needle");
    let caption = Caption { id: &id, class: size.name(), title, description: &describe_section(section) };
    let height = if size == DrawingSize::Wide { 360.0 } else { 320.0 };
    let area = Area { x: LEFT, y: 8.0, width: size.width() - LEFT - 8.0, height };
    let plot = plot_of_section(section, area);
    let mut svg = Svg::new(size.width(), area.bottom() + 14.0, &caption);
    let names = draw_layers(&mut svg, &plot, section);
    draw_depths(&mut svg, &plot);
    let shapes: Vec<Area> = section.structures.iter().map(|s| draw_structure(&mut svg, &plot, s)).collect();
    draw_needle(&mut svg, &plot, section);
    draw_names(&mut svg, &plot, section, &Drawn { shapes, names });
    svg.finish()
}

fn describe_section(section: &CrossSection) -> String {
    let layers: Vec<String> =
        section.layers.iter().map(|(name, _, mm)| format!("{name} {} mm", format::format_fixed(*mm, 1))).collect();
    let structures: Vec<&str> = section.structures.iter().map(|s| s.name.as_str()).collect();
    let besides =
        if structures.is_empty() { String::new() } else { tr!("Structures: {names}.", names = structures.join(", ")) };
    let needle = tr!(
        "Layers from the skin down: {layers}. The needle enters at {angle} to the surface normal, {depth} to the target.",
        layers = layers.join(", "),
        angle = format!("{:.0}°", section.angle_deg),
        depth = format::format_stated(section.target_depth_mm, "mm")
    );
    format!("{needle} {besides}").trim_end().to_owned()
}

/// Returns a point on the needle's line.
fn point_on_needle(section: &CrossSection, along_mm: f64) -> SectionPoint {
    let angle = section.angle_deg.to_radians();
    SectionPoint::new(along_mm * libm::sin(angle), along_mm * libm::cos(angle))
}

fn plot_of_section(section: &CrossSection, area: Area) -> Plot {
    let target = point_on_needle(section, section.target_depth_mm);
    let lowest = section.structures.iter().map(|s| s.outline.bottom()).fold(target.depth_mm, f64::max);
    let depth = Extent::new(-ABOVE, lowest.max(10.0) * 1.12 + 4.0);
    let mm_per_unit = depth.length() / area.height;
    let half_width = area.width * mm_per_unit / 2.0;
    let middle = target.across_mm / 2.0;
    Plot::falling(area, Extent::new(middle - half_width, middle + half_width), depth)
}

/// Areas that are already covered.
struct Drawn {
    /// Bounding box of each structure.
    shapes: Vec<Area>,
    /// Areas of the layer names.
    names: Vec<Area>,
}

/// Draws the layers and returns the areas of their names.
fn draw_layers(svg: &mut Svg, plot: &Plot, section: &CrossSection) -> Vec<Area> {
    let mut top_mm = 0.0;
    let mut names = Vec::new();
    for (name, texture, thickness_mm) in &section.layers {
        let row = plot.row(top_mm, top_mm + thickness_mm);
        if plot.y.contains(top_mm) {
            svg.rect(&format!("band {}", texture_class(texture)), row);
            svg.line("boundary", PaperPoint::new(row.x, row.y), PaperPoint::new(row.right(), row.y));
            names.push((name, row));
        }
        top_mm += thickness_mm;
    }
    let mut free_from = 0.0;
    let place = |(name, row): (&String, Area)| {
        // The name of a thin layer moves down until it is clear of the name above.
        let baseline = (row.y + 13.0).max(free_from);
        svg.text("layer-name", PaperPoint::new(row.x + 8.0, baseline), name);
        free_from = baseline + 14.0;
        Area { x: row.x + 8.0, y: baseline - 11.0, width: text_width(name), height: 14.0 }
    };
    names.into_iter().map(place).collect()
}

fn draw_depths(svg: &mut Svg, plot: &Plot) {
    let ticks: Vec<f64> = plot.y.ticks(9).into_iter().filter(|t| *t >= 0.0).collect();
    for tick in &ticks {
        let y = plot.y.at(*tick);
        svg.line("axis", PaperPoint::new(LEFT - 4.0, y), PaperPoint::new(LEFT, y));
        svg.text("tick end", PaperPoint::new(LEFT - 7.0, y + 4.0), &format!("{tick:.0}"));
    }
    svg.text_upwards(
        "axis-title middle",
        PaperPoint::new(12.0, plot.area.y + plot.area.height / 2.0),
        tr!("depth below the skin (mm)"),
    );
}

/// Draws a structure and returns its bounding box.
fn draw_structure(svg: &mut Svg, plot: &Plot, structure: &SectionStructure) -> Area {
    let on_paper = |point: &SectionPoint| plot.at(point.across_mm, point.depth_mm);
    let loops: Vec<Vec<PaperPoint>> =
        structure.outline.loops().iter().map(|line| line.iter().map(on_paper).collect()).collect();
    svg.region(&format!("structure {}", structure.kind), &loops);
    let across = Extent::around(loops.iter().flatten().map(|point| point.x));
    let down = Extent::around(loops.iter().flatten().map(|point| point.y));
    Area { x: across.from, y: down.from, width: across.length(), height: down.length() }
}

fn draw_needle(svg: &mut Svg, plot: &Plot, section: &CrossSection) {
    let place = |along_mm: f64| {
        let point = point_on_needle(section, along_mm);
        plot.at(point.across_mm, point.depth_mm)
    };
    let hub_mm = -ABOVE * 0.9;
    svg.line("needle", place(hub_mm), place(0.0));
    svg.line("path", place(0.0), place(section.target_depth_mm));
    let target = place(section.target_depth_mm);
    let PaperPoint { x, y } = target;
    svg.circle("aim", target, 7.0);
    svg.line("aim", PaperPoint::new(x - 11.0, y), PaperPoint::new(x + 11.0, y));
    svg.line("aim", PaperPoint::new(x, y - 11.0), PaperPoint::new(x, y + 11.0));
    let PaperPoint { x, y } = place(hub_mm);
    let name = tr!("needle, {angle} to the normal", angle = format!("{:.0}°", section.angle_deg));
    let fits = x + 10.0 + text_width(&name) <= plot.area.right();
    let (class, x) = if fits { ("needle-name", x + 10.0) } else { ("needle-name end", x - 10.0) };
    svg.text(class, PaperPoint::new(x, y + 12.0), &name);
}

/// Writes the names of the target and the structures, clear of the shapes, of each other and of the
/// planned path.
fn draw_names(svg: &mut Svg, plot: &Plot, section: &CrossSection, drawn: &Drawn) {
    let around = |centre: PaperPoint, reach: f64| {
        let (x, y) = (centre.x - reach, centre.y - reach);
        Area { x, y, width: 2.0 * reach, height: 2.0 * reach }
    };
    let place = |share: f64| {
        let point = point_on_needle(section, section.target_depth_mm * share);
        plot.at(point.across_mm, point.depth_mm)
    };
    let target = around(place(1.0), 12.0);
    let mut labels = Labels::new(plot.area);
    drawn.shapes.iter().chain(&drawn.names).for_each(|area| labels.avoid(*area));
    labels.avoid(target);
    (0..20).for_each(|i| labels.avoid(around(place(f64::from(i) / 20.0), 3.0)));
    let depth = format::format_stated(section.target_depth_mm, "mm");
    labels.place(svg, "target-name", &tr!("target at {depth}", depth = depth), target);
    for (structure, shape) in section.structures.iter().zip(&drawn.shapes) {
        labels.place(svg, "structure-name", &structure.name, *shape);
    }
}

#[cfg(test)]
mod tests {
    //! The drawing must be to scale, contain every layer and structure, and show the needle at the
    //! angle of the exercise.

    use super::*;

    fn section(angle_deg: f64) -> CrossSection {
        let layer = |name: &str, mm| (name.to_owned(), name.to_owned(), mm);
        let outline = StructureOutline::Circle { centre: SectionPoint::new(12.0, 18.0), radius_mm: 4.0 };
        CrossSection {
            layers: vec![layer("skin", 0.8), layer("fat", 8.4), layer("muscle", 39.0)],
            angle_deg,
            target_depth_mm: 20.0,
            structures: vec![SectionStructure { name: "artery <1>".to_owned(), kind: "vessel", outline }],
        }
    }

    #[test]
    fn shows_every_layer_structure_and_the_target() {
        let markup = draw_cross_section(&section(30.0), DrawingSize::Wide);
        for wanted in [
            "band skin",
            "band fat",
            "band muscle",
            "structure vessel",
            "artery &lt;1&gt;",
            "class=\"aim\"",
            "target at 20\u{a0}mm",
        ] {
            assert!(markup.contains(wanted), "{wanted} is missing");
        }
    }

    #[test]
    fn a_millimetre_is_as_long_across_as_down() {
        let area = Area { x: 0.0, y: 0.0, width: 600.0, height: 300.0 };
        let plot = plot_of_section(&section(30.0), area);
        let (across, down) = (plot.x.at(5.0) - plot.x.at(0.0), plot.y.at(5.0) - plot.y.at(0.0));
        assert!((across - down).abs() < 1e-9, "{across} against {down}");
    }

    #[test]
    fn the_needle_leans_by_its_angle() {
        let point = point_on_needle(&section(30.0), 20.0);
        assert!((point.across_mm - 10.0).abs() < 1e-9 && (point.depth_mm - 17.320_508).abs() < 1e-6);
    }

    #[test]
    fn a_rod_is_as_long_as_its_ends_and_as_thick_as_its_radius() {
        let points = outline_rod(SectionPoint::new(0.0, 5.0), SectionPoint::new(10.0, 5.0), 2.0);
        let across = Extent::around(points.iter().map(|point| point.across_mm));
        let down = Extent::around(points.iter().map(|point| point.depth_mm));
        for (value, wanted) in [(across.from, -2.0), (across.to, 12.0), (down.from, 3.0), (down.to, 7.0)] {
            assert!((value - wanted).abs() < 1e-9, "{value} is not {wanted}");
        }
    }
}
