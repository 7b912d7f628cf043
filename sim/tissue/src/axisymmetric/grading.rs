//! Grading of a mesh: element sizes that follow the scale of the field, and orders that decrease
//! where it fades.
//!
//! At a distance d from a load of radius a the field varies over about a + d, so elements grow in
//! proportion to that: their number between two distances is a difference of logarithms. High
//! orders pay off near the load; the field fades with the distance and with it the benefit of an
//! order (hp-refinement, Babuška and Guo 1988). The three constants are the cheapest that a scan
//! found for the reference cases, at 1 % and at 0.1 %, over size 1 to 2, decay 0.5 to 1.6 and
//! thinness 0.15 to 0.3; the cost is flat around them.

use super::basis::MAX_ORDER;
use super::mesh::{MeshSpec, Strip, lines_m};
use crate::Problem;

/// Size of an element, as a fraction of a + d.
const SIZE: f64 = 1.4;

/// Orders lost per element on the way from the load.
const DECAY: f64 = 0.8 * SIZE;

/// A strip with a fraction s of its due size has an error like (s · THINNESS)^(order + 1): a thin
/// layer needs a lower order.
const THINNESS: f64 = 0.2;

/// Excess over its due size, as a fraction of it, up to which an element is not divided.
const SLACK: f64 = 0.2;

/// Linear elements lock where a layer bends or is incompressible.
pub(super) const LEAST_ORDER: usize = 2;

/// Sizes of the two strips at the side, as fractions of the last strip: enough for the corner where
/// a stiff layer meets the clamp, whose stress is singular and which no order resolves (Babuška and
/// Guo 1988 also use 0.15).
const AT_SIDE: [f64; 2] = [0.15, 0.0225];

impl MeshSpec {
    /// The graded mesh of a level: the order of an element at the load, which need not be whole, 2
    /// to 10.
    #[must_use]
    pub fn graded(problem: &Problem, level: f64) -> Self {
        Self::by(
            &LevelGrading { radius_m: problem.load.radius_m, level, size: SIZE, decay: DECAY, thinness: THINNESS },
            problem,
        )
    }

    /// A mesh that shares only the mandatory lines of the problem with a graded one: smaller
    /// elements, so that their ends are elsewhere, and one order in all of them, near and far,
    /// thick and thin. It therefore captures what a graded mesh misses because of its low orders or
    /// its element ends.
    #[must_use]
    pub fn even(problem: &Problem, order: usize, size: f64) -> Self {
        let level = order as f64;
        let grading = LevelGrading { radius_m: problem.load.radius_m, level, size, decay: 0.0, thinness: 0.0 };
        Self::by(&grading, problem).graded_to_side()
    }

    fn by(grading: &LevelGrading, problem: &Problem) -> Self {
        let mut mesh = Self { radial: Vec::new(), axial: Vec::new() };
        grading.fill([0.0, problem.slab.radius_m], [0.0, problem.slab.radius_m], &mut mesh.radial);
        let (lines, [from_m, to_m]) = (lines_m(problem), problem.load.ends_m());
        for ends in lines.windows(2) {
            let (ends_m, half_m) = ([ends[0], ends[1]], 0.5 * (ends[1] - ends[0]));
            let middle_m = ends[0] + half_m;
            if !(from_m..=to_m).contains(&middle_m) {
                let distance = |depth_m: f64| (from_m - depth_m).max(depth_m - to_m).max(0.0);
                grading.fill(ends_m, ends_m.map(distance), &mut mesh.axial);
            } else if grading.count(half_m) <= 0.5 {
                grading.fill(ends_m, [0.0, 2.0 * half_m], &mut mesh.axial);
            } else {
                // Along a drag, the field changes fast with the depth only near a boundary or an
                // end of the drag.
                grading.fill([ends[0], middle_m], [0.0, half_m], &mut mesh.axial);
                grading.fill([middle_m, ends[1]], [half_m, 0.0], &mut mesh.axial);
            }
        }
        mesh
    }

    /// The same mesh with its last radial strip graded towards the clamped side, for layers that
    /// transmit the load as far as that.
    #[must_use]
    pub fn graded_to_side(mut self) -> Self {
        if let Some(last) = self.radial.pop() {
            let from_m = self.radial.last().map_or(0.0, |strip| strip.end_m);
            let ends_m = AT_SIDE.map(|share| last.end_m - share * (last.end_m - from_m));
            self.radial.extend(ends_m.map(|end_m| Strip { end_m, ..last }));
            self.radial.push(last);
        }
        self
    }

    /// The same mesh with the orders of every strip raised, up to [`MAX_ORDER`].
    #[must_use]
    pub fn raised(mut self, by: usize) -> Self {
        let strips = self.radial.iter_mut().chain(&mut self.axial);
        strips.for_each(|strip| strip.order = (strip.order + by).min(MAX_ORDER));
        self
    }

    /// Meshes of increasing cost and accuracy for one problem, a factor of about 3 in error apart.
    #[must_use]
    pub fn ladder(problem: &Problem) -> Vec<Self> {
        LEVELS.map(|level| Self::graded(problem, level as f64)).collect()
    }
}

/// Levels of the ladder.
pub(super) const LEVELS: std::ops::RangeInclusive<usize> = LEAST_ORDER..=MAX_ORDER;

struct LevelGrading {
    /// Radius of the load, in m.
    radius_m: f64,
    /// Order of an element at the load.
    level: f64,
    /// Size of an element, as a fraction of a + d.
    size: f64,
    /// Orders lost per element on the way from the load.
    decay: f64,
    /// As [`THINNESS`]; 0 gives a thin strip the order of a thick one.
    thinness: f64,
}

impl LevelGrading {
    /// Number of elements between the load and a distance from it, in m.
    fn count(&self, distance_m: f64) -> f64 {
        libm::log1p(distance_m / self.radius_m) / self.size
    }

    /// The distance, in m, up to which there are `count` elements.
    fn distance_m(&self, count: f64) -> f64 {
        libm::expm1(count * self.size) * self.radius_m
    }

    /// Appends strips from `ends_m[0]` to `ends_m[1]`, at these distances from the load.
    fn fill(&self, ends_m: [f64; 2], distances_m: [f64; 2], strips: &mut Vec<Strip>) {
        let [first, last] = distances_m.map(|distance_m| self.count(distance_m));
        let due = (last - first).abs();
        let strips_due = (due - SLACK).ceil().max(1.0);
        let away = if last > first { 1.0 } else { -1.0 };
        for strip in 1..=strips_due as usize {
            let at = |part: f64| first + (last - first) * (strip as f64 - part) / strips_due;
            let end_m = ends_m[0] + away * (self.distance_m(at(0.0)) - distances_m[0]);
            let end_m = if strip == strips_due as usize { ends_m[1] } else { end_m };
            strips.push(Strip { end_m, order: self.order(at(0.5), due / strips_due) });
        }
    }

    /// The order of a strip with a fraction of its due size, centred at a number of elements from
    /// the load.
    fn order(&self, count: f64, share: f64) -> usize {
        let full = self.level - self.decay * (count - 0.5).max(0.0);
        let order = if self.thinness > 0.0 {
            let thin = libm::log(self.thinness);
            (full + 1.0) * thin / (thin + libm::log(share.min(1.0))) - 1.0
        } else {
            full
        };
        ((order + 0.5) as usize).clamp(LEAST_ORDER, MAX_ORDER)
    }
}
