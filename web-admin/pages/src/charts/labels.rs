//! Placement of labels in a drawing, each next to its object and clear of everything else.

use super::svg::{Area, PaperPoint, Svg, text_width};

/// Height of a line of text.
const LINE: f64 = 16.0;

/// Truncates a name to a width, in the drawing's units.
#[must_use]
pub fn shorten_name(name: &str, width: f64) -> String {
    if text_width(name) <= width {
        return name.to_owned();
    }
    let kept =
        name.char_indices().map(|(at, _)| &name[..at]).take_while(|part| text_width(part) < width - text_width("…"));
    format!("{}…", kept.last().unwrap_or_default().trim_end())
}

/// Breaks a text between words into lines of at most `width`, in the drawing's units; a longer word
/// gets its own line.
#[must_use]
pub fn wrap_lines(text: &str, width: f64) -> Vec<&str> {
    let mut lines = Vec::new();
    let mut rest = text.trim();
    while text_width(rest) > width {
        let breaks: Vec<usize> = rest.match_indices(' ').map(|(at, _)| at).collect();
        let fits = breaks.iter().rev().find(|at| text_width(&rest[..**at]) <= width).or(breaks.first());
        let Some(at) = fits.copied() else { break };
        lines.push(&rest[..at]);
        rest = rest[at..].trim_start();
    }
    lines.push(rest);
    lines
}

/// Tracks the areas of a drawing that are covered.
#[derive(Debug)]
pub struct Labels {
    paper: Area,
    taken: Vec<Area>,
}

impl Labels {
    /// Creates an empty drawing area.
    #[must_use]
    pub fn new(paper: Area) -> Self {
        Self { paper, taken: Vec::new() }
    }

    /// Marks an area as covered.
    pub fn avoid(&mut self, area: Area) {
        self.taken.push(area);
    }

    /// Writes a label on the first free side of its object: right, left, below, above; below if no
    /// side is free.
    pub fn place(&mut self, svg: &mut Svg, class: &str, name: &str, thing: Area) {
        let sides = rooms_beside(thing, text_width(name));
        let (anchor, room) = sides.iter().find(|(_, room)| self.is_free(room)).unwrap_or(&sides[2]);
        let x = match *anchor {
            "end" => room.right(),
            "middle" => room.x + room.width / 2.0,
            _ => room.x,
        };
        svg.text(&format!("{class} {anchor}"), PaperPoint::new(x, room.bottom() - 4.0), name);
        self.taken.push(*room);
    }

    fn is_free(&self, room: &Area) -> bool {
        let inside = room.x >= self.paper.x
            && room.right() <= self.paper.right()
            && room.y >= self.paper.y
            && room.bottom() <= self.paper.bottom();
        inside && !self.taken.iter().any(|taken| taken.meets(room))
    }
}

/// Returns text anchor and area of a label on each side.
fn rooms_beside(thing: Area, width: f64) -> [(&'static str, Area); 4] {
    let (middle_x, middle_y) = (thing.x + thing.width / 2.0, thing.y + thing.height / 2.0);
    let room = |x, y| Area { x, y, width, height: LINE };
    [
        ("start", room(thing.right() + 6.0, middle_y - LINE / 2.0)),
        ("end", room(thing.x - 6.0 - width, middle_y - LINE / 2.0)),
        ("middle", room(middle_x - width / 2.0, thing.bottom() + 2.0)),
        ("middle", room(middle_x - width / 2.0, thing.y - LINE - 2.0)),
    ]
}

#[cfg(test)]
mod tests {
    //! Labels must not overlap or leave the drawing.

    use super::*;

    #[test]
    fn names_take_the_first_free_side() {
        let paper = Area { x: 0.0, y: 0.0, width: 200.0, height: 200.0 };
        let thing = Area { x: 90.0, y: 90.0, width: 20.0, height: 20.0 };
        let mut labels = Labels::new(paper);
        let mut svg = Svg::ornament(200.0, 200.0, "c");
        for _ in 0..3 {
            labels.place(&mut svg, "name", "vessel", thing);
        }
        let [right, left, below] = labels.taken[..] else { panic!("three rooms") };
        assert!(right.x > thing.right() && left.right() < thing.x && below.y > thing.bottom());
        assert!(!right.meets(&left) && !left.meets(&below));
    }

    #[test]
    fn a_name_that_would_leave_the_paper_goes_to_the_other_side() {
        let paper = Area { x: 0.0, y: 0.0, width: 200.0, height: 200.0 };
        let mut labels = Labels::new(paper);
        let edge = Area { x: 170.0, y: 90.0, width: 20.0, height: 20.0 };
        labels.place(&mut Svg::ornament(200.0, 200.0, "c"), "name", "vessel", edge);
        assert!(labels.taken[0].right() < edge.x);
    }
}
