//! A small writer of SVG: escapes every text, prints every number short, knows no colour.

use std::fmt::Write;

/// What a drawing is called and shows: read out in place of the picture.
#[derive(Clone, Copy, Debug)]
pub struct Caption<'a> {
    /// Id, unique on the page.
    pub id: &'a str,
    /// Classes.
    pub class: &'a str,
    /// Title.
    pub title: &'a str,
    /// Description.
    pub description: &'a str,
}

/// A rectangle: left, top, width, height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// Left.
    pub x: f64,
    /// Top.
    pub y: f64,
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
}

impl Area {
    /// Right.
    #[must_use]
    pub fn right(&self) -> f64 {
        self.x + self.width
    }

    /// Bottom.
    #[must_use]
    pub fn bottom(&self) -> f64 {
        self.y + self.height
    }

    /// The two share some room.
    #[must_use]
    pub fn meets(&self, other: &Self) -> bool {
        self.x < other.right() && other.x < self.right() && self.y < other.bottom() && other.y < self.bottom()
    }
}

/// A drawing in the making.
#[derive(Debug)]
pub struct Svg {
    body: String,
}

impl Svg {
    /// Begins a drawing of a width and height.
    #[must_use]
    pub fn new(width: f64, height: f64, caption: &Caption<'_>) -> Self {
        let Caption { id, class, title, description } = caption;
        let (width, height) = (number(width), number(height));
        let body = format!(
            r#"<svg class="chart {class}" viewBox="0 0 {width} {height}" role="img" aria-labelledby="{id}-t {id}-d"><title id="{id}-t">{}</title><desc id="{id}-d">{}</desc>"#,
            escape(title),
            escape(description)
        );
        Self { body }
    }

    /// Begins a small drawing that only repeats the text beside it.
    #[must_use]
    pub fn ornament(width: f64, height: f64, class: &str) -> Self {
        let (width, height) = (number(width), number(height));
        let size = format!(r#"width="{width}" height="{height}" viewBox="0 0 {width} {height}""#);
        Self { body: format!(r#"<svg class="{class}" {size} aria-hidden="true" focusable="false">"#) }
    }

    /// Ends the drawing.
    #[must_use]
    pub fn finish(mut self) -> String {
        self.body.push_str("</svg>");
        self.body
    }

    /// A rectangle; one without extent is left out.
    pub fn rect(&mut self, class: &str, area: Area) {
        if area.width > 0.0 && area.height > 0.0 {
            let (x, y, w, h) = (number(area.x), number(area.y), number(area.width), number(area.height));
            self.push(format_args!(r#"<rect class="{class}" x="{x}" y="{y}" width="{w}" height="{h}"/>"#));
        }
    }

    /// A straight line.
    pub fn line(&mut self, class: &str, from: (f64, f64), to: (f64, f64)) {
        let (x1, y1, x2, y2) = (number(from.0), number(from.1), number(to.0), number(to.1));
        self.push(format_args!(r#"<line class="{class}" x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}"/>"#));
    }

    /// A line through points; fewer than two are left out.
    pub fn polyline(&mut self, class: &str, points: &[(f64, f64)]) {
        if points.len() > 1 {
            let points = join(points);
            self.push(format_args!(r#"<polyline class="{class}" points="{points}"/>"#));
        }
    }

    /// A closed shape.
    pub fn polygon(&mut self, class: &str, points: &[(f64, f64)]) {
        if points.len() > 2 {
            let points = join(points);
            self.push(format_args!(r#"<polygon class="{class}" points="{points}"/>"#));
        }
    }

    /// A circle.
    pub fn circle(&mut self, class: &str, centre: (f64, f64), radius: f64) {
        let (cx, cy, r) = (number(centre.0), number(centre.1), number(radius));
        self.push(format_args!(r#"<circle class="{class}" cx="{cx}" cy="{cy}" r="{r}"/>"#));
    }

    /// Text from a point on its baseline. The classes `middle` and `end` anchor it elsewhere.
    pub fn text(&mut self, class: &str, at: (f64, f64), text: &str) {
        let (x, y, text) = (number(at.0), number(at.1), escape(text));
        self.push(format_args!(r#"<text class="{class}" x="{x}" y="{y}">{text}</text>"#));
    }

    /// Text that reads upwards around a point.
    pub fn text_upwards(&mut self, class: &str, at: (f64, f64), text: &str) {
        let (x, y, text) = (number(at.0), number(at.1), escape(text));
        self.push(format_args!(r#"<text class="{class}" transform="translate({x} {y}) rotate(-90)">{text}</text>"#));
    }

    fn push(&mut self, markup: std::fmt::Arguments<'_>) {
        // Writing into a String cannot fail.
        let _ = self.body.write_fmt(markup);
    }
}

fn join(points: &[(f64, f64)]) -> String {
    let mut joined = String::with_capacity(points.len() * 12);
    for (x, y) in points {
        let _ = write!(joined, "{},{} ", number(*x), number(*y));
    }
    joined.truncate(joined.trim_end().len());
    joined
}

/// One decimal, a tenth of a pixel, and none where it is 0. Not-a-number has no place on paper and becomes 0.
fn number(value: f64) -> String {
    let value = if value.is_finite() { value } else { 0.0 };
    let text = format!("{value:.1}");
    let text = text.strip_suffix(".0").map_or(text.clone(), str::to_owned);
    if text == "-0" { "0".to_owned() } else { text }
}

/// Text as it may stand in markup.
#[must_use]
pub fn escape(text: &str) -> String {
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

/// Rough width of a text in a chart, in its units: enough to keep labels apart.
#[must_use]
pub fn text_width(text: &str) -> f64 {
    f64::from(u32::try_from(text.chars().count()).unwrap_or(u32::MAX)) * 6.8
}

#[cfg(test)]
mod tests {
    //! Names come from documents that anybody may write: none of them may become markup.

    use super::*;

    #[test]
    fn text_cannot_become_markup() {
        let caption = Caption { id: "x", class: "c", title: "a<b>", description: "\"d\" & 'e'" };
        let mut svg = Svg::new(10.0, 10.0, &caption);
        svg.text("label", (1.0, 2.0), "</text><script>alert(1)</script>");
        let markup = svg.finish();
        assert!(!markup.contains("<script") && !markup.contains("a<b>"));
        assert!(markup.contains("&lt;script&gt;") && markup.contains("&quot;d&quot; &amp; &#39;e&#39;"));
    }

    #[test]
    fn numbers_are_short_and_always_numbers() {
        assert_eq!([12.0, 12.34, -0.01, f64::NAN, f64::INFINITY].map(number), ["12", "12.3", "0", "0", "0"]);
    }

    #[test]
    fn a_line_needs_two_points() {
        let mut svg = Svg::ornament(1.0, 1.0, "c");
        svg.polyline("curve", &[(0.0, 0.0)]);
        svg.polygon("area", &[(0.0, 0.0), (1.0, 1.0)]);
        assert!(!svg.finish().contains("points"));
    }
}
