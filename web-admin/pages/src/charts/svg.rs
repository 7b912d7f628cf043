//! A small SVG writer: escapes all text, writes numbers with at most one decimal, leaves colours to
//! the style sheet.

use std::fmt::{self, Write};

/// Title and description of a drawing, for screen readers.
#[derive(Clone, Copy, Debug)]
pub struct Caption<'a> {
    /// Id, unique on the page.
    pub id: &'a str,
    /// CSS classes.
    pub class: &'a str,
    /// Title.
    pub title: &'a str,
    /// Description.
    pub description: &'a str,
}

/// A rectangle, in units of the drawing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// Left edge.
    pub x: f64,
    /// Top edge.
    pub y: f64,
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
}

impl Area {
    /// Returns the right edge.
    #[must_use]
    pub fn right(&self) -> f64 {
        self.x + self.width
    }

    /// Returns the bottom edge.
    #[must_use]
    pub fn bottom(&self) -> f64 {
        self.y + self.height
    }

    /// Returns whether the two rectangles overlap.
    #[must_use]
    pub fn meets(&self, other: &Self) -> bool {
        self.x < other.right() && other.x < self.right() && self.y < other.bottom() && other.y < self.bottom()
    }
}

/// A point of the drawing, in its units, measured from the top left corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperPoint {
    /// Distance from the left edge.
    pub x: f64,
    /// Distance from the top edge.
    pub y: f64,
}

impl PaperPoint {
    /// Creates a point from its coordinates.
    #[must_use]
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }
}

/// An SVG document under construction.
#[derive(Debug)]
pub struct Svg {
    body: String,
}

impl Svg {
    /// Begins a drawing with a width and height.
    #[must_use]
    pub fn new(width: f64, height: f64, caption: &Caption<'_>) -> Self {
        let Caption { id, class, title, description } = caption;
        let (width, height) = (Short(width), Short(height));
        let body = format!(
            r#"<svg class="chart {class}" viewBox="0 0 {width} {height}" role="img" aria-labelledby="{id}-t {id}-d"><title id="{id}-t">{}</title><desc id="{id}-d">{}</desc>"#,
            escape_markup(title),
            escape_markup(description)
        );
        Self { body }
    }

