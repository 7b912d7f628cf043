//! The mesh: strips across the radius times strips along the depth.

use law::axial::ParamError;
use phrase::{Phrase, phrase};

use super::basis::MAX_ORDER;
use crate::Problem;

/// Depths closer than this are equal, in m.
const SAME_DEPTH_M: f64 = 1e-9;

/// A strip of elements across one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strip {
    /// End of the strip, in m; it begins at the end of the previous one, the first at 0.
    pub end_m: f64,
    /// Order of its polynomials in this direction, 1 to [`MAX_ORDER`].
    pub order: usize,
}

/// A mesh of tensor-product elements. Every boundary between layers and both ends of the load must
/// be the end of an axial strip.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshSpec {
    /// Strips from the axis to the side.
    pub radial: Vec<Strip>,
    /// Strips from the skin to the base.
    pub axial: Vec<Strip>,
}

impl MeshSpec {
    /// The mesh with every strip halved: twice as fine.
    #[must_use]
    pub fn halved(&self) -> Self {
        let halves = |strips: &[Strip]| {
            let ends = std::iter::once(0.0).chain(strips.iter().map(|strip| strip.end_m)).zip(strips);
            ends.flat_map(|(from_m, &strip)| [Strip { end_m: 0.5 * (from_m + strip.end_m), ..strip }, strip]).collect()
        };
        Self { radial: halves(&self.radial), axial: halves(&self.axial) }
    }

    /// A description of the mesh for the user.
    pub(super) fn in_words(&self) -> Phrase {
        let Self { radial, axial } = self;
        let order = radial.iter().chain(axial).map(|strip| strip.order).max().unwrap_or(0);
        let [wide, deep] = [radial.len(), axial.len()];
        phrase!("{wide} × {deep} elements of order up to {order}", wide = wide, deep = deep, order = order)
    }

    /// Checks that the mesh fits the problem.
    ///
    /// # Errors
    /// The first strip that does not fit, or the first depth at which a strip must end.
    pub(super) fn check(&self, problem: &Problem) -> Result<(), ParamError> {
        let lines_m = lines_m(problem);
        check_strips("mesh.radial", &self.radial, problem.slab.radius_m)?;
        check_strips("mesh.axial", &self.axial, lines_m[lines_m.len() - 1])?;
        let ends = |line: f64| line <= SAME_DEPTH_M || self.axial.iter().any(|s| same_depth(s.end_m, line));
        lines_m.iter().find(|&&line| !ends(line)).map_or(Ok(()), |&value| {
            let allowed = "a strip must end at every boundary between layers and at both ends of the load";
            Err(ParamError { field: "mesh.axial".into(), value, unit: "m", allowed })
        })
    }
}

fn check_strips(name: &str, strips: &[Strip], length_m: f64) -> Result<(), ParamError> {
    let mut from_m = 0.0;
    for (at, &Strip { end_m, order }) in strips.iter().enumerate() {
        if !(end_m > from_m && end_m.is_finite()) {
            let allowed = "must be a number above the end of the strip before";
            return Err(ParamError { field: format!("{name}[{at}].end_m"), value: end_m, unit: "m", allowed });
        }
        if !(1..=MAX_ORDER).contains(&order) {
            let (value, allowed) = (order as f64, "must be from 1 to 10");
            return Err(ParamError { field: format!("{name}[{at}].order"), value, unit: "", allowed });
        }
        from_m = end_m;
    }
    if (from_m - length_m).abs() <= 1e-9 * length_m {
        return Ok(());
    }
    let allowed = "the last strip must end at the side, or at the base";
    Err(ParamError { field: name.into(), value: from_m, unit: "m", allowed })
}

pub(super) fn same_depth(a_m: f64, b_m: f64) -> bool {
    (a_m - b_m).abs() <= SAME_DEPTH_M
}

/// Depths at which a strip must end, ascending, from 0 to the base, in m.
pub(super) fn lines_m(problem: &Problem) -> Vec<f64> {
    let mut lines = problem.slab.solid().boundaries_m();
    for end_m in problem.load.ends_m() {
        if !lines.iter().any(|&line| same_depth(line, end_m)) {
            lines.push(end_m);
        }
    }
    lines.sort_by(f64::total_cmp);
    lines
}

/// A strip with its nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub from_m: f64,
    pub to_m: f64,
    pub order: usize,
    /// Its first node in this direction.
    pub first: usize,
}

impl Span {
    pub fn middle_m(&self) -> f64 {
        0.5 * (self.from_m + self.to_m)
    }

    pub fn half_m(&self) -> f64 {
        0.5 * (self.to_m - self.from_m)
    }
}

/// The strips of one direction.
#[derive(Clone, Debug)]
pub(super) struct Spans(Vec<Span>);

impl Spans {
    pub fn new(strips: &[Strip]) -> Self {
        let (mut from_m, mut first) = (0.0, 0);
        let spans = strips.iter().map(|strip| {
            let span = Span { from_m, to_m: strip.end_m, order: strip.order, first };
            (from_m, first) = (strip.end_m, first + strip.order);
            span
        });
        Self(spans.collect())
    }

    pub fn all(&self) -> &[Span] {
        &self.0
    }

    /// Number of nodes in this direction.
    pub fn nodes(&self) -> usize {
        self.0.last().map_or(0, |span| span.first + span.order + 1)
    }

    /// The strip that contains a position, and its coordinate in [−1, 1]; `None` outside the
    /// strips, with a tolerance for rounding.
    pub fn find(&self, at_m: f64) -> Option<(&Span, f64)> {
        let last = self.0.last()?;
        let rounding_m = 1e-9 * last.to_m;
        if !(-rounding_m..=last.to_m + rounding_m).contains(&at_m) {
            return None;
        }
        let span = self.0.get(self.0.partition_point(|span| span.to_m < at_m)).unwrap_or(last);
        Some((span, ((at_m - span.middle_m()) / span.half_m()).clamp(-1.0, 1.0)))
    }
}