    /// Begins a small drawing that only repeats adjacent text and is hidden from screen readers.
    #[must_use]
    pub fn ornament(width: f64, height: f64, class: &str) -> Self {
        let (width, height) = (Short(width), Short(height));
        let size = format!(r#"width="{width}" height="{height}" viewBox="0 0 {width} {height}""#);
        Self { body: format!(r#"<svg class="{class}" {size} aria-hidden="true" focusable="false">"#) }
    }

    /// Closes the drawing and returns its markup.
    #[must_use]
    pub fn finish(mut self) -> String {
        self.body.push_str("</svg>");
        self.body
    }

    /// Draws a rectangle; an empty one is omitted.
    pub fn rect(&mut self, class: &str, area: Area) {
        if area.width > 0.0 && area.height > 0.0 {
            let (x, y, w, h) = (Short(area.x), Short(area.y), Short(area.width), Short(area.height));
            self.push(format_args!(r#"<rect class="{class}" x="{x}" y="{y}" width="{w}" height="{h}"/>"#));
        }
    }

    /// Draws a straight line.
    pub fn line(&mut self, class: &str, from: PaperPoint, to: PaperPoint) {
        let (x1, y1, x2, y2) = (Short(from.x), Short(from.y), Short(to.x), Short(to.y));
        self.push(format_args!(r#"<line class="{class}" x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}"/>"#));
    }

    /// Draws a line through points; omitted with fewer than two points.
    pub fn polyline(&mut self, class: &str, points: &[PaperPoint]) {
        if points.len() > 1 {
            let points = join_points(points);
            self.push(format_args!(r#"<polyline class="{class}" points="{points}"/>"#));
        }
    }

    /// Draws a closed shape; omitted with fewer than three points.
    pub fn polygon(&mut self, class: &str, points: &[PaperPoint]) {
        if points.len() > 2 {
            let points = join_points(points);
            self.push(format_args!(r#"<polygon class="{class}" points="{points}"/>"#));
        }
    }

    /// Fills the points that lie within an odd number of closed contours.
    pub fn region(&mut self, class: &str, loops: &[Vec<PaperPoint>]) {
        let lines: Vec<String> = loops.iter().map(|line| format!("M{}Z", join_points(line))).collect();
        self.push(format_args!(r#"<path class="{class}" fill-rule="evenodd" d="{}"/>"#, lines.concat()));
    }

    /// Draws a circle.
    pub fn circle(&mut self, class: &str, centre: PaperPoint, radius: f64) {
        let (cx, cy, r) = (Short(centre.x), Short(centre.y), Short(radius));
        self.push(format_args!(r#"<circle class="{class}" cx="{cx}" cy="{cy}" r="{r}"/>"#));
    }

    /// Writes text that starts at a point on its baseline. The classes `middle` and `end` anchor it
    /// differently.
    pub fn text(&mut self, class: &str, at: PaperPoint, text: &str) {
        let (x, y, text) = (Short(at.x), Short(at.y), escape_markup(text));
        self.push(format_args!(r#"<text class="{class}" x="{x}" y="{y}">{text}</text>"#));
    }

    /// Writes text rotated to read upwards at a point.
    pub fn text_upwards(&mut self, class: &str, at: PaperPoint, text: &str) {
        let (x, y, text) = (Short(at.x), Short(at.y), escape_markup(text));
        self.push(format_args!(r#"<text class="{class}" transform="translate({x} {y}) rotate(-90)">{text}</text>"#));
    }

    fn push(&mut self, markup: fmt::Arguments<'_>) {
        // Writing to a `String` cannot fail.
        let _ = self.body.write_fmt(markup);
    }
}

fn join_points(points: &[PaperPoint]) -> String {
    let mut joined = String::with_capacity(points.len() * 12);
    for PaperPoint { x, y } in points {
        // Writing to a `String` cannot fail.
        let _ = write!(joined, "{},{} ", Short(*x), Short(*y));
    }
    joined.truncate(joined.trim_end().len());
    joined
}

/// A length as written in markup: rounded to one decimal, a tenth of a pixel, and without decimals
/// if that is 0. NaN and infinities become 0.
struct Short(f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Drawings contain thousands of numbers, and integers are formatted much faster than
        // floats. The cast saturates at the range of `i64`.
        let tenths = if self.0.is_finite() { libm::rint(self.0 * 10.0) as i64 } else { 0 };
        let (sign, whole, rest) =
            (if tenths < 0 { "-" } else { "" }, tenths.unsigned_abs() / 10, tenths.unsigned_abs() % 10);
        if rest == 0 { write!(f, "{sign}{whole}") } else { write!(f, "{sign}{whole}.{rest}") }
    }
}

/// Escapes text for use in markup.
#[must_use]
pub fn escape_markup(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            c => safe.push(c),
        }
    }
    safe
}

/// Returns the approximate width of a text, in units of the chart: accurate enough to keep labels
/// apart.
#[must_use]
pub fn text_width(text: &str) -> f64 {
    text.chars().count() as f64 * 6.8
}

#[cfg(test)]
mod tests {
    //! Names come from documents that any author may write: they must never become markup.

    use super::*;

    #[test]
    fn text_cannot_become_markup() {
        let caption = Caption { id: "x", class: "c", title: "a<b>", description: "\"d\" & 'e'" };
        let mut svg = Svg::new(10.0, 10.0, &caption);
        svg.text("label", PaperPoint::new(1.0, 2.0), "</text><script>alert(1)</script>");
        let markup = svg.finish();
        assert!(!markup.contains("<script") && !markup.contains("a<b>"));
        assert!(markup.contains("&lt;script&gt;") && markup.contains("&quot;d&quot; &amp; &#39;e&#39;"));
    }

    #[test]
    fn numbers_are_short_and_always_numbers() {
        assert_eq!(
            [12.0, 12.34, -0.01, f64::NAN, f64::INFINITY].map(|value| Short(value).to_string()),
            ["12", "12.3", "0", "0", "0"]
        );
    }

    #[test]
    fn a_line_needs_two_points() {
        let mut svg = Svg::ornament(1.0, 1.0, "c");
        svg.polyline("curve", &[PaperPoint::new(0.0, 0.0)]);
        svg.polygon("area", &[PaperPoint::new(0.0, 0.0), PaperPoint::new(1.0, 1.0)]);
        assert!(!svg.finish().contains("points"));
    }
}
